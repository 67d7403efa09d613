//! One axis of a rig: what planning may know, what the interlocks rely on, what its drive is told and does not enforce.

use drivers::cia402::DriveSettings;
use procedures::axis::AxisLimits;

use super::safety::Safety;
use super::stopping::StopModel;

/// Where a velocity loop takes its rate from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityFeedback {
    /// The drive's own velocity, from the encoder.
    Encoder,
    /// The inertial unit on the frame of the inner axis.
    Gyro,
}

/// One axis of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct RigAxis {
    /// Name in procedures, requirements and logs, e.g. `az`.
    pub name: String,
    /// Name of the axis on which this one is mounted; `None` for an axis that stands on the ground.
    pub carried_by: Option<String>,
    /// Section of the parameters file with its gains.
    pub gains: String,
    /// What planning and judging may know.
    pub limits: AxisLimits,
    /// What the interlocks rely on.
    pub guard: AxisGuard,
    /// What the drive is told and checked against.
    pub drive: DriveSettings,
    /// Serial number that the drive must have; `None` takes any.
    pub serial: Option<u32>,
    /// Where the velocity loop takes its rate from.
    pub velocity_feedback: VelocityFeedback,
}

/// Limits of one axis that the interlocks rely on, SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisGuard {
    /// What the rig file says about its safety.
    pub safety: Safety,
    /// How it stops, and where it must.
    pub stop: StopModel,
    /// Torque that the drive may show.
    pub max_torque_nm: f64,
    /// Angle of one encoder count.
    pub encoder_quantum_rad: f64,
    /// Largest torque that the loads have anywhere in the travel.
    pub worst_load_nm: f64,
    /// Bit of 60FDh of the first drive that is 1 while the emergency stop chain is open; `None` without a wire.
    pub emergency_stop_bit: Option<u32>,
    /// Bit of 60FDh of the first drive that is 1 while the enabling switch is held; `None` without one.
    pub enabling_switch_bit: Option<u32>,
    /// Whether the drive tells the temperature of its heat sink.
    pub watches_heat_sink: bool,
}

/// A stop is never computed with less than this share of the deceleration in the rig file.
const LEAST_DECELERATION_SHARE: f64 = 0.05;

impl AxisGuard {
    /// Deceleration that this torque gives against the worst of the loads, at the most that of the rig file. Friction
    /// helps, but nobody vouches for it.
    pub fn deceleration_with_rad_per_s2(&self, torque_nm: f64) -> f64 {
        let stated = self.stop.deceleration_rad_per_s2;
        let given = (torque_nm - self.worst_load_nm) / self.stop.inertia_kg_m2;
        given.max(LEAST_DECELERATION_SHARE * stated).min(stated)
    }

    /// From now on stops are computed with what this torque gives.
    pub fn rely_on(&mut self, torque_nm: f64) {
        self.stop.deceleration_rad_per_s2 = self.deceleration_with_rad_per_s2(torque_nm);
    }
}

/// Something that a drive does not enforce in cyclic synchronous torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotEnforced {
    /// What, with its object.
    pub what: &'static str,
    /// Why the drive does not.
    pub why: &'static str,
    /// Interlocks of the bench that watch it instead.
    pub watched_by: &'static str,
}

/// What a CiA 402 drive does not enforce in CST (torque mode): there only the bench watches.
pub const NOT_ENFORCED: &[NotEnforced] = &[
    NotEnforced {
        what: "soft limits (607Dh)",
        why: "CST has no position demand to limit; the drive only reports them (bit 11 of the statusword)",
        watched_by: "position, braking curve",
    },
    NotEnforced {
        what: "following error (6065h, 6066h)",
        why: "CST has no position demand to follow; its supervision is switched off",
        watched_by: "following error",
    },
    NotEnforced {
        what: "acceleration",
        why: "CST has no acceleration limit: torque acts at once, up to 6072h",
        watched_by: "acceleration, runaway",
    },
    NotEnforced {
        what: "halt (bit 8 of the controlword)",
        why: "not used: a stop is a deceleration under control, then quick stop (605Ah)",
        watched_by: "drive state",
    },
];
