//! A slow stroke: what the encoder errs within the pitches of its scale.

use analysis::goodness::BY_SCATTER;
use analysis::pitch::pitch_error;

use super::RIPPLE;
use super::keys::{SLOW, Slow};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::inertial::{Samples, body_rates};
use crate::log::Window;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::Reason;

const ESTIMATOR: &str = "pitch-error/2";

/// Whether a point is such a stroke.
pub(super) fn passes_pitches(case: &Case) -> bool {
    case.segments.iter().any(|segment| segment.label == SLOW)
}

pub(super) fn analyse(keys: &Slow, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    match measured(keys, case, window, axes) {
        Ok(measurement) => PointResult { measurements: vec![measurement], ..PointResult::of(case) },
        Err(reason) => PointResult::without(case, &[(RIPPLE, Q::Angle)], ESTIMATOR, reason),
    }
}

fn measured(keys: &Slow, case: &Case, window: &Window, axes: &Axes) -> Result<Measurement, Reason> {
    let span = window.segment(case, SLOW)?;
    let samples = Samples::read(window, axes, span.start_s, span.end_s)?;
    let is_inner = axes.gimbal_index(&case.axis) == Some(1);
    let turned_rad = &samples.turned_rad[usize::from(is_inner)];
    let estimate =
        pitch_error(turned_rad, &about_axis(&samples, is_inner), samples.period_s, keys.pitches_per_rev)?;
    let mut measured = Measurement {
        point: Some(case.point.clone()),
        flags: samples.flags.clone(),
        excluded: samples.excluded.clone(),
        evidence: samples.evidence(),
        ..Measurement::new(RIPPLE, &case.axis, Q::Angle, Some(estimate), ESTIMATOR)
    };
    measured.flags.push(BY_SCATTER.to_owned());
    measured.set_angles(samples.passed_rad(usize::from(is_inner)));
    Ok(measured)
}

/// Rate about the axis by the gyros, over each sample but the first.
fn about_axis(samples: &Samples, is_inner: bool) -> Vec<f64> {
    let elevation = samples.elevation_rad();
    let along = |k: usize| {
        let [az, el] = if is_inner { [0.0, 1.0] } else { [1.0, 0.0] };
        let direction = body_rates(az, el, elevation[k - 1]);
        (0..3).map(|gyro| direction[gyro] * samples.rate_rad_per_s[gyro][k]).sum()
    };
    (1..samples.len()).map(along).collect()
}
