//! What a person should know of an excitation before it runs.

use analysis::excitation::{Law, Sweep, expected_peak_error};

use super::course::Course;
use super::keys::{Excited, Form};
use crate::axis::Axes;
use crate::kinds::position::positioned::Elevation;
use crate::quantity::QuantityKind as Q;

/// Damping of the lightest modes of the structure.
const LIGHT_DAMPING: f64 = 0.03;

/// Background, windows and cogging for each level, and what a sweep's rate would do to a tracking filter.
pub(in crate::kinds) fn notes(keys: &Excited, axis: &str, axes: &Axes) -> Vec<String> {
    let Some(limits) = axes.get(axis) else { return Vec::new() };
    let mut all = Vec::new();
    for &level_v in &keys.levels_v {
        let middle = match Elevation::of(axis, axes).is_own() {
            true => keys.elevations_rad.first().copied().unwrap_or(0.0),
            false => keys.background.middle_rad,
        };
        let Ok(course) = Course::new(keys, limits, middle, level_v) else { continue };
        let level = Q::Voltage.format(level_v);
        let window = Q::Time.format(course.window_s);
        if course.velocity_rad_per_s == 0.0 {
            all.push(format!("{level}: from rest, windows of {window}"));
            continue;
        }
        let cogging: Vec<String> = course.cogging_hz(limits).iter().map(|hz| format!("{hz:.2}")).collect();
        if keys.background.target_turn_s.is_some() {
            all.push(format!(
                "{level}: follows a target that sweeps by {} about its middle, {:.1} s from turn to turn",
                Q::Angle.format(0.5 * (course.ends_rad[1] - course.ends_rad[0])),
                course.stroke_s
            ));
        }
        all.push(format!(
            "{level}: slides at {:.3} rad/s, windows of {window}; cogging at {} Hz, no lines within 0.3 Hz of it",
            course.velocity_rad_per_s,
            cogging.join(", ")
        ));
        all.extend((keys.form == Form::Sweep).then(|| sweep(keys, &course)));
    }
    all
}

/// ISO 7626-2 against the sweep where it is worst, at its lowest frequency, and what that does here.
fn sweep(keys: &Excited, course: &Course) -> String {
    let [from_hz, to_hz] = keys.band_hz;
    let duration_s = course.window_s;
    let law = Law::Logarithmic;
    let amplitude = 1.0;
    let sweep = Sweep { from_hz, to_hz, duration_s, law, amplitude };
    let lowest_hz = from_hz.min(to_hz);
    let eta = sweep.eta(LIGHT_DAMPING, lowest_hz);
    let verdict = match sweep.within_iso_limit(LIGHT_DAMPING, lowest_hz) {
        true => "within",
        false => "faster than",
    };
    let error = match expected_peak_error(eta) {
        Some(ratio) => format!("{:+.1} %", 100.0 * ratio),
        None => "more than -10 %".to_owned(),
    };
    format!(
        "sweep of {lowest_hz:.1} Hz at damping {LIGHT_DAMPING}: {verdict} ISO 7626-2 (eta {eta:.2}); a tracking filter \
         would read its peak {error} wrong, whole windows are evaluated instead"
    )
}
