//! One point: a rig of its own, the loop, and what goes into the log beside the rows.

use drivers::device::DeviceError;
use procedures::axis::ticks_per_row;
use procedures::case::Case;
use procedures::log::{Attachment, Plan};
use reports::record::DeviceRecord;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::world::WorldRecord;

use super::Setup;
use super::ask::answered;
use crate::axis_loop::AxisLoop;
use crate::clock::Clock;
use crate::dither::Dither;
use crate::judge;
use crate::model::rig::Rig;
use crate::recorder::Recorder;
use crate::rig::{OpenRig, limited};
use crate::run::{Conditions, PointOutcome, run_point};
use procedures::log::PointStatus;

/// An axis farther than this outside its travel stands where it must never be.
const OUTSIDE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Devices on the gimbal are logged at this rate at the most while no procedure is about them.
const PAYLOAD_LOG_HZ: f64 = 500.0;
/// The same as a share of the log's own rate: who asks for few rows does so of all devices.
const PAYLOAD_SHARE: f64 = 0.25;

pub(super) fn one_point(
    setup: &Setup<'_>,
    index: usize,
    plan: &Plan,
    (point, log_start_ns): (usize, u64),
    recorder: &mut Recorder,
) -> Result<Ended, DeviceError> {
    let case = &plan.cases[point];
    let (rig_file, gains) = (setup.rig_of(index), setup.gains_of(index));
    let (unit, rate_hz) =
        (crate::scenery::shown(&setup.unit_of(index).settings, case), rig_file.loop_rate_hz);
    let start = start_state(setup, case);
    let simulated = SimulatedRig::at_rate(&unit, &address(plan, case), start, rate_hz);
    let wires = (setup.seams.wires)(&simulated);
    let limits = limited(rig_file, case);
    let mut rig = OpenRig::open(wires, &limits, &gains, &Clock::Virtual)?.arm()?;
    let loops = AxisLoop::of_rig(rig_file, &gains);
    let moving = rig_file.axis_index(&case.axis).ok_or_else(|| DeviceError::Bus {
        device: rig_file.id.clone(),
        reason: format!("the rig has no axis `{}`", case.axis),
    })?;
    let quantum_nm = plan.axes.get(&case.axis).map_or(0.0, |a| a.torque_quantum_nm);
    let log_every = (rate_hz / plan.log_rate_hz).round().max(1.0) as u64;
    let conditions = Conditions {
        point,
        case,
        moving,
        log_start_ns,
        loop_rate_hz: rate_hz,
        log_every,
        log_payload_every: if case.logs_payload_fully {
            1
        } else {
            (plan.log_rate_hz / PAYLOAD_LOG_HZ.min(PAYLOAD_SHARE * plan.log_rate_hz)).ceil() as u64
        },
        max_missed_periods: rig_file.max_missed_periods,
        gates: &setup.plan.procedures[index].procedure.gates,
        questions: &answered(&setup.plan.asked(&setup.plan.procedures[index])),
        parks: point + 1 == plan.cases.len(),
        stop: &setup.stop,
        clock: Clock::Virtual,
    };
    let mut dither = Dither::new(plan, &case.point, quantum_nm);
    let mut outcome = run_point(&mut rig, loops, &conditions, &mut dither, recorder);
    let contacts = contacts(rig_file, &outcome, &simulated.record());
    if !contacts.is_empty() {
        // What failed besides does not hide it.
        let others = outcome.error.take().into_iter();
        outcome.error = Some(contacts.iter().cloned().chain(others).collect::<Vec<_>>().join("; "));
        outcome.status = PointStatus::Errored;
    }
    Ok(Ended { outcome, contacts })
}

/// How a point ended, and which axes met an end stop in it.
pub(super) struct Ended {
    pub(super) outcome: PointOutcome,
    pub(super) contacts: Vec<String>,
}

/// End stops that were met. The simulator sees a contact; what the bench itself can see is an axis that is left outside
/// its travel. Neither is ever what was planned.
fn contacts(rig: &Rig, outcome: &PointOutcome, record: &WorldRecord) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for (k, axis) in rig.axes.iter().enumerate() {
        let [low, high] = axis.limits.travel_rad;
        let met: Vec<_> = record.crashes.iter().filter(|(name, ..)| *name == axis.name).collect();
        let left = outcome.safe.axes.iter().find(|left| left.axis == k).map(|left| left.position_rad);
        let outside = left.filter(|at| *at < low - OUTSIDE_RAD || *at > high + OUTSIDE_RAD);
        if let Some((name, at_s, speed)) = met.first() {
            let again = if met.len() > 1 { format!(", {} contacts", met.len()) } else { String::new() };
            let speed = speed.to_degrees();
            all.push(format!("{name} hit its end stop at {at_s:.3} s with {speed:.2} deg/s{again}"));
        } else if let Some(at) = outside {
            let [low, high, at] = [low, high, at].map(f64::to_degrees);
            let name = &axis.name;
            all.push(format!("{name} stands at {at:.3} deg, outside its travel {low:.1} .. {high:.1} deg"));
        }
    }
    all
}

fn address(plan: &Plan, case: &Case) -> SeedAddress {
    SeedAddress { seed: plan.seed, procedure: plan.procedure.clone(), point: case.point.clone() }
}

/// Every point of the virtual tier starts from a declared state: at rest, bristles relaxed, heat sinks at ambient.
fn start_state(setup: &Setup<'_>, case: &Case) -> StartState {
    let at = |axis: &str| case.start_pose_rad.get(axis).copied().unwrap_or(0.0);
    StartState { az_rad: at("az"), el_rad: at("el"), heat_sink_degc: setup.unit.settings.az.ambient_degc }
}

pub(super) fn log_plan(setup: &Setup<'_>, index: usize) -> Plan {
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
        mode: "simulated".to_owned(),
    }
}

pub(super) fn attachments(setup: &Setup<'_>, index: usize) -> Vec<Attachment> {
    let attach = |name: &str, text: &str| Attachment { name: name.to_owned(), text: text.to_owned() };
    let mut all = vec![
        attach("procedure.toml", &setup.plan.procedures[index].procedure.source.text),
        attach("requirements.toml", &setup.plan.requirements_source.text),
        attach("rig.toml", &setup.rig.source.text),
    ];
    if let Some(state) = setup.plan.state_of(&setup.plan.procedures[index]) {
        all.push(attach(judge::STATE, &state.source.text));
    }
    for (layer, source) in setup.unit_of(index).sources.iter().enumerate() {
        all.push(attach(&format!("unit.{layer}.toml"), &source.text));
    }
    all
}

/// Opens the rig once, before anything moves, to learn the name of its bus and who its devices are.
pub(super) fn identify(setup: &Setup<'_>) -> Result<(String, Vec<DeviceRecord>), DeviceError> {
    let address = SeedAddress { seed: setup.seed, procedure: "identify".to_owned(), point: String::new() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: setup.unit.settings.az.ambient_degc };
    let simulated = SimulatedRig::new(&setup.unit.settings, &address, start);
    let wires = (setup.seams.wires)(&simulated);
    let bus = wires.bus.name().to_owned();
    let rig = OpenRig::open(wires, setup.rig, setup.gains, &Clock::Virtual)?;
    Ok((bus, crate::devices::records(setup.rig, &rig)))
}
