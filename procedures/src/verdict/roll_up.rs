//! From judgements to one verdict for each requirement and one for the campaign.

use super::{Judgement, Outcome, Overall, Verdict, applies, judge};
use crate::campaign::Claim;
use crate::condition::{Meets, kind_of, same};
use crate::measurement::Measurement;
use crate::quantity::Limit;
use crate::requirement::{Requirement, Requirements, Take};

/// Every requirement's outcome over all procedures (id, measurements), in the order of the requirements file.
///
/// The worst verdict counts, and among equals the smallest margin relative to its limit (so that limits of different
/// quantities compare), and among those the first measured. A `must_measure` id without any judgement makes the
/// campaign incomplete; so does a campaign in which nothing at all was judged. A requirement of which a part was not
/// measured passes in no case: it is inconclusive unless what was measured fails. In a screening a requirement that was
/// not measured under all conditions that it claims has no verdict unless what was measured fails.
pub fn roll_up(
    requirements: &Requirements,
    procedures: &[(String, Vec<Measurement>)],
    must_measure: &[String],
    claim: Claim,
) -> (Vec<Outcome>, Overall) {
    let outcomes: Vec<Outcome> = requirements
        .all
        .iter()
        .map(|r| outcome(r, procedures, must_measure.contains(&r.id), claim))
        .collect();
    let unknown = must_measure.iter().any(|id| requirements.get(id).is_none());
    let missing = outcomes.iter().any(|o| o.required && o.judged == 0);
    let nothing = outcomes.iter().all(|o| o.judged == 0);
    let incomplete = (unknown || missing || nothing).then_some(Overall::Incomplete);
    let first_look = (claim == Claim::Screening).then_some(Overall::Screening);
    let worst = outcomes.iter().map(|o| overall(o.verdict)).chain(incomplete).chain(first_look).max();
    (outcomes, worst.unwrap_or(Overall::Incomplete))
}

fn outcome(
    requirement: &Requirement,
    procedures: &[(String, Vec<Measurement>)],
    required: bool,
    claim: Claim,
) -> Outcome {
    let Take::Worst = requirement.take;
    let mut worst: Option<(f64, &str, Judgement)> = None;
    let mut judged = 0;
    let mut seen = Vec::new();
    for (procedure, measurements) in procedures {
        for (index, measurement) in measurements.iter().enumerate() {
            if !applies(requirement, measurement) {
                continue;
            }
            let judgement = judge(measurement, index, requirement);
            let of = requirement.judged(&measurement.measurand);
            let limit = of.and_then(|j| j.limit_of(measurement));
            // Outside of every band and mask a measurement is told, and verifies nothing.
            if limit.is_some() || of.is_none_or(|j| !j.is_limited()) {
                judged += 1;
                seen.push(measurement);
            }
            let margin = relative_margin(&judgement, limit.as_deref());
            let counts = worst.as_ref().is_none_or(|(least, _, so_far)| {
                judgement.verdict > so_far.verdict
                    || judgement.verdict == so_far.verdict && margin.total_cmp(least).is_lt()
            });
            if counts {
                worst = Some((margin, procedure, judgement));
            }
        }
    }
    let measured = worst.as_ref().map_or(Verdict::None, |(_, _, judgement)| judgement.verdict);
    let [measurands, values, covers] =
        if judged > 0 { missing(requirement, &seen) } else { Default::default() };
    let is_screening = claim == Claim::Screening;
    let mut before_coverage = measured;
    if !measurands.is_empty() || !values.is_empty() && !is_screening {
        before_coverage = measured.max(Verdict::Inconclusive);
    }
    let is_covered = values.is_empty() && covers.is_empty();
    let verdict = match before_coverage {
        good if good <= Verdict::ConditionalPass && !is_covered && is_screening => Verdict::Screened,
        other if !is_covered && !is_screening => other.max(Verdict::Inconclusive),
        other => other,
    };
    let missing: Vec<String> = measurands.into_iter().chain(values).chain(covers).collect();
    Outcome {
        requirement: requirement.id.clone(),
        verdict,
        before_coverage,
        reason: (!missing.is_empty()).then(|| format!("not measured: {}", missing.join(", "))),
        decided_by: worst.map(|(_, procedure, judgement)| (procedure.to_owned(), judgement)),
        judged,
        required,
    }
}

/// What the requirement demands and nobody measured: measurands with a limit, values of conditions that it lists, axes and
/// stretches that it claims.
fn missing(requirement: &Requirement, seen: &[&Measurement]) -> [Vec<String>; 3] {
    let limited = requirement.judges.iter().filter(|j| j.is_limited());
    let unseen = limited.filter(|j| seen.iter().all(|m| m.measurand != j.measurand));
    let measurands = unseen.map(|j| j.measurand.clone()).collect();
    let mut values = Vec::new();
    for filter in &requirement.conditions {
        let Meets::OneOf { values: listed, .. } = &filter.meets else { continue };
        let is_measured = |value: f64| {
            let mut conditions = seen.iter().flat_map(|m| &m.conditions);
            conditions.any(|c| c.name == filter.condition && same(c.requested, value))
        };
        let kind = kind_of(&filter.condition);
        let text = |v: f64| kind.map_or_else(|| v.to_string(), |k| k.format(v));
        let left_out = listed.iter().filter(|v| !is_measured(**v));
        values.extend(left_out.map(|v| format!("{} {}", filter.condition, text(*v))));
    }
    [measurands, values, requirement.not_covered(seen)]
}

/// The margin over the size of the limit: half the width of a range, the bound's magnitude otherwise. Without a
/// margin +∞: whatever has one decides before it.
fn relative_margin(judgement: &Judgement, limit: Option<&Limit>) -> f64 {
    let Some((margin, limit)) = judgement.margin.zip(limit) else { return f64::INFINITY };
    let size = match (limit.low, limit.high) {
        (Some(low), Some(high)) => 0.5 * (high - low),
        (low, high) => low.or(high).map_or(1.0, f64::abs),
    };
    if size > 0.0 { margin / size } else { margin }
}

fn overall(verdict: Verdict) -> Overall {
    match verdict {
        Verdict::None | Verdict::Pass => Overall::Pass,
        Verdict::Screened => Overall::Screening,
        Verdict::ConditionalPass => Overall::ConditionalPass,
        Verdict::Inconclusive => Overall::Inconclusive,
        Verdict::ConditionalFail => Overall::ConditionalFail,
        Verdict::Fail => Overall::Fail,
    }
}
