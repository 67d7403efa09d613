//! From samples to calls.

use std::collections::{BTreeMap, BTreeSet};

use analysis::estimate::Estimate;
use analysis::family_wise::holm;
use analysis::paired;

use super::decision::{Arm, Call, Decision, LostPass, Outcome, Undecided, UnitShift};
use super::sample::{CriterionSamples, Reading, RegressionError, Sample, check};
use super::{Criteria, Criterion, Look, Scale, Worse};

/// Largest probability that any criterion of the blocking family blocks though no mean shift is above zero.
pub const FAMILY_LEVEL: f64 = 0.05;
/// Shifts below this share of the values are rounding.
const ROUNDING: f64 = 1e-9;

/// Calls every criterion, and the comparison.
///
/// With the interval [L, H] of the mean shift over units, + worse, at the level of the look: identical where all shifts are below
/// 1e-9 of the values; equivalent where −margin ≤ L and H ≤ margin; otherwise worse where L > 0, better where H < 0, and
/// otherwise inconclusive.
///
/// A worse criterion blocks only where its one-sided p, adjusted by Holm over all blocking criteria and multiplied by the number of
/// looks, is below [`FAMILY_LEVEL`]: so the probability of any false block stays below it over the whole comparison. A worse
/// one that is not upheld stays called worse, does not block, and leaves the comparison inconclusive.
///
/// # Errors
/// All that is wrong with the samples at once: see [`RegressionError`].
pub fn decide(
    criteria: &Criteria,
    samples: &[CriterionSamples],
    look: Look,
) -> Result<Decision, Vec<RegressionError>> {
    let errors = check(criteria, samples, look);
    if !errors.is_empty() {
        return Err(errors);
    }
    let level = look.level();
    let judged = |criterion: &Criterion| {
        let own = samples.iter().find(|own| own.is_of(criterion));
        outcome(criterion, own.map_or(&[], |own| own.samples.as_slice()), level)
    };
    let mut outcomes: Vec<Outcome> = criteria.all.iter().map(judged).collect();
    let looks = match look {
        Look::Single => 1,
        Look::Sequential { .. } => criteria.looks.len(),
    };
    uphold(&mut outcomes, looks);
    Ok(Decision { look, level, call: Decision::call_of(&outcomes), outcomes })
}

/// A sample with values in both arms.
struct Pair<'s> {
    sample: &'s Sample,
    baseline: f64,
    candidate: f64,
}

/// Pairs of each unit, by seed.
type Units<'s> = BTreeMap<u32, Vec<Pair<'s>>>;

fn units_of(samples: &[Sample]) -> Units<'_> {
    let mut units: Units<'_> = BTreeMap::new();
    for sample in samples {
        if let (Some(baseline), Some(candidate)) = (sample.baseline.value, sample.candidate.value) {
            units.entry(sample.unit).or_default().push(Pair { sample, baseline, candidate });
        }
    }
    for pairs in units.values_mut() {
        pairs.sort_by_key(|pair| pair.sample.seed);
    }
    units
}

fn outcome(criterion: &Criterion, samples: &[Sample], level: f64) -> Outcome {
    let units = units_of(samples);
    let bare = Outcome {
        criterion: criterion.clone(),
        call: Call::Inconclusive,
        blocks: false,
        differs: false,
        why: None,
        units: units.len(),
        left_out: samples.len() - units.values().map(Vec::len).sum::<usize>(),
        baseline: arm(&units, |sample| sample.baseline),
        candidate: arm(&units, |sample| sample.candidate),
        shift: None,
        interval: None,
        scatter: None,
        p: None,
        adjusted_p: None,
        units_needed: None,
        shifts: Vec::new(),
        lost: lost(samples),
    };
    let shifts = match shifts(criterion, &units) {
        Ok(shifts) => shifts,
        Err(why) => return Outcome { why: Some(why), ..bare },
    };
    let means: Vec<f64> = shifts.iter().map(|unit| unit.shift).collect();
    let bare = Outcome { shift: average(&means), shifts, ..bare };
    let outcome = match paired::mean(&means) {
        Ok(mean) => called(bare, &mean, level, is_identical(criterion, &units)),
        Err(_) => Outcome { why: Some(Undecided::FewUnits { units: means.len() }), ..bare },
    };
    let paired = samples.len() - outcome.left_out;
    match candidate_without(samples) {
        // The few that are left may be the good ones.
        0 if outcome.call != Call::Worse && 2 * outcome.left_out > samples.len() && paired > 1 => {
            let why = Some(Undecided::MostLeftOut { units: paired, of: samples.len() });
            Outcome { call: Call::Inconclusive, why, units_needed: None, ..outcome }
        }
        0 => outcome,
        // Units that were left out may be the worst ones: nothing but a shift that is worse without them is known.
        _ if outcome.call == Call::Worse => outcome,
        units => {
            let why = Some(Undecided::CandidateWithout { units });
            Outcome { call: Call::Inconclusive, why, units_needed: None, ..outcome }
        }
    }
}

/// Units on which the baseline has a value and the candidate none, with any seed.
fn candidate_without(samples: &[Sample]) -> usize {
    let without = samples.iter().filter(|s| s.baseline.value.is_some() && s.candidate.value.is_none());
    without.map(|sample| sample.unit).collect::<BTreeSet<u32>>().len()
}

/// The call by the interval of the mean shift.
fn called(bare: Outcome, mean: &Estimate, level: f64, is_identical: bool) -> Outcome {
    let margin = bare.criterion.margin;
    let [low, high] = paired::interval(mean, level);
    let call = if is_identical {
        Call::Identical
    } else if -margin <= low && high <= margin {
        Call::Equivalent
    } else if low > 0.0 {
        Call::Worse
    } else if high < 0.0 {
        Call::Better
    } else {
        Call::Inconclusive
    };
    let is_wide = call == Call::Inconclusive;
    Outcome {
        call,
        differs: !is_identical && (low > 0.0 || high < 0.0),
        why: is_wide.then_some(Undecided::Wide),
        interval: Some([low, high]),
        scatter: Some(paired::scatter(mean)),
        p: Some(if is_identical { 1.0 } else { paired::p_not_above(mean, 0.0) }),
        units_needed: if is_wide { units_needed(mean, margin, level) } else { None },
        ..bare
    }
}

/// Settles which worse criteria block, in the family of all blocking criteria.
fn uphold(outcomes: &mut [Outcome], looks: usize) {
    let mut family: Vec<&mut Outcome> =
        outcomes.iter_mut().filter(|outcome| outcome.criterion.blocking).collect();
    // A criterion without a p belongs to the family all the same.
    let p_values: Vec<f64> = family.iter().map(|outcome| outcome.p.unwrap_or(1.0)).collect();
    let tests = (p_values.len() * looks) as f64;
    for (outcome, adjusted) in family.iter_mut().zip(holm(&p_values)) {
        let adjusted_p = (adjusted * looks as f64).min(1.0);
        outcome.adjusted_p = outcome.p.map(|_| adjusted_p);
        outcome.blocks = outcome.call == Call::Worse && adjusted_p < FAMILY_LEVEL;
        if outcome.call == Call::Worse && !outcome.blocks {
            outcome.why = Some(Undecided::NotUpheld { adjusted_p, level: FAMILY_LEVEL });
            // As the first of its family it would be upheld at this level.
            let shifts: Vec<f64> = outcome.shifts.iter().map(|unit| unit.shift).collect();
            let level = 1.0 - 2.0 * FAMILY_LEVEL / tests;
            outcome.units_needed =
                paired::mean(&shifts).ok().and_then(|mean| units_needed(&mean, 0.0, level));
        }
    }
}

/// How many units more would decide, if mean and scatter stayed as they are; at least one.
fn units_needed(mean: &Estimate, margin: f64, level: f64) -> Option<u64> {
    let pairs = paired::pairs_to_decide(mean, margin, level)?;
    Some(pairs.saturating_sub(mean.n as u64).max(1))
}

/// Shift of every unit, or the first one that has none.
fn shifts(criterion: &Criterion, units: &Units<'_>) -> Result<Vec<UnitShift>, Undecided> {
    let mut all = Vec::with_capacity(units.len());
    for (&unit, pairs) in units {
        let shifts: Result<Vec<f64>, Undecided> = pairs.iter().map(|pair| shift(criterion, pair)).collect();
        if let Some(shift) = average(&shifts?) {
            all.push(UnitShift { unit, shift });
        }
    }
    Ok(all)
}

/// Shift of one pair, + is worse.
fn shift(criterion: &Criterion, pair: &Pair<'_>) -> Result<f64, Undecided> {
    let Pair { sample, baseline, candidate } = *pair;
    let shift =
        match criterion.scale {
            Scale::Difference => candidate - baseline,
            Scale::LogRatio => paired::log_ratio(baseline, candidate)
                .map_err(|_| Undecided::NotPositive { unit: sample.unit, baseline, candidate })?,
        };
    Ok(match criterion.worse {
        Worse::Higher => shift,
        // Less zero is zero, not −0.
        Worse::Lower => 0.0 - shift,
    })
}

/// Whether every pair has the same value in both arms, up to rounding.
fn is_identical(criterion: &Criterion, units: &Units<'_>) -> bool {
    let pairs = || units.values().flatten();
    let values = pairs().flat_map(|pair| [pair.baseline, pair.candidate]);
    let scale = match criterion.scale {
        Scale::Difference => values.map(f64::abs).fold(criterion.margin, f64::max),
        Scale::LogRatio => 1.0,
    };
    pairs().all(|pair| shift(criterion, pair).is_ok_and(|shift| shift.abs() < ROUNDING * scale))
}

/// One arm over all units.
fn arm(units: &Units<'_>, reading: impl Fn(&Sample) -> Reading) -> Option<Arm> {
    let value = |pair: &Pair<'_>| reading(pair.sample).value;
    let of_unit = |pairs: &Vec<Pair<'_>>| average(&pairs.iter().filter_map(value).collect::<Vec<f64>>());
    let means: Vec<f64> = units.values().filter_map(of_unit).collect();
    let squares: Vec<f64> = units.values().flatten().map(|pair| reading(pair.sample).u.powi(2)).collect();
    let passed = units.values().filter(|pairs| pairs.iter().all(|pair| reading(pair.sample).passes)).count();
    Some(Arm { mean: average(&means)?, u: average(&squares)?.sqrt(), passed })
}

/// Units that pass with the baseline and not with the candidate, with any seed.
fn lost(samples: &[Sample]) -> Vec<LostPass> {
    let mut units: BTreeMap<u32, Vec<u64>> = BTreeMap::new();
    for sample in samples.iter().filter(|sample| sample.baseline.passes && !sample.candidate.passes) {
        units.entry(sample.unit).or_default().push(sample.seed);
    }
    let lost = |(unit, mut seeds): (u32, Vec<u64>)| {
        seeds.sort_unstable();
        LostPass { unit, seeds }
    };
    units.into_iter().map(lost).collect()
}

/// Arithmetic mean; `None` of nothing.
fn average(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
