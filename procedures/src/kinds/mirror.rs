//! The mirror by itself: impedance of its actuators, response of its servo.

use crate::axis::Axes;
use crate::device::MIRROR_AXES;
use crate::measurement::Conclusion;

pub(in crate::kinds) mod fsm_impedance;
pub(in crate::kinds) mod fsm_response;

/// A conclusion about the mirror whose measurements belong to the axes that it and the trackers look along: cross-elevation belongs to the outer axis,
/// elevation to the inner one.
pub(in crate::kinds) fn on_gimbal(mut conclusion: Conclusion, axes: &Axes) -> Conclusion {
    let Ok(gimbal) = axes.gimbal() else { return conclusion };
    for measurement in &mut conclusion.measurements {
        if let Some(index) = MIRROR_AXES.iter().position(|word| *word == measurement.axis) {
            gimbal.names()[index].clone_into(&mut measurement.axis);
        }
    }
    conclusion
}
