//! Pose accuracy and repeatability of one axis, after ISO 9283:1998.

use super::{LEAST_RUNS, PositioningError, deviation};
use crate::estimate::Estimate;
use crate::uncertainty::{Component, combine};

/// Cycles that the standard asks for. Fewer are taken from [`LEAST_RUNS`] on; who reports them says how many there were.
pub const POSE_CYCLES: usize = 30;

/// One pose, reached again and again from the same side; rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Pose accuracy AP = |x̄ − command|.
    pub accuracy: Estimate,
    /// Pose repeatability RP = l̄ + 3·S_l with l = |x − x̄|.
    pub repeatability: Estimate,
}

/// Accuracy and repeatability of a pose from the deviations (actual less commanded place, rad) of its cycles.
///
/// `instrument_u_rad`: standard uncertainty of the instrument at this place; it shifts all cycles alike. The uncertainty of
/// RP follows from its parts: l̄ of n cycles, S_l like any standard deviation, s/√(2(n − 1)).
///
/// # Errors
/// Fewer than [`LEAST_RUNS`] cycles, or values that are no numbers.
pub fn pose(
    command_rad: f64,
    deviations_rad: &[f64],
    instrument_u_rad: f64,
) -> Result<Pose, PositioningError> {
    let n = deviations_rad.len();
    let target_deg = command_rad.to_degrees();
    if n < LEAST_RUNS {
        return Err(PositioningError::FewRuns { target_deg, way: "of a pose", found: n });
    }
    if deviations_rad.iter().any(|x| !x.is_finite()) {
        return Err(PositioningError::NotANumber { target_deg });
    }
    let (mean, spread) = deviation(deviations_rad);
    let distances: Vec<f64> = deviations_rad.iter().map(|x| (x - mean).abs()).collect();
    let (distance, distance_spread) = deviation(&distances);
    let count = n as f64;
    let dof = (n - 1) as f64;
    let of_mean = combine(&[Component { u: spread / count.sqrt(), dof }, Component::known(instrument_u_rad)]);
    let of_spread = distance_spread * (1.0 / count + 9.0 / (2.0 * dof)).sqrt();
    Ok(Pose {
        accuracy: Estimate { value: mean.abs(), u: of_mean.u, dof: of_mean.dof, n },
        repeatability: Estimate { value: distance + 3.0 * distance_spread, u: of_spread, dof, n },
    })
}
