//! From judgements to one verdict for each requirement and one for the campaign.

use super::{Judgement, Outcome, Overall, Verdict, applies, judge};
use crate::measurement::Measurement;
use crate::quantity::Limit;
use crate::requirement::{Requirement, Requirements, Take};

/// Every requirement's outcome over all procedures (id, measurements), in the order of the requirements file.
///
/// The worst verdict counts, and among equals the smallest margin relative to its limit (so that limits of different
/// quantities compare), and among those the first measured. A `must_measure` id without any judgement makes the
/// campaign incomplete; so does a campaign in which nothing at all was judged.
pub fn roll_up(
    requirements: &Requirements,
    procedures: &[(String, Vec<Measurement>)],
    must_measure: &[String],
) -> (Vec<Outcome>, Overall) {
    let outcomes: Vec<Outcome> =
        requirements.all.iter().map(|r| outcome(r, procedures, must_measure.contains(&r.id))).collect();
    let unknown = must_measure.iter().any(|id| requirements.get(id).is_none());
    let missing = outcomes.iter().any(|o| o.required && o.judged == 0);
    let nothing = outcomes.iter().all(|o| o.judged == 0);
    let incomplete = (unknown || missing || nothing).then_some(Overall::Incomplete);
    let worst = outcomes.iter().map(|o| overall(o.verdict)).chain(incomplete).max();
    (outcomes, worst.unwrap_or(Overall::Incomplete))
}

fn outcome(requirement: &Requirement, procedures: &[(String, Vec<Measurement>)], required: bool) -> Outcome {
    let Take::Worst = requirement.take;
    let mut worst: Option<(f64, &str, Judgement)> = None;
    let mut judged = 0;
    for (procedure, measurements) in procedures {
        for (index, measurement) in measurements.iter().enumerate() {
            if !applies(requirement, measurement) {
                continue;
            }
            judged += 1;
            let judgement = judge(measurement, index, requirement);
            let limit = requirement.judged(&measurement.measurand).and_then(|j| j.limit.as_ref());
            let margin = relative_margin(&judgement, limit);
            let counts = worst.as_ref().is_none_or(|(least, _, so_far)| {
                judgement.verdict > so_far.verdict
                    || judgement.verdict == so_far.verdict && margin.total_cmp(least).is_lt()
            });
            if counts {
                worst = Some((margin, procedure, judgement));
            }
        }
    }
    Outcome {
        requirement: requirement.id.clone(),
        verdict: worst.as_ref().map_or(Verdict::None, |(_, _, judgement)| judgement.verdict),
        decided_by: worst.map(|(_, procedure, judgement)| (procedure.to_owned(), judgement)),
        judged,
        required,
    }
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
        Verdict::ConditionalPass => Overall::ConditionalPass,
        Verdict::Inconclusive => Overall::Inconclusive,
        Verdict::ConditionalFail => Overall::ConditionalFail,
        Verdict::Fail => Overall::Fail,
    }
}
