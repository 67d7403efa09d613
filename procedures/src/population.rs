//! What a population of units measures: how many pass, how values are spread, and which settings they depend on.
//!
//! Pure: from the readings of units to rows of a report. Units of independent draws give exact intervals of the pass probability
//! (Clopper and Pearson) and of quantiles (order statistics). Units of a design of several randomisations cover the settings more
//! evenly; what their results are uncertain by is told from how the randomisations differ. Methods: estimators.md §1.10.

pub use analysis::{copula, design, rank, truncated_normal};

use analysis::proportion::clopper_pearson;
use analysis::quantile::{quantile, quantile_interval};
use serde::Serialize;

use crate::quantity::QuantityKind;
use crate::verdict::Verdict;

mod sensitivity;
#[cfg(test)]
mod tests;

pub use sensitivity::Sensitivity;

/// Level of the intervals of pass probabilities and quantiles.
pub const LEVEL: f64 = 0.95;
/// Shares of the units that lie below the quantiles of a report.
pub const SHARES: [f64; 3] = [0.05, 0.5, 0.95];

/// What one unit of a population came to.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredUnit {
    /// Id of the unit.
    pub id: String,
    /// The randomisation that it belongs to, from 0; 0 for independent draws.
    pub set: usize,
    /// Settings that were drawn, by their keys, SI.
    pub settings_si: Vec<(String, f64)>,
    /// What was judged on it.
    pub readings: Vec<Reading>,
}

/// The value of a measurand that decided a requirement.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Id of the requirement.
    pub requirement: String,
    /// Measurand.
    pub measurand: String,
    /// Kind of quantity of its value.
    pub kind: QuantityKind,
    /// Value, SI; `None` where the measurement is inconclusive.
    pub value_si: Option<f64>,
    /// Verdict on this value.
    pub verdict: Verdict,
}

/// How the units were chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "draws")]
pub enum Draws {
    /// Each on its own.
    Independent,
    /// So many sets of points, each randomised on its own.
    Randomised {
        /// Sets.
        sets: usize,
    },
}

/// A requirement and one of its measurands over all units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Id of the requirement.
    pub requirement: String,
    /// Measurand.
    pub measurand: String,
    /// Kind of quantity of the values.
    pub kind: QuantityKind,
    /// Units on which it was judged.
    pub units: usize,
    /// Of these, units that pass, with or without condition.
    pub passes: usize,
    /// Of these, units without a conclusive verdict. They do not count as passes.
    pub inconclusive: usize,
    /// Pass probability.
    pub pass: Estimated,
    /// Quantiles of the values, for each of [`SHARES`]; empty where no unit has a value.
    pub quantiles: Vec<Quantile>,
    /// Settings on which the values depend, the strongest first.
    pub sensitivities: Vec<Sensitivity>,
    /// Settings that were looked at.
    pub settings_tested: usize,
}

/// An estimate with what its uncertainty is told by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimated {
    /// The estimate, SI.
    pub value: f64,
    /// Interval of [`LEVEL`] for independent draws; an end beyond the sample is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[Option<f64>; 2]>,
    /// Standard uncertainty, from the scatter over randomisations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
}

/// A quantile of the values of a measurand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantile {
    /// Share of the units that lies below it.
    pub share: f64,
    /// Its value.
    #[serde(flatten)]
    pub estimated: Estimated,
}

/// Every requirement and measurand that any of the units was judged by, in the order in which they come first.
pub fn evaluate(units: &[MeasuredUnit], draws: Draws) -> Vec<Row> {
    let mut names: Vec<&Reading> = Vec::new();
    for reading in units.iter().flat_map(|unit| &unit.readings) {
        if !names.iter().any(|name| is_same(name, reading)) {
            names.push(reading);
        }
    }
    names.into_iter().map(|name| row(units, draws, name)).collect()
}

fn is_same(a: &Reading, b: &Reading) -> bool {
    a.requirement == b.requirement && a.measurand == b.measurand
}

/// A unit with its reading of one requirement and measurand; one whose run ended before has none, and does not pass.
#[derive(Clone, Copy)]
struct Judged<'a> {
    unit: &'a MeasuredUnit,
    reading: Option<&'a Reading>,
}

impl Judged<'_> {
    fn passes(&self) -> bool {
        self.reading.is_some_and(|own| matches!(own.verdict, Verdict::Pass | Verdict::ConditionalPass))
    }

    fn value_si(&self) -> Option<f64> {
        self.reading?.value_si
    }

    fn is_conclusive(&self) -> bool {
        let fails = |own: &Reading| matches!(own.verdict, Verdict::Fail | Verdict::ConditionalFail);
        self.passes() || self.reading.is_some_and(fails)
    }
}

fn row(units: &[MeasuredUnit], draws: Draws, name: &Reading) -> Row {
    let judged: Vec<Judged<'_>> = units
        .iter()
        .map(|unit| Judged { unit, reading: unit.readings.iter().find(|reading| is_same(name, reading)) })
        .collect();
    let (sensitivities, settings_tested) = sensitivity::of_values(&judged, draws);
    Row {
        requirement: name.requirement.clone(),
        measurand: name.measurand.clone(),
        kind: name.kind,
        units: judged.len(),
        passes: judged.iter().filter(|one| one.passes()).count(),
        inconclusive: judged.iter().filter(|one| !one.is_conclusive()).count(),
        pass: pass(&judged, draws),
        quantiles: SHARES.into_iter().filter_map(|share| quantile_of(&judged, draws, share)).collect(),
        sensitivities,
        settings_tested,
    }
}

fn share_of_passes(judged: &[Judged<'_>]) -> Option<f64> {
    let passes = judged.iter().filter(|one| one.passes()).count();
    (!judged.is_empty()).then(|| passes as f64 / judged.len() as f64)
}

fn pass(judged: &[Judged<'_>], draws: Draws) -> Estimated {
    let value = share_of_passes(judged).unwrap_or(0.0);
    match draws {
        Draws::Independent => {
            let passes = judged.iter().filter(|one| one.passes()).count() as u64;
            let interval = clopper_pearson(passes, judged.len() as u64, LEVEL).ok();
            Estimated { value, interval: interval.map(|ends| ends.map(Some)), u: None }
        }
        Draws::Randomised { sets } => {
            Estimated { value, interval: None, u: scatter(judged, sets, share_of_passes) }
        }
    }
}

fn values_of(judged: &[Judged<'_>]) -> Vec<f64> {
    let mut values: Vec<f64> = judged.iter().filter_map(Judged::value_si).collect();
    values.sort_by(f64::total_cmp);
    values
}

fn quantile_of(judged: &[Judged<'_>], draws: Draws, share: f64) -> Option<Quantile> {
    let values = values_of(judged);
    let value = quantile(&values, share)?;
    let estimated = match draws {
        Draws::Independent => {
            Estimated { value, interval: Some(quantile_interval(&values, share, LEVEL)), u: None }
        }
        Draws::Randomised { sets } => {
            let of_set = |set: &[Judged<'_>]| quantile(&values_of(set), share);
            Estimated { value, interval: None, u: scatter(judged, sets, of_set) }
        }
    };
    Some(Quantile { share, estimated })
}

/// Standard uncertainty of a mean over randomisations; `None` where fewer than two of them have a value.
fn scatter(
    judged: &[Judged<'_>],
    sets: usize,
    estimate: impl Fn(&[Judged<'_>]) -> Option<f64>,
) -> Option<f64> {
    let values: Vec<f64> = (0..sets).filter_map(|set| estimate(&in_set(judged, set))).collect();
    standard_error(&values)
}

fn in_set<'a>(judged: &[Judged<'a>], set: usize) -> Vec<Judged<'a>> {
    judged.iter().copied().filter(|one| one.unit.set == set).collect()
}

/// Standard deviation of the mean of independent values; `None` of fewer than two.
fn standard_error(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((squares / (count - 1.0) / count).sqrt())
}
