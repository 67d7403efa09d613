//! What a campaign covers: requirements that were measured, declared, or neither, and why.

use procedures::verdict::Verdict;

use crate::record::{Findings, Status};

/// Requirements by how they are covered; ids in the order of the requirements file. Every one stands in one list.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Coverage<'a> {
    /// With a statement of conformity or of a shortfall.
    pub(crate) judged: Vec<&'a str>,
    /// Looked at in part, without a shortfall.
    pub(crate) screened: Vec<&'a str>,
    /// Without a statement: a number is missing, in doubt, or not known well enough.
    pub(crate) inconclusive: Vec<&'a str>,
    /// Measured without a limit.
    pub(crate) reported: Vec<&'a str>,
    /// Shown by analysis, inspection or demonstration: evidence is named.
    pub(crate) declared: Vec<&'a str>,
    /// The campaign must measure it and did not.
    pub(crate) missing: Vec<&'a str>,
    /// Not in this campaign.
    pub(crate) elsewhere: Vec<&'a str>,
    /// No kind of experiment measures it yet.
    pub(crate) without_kind: Vec<&'a str>,
}

impl<'a> Coverage<'a> {
    /// Of all requirements that the findings know, those included that they only name.
    pub(crate) fn of(findings: &'a Findings) -> Self {
        let mut coverage = Self::default();
        for requirement in &findings.requirements {
            let id = requirement.id.as_str();
            let measured = findings.outcome(id).filter(|o| o.judged > 0).map(|o| o.verdict);
            let list = match () {
                () if measured == Some(Verdict::Screened) => &mut coverage.screened,
                () if measured == Some(Verdict::Inconclusive) => &mut coverage.inconclusive,
                () if measured == Some(Verdict::None) => &mut coverage.reported,
                () if measured.is_some() => &mut coverage.judged,
                () if requirement.evidence.is_some() => &mut coverage.declared,
                () if requirement.required => &mut coverage.missing,
                () if findings.no_kind_measures_it_yet.iter().any(|n| n == id) => &mut coverage.without_kind,
                () => &mut coverage.elsewhere,
            };
            list.push(id);
        }
        let named = |ids: &'a [String]| ids.iter().filter(|id| findings.requirement(id).is_none());
        coverage.elsewhere.extend(named(&findings.not_in_this_campaign).map(String::as_str));
        coverage.without_kind.extend(named(&findings.no_kind_measures_it_yet).map(String::as_str));
        coverage
    }

    /// How many were neither measured nor declared.
    pub(crate) fn unmeasured(&self) -> usize {
        self.missing.len() + self.elsewhere.len() + self.without_kind.len()
    }

    /// How many there are.
    pub(crate) fn all(&self) -> usize {
        let measured = [&self.judged, &self.screened, &self.inconclusive, &self.reported].map(Vec::len);
        measured.iter().sum::<usize>() + self.declared.len() + self.unmeasured()
    }
}

/// How many procedures and points there are, and how many of them completed.
pub(crate) fn completed(findings: &Findings) -> [[usize; 2]; 2] {
    let procedures = &findings.procedures;
    let points = || procedures.iter().flat_map(|p| &p.points);
    let whole = |status: Status| status == Status::Completed;
    [
        [procedures.iter().filter(|p| whole(p.status)).count(), procedures.len()],
        [points().filter(|p| whole(p.status)).count(), points().count()],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn every_requirement_is_covered_in_one_way() {
        let mut results = sample::results();
        let declared = &mut results.findings.requirements[7];
        declared.evidence = Some("drawing 17, sheet 3".to_owned());
        let coverage = Coverage::of(&results.findings);
        assert_eq!((coverage.judged.len(), coverage.inconclusive.len()), (5, 1));
        assert_eq!((coverage.screened.len(), coverage.reported.len()), (0, 0));
        assert_eq!(coverage.declared, ["POS-ACC"]);
        assert_eq!(coverage.missing, ["SPR-EL"]);
        assert_eq!(coverage.without_kind, ["FSM-BW", "STR-XAX"]);
        assert_eq!((coverage.elsewhere.len(), coverage.all()), (0, 10));
    }

    /// "Measured 47 of 47" once counted what has no number.
    #[test]
    fn what_was_screened_or_only_reported_is_not_judged() {
        let mut results = sample::results();
        let before = Coverage::of(&results.findings).judged.len();
        let measured: Vec<usize> = (0..results.findings.outcomes.len())
            .filter(|&k| results.findings.outcomes[k].judged > 0)
            .collect();
        results.findings.outcomes[measured[0]].verdict = Verdict::Screened;
        results.findings.outcomes[measured[1]].verdict = Verdict::None;
        let ids = [0, 1].map(|k| results.findings.outcomes[measured[k]].requirement.clone());
        let coverage = Coverage::of(&results.findings);
        assert_eq!(coverage.screened, [ids[0].as_str()]);
        assert_eq!(coverage.reported, [ids[1].as_str()]);
        assert_eq!(coverage.judged.len(), before - 2);
        assert_eq!(coverage.all(), 10);
    }

    #[test]
    fn points_that_did_not_complete_are_counted() {
        assert_eq!(completed(&sample::results().findings), [[2, 2], [4, 5]]);
    }
}
