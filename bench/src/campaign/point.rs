//! One point: a rig of its own, the loop, and what goes into the log beside the rows.

use drivers::device::DeviceError;
use procedures::axis::ticks_per_row;
use procedures::case::Case;
use procedures::log::{Attachment, Plan};
use procedures::procedure::Procedure;
use reports::record::DeviceRecord;

use super::Setup;
use super::ask::answered;
use super::procedure::planned_from_s;
use crate::clock::Clock;
use crate::cycle::axis_loop::AxisLoop;
use crate::cycle::dither::Dither;
use crate::cycle::recorder::Recorder;
use crate::cycle::run::{Conditions, PointError, PointOutcome, run_point};
use crate::model::rig::Rig;
use crate::plan::preflight::computed_worst;
use crate::record::log::{self, attachment};
use crate::rig::PointSettings;
use crate::site::{Contact, Purpose};
use procedures::log::PointStatus;

/// An axis farther than this outside its travel stands where it must never be.
const OUTSIDE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Devices on the gimbal are logged at this rate at the most while no procedure is about them.
const PAYLOAD_LOG_HZ: f64 = 500.0;
/// Rows of the payload as a share of the log's own rate: who asks for few rows does so of all devices.
const PAYLOAD_SHARE: f64 = 0.25;

/// Log time of a run's first point: one second after the epoch, because zero means "no time" to some readers.
pub(super) const LOG_EPOCH_NS: u64 = 1_000_000_000;

/// A point with what its loop needs beside a rig.
pub(super) struct Planned<'a> {
    pub(super) case: &'a Case,
    pub(super) dither: Dither,
    conditions: Conditions<'a>,
}

impl<'a> Planned<'a> {
    /// A point of a procedure, ticked by `clock`; `plan` is that of its log.
    pub(super) fn new(
        setup: &'a Setup<'a>,
        index: usize,
        plan: &Plan,
        point: usize,
        clock: Clock,
    ) -> Result<Self, DeviceError> {
        let planned = &setup.plan.procedures[index];
        let case = &planned.cases[point];
        let rig_file = setup.rig_of(index);
        let moving = rig_file.axis_index(&case.axis).ok_or_else(|| DeviceError::Bus {
            device: rig_file.id.clone(),
            reason: format!("the rig has no axis `{}`", case.axis),
        })?;
        let quantum_nm = plan.axes.get(&case.axis).map_or(0.0, |a| a.torque_quantum_nm);
        let payload_hz = PAYLOAD_LOG_HZ.min(PAYLOAD_SHARE * plan.log_rate_hz);
        let conditions = Conditions {
            point,
            case,
            moving,
            log_start_ns: LOG_EPOCH_NS,
            loop_rate_hz: rig_file.loop_rate_hz,
            log_every: (rig_file.loop_rate_hz / plan.log_rate_hz).round().max(1.0) as u64,
            log_payload_every: if case.logs_payload_fully {
                1
            } else {
                (plan.log_rate_hz / payload_hz).ceil() as u64
            },
            max_missed_periods: rig_file.max_missed_periods,
            gates: &planned.procedure.gates,
            questions: [].into(),
            parks: point + 1 == planned.cases.len(),
            stop: &setup.stop,
            clock,
            progress: setup.underway.progress(&planned.procedure.id),
        };
        Ok(Self { case, dither: Dither::new(plan, &case.point, quantum_nm), conditions })
    }

    pub(super) fn conditions(&self) -> Conditions<'a> {
        self.conditions.clone()
    }
}

/// Runs a point on a rig of its own.
pub(super) fn one_point<'a>(
    setup: &'a Setup<'a>,
    index: usize,
    plan: &Plan,
    point: usize,
    log_start_ns: u64,
    recorder: &mut Recorder,
) -> Result<Ended, DeviceError> {
    let planned = Planned::new(setup, index, plan, point, Clock::Virtual)?;
    let case = planned.case;
    let rig_file = setup.rig_of(index);
    let gains = setup.gains_of(index);
    let purpose = Purpose {
        seed: plan.seed,
        procedure: &plan.procedure,
        case: Some(case),
        stage: setup.plan.procedures[index].stage,
        planned_s: planned_from_s(setup.plan, index, point),
        pose_rad: case.start_pose_rad.clone(),
    };
    let opened = setup.site.open(rig_file, &gains, &purpose)?;
    let mut rig = opened.rig.arm(&opened.clock)?;
    let clock = opened.clock;
    rig.change_before_ticks(&PointSettings::for_case(rig_file, case), &clock)?;
    let conditions = Conditions {
        log_start_ns,
        questions: answered(&setup.plan.asked(&setup.plan.procedures[index])),
        clock,
        ..planned.conditions()
    };
    let loops = AxisLoop::of_rig_with(rig_file, &gains, &setup.laws, None)?;
    let outcome = run_point(&mut rig, loops, conditions, planned.dither, recorder);
    Ok(ended(rig_file, outcome, &opened.surroundings.contacts()))
}

/// A point's end with the end stops that were met in it.
pub(super) fn ended(rig: &Rig, mut outcome: PointOutcome, seen: &[Contact]) -> Ended {
    let contacts = contacts(rig, &outcome, seen);
    if !contacts.is_empty() {
        // What failed besides does not hide it.
        let others = outcome.error.take().map(|error| error.to_string());
        let all: Vec<String> = contacts.iter().cloned().chain(others).collect();
        outcome.error = Some(PointError::Bench(all.join("; ")));
        outcome.status = PointStatus::Errored;
    }
    Ended { outcome, contacts }
}

/// How a point ended, and which axes met an end stop in it.
pub(super) struct Ended {
    pub(super) outcome: PointOutcome,
    pub(super) contacts: Vec<String>,
}

/// End stops that were met: contacts that the site saw, and axes that are left outside their travel, which is what the
/// bench itself can see. Neither is ever what was planned.
fn contacts(rig: &Rig, outcome: &PointOutcome, seen: &[Contact]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for (k, axis) in rig.axes.iter().enumerate() {
        let [low, high] = axis.limits.travel_rad;
        let met: Vec<&Contact> = seen.iter().filter(|contact| contact.axis == axis.name).collect();
        let left = outcome.safe.axes.iter().find(|left| left.axis == k).map(|left| left.position_rad);
        let outside = left.filter(|at| *at < low - OUTSIDE_RAD || *at > high + OUTSIDE_RAD);
        if let Some(Contact { axis, at_s, speed_rad_per_s }) = met.first() {
            let again = if met.len() > 1 { format!(", {} contacts", met.len()) } else { String::new() };
            let speed = speed_rad_per_s.to_degrees();
            all.push(format!("{axis} hit its end stop at {at_s:.3} s, at {speed:.2} deg/s{again}"));
        } else if let Some(at) = outside {
            let [low, high, at] = [low, high, at].map(f64::to_degrees);
            let name = &axis.name;
            all.push(format!("{name} is at {at:.3} deg, outside its travel {low:.1} .. {high:.1} deg"));
        }
    }
    all
}

pub(super) fn log_plan(setup: &Setup<'_>, devices: &[DeviceRecord], index: usize) -> Plan {
    let planned = &setup.plan.procedures[index];
    let loop_rate_hz = setup.rig.loop_rate_hz;
    let every = ticks_per_row(loop_rate_hz, planned.procedure.log_rate_hz);
    Plan {
        schema: 1,
        procedure: planned.procedure.id.clone(),
        axis: planned.procedure.axis.clone(),
        seed: setup.seed,
        loop_rate_hz,
        log_rate_hz: loop_rate_hz / every,
        command_delay_ticks: 1,
        axes: setup.rig_of(index).limits(),
        cases: planned.cases.clone(),
        mode: log::mode_of(log::origin(devices)).to_owned(),
    }
}

pub(super) fn attachments(setup: &Setup<'_>, devices: &[DeviceRecord], index: usize) -> Vec<Attachment> {
    let mut all = vec![
        attachment(log::PROCEDURE, &setup.plan.procedures[index].procedure.source.text),
        attachment(log::REQUIREMENTS, &setup.plan.requirements_source.text),
        attachment(log::RIG, &setup.rig.source.text),
    ];
    if let Some(state) = setup.plan.state_of(&setup.plan.procedures[index]) {
        all.push(attachment(log::STATE, &state.source.text));
    }
    let laws = setup.laws.records();
    if !laws.is_empty() {
        let text = serde_json::to_string(&laws).expect("names and digests have a JSON form");
        all.push(attachment(log::LAWS, &text));
    }
    let identities = serde_json::to_string(devices).expect("names and sentences have a JSON form");
    all.push(attachment(log::DEVICES, &identities));
    let planned = &setup.plan.procedures[index];
    let Procedure { id, axis, .. } = &planned.procedure;
    if let Some(computed) = computed_worst(id, axis, &planned.cases, setup.rig) {
        let text = serde_json::to_string(&computed).expect("numbers and sentences have a JSON form");
        all.push(attachment(log::COMPUTED, &text));
    }
    for (layer, source) in setup.unit_of(index).sources.iter().enumerate() {
        all.push(attachment(&log::unit_layer(layer), &source.text));
    }
    all
}

/// Opens the rig once, before anything moves, to learn the name of its bus and who its devices are.
pub(super) fn identify(setup: &Setup<'_>) -> Result<(String, Vec<DeviceRecord>), DeviceError> {
    let purpose = Purpose { seed: setup.seed, procedure: "identify", ..Purpose::default() };
    let session = setup.site.open(setup.rig, setup.gains, &purpose)?;
    Ok((session.bus, crate::rig::identities::records(setup.rig, &session.rig, &session.grounds)))
}
