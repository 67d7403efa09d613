//! From judgements to one verdict for each requirement and one for the campaign.

use super::{Judgement, MeasurandOutcome, Outcome, Overall, Verdict, applies, judge};
use crate::campaign::Claim;
use crate::condition::{Meets, kind_of, same};
use crate::measurement::Measurement;
use crate::requirement::{Band, Requirement, Requirements, Take};

/// Every requirement's outcome over all procedures (id, measurements), in the order of the requirements file.
///
/// The worst verdict counts, and among equals the smallest distance to the guard band over the expanded uncertainty (so that limits
/// of different quantities compare; the largest magnitude where nothing limits it), and among those the first measured. A `must_measure` id without any judgement makes the
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
    let mut all: Vec<Judged<'_>> = Vec::new();
    let mut seen = Vec::new();
    for (procedure, measurements) in procedures {
        for (index, measurement) in measurements.iter().enumerate() {
            if !applies(requirement, measurement) {
                continue;
            }
            let judgement = judge(measurement, index, requirement);
            let judged = requirement.judged(&measurement.measurand);
            // Outside of every band and mask a measurement is told, and verifies nothing.
            let is_limited = judged.is_some_and(|j| j.limit_of(measurement).is_some());
            let counts = is_limited || judged.is_none_or(|j| !j.is_limited());
            if counts {
                seen.push(measurement);
            }
            all.push(Judged { procedure, measurement, judgement, counts });
        }
    }
    let judged = seen.len();
    let worst = worst_of(all.iter());
    let measured = worst.map_or(Verdict::None, |worst| worst.judgement.verdict);
    let [measurands, values, covers] =
        if judged > 0 { missing(requirement, &seen) } else { Default::default() };
    let is_screening = claim == Claim::Screening;
    let mut before_coverage = measured;
    if !measurands.is_empty() || !values.is_empty() && !is_screening {
        before_coverage = measured.max(Verdict::Inconclusive);
    }
    let is_covered = values.is_empty() && covers.is_empty();
    let verdict = covered(before_coverage, is_covered, is_screening);
    let own_verdict = |verdict| covered(verdict, is_covered, is_screening);
    let missing: Vec<String> = measurands.into_iter().chain(values).chain(covers).collect();
    Outcome {
        requirement: requirement.id.clone(),
        verdict,
        before_coverage,
        reason: (!missing.is_empty()).then(|| format!("not measured: {}", missing.join(", "))),
        decided_by: worst.map(Judged::decided_by),
        by_measurand: by_limit(requirement, &all, own_verdict),
        judged,
        required,
    }
}

/// The same for each limit: that of each measurand, and those of its bands. `covered` is what coverage leaves of a verdict.
fn by_limit(
    requirement: &Requirement,
    all: &[Judged<'_>],
    covered: impl Fn(Verdict) -> Verdict,
) -> Vec<MeasurandOutcome> {
    let limits = requirement.judges.iter().flat_map(|judged| {
        let bands = judged.bands.iter().map(Some);
        std::iter::once(None).chain(bands).map(move |band| (judged, band))
    });
    let outcome = |(judged, band): (&crate::requirement::Judged, Option<&Band>)| {
        let is_own = |m: &Measurement| m.measurand == judged.measurand && judged.band_of(m) == band;
        let own = || all.iter().filter(|j| is_own(j.measurement));
        let worst = worst_of(own())?;
        Some(MeasurandOutcome {
            measurand: judged.measurand.clone(),
            band: band.map(Band::text),
            // What nothing limits has no verdict to lose.
            verdict: match worst.judgement.verdict {
                Verdict::None => Verdict::None,
                limited => covered(limited),
            },
            decided_by: worst.decided_by(),
            judged: own().filter(|j| j.counts).count(),
        })
    };
    limits.filter_map(outcome).collect()
}

/// A measurement that a requirement judges.
#[derive(Debug)]
struct Judged<'a> {
    procedure: &'a str,
    measurement: &'a Measurement,
    judgement: Judgement,
    /// Whether it verifies anything.
    counts: bool,
}

impl Judged<'_> {
    fn decided_by(&self) -> (String, Judgement) {
        (self.procedure.to_owned(), self.judgement.clone())
    }

    /// Distance to the guard band in expanded uncertainties, then the margin; the smaller, the worse. What nothing limits is
    /// worse the larger it is; what has no value decides after all others of its verdict.
    fn rank(&self) -> [f64; 2] {
        let Judgement { margin, guard_band, expanded_u, .. } = self.judgement;
        let value = self.measurement.value;
        match margin {
            Some(margin) if expanded_u > 0.0 => [(margin - guard_band) / expanded_u, margin],
            Some(margin) => [f64::INFINITY.copysign(margin), margin],
            None => value.map_or([f64::INFINITY; 2], |value| [-value.abs(); 2]),
        }
    }
}

/// The one that decides; of equals the first.
fn worst_of<'j, 'a: 'j>(all: impl Iterator<Item = &'j Judged<'a>>) -> Option<&'j Judged<'a>> {
    let worse = |a: &Judged<'_>, b: &Judged<'_>| {
        let [a_rank, b_rank] = [a.rank(), b.rank()];
        let by_rank = a_rank[0].total_cmp(&b_rank[0]).then(a_rank[1].total_cmp(&b_rank[1]));
        b.judgement.verdict.cmp(&a.judgement.verdict).then(by_rank)
    };
    all.min_by(|a, b| worse(a, b))
}

/// The verdict that is left where not all was measured that the requirement claims.
fn covered(measured: Verdict, is_covered: bool, is_screening: bool) -> Verdict {
    match measured {
        good if good <= Verdict::ConditionalPass && !is_covered && is_screening => Verdict::Screened,
        other if !is_covered && !is_screening => other.max(Verdict::Inconclusive),
        other => other,
    }
}

/// What the requirement demands and nobody measured: measurands with a limit, values of conditions that it lists (asked for and
/// reached), and, as coverage, limits of bands, axes and stretches that it claims.
fn missing(requirement: &Requirement, seen: &[&Measurement]) -> [Vec<String>; 3] {
    let limited = requirement.judges.iter().filter(|j| j.is_limited());
    let unseen = limited.filter(|j| seen.iter().all(|m| m.measurand != j.measurand));
    let measurands = unseen.map(|j| j.measurand.clone()).collect();
    let mut values = Vec::new();
    for filter in &requirement.conditions {
        let Meets::OneOf { values: listed, .. } = &filter.meets else { continue };
        let is_measured = |value: f64| {
            let mut conditions = seen.iter().flat_map(|m| &m.conditions);
            conditions.any(|c| c.name == filter.condition && same(c.requested, value) && c.is_as_requested())
        };
        let kind = kind_of(&filter.condition);
        let text = |v: f64| kind.map_or_else(|| v.to_string(), |k| k.format(v));
        let left_out = listed.iter().filter(|v| !is_measured(**v));
        values.extend(left_out.map(|v| format!("{} {}", filter.condition, text(*v))));
    }
    let limits = requirement.judges.iter().flat_map(|judged| unmeasured_limits(judged, seen));
    [measurands, values, limits.chain(requirement.not_covered(seen)).collect()]
}

/// Limits of a measurand that has several, by none of which anything was judged; nothing of a measurand that was not measured at all.
fn unmeasured_limits(judged: &crate::requirement::Judged, seen: &[&Measurement]) -> Vec<String> {
    let own: Vec<Option<&Band>> =
        seen.iter().filter(|m| m.measurand == judged.measurand).map(|m| judged.band_of(m)).collect();
    if own.is_empty() || judged.bands.is_empty() {
        return Vec::new();
    }
    let base = judged.limit.as_ref().filter(|_| !own.contains(&None)).map(|limit| limit.text.clone());
    let bands = judged.bands.iter().filter(|band| !own.contains(&Some(band))).map(Band::text);
    base.into_iter().chain(bands).map(|limit| format!("{} {limit}", judged.measurand)).collect()
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
