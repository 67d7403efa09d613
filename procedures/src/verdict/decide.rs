//! One measurement against one limit, with coverage factor and tail probability from Student's t.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::{Judgement, LEAST_DOF, Verdict};
use crate::measurement::{Bound, Measurement};
use crate::quantity::{Limit, QuantityKind};
use crate::requirement::{Band, Requirement, Rule};

/// Probability below +k of a standard normal at k = 2 (report.md §3): U covers 95.45 % two-sided.
const COVERAGE: f64 = 0.97725;

/// Coverage factor k = t(0.97725, ν): 2.00 at ν = ∞ (`None`), 2.32 at 9, 2.87 at 4. Fewer than one degree of freedom
/// count as one (no verdict is given there anyhow).
pub fn coverage_factor(dof: Option<f64>) -> f64 {
    match student(dof) {
        Some(student) => student.inverse_cdf(COVERAGE),
        None => normal().inverse_cdf(COVERAGE),
    }
}

/// P(T > z) with ν degrees of freedom.
fn upper_tail(z: f64, dof: Option<f64>) -> f64 {
    /// Far beyond every tail that a double holds; the distributions do not take infinities or their squares.
    const FAR: f64 = 1e100;
    if z.is_nan() || z.abs() > FAR {
        return f64::from(u8::from(z < 0.0));
    }
    match student(dof) {
        Some(student) => student.sf(z),
        None => normal().sf(z),
    }
}

/// P(|T| > z) with ν degrees of freedom, of `z` ≥ 0.
pub(crate) fn two_sided_tail(z: f64, dof: Option<f64>) -> f64 {
    (2.0 * upper_tail(z, dof)).min(1.0)
}

/// `None` stands for infinitely many degrees of freedom.
fn student(dof: Option<f64>) -> Option<StudentsT> {
    /// From here on t and normal agree to 1e-6 in k, and the incomplete beta function loses digits.
    const NORMAL_FROM: f64 = 1e6;
    let dof =
        dof.map(|dof| if dof.is_nan() { 1.0 } else { dof.max(1.0) }).filter(|dof| *dof < NORMAL_FROM)?;
    StudentsT::new(0.0, 1.0, dof).ok()
}

fn normal() -> Normal {
    Normal::standard()
}

/// Holds one measurement against one requirement, by what the requirement says about its measurand. A measurement
/// that the requirement does not judge (see [`super::applies`]) gets [`Verdict::None`].
pub fn judge(measurement: &Measurement, index: usize, requirement: &Requirement) -> Judgement {
    let k = coverage_factor(measurement.dof);
    let blank = Judgement {
        requirement: requirement.id.clone(),
        measurement: index,
        k,
        expanded_u: k * measurement.u,
        guard_band: 0.0,
        acceptance: [None, None],
        margin: None,
        probability_outside: None,
        verdict: Verdict::None,
        goal_met: None,
        limit: None,
        band: None,
        reason: None,
    };
    let Some(judged) = requirement.judged(&measurement.measurand) else { return blank };
    let limit = judged.limit_of(measurement);
    let guarded = match &limit {
        Some(limit) => guarded(blank, measurement.u, limit, judged.rule),
        None => blank,
    };
    let special = limit.as_deref().filter(|limit| judged.limit.as_ref() != Some(limit));
    let band = judged.band_of(measurement).map(Band::text);
    let guarded = Judgement { limit: special.cloned(), band, ..guarded };
    match usable(measurement, limit.as_deref()) {
        Ok(value) => {
            let goal_met = judged.goal.as_ref().map(|goal| goal.holds(value));
            let held = match &limit {
                Some(limit) => against(guarded, value, measurement, limit),
                None => guarded,
            };
            Judgement { goal_met, ..held }
        }
        // A report-only requirement stays without verdict even where the measurement has no value.
        Err(reason) => {
            let verdict = if limit.is_some() { Verdict::Inconclusive } else { Verdict::None };
            Judgement { verdict, reason: Some(reason.to_string()), ..guarded }
        }
    }
}

/// Why no verdict can rest on a measurement.
#[derive(Debug, thiserror::Error)]
enum Unusable {
    /// The measurement says why itself.
    #[error("{0}")]
    Inconclusive(String),
    #[error("there is no value")]
    NoValue,
    #[error("the measurement is {}, but the limit is not", kind.noun())]
    WrongKind { kind: QuantityKind },
    #[error("the value is not a finite number")]
    ValueNotFinite,
    #[error("the uncertainty is not known")]
    NoUncertainty,
    #[error("{dof:.1} effective degrees of freedom, at least {LEAST_DOF} are needed")]
    FewDegrees { dof: f64 },
}

/// The value, or why no verdict can rest on this measurement.
fn usable(measurement: &Measurement, limit: Option<&Limit>) -> Result<f64, Unusable> {
    if let Some(reason) = &measurement.inconclusive {
        return Err(Unusable::Inconclusive(reason.clone()));
    }
    let value = measurement.value.ok_or(Unusable::NoValue)?;
    if limit.is_some_and(|limit| limit.kind != measurement.kind) {
        return Err(Unusable::WrongKind { kind: measurement.kind });
    }
    if !value.is_finite() {
        return Err(Unusable::ValueNotFinite);
    }
    if !measurement.u.is_finite() || measurement.u < 0.0 {
        return Err(Unusable::NoUncertainty);
    }
    match measurement.dof {
        Some(dof) if dof.is_nan() || dof < LEAST_DOF => Err(Unusable::FewDegrees { dof }),
        _ => Ok(value),
    }
}

/// Guard band and acceptance limits, known before any value is.
fn guarded(blank: Judgement, u: f64, limit: &Limit, rule: Rule) -> Judgement {
    let guard_band = match rule {
        Rule::Simple => 0.0,
        Rule::GuardedNinetyFive => 1.65 * u,
        Rule::GuardedU => blank.expanded_u,
    };
    let acceptance = [limit.low.map(|low| low + guard_band), limit.high.map(|high| high - guard_band)];
    Judgement { guard_band, acceptance, ..blank }
}

/// Margin, risk and verdict of a value.
fn against(guarded: Judgement, value: f64, measurement: &Measurement, limit: &Limit) -> Judgement {
    let margin = margin(limit, value);
    let verdict = verdict(limit, value, guarded.acceptance, margin, guarded.guard_band);
    let passes = matches!(verdict, Verdict::Pass | Verdict::ConditionalPass);
    let doubt = measurement.doubt.as_deref().filter(|_| passes);
    let undecided = measurement.bound.as_ref().filter(|bound| !decides(bound, value, limit, passes));
    let reason = undecided.map(|bound| format!("the value is a bound, {}", bound.reason()));
    let reason = reason.or_else(|| doubt.map(str::to_owned));
    let outside = probability_outside(limit, value, measurement.u, measurement.dof);
    Judgement {
        margin: Some(margin),
        probability_outside: undecided.is_none().then_some(outside),
        verdict: if reason.is_some() { Verdict::Inconclusive } else { verdict },
        reason,
        ..guarded
    }
}

/// Whether what holds for a value holds for every truth on its side: beyond it no limit may follow that would be missed (of a
/// value inside) or met (of a value outside).
fn decides(bound: &Bound, value: f64, limit: &Limit, passes: bool) -> bool {
    let (ahead, lies_beyond) = match bound {
        Bound::AtLeast(_) => (limit.high, limit.high.is_some_and(|high| value >= high)),
        Bound::AtMost(_) => (limit.low, limit.low.is_some_and(|low| value <= low)),
    };
    if passes { ahead.is_none() } else { lies_beyond }
}

/// Distance to the nearest bound, positive inside.
fn margin(limit: &Limit, value: f64) -> f64 {
    let below = limit.high.map_or(f64::INFINITY, |high| high - value);
    let above = limit.low.map_or(f64::INFINITY, |low| value - low);
    below.min(above)
}

/// Pass inside the acceptance limits, conditional pass between those and the limit, conditional fail outside the
/// limit by less than the guard band, otherwise fail. A simple rule has no band and so no conditionals.
fn verdict(limit: &Limit, value: f64, acceptance: [Option<f64>; 2], margin: f64, guard_band: f64) -> Verdict {
    if limit.holds_with(value, acceptance[0], acceptance[1]) {
        Verdict::Pass
    } else if limit.holds(value) {
        Verdict::ConditionalPass
    } else if -margin < guard_band {
        Verdict::ConditionalFail
    } else {
        Verdict::Fail
    }
}

/// Probability that the true value lies outside, for a value with standard uncertainty u and no prior knowledge
/// (JCGM 106:2012, with Student's t in place of the normal).
fn probability_outside(limit: &Limit, value: f64, u: f64, dof: Option<f64>) -> f64 {
    let tail = |distance: f64| {
        if u > 0.0 { upper_tail(distance / u, dof) } else { f64::from(u8::from(distance < 0.0)) }
    };
    let above = limit.high.map_or(0.0, |high| tail(high - value));
    let below = limit.low.map_or(0.0, |low| tail(value - low));
    (above + below).min(1.0)
}
