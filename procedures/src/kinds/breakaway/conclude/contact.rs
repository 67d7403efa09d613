//! Bristle stiffness and bending length from the starts of all ramps.

use analysis::dwell::mean;
use analysis::presliding::RampFit;
use analysis::uncertainty::{Component, combine, mean_of_repeats};

use super::ramps::RampCourse;
use super::{Conclusion, Findings, Q};
use crate::measurement::Measurement;

const ESTIMATOR: &str = "presliding-exponential/1";

/// What the ramps agree on.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    /// Bending length z_ss = T_∞/σ0, mean over the ramps, rad.
    pub(super) z_ss_rad: f64,
    /// Its relative standard uncertainty.
    pub(super) z_ss_u_ratio: f64,
    /// Ramps that it rests on.
    pub(super) count: usize,
}

impl Contact {
    /// The mean of the ramps' own z_ss; `None` if no ramp's fit converged.
    pub(super) fn of(ramps: &[RampCourse<'_>]) -> Option<Self> {
        let fits: Vec<&RampFit> = ramps.iter().filter_map(|r| r.fit.as_ref()).collect();
        Self::over(&fits)
    }

    /// The same over given fits.
    pub(super) fn over(fits: &[&RampFit]) -> Option<Self> {
        let each: Vec<f64> = fits.iter().map(|f| f.z_ss_rad()).collect();
        if each.is_empty() {
            return None;
        }
        let z_ss_rad = mean(&each);
        // Noise of each fit: stiffness and plateau move against each other, so their relative u add.
        let noise =
            fits.iter().map(|f| (f.sigma0_u / f.sigma0 + f.plateau_u_nm / f.plateau_nm).powi(2)).sum::<f64>();
        let z_ss_u_ratio = noise.sqrt() / fits.len() as f64;
        Some(Self { z_ss_rad, z_ss_u_ratio, count: fits.len() })
    }
}

/// Reports the stiffness, or why there is none.
pub(super) fn conclude(
    findings: &Findings<'_>,
    ramps: &[RampCourse<'_>],
    contact: Option<&Contact>,
    conclusion: &mut Conclusion,
) {
    if ramps.is_empty() {
        return;
    }
    let Some(contact) = contact else {
        let reasons = ramps.iter().find_map(|r| r.course.as_ref().err().cloned());
        let reason = reasons.unwrap_or_else(|| "the exponential fit converged for no ramp".to_owned());
        conclusion.measurements.push(findings.none("bristle-stiffness", Q::Stiffness, ESTIMATOR, reason));
        return;
    };
    conclusion.measurements.push(stiffness(findings, ramps));
    conclusion.remarks.push(format!(
        "Bending length z_ss = T_∞/σ0 = {:.5} mrad (mean of {} ramps); breakaway is judged between {:.3} and {:.3} mrad.",
        1e3 * contact.z_ss_rad,
        contact.count,
        3e3 * contact.z_ss_rad,
        8e3 * contact.z_ss_rad
    ));
}

/// The mean stiffness of all ramps with a fit, of which there is at least one.
fn stiffness(findings: &Findings<'_>, ramps: &[RampCourse<'_>]) -> Measurement {
    let fitted: Vec<(&RampCourse<'_>, &RampFit)> =
        ramps.iter().filter_map(|r| r.fit.as_ref().map(|f| (r, f))).collect();
    let values: Vec<f64> = fitted.iter().map(|(_, f)| f.sigma0).collect();
    let n = values.len();
    let noise = fitted.iter().map(|(_, f)| f.sigma0_u.powi(2)).sum::<f64>().sqrt() / n as f64;
    let scatter = mean_of_repeats(&values).map_or(Component::known(noise), |(_, c)| c);
    let value = mean(&values);
    let model = Component::known(value * model_ratio(&fitted) / 3.0_f64.sqrt());
    let spread = combine(&[scatter, model, findings.torque_constant(value)]);
    let mut measurement =
        findings.measurement("bristle-stiffness", Q::Stiffness, value, spread, n, ESTIMATOR);
    measurement.flags.push(format!("exponential fit on {n} ramps"));
    let missing = ramps.len() - n;
    if missing > 0 {
        measurement.flags.push(format!("{missing} ramps without a fit"));
    }
    measurement.evidence = fitted
        .iter()
        .filter_map(|(r, _)| r.course.as_ref().ok())
        .map(|c| findings.evidence(c.span_s))
        .collect();
    measurement
}

/// What the exponential leaves out (fall of friction with speed, renewal of the contact), relative: the plateau that
/// the fit tends to and the largest effort are two readings of one torque; their mean distance is taken as the half
/// width of a rectangular distribution.
fn model_ratio(fitted: &[(&RampCourse<'_>, &RampFit)]) -> f64 {
    let each: Vec<f64> = fitted
        .iter()
        .filter_map(|(r, f)| {
            let top = r.top_nm?;
            Some((f.plateau_nm / top - 1.0).abs())
        })
        .collect();
    if each.is_empty() { 0.0 } else { mean(&each) }
}
