//! Measurements of a point from its modes.

use analysis::estimate::Estimate;
use analysis::modal::Mode;

use super::expected::{Expected, Place};
use super::fit::{Fitted, participation};
use super::responses::SENSORS;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind as Q;

pub(super) const DAMPING: &str = "mode-damping";
pub(super) const PARTICIPATION: &str = "mode-participation";
pub(super) const ESTIMATOR: &str = "modes/1";
/// Cost over degrees of freedom up to which the model describes the lines.
const GOOD_MISFIT: f64 = 3.0;

/// What the expected modes of a point measure.
pub(super) fn measurements(
    axis: &str,
    expected: &[Expected],
    fitted: &Fitted,
    elevation_rad: f64,
) -> Vec<Measurement> {
    let mut all = Vec::new();
    for (e, pair) in expected.iter().zip(&fitted.pairs) {
        match pair {
            Some(k) => {
                all.push(frequency(axis, e, fitted, *k, elevation_rad));
                all.push(damping(axis, e, fitted, *k));
                all.push(share(axis, e, fitted, *k));
            }
            None => all.push(not_visible(axis, e, elevation_rad)),
        }
    }
    all
}

/// Why an expected mode has no frequency.
pub(super) fn not_visible(axis: &str, e: &Expected, elevation_rad: f64) -> Measurement {
    let [low, high] = e.range_hz(elevation_rad);
    let place = if low == high { format!("{low:.1} Hz") } else { format!("{low} Hz .. {high} Hz") };
    let reason = format!("mode {} not visible: none found near {place} whose residue exceeds 4 u", e.mode);
    Measurement::inconclusive(e.measurand(), axis, e.kind(), ESTIMATOR, reason)
}

fn estimate(fitted: &Fitted, value: f64, u: f64) -> Estimate {
    let n = fitted.modal.fit.dof / 2;
    Estimate { value, u, dof: fitted.modal.fit.dof as f64, n }
}

fn frequency(axis: &str, e: &Expected, fitted: &Fitted, k: usize, elevation_rad: f64) -> Measurement {
    let mode = &fitted.modal.modes[k];
    let scale_hz = match e.place {
        Place::Curve(_) => e.range_hz(elevation_rad)[0],
        Place::Band(_) => 1.0,
    };
    let value = match e.place {
        Place::Curve(_) => mode.frequency_hz / scale_hz - 1.0,
        Place::Band(_) => mode.frequency_hz,
    };
    let measured = estimate(fitted, value, mode.frequency_u_hz / scale_hz);
    let mut flags = vec![format!("found at {:.3} Hz", mode.frequency_hz)];
    if matches!(e.place, Place::Curve(_)) {
        flags.push(format!("expected at {scale_hz:.2} Hz"));
    }
    let misfit = fitted.modal.fit.misfit_ratio();
    if misfit > GOOD_MISFIT {
        flags.push(format!("fit misses the lines by {:.1} times their noise, u widened", misfit.sqrt()));
    }
    Measurement { flags, ..Measurement::new(e.measurand(), axis, e.kind(), Some(measured), ESTIMATOR) }
}

fn named(e: &Expected, mode: &Mode) -> String {
    format!("mode {} at {:.2} Hz", e.mode, mode.frequency_hz)
}

fn damping(axis: &str, e: &Expected, fitted: &Fitted, k: usize) -> Measurement {
    let mode = &fitted.modal.modes[k];
    let measurement = match &mode.damping {
        Ok(d) => {
            let measured = estimate(fitted, d.ratio, d.u);
            Measurement::new(DAMPING, axis, Q::Ratio, Some(measured), ESTIMATOR)
        }
        Err(reason) => Measurement::inconclusive(DAMPING, axis, Q::Ratio, ESTIMATOR, reason.to_string()),
    };
    Measurement { flags: vec![named(e, mode)], ..measurement }
}

fn share(axis: &str, e: &Expected, fitted: &Fitted, k: usize) -> Measurement {
    let [gyro, encoder] = [0, 1].map(|sensor| participation(&fitted.modal, k, sensor, fitted.apart));
    let measured = estimate(fitted, gyro.value, gyro.u);
    let other = format!("{} {:.4}, u {:.4}", SENSORS[1], encoder.value, encoder.u);
    Measurement {
        flags: vec![named(e, &fitted.modal.modes[k]), other],
        ..Measurement::new(PARTICIPATION, axis, Q::Ratio, Some(measured), ESTIMATOR)
    }
}
