//! Verdicts as words and symbols, and the statement of conformity.
//!
//! A verdict is always a word and a symbol; colour is a third hint, never the only one.

use procedures::verdict::{Overall, Verdict};

use crate::coverage::Coverage;
use crate::record::{DecisionRule, EvidenceState, Findings, Origin, Results, StopFinding};

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
pub(crate) const VERDICTS: [Verdict; 7] = [
    Verdict::Fail,
    Verdict::ConditionalFail,
    Verdict::Inconclusive,
    Verdict::ConditionalPass,
    Verdict::Pass,
    Verdict::Screened,
    Verdict::None,
];

/// The sign of a verdict.
pub(crate) fn verdict(verdict: Verdict) -> Sign {
    match verdict {
        Verdict::None => sign("no verdict", "–", "none"),
        Verdict::Screened => sign("screened", "◌", "none"),
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
        Overall::Screening => sign("SCREENING", "◌", "none"),
        Overall::Incomplete => sign("INCOMPLETE", "…", "inconclusive"),
        Overall::Inconclusive => sign("INCONCLUSIVE", "?", "inconclusive"),
        Overall::ConditionalFail => sign("CONDITIONAL FAIL", "(✗)", "fail"),
        Overall::Fail => sign("FAIL", "✗", "fail"),
    }
}

/// How a stop compares with what was computed for it. One that ended beyond the travel is none, however short it was.
pub(crate) fn against_computed(stop: &StopFinding) -> Sign {
    if stop.left_the_travel() {
        sign("LEFT THE TRAVEL", "✗", "fail")
    } else if stop.exceeds() {
        sign("EXCEEDED", "✗", "fail")
    } else {
        sign("within", "✓", "pass")
    }
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
    let coverage = Coverage::of(findings);
    counts.push((sign("declared", "–", "none"), coverage.declared.len()));
    counts.push((sign("not measured", "–", "none"), coverage.unmeasured()));
    counts.retain(|(_, n)| *n > 0);
    counts
}

/// What a first look without a shortfall says and does not say; `None` for every other outcome.
pub fn screening(findings: &Findings) -> Option<String> {
    if findings.overall != Overall::Screening {
        return None;
    }
    let count = |verdicts: &[Verdict]| {
        findings.outcomes.iter().filter(|o| o.judged > 0 && verdicts.contains(&o.verdict)).count()
    };
    let verified = count(&[Verdict::Pass, Verdict::ConditionalPass]);
    let in_part = count(&[Verdict::Screened]);
    Some(format!("no shortfall found; {verified} verified, {in_part} covered in part; not an acceptance"))
}

/// The state of the evidence on one line.
pub(crate) fn evidence(results: &Results) -> String {
    results.evidence.as_ref().map_or_else(|| "not checked".to_owned(), |found| found.sentence())
}

/// What stands on every page of a report whose evidence was found altered.
pub(crate) fn evidence_mark(results: &Results) -> Option<&'static str> {
    let altered = results.evidence.as_ref().is_some_and(|e| e.state == EvidenceState::Altered);
    altered.then_some("EVIDENCE ALTERED")
}

/// What the report is called.
pub(crate) fn heading(results: &Results) -> String {
    let findings = &results.findings;
    let partial = if findings.campaign.partial { "PARTIAL " } else { "" };
    format!("{partial}Test report: {}", findings.campaign.title)
}

/// The statement of conformity, one sentence for each decision rule in use, generated from the requirements that
/// were judged. The rule of the most is said last, for all others.
pub(crate) fn statement(findings: &Findings) -> Vec<String> {
    let all = [DecisionRule::GuardedU, DecisionRule::GuardedNinetyFive, DecisionRule::Simple];
    let mut by_rule: Vec<(DecisionRule, Vec<&str>)> =
        all.map(|rule| (rule, judged_by(findings, rule))).into();
    by_rule.retain(|(_, ids)| !ids.is_empty());
    // The sort is stable: among equals the order above.
    by_rule.sort_by_key(|(_, ids)| ids.len());
    let most = by_rule.len().saturating_sub(1);
    let mut sentences: Vec<String> = by_rule
        .iter()
        .enumerate()
        .map(|(i, (rule, ids))| {
            let whom = match (i == most, most) {
                (true, 0) if ids.len() > 1 => format!("all {} requirements judged", ids.len()),
                (true, 1..) if ids.len() > 1 => format!("the other {} requirements judged", ids.len()),
                _ => ids.join(", "),
            };
            format!("Decision rule for {whom}: {}.", rule.statement())
        })
        .collect();
    if sentences.is_empty() {
        sentences.push("No conformity is stated: no requirement with a limit was judged.".to_owned());
    }
    if let Some(word) = watermark(findings.origin) {
        sentences.push(format!("{word}: this report is not evidence of the conformity of a real unit."));
    }
    sentences.push("Results relate only to the item tested.".to_owned());
    sentences
}

/// Ids of the requirements that were measured and are compared with a limit by this rule.
fn judged_by(findings: &Findings, rule: DecisionRule) -> Vec<&str> {
    findings
        .requirements
        .iter()
        .filter(|r| r.judges.iter().any(|j| j.rule == rule && j.is_limited()))
        .filter(|r| findings.outcome(&r.id).is_some_and(|o| o.judged > 0))
        .map(|r| r.id.as_str())
        .collect()
}

/// `1 h 02 min`, `33 min 25 s`, `67 s`, `4.2 s`.
pub(crate) fn duration(s: f64) -> String {
    let whole = s.max(0.0).round() as u64;
    match whole {
        0..10 => format!("{} s", crate::number::short(s.max(0.0), 2)),
        10..120 => format!("{whole} s"),
        120..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}
