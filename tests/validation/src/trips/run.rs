//! A trial through the real loop.

use std::sync::Arc;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use bench::clock::Clock;
use bench::cycle::axis_loop::AxisLoop;
use bench::cycle::dither::Dither;
use bench::cycle::recorder::Recorder;
use bench::cycle::run::{Conditions, PointOutcome, run_point};
use bench::rig::OpenRig;
use bench::rig::wires::Wires;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState, WorldRecord};

use super::cause::{Act, CAUSES};
use super::draw::Plan;
use super::tap::{Record, Sample, Tap};
use super::{Bed, UNITS};
use crate::conditions::of_point;

/// What was seen of a trial.
pub(super) struct Witnessed {
    pub(super) samples: Vec<Sample>,
    /// When the cause set in, s; `None` where the drives never came into operation.
    pub(super) caused_s: Option<f64>,
    pub(super) outcome: PointOutcome,
    pub(super) world: WorldRecord,
}

/// Runs a plan.
pub(super) fn run(bed: &Bed, plan: &Plan) -> Witnessed {
    run_with(bed, plan, (CAUSES[plan.cause].act)(plan.axis), None)
}

/// Runs the same without its cause, up to a sample: what would have been commanded.
pub(super) fn undisturbed(bed: &Bed, plan: &Plan, until: usize) -> Vec<Sample> {
    let never = Act::Fault(sim_devices::rig::Fault::FramesLost { count: 0 });
    run_with(bed, plan, never, Some(until)).samples
}

fn run_with(bed: &Bed, plan: &Plan, act: Act, until: Option<usize>) -> Witnessed {
    let address =
        SeedAddress { seed: plan.seed, procedure: "TRIPS".to_owned(), point: UNITS[plan.unit].to_owned() };
    let start = StartState { az_rad: plan.from_rad[0], el_rad: plan.from_rad[1], heat_sink_degc: 40.0 };
    let variation = &plan.variation;
    let rig_file = variation.rig(&bed.rig);
    let unit = variation.unit(&bed.units[plan.unit]);
    let clock = variation.clock(plan.seed, rig_file.loop_rate_hz);
    let simulated = SimulatedRig::new(&unit, &address, start);
    let stop = Arc::new(AtomicU16::new(0));
    let record = Record::new(act, Duration::from_secs_f64(plan.after_s), until);
    let mut wires = Wires::simulated(&simulated);
    wires.bus = Tap::on(&simulated, Arc::clone(&stop), record.clone());
    let mut rig = OpenRig::open(wires, &rig_file, &bed.gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("the simulated rig opens: nothing has happened to it yet");
    let case = plan.case(&bed.rig);
    let loops = AxisLoop::of_rig(&rig_file, &bed.gains);
    let conditions = Conditions {
        moving: plan.axis,
        log_start_ns: 0,
        loop_rate_hz: bed.rig.loop_rate_hz,
        log_payload_every: 1,
        max_missed_periods: bed.rig.max_missed_periods,
        clock,
        ..of_point(&case, &stop)
    };
    let dither = Dither::new(&log_plan(bed, plan), "trial", 0.0);
    let outcome = run_point(&mut rig, loops, conditions, dither, &mut Recorder::discarding());
    drop(rig);
    let mut record = record.borrow_mut();
    Witnessed {
        samples: std::mem::take(&mut record.samples),
        caused_s: record.caused.map(|at| at.as_secs_f64()),
        outcome,
        world: simulated.record(),
    }
}

/// The dither is addressed by a plan.
fn log_plan(bed: &Bed, plan: &Plan) -> procedures::log::Plan {
    procedures::log::Plan {
        schema: procedures::log::PLAN_SCHEMA,
        procedure: "TRIPS".to_owned(),
        axis: bed.rig.axes[plan.axis].name.clone(),
        seed: plan.seed,
        loop_rate_hz: bed.rig.loop_rate_hz,
        log_rate_hz: bed.rig.loop_rate_hz,
        command_delay_ticks: 1,
        axes: bed.rig.limits(),
        cases: Vec::new(),
        mode: "simulated".to_owned(),
    }
}
