//! What happened to the safety of a procedure: trips, stops reached against computed, how the axes were left.

use procedures::log::{FinalState, StopRecord};
use serde::{Deserialize, Serialize};

/// Safety of one procedure. Angles rad, rates rad/s, times s, energies J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SafetyFindings {
    /// Worst cases as computed before anything moved; `None` where the log has no rig file to compute them from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub computed: Option<ComputedWorst>,
    /// Trips in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trips: Vec<TripFinding>,
    /// Stops.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stops: Vec<StopFinding>,
    /// How the axes were left after the last point.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left: Vec<FinalState>,
}

/// Worst cases of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComputedWorst {
    /// Largest angle of a stop.
    pub stop_angle_rad: f64,
    /// Longest time of a stop; `None` where friction stops the axis.
    pub stop_s: Option<f64>,
    /// Angle to the soft limit after the stop that ends nearest to one.
    pub room_rad: f64,
    /// Where the worst coast without torque ends; `None` where nothing moves.
    pub coast_to_rad: Option<f64>,
    /// Energy with which it meets the end of travel; `None` where it does not.
    pub impact_energy_j: Option<f64>,
    /// Speed of that contact.
    pub impact_rad_per_s: Option<f64>,
    /// What no software takes away, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub risks: Vec<String>,
}

/// A trip.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TripFinding {
    /// Point.
    pub point: String,
    /// Whether it was the first of its point: the cause, where the others may be consequences.
    pub first_out: bool,
    /// Interlock and what it saw, with numbers and limits.
    pub reason: String,
}

/// A stop of a point of this name: reached against computed.
pub type StopFinding = StopRecord<String>;

/// Something that the drives do not enforce in the mode that the bench uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NotEnforcedFinding {
    /// What, with its object.
    pub what: String,
    /// Interlocks of the bench that watch it instead.
    pub watched_by: String,
    /// Why the drives do not.
    pub why: String,
}

impl SafetyFindings {
    /// Makes every number finite. A stop with a number that is none counts as one that did not come to rest.
    pub(super) fn make_finite(&mut self) {
        for stop in &mut self.stops {
            let numbers = [
                &mut stop.from_rad,
                &mut stop.from_rad_per_s,
                &mut stop.computed_angle_rad,
                &mut stop.reached_angle_rad,
                &mut stop.took_s,
                &mut stop.to_rad,
                &mut stop.room_rad,
            ];
            let mut broken = stop.computed_s.is_some_and(|s| !s.is_finite());
            for number in numbers {
                if !number.is_finite() {
                    (*number, broken) = (0.0, true);
                }
            }
            stop.computed_s = stop.computed_s.filter(|s| s.is_finite());
            stop.standstill &= !broken;
        }
        self.left.retain(|l| l.position_rad.is_finite());
        for left in &mut self.left {
            left.swing_to_rad = left.swing_to_rad.filter(|v| v.is_finite());
            left.swing_rad_per_s = left.swing_rad_per_s.filter(|v| v.is_finite());
        }
        self.computed =
            self.computed.take().filter(|c| c.stop_angle_rad.is_finite() && c.room_rad.is_finite());
        if let Some(computed) = &mut self.computed {
            let numbers = [
                &mut computed.stop_s,
                &mut computed.coast_to_rad,
                &mut computed.impact_energy_j,
                &mut computed.impact_rad_per_s,
            ];
            numbers.into_iter().for_each(|number| *number = number.filter(|v| v.is_finite()));
        }
    }
}
