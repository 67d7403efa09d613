//! What can go wrong in a trial.

use std::time::Duration;

use bench::model::axis::AxisGuard;
use sim_devices::rig::{EncoderFault, Fault};

use super::tap::Sample;

/// What stops the axis after a cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Braking {
    /// The bench or the drive: there is torque, and a sensor to brake by.
    Torque,
    /// Friction alone.
    Friction,
    /// Torque, as long as the DC link lasts.
    WhileItLasts,
}

/// How a cause acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Act {
    /// As a signal would: the flag of the operator's order.
    Order,
    /// On the far side of the wires.
    Fault(Fault),
}

/// One cause.
pub struct Cause {
    /// Name in the table.
    pub name: &'static str,
    /// What stops the axis.
    pub braking: Braking,
    /// Time that the interlocks need to tell it, in which a loop may act on what is wrong.
    pub(super) hidden_s: f64,
    /// What happens, to the drive of the moving axis.
    pub(super) act: fn(usize) -> Act,
    /// Whether the inputs of a tick show it; `None` where only the interlocks can tell.
    pub(super) seen: Option<fn(&Sample, usize, &AxisGuard) -> bool>,
}

impl Cause {
    /// Whether the gyro goes on to tell a rate, and a wrong one.
    pub(super) fn falsifies_gyro(&self, drive: usize) -> bool {
        matches!((self.act)(drive), Act::Fault(Fault::ImuFrozen | Fault::GyroOffset { .. }))
    }
}

const fn cause(
    name: &'static str,
    braking: Braking,
    act: fn(usize) -> Act,
    seen: Option<fn(&Sample, usize, &AxisGuard) -> bool>,
) -> Cause {
    Cause { name, braking, hidden_s: 0.0, act, seen }
}

/// A cause that only the interlocks can tell, and need time for.
const fn hidden(name: &'static str, braking: Braking, hidden_s: f64, act: fn(usize) -> Act) -> Cause {
    Cause { name, braking, hidden_s, act, seen: None }
}

/// A channel that is the same for this long is looked at (safety.md: interlocks).
const FROZEN_S: f64 = 0.050;

fn out_of_operation(sample: &Sample, axis: usize, _: &AxisGuard) -> bool {
    sample.statusword[axis] & 0x6F != 0x27
}

fn third_bad_frame(sample: &Sample, _: usize, _: &AxisGuard) -> bool {
    sample.bad_in_row >= 3
}

fn link_low(sample: &Sample, axis: usize, guard: &AxisGuard) -> bool {
    sample.bus_v < guard.safety.bus_voltage_v[0] || out_of_operation(sample, axis, guard)
}

fn hot(sample: &Sample, axis: usize, guard: &AxisGuard) -> bool {
    sample.heat_sink_degc[axis] > guard.safety.max_heat_sink_degc
}

fn input_open(sample: &Sample, bit: u32) -> bool {
    sample.digital_inputs & 1 << bit != 0
}

/// Longest silence that the drives' watchdogs let pass, in frames of 250 µs, is 80.
const LOST_FRAMES: u32 = 20;
/// A current that drives the axis into a limit, A.
const STUCK_A: f64 = 8.0;

/// Every cause that is tried.
pub const CAUSES: &[Cause] = &[
    cause("operator stop", Braking::Torque, |_| Act::Order, Some(|s, _, _| s.ordered)),
    cause(
        "emergency stop",
        Braking::Friction,
        |_| Act::Fault(Fault::EmergencyStop { pressed: true }),
        Some(|s, _, _| input_open(s, 3)),
    ),
    cause(
        "safe torque off, one drive",
        Braking::Friction,
        |drive| Act::Fault(Fault::SafeTorqueOff { drive, active: true }),
        Some(out_of_operation),
    ),
    cause(
        "encoder fault",
        Braking::Friction,
        |drive| Act::Fault(Fault::Encoder { drive, fault: Some(EncoderFault::Error) }),
        Some(out_of_operation),
    ),
    hidden("encoder frozen", Braking::Friction, FROZEN_S, |drive| Act::Fault(Fault::EncoderFrozen { drive })),
    cause(
        "power stage fault",
        Braking::Friction,
        |drive| Act::Fault(Fault::Drive { drive, code: 0x2310 }),
        Some(out_of_operation),
    ),
    cause(
        "drive fault",
        Braking::Torque,
        |drive| Act::Fault(Fault::Drive { drive, code: 0xFF01 }),
        Some(out_of_operation),
    ),
    hidden("current stuck", Braking::Friction, FROZEN_S, |drive| {
        Act::Fault(Fault::CurrentStuck { drive, current_a: STUCK_A })
    }),
    cause(
        "bus silent",
        Braking::Torque,
        |_| Act::Fault(Fault::BusSilent { lasting: None }),
        Some(third_bad_frame),
    ),
    cause(
        "bus silent for 200 ms",
        Braking::Torque,
        |_| Act::Fault(Fault::BusSilent { lasting: Some(Duration::from_millis(200)) }),
        Some(third_bad_frame),
    ),
    cause(
        "frames lost",
        Braking::Torque,
        |_| Act::Fault(Fault::FramesLost { count: LOST_FRAMES }),
        Some(third_bad_frame),
    ),
    cause("gyro silent", Braking::Torque, |_| Act::Fault(Fault::ImuSilent), None),
    hidden("gyro frozen", Braking::Torque, FROZEN_S, |_| Act::Fault(Fault::ImuFrozen)),
    cause("gyro offset", Braking::Torque, |_| Act::Fault(Fault::GyroOffset { by_rad_per_s: 0.1 }), None),
    cause("supply lost", Braking::WhileItLasts, |_| Act::Fault(Fault::SupplyLost), Some(link_low)),
    cause("heat sink", Braking::Torque, |drive| Act::Fault(Fault::HeatSink { drive, degc: 84.5 }), Some(hot)),
    cause(
        "enabling switch released",
        Braking::Torque,
        |_| Act::Fault(Fault::EnablingSwitch { held: false }),
        Some(|s, _, _| !input_open(s, 16)),
    ),
];
