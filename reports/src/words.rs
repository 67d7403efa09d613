//! Verdicts as words and symbols, and the statement of conformity.
//!
//! A verdict is always a word and a symbol; colour is a third hint, never the only one.

use procedures::verdict::{Overall, Verdict};

use crate::record::{DecisionRule, Findings, Origin, Results};
use crate::row;

/// How a verdict is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sign {
    pub(crate) word: &'static str,
    pub(crate) symbol: &'static str,
    /// Class in the style sheet.
    pub(crate) class: &'static str,
}

const fn sign(word: &'static str, symbol: &'static str, class: &'static str) -> Sign {
    Sign { word, symbol, class }
}

/// Every verdict in the order of a summary.
pub(crate) const VERDICTS: [Verdict; 6] = [
    Verdict::Fail,
    Verdict::ConditionalFail,
    Verdict::Inconclusive,
    Verdict::ConditionalPass,
    Verdict::Pass,
    Verdict::None,
];

/// The sign of a verdict.
pub(crate) fn verdict(verdict: Verdict) -> Sign {
    match verdict {
        Verdict::None => sign("no verdict", "–", "none"),
        Verdict::Pass => sign("pass", "✓", "pass"),
        Verdict::ConditionalPass => sign("conditional pass", "(✓)", "conditional"),
        Verdict::Inconclusive => sign("inconclusive", "?", "inconclusive"),
        Verdict::ConditionalFail => sign("conditional fail", "(✗)", "fail"),
        Verdict::Fail => sign("fail", "✗", "fail"),
    }
}

/// The sign of a whole campaign.
pub(crate) fn overall(overall: Overall) -> Sign {
    match overall {
        Overall::Pass => sign("PASS", "✓", "pass"),
        Overall::ConditionalPass => sign("CONDITIONAL PASS", "(✓)", "conditional"),
        Overall::Incomplete => sign("INCOMPLETE", "…", "inconclusive"),
        Overall::Inconclusive => sign("INCONCLUSIVE", "?", "inconclusive"),
        Overall::ConditionalFail => sign("CONDITIONAL FAIL", "(✗)", "fail"),
        Overall::Fail => sign("FAIL", "✗", "fail"),
    }
}

/// How a stop compares with what was computed for it.
pub(crate) fn against_computed(exceeds: bool) -> Sign {
    if exceeds { sign("EXCEEDED", "✗", "fail") } else { sign("within", "✓", "pass") }
}

/// The word that stands on every page unless all devices were real.
pub(crate) fn watermark(origin: Origin) -> Option<&'static str> {
    match origin {
        Origin::Real => None,
        Origin::Mixed => Some("PARTLY SIMULATED"),
        Origin::Simulated => Some("SIMULATED"),
        Origin::Imported => Some("IMPORTED RECORD"),
    }
}

/// `8 pass`, `1 fail`, …: how many requirements came to which verdict, the worst first; none left out.
pub(crate) fn tally(findings: &Findings) -> Vec<(Sign, usize)> {
    let measured = |v: Verdict| findings.outcomes.iter().filter(|o| o.judged > 0 && o.verdict == v).count();
    let mut counts: Vec<(Sign, usize)> = VERDICTS.iter().map(|&v| (verdict(v), measured(v))).collect();
    let unmeasured = findings.outcomes.iter().filter(|o| o.judged == 0).count();
    let without_outcome = findings.requirements.iter().filter(|r| findings.outcome(&r.id).is_none()).count();
    let named_only: usize = row::named_only(findings).iter().map(|(_, ids)| ids.len()).sum();
    let missing = unmeasured + without_outcome + named_only;
    counts.push((sign("not measured", "–", "none"), missing));
    counts.retain(|(_, n)| *n > 0);
    counts
}

/// Ids of the requirements with this verdict that were measured.
pub(crate) fn ids(findings: &Findings, verdict: Verdict) -> Vec<&str> {
    let of_verdict = findings.outcomes.iter().filter(|o| o.verdict == verdict && o.judged > 0);
    of_verdict.map(|o| o.requirement.as_str()).collect()
}

/// Required ids without a measurement.
pub(crate) fn missing(findings: &Findings) -> Vec<&str> {
    let unmeasured = findings.outcomes.iter().filter(|o| o.required && o.judged == 0);
    unmeasured.map(|o| o.requirement.as_str()).collect()
}

/// What the report is called.
pub(crate) fn heading(results: &Results) -> String {
    let findings = &results.findings;
    let partial = if findings.campaign.partial { "PARTIAL " } else { "" };
    format!("{partial}Test report: {}", findings.campaign.title)
}

/// The statement of conformity, one sentence for each decision rule in use, generated from the requirements that
/// were judged.
pub(crate) fn statement(findings: &Findings) -> Vec<String> {
    let mut sentences = Vec::new();
    for rule in [DecisionRule::GuardedU, DecisionRule::GuardedNinetyFive, DecisionRule::Simple] {
        let ids: Vec<&str> = findings
            .requirements
            .iter()
            .filter(|r| r.judges.iter().any(|j| j.rule == rule && j.is_limited()))
            .filter(|r| findings.outcome(&r.id).is_some_and(|o| o.judged > 0))
            .map(|r| r.id.as_str())
            .collect();
        if !ids.is_empty() {
            sentences.push(format!("Decision rule for {}: {}.", ids.join(", "), rule.statement()));
        }
    }
    if sentences.is_empty() {
        sentences.push("No conformity is stated: no requirement with a limit was judged.".to_owned());
    }
    if let Some(word) = watermark(findings.origin) {
        sentences.push(format!("{word}: this report is no evidence of the conformity of a real unit."));
    }
    sentences.push("Results relate only to the item tested.".to_owned());
    sentences
}
