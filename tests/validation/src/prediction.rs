//! What the bench will find on a unit, from its settings: every requirement that the unit decides, by closed formula or
//! linear model, and by a short simulation where there is no formula.
//!
//! Nothing here knows of defects: a prediction reads the settings that the simulation obeys. The uncertainties are those
//! that the measurement will have (expanded, k = 2), named where they are used: rows of the estimators' acceptance
//! table, or the instrument.

mod atmosphere;
mod drivetrain;
mod duty;
mod friction;
mod imu;
mod loops;
mod mirror;
mod motion;
mod polarity;
mod position;
pub mod rig_limits;
mod servo;
mod structure;
mod tracking;

use controllers::{AxisGains, DirectorGains};
use sim_devices::unit::{AxisSettings, StructureSettings, UnitSettings};

pub(crate) use friction::cogging_peak_nm;
pub use loops::{TRACK_HZ, TRACK_PERIOD_S, VELOCITY_HZ};
pub use mirror::{
    MODES_HZ as MIRROR_MODES_HZ, open_loop as mirror_open_loop, optical_gain_departure,
    stroke_rad as mirror_stroke_rad,
};
pub use polarity::{bus, polarity};
pub(crate) use position::encoder_error_rad;
pub use servo::LOOP_RATE_HZ;
pub use structure::ANALYSED_HZ;

/// One figure that a measurement is expected to give.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Id of the requirement whose limit it is compared with.
    pub requirement: &'static str,
    /// 0 azimuth, 1 elevation; `None` where it belongs to no axis.
    pub axis: Option<usize>,
    /// What it is, e.g. `acceleration`.
    pub quantity: &'static str,
    /// Where or how, e.g. `elevation 80 deg`; may be empty.
    pub condition: String,
    /// Value, SI. Not a number where the unit is in no state to be measured, e.g. a loop that swings.
    pub value_si: f64,
    /// Expanded uncertainty (k = 2) that the measurement will have, SI.
    pub uncertainty_si: f64,
}

/// Elevations at which loops are measured, in degrees: the nodes of the study's tables.
const ELEVATIONS_DEG: [f64; 11] = [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0];

/// Everything that the settings of a unit decide.
pub fn predict(unit: &UnitSettings, gains: &DirectorGains) -> Vec<Expected> {
    let subject = Subject { unit, gains };
    [
        motion::rows,
        duty::rows,
        friction::rows,
        position::rows,
        imu::rows,
        structure::rows,
        loops::rows,
        mirror::rows,
        atmosphere::rows,
        tracking::rows,
    ]
    .iter()
    .flat_map(|rows| rows(&subject))
    .collect()
}

/// A unit and the gains of its production controllers.
struct Subject<'a> {
    unit: &'a UnitSettings,
    gains: &'a DirectorGains,
}

impl Subject<'_> {
    fn axis(&self, axis: usize) -> &AxisSettings {
        self.unit.axis(axis)
    }

    fn structure(&self, axis: usize) -> &StructureSettings {
        [&self.unit.az_structure, &self.unit.el_structure][axis]
    }

    fn gains(&self, axis: usize) -> &AxisGains {
        [&self.gains.az, &self.gains.el][axis]
    }
}

/// Torque that a motor gives over what its drive believes: measured torques are true ones over this.
fn torque_ratio(axis: &AxisSettings) -> f64 {
    axis.torque_constant_nm_per_a * axis.rated_current_a / axis.rated_torque_nm
}

/// A row of one requirement.
fn row(
    requirement: &'static str,
    axis: impl Into<Option<usize>>,
    quantity: &'static str,
    condition: impl Into<String>,
    value_si: f64,
    uncertainty_si: f64,
) -> Expected {
    Expected {
        requirement,
        axis: axis.into(),
        quantity,
        condition: condition.into(),
        value_si,
        uncertainty_si,
    }
}

#[cfg(test)]
mod tests;
