//! Verdicts on the terminal, and what they mean for the exit code.

use procedures::verdict::{Judgement, Overall, Verdict};
use reports::record::Findings;

use super::output;
use crate::exit;

/// One row per judged requirement; where it judges several measurands, one for each of them.
pub(super) fn text(findings: &Findings) -> String {
    let mut rows = vec![["requirement", "verdict", "value", "U", "limit"].map(str::to_owned).to_vec()];
    for outcome in findings.outcomes.iter().filter(|o| o.judged > 0) {
        let requirement = findings.requirement(&outcome.requirement);
        let mut add = |verdict: Verdict, decided_by: Option<&(String, Judgement)>, limit: &str| {
            let [value, u] = numbers(findings, decided_by);
            rows.push(vec![
                outcome.requirement.clone(),
                word(verdict).to_owned(),
                value,
                u,
                limit.to_owned(),
            ]);
        };
        if outcome.by_measurand.len() < 2 {
            add(outcome.verdict, outcome.decided_by.as_ref(), requirement.map_or("", |r| &r.limit_text));
        }
        for one in outcome.by_measurand.iter().filter(|_| outcome.by_measurand.len() >= 2) {
            let limit = requirement.and_then(|r| r.judged(&one.measurand)?.limit.as_ref());
            let text = limit.map_or("", |limit| limit.text.as_str());
            add(one.verdict, Some(&one.decided_by), format!("{} {text}", one.measurand).trim_end());
        }
    }
    if rows.len() == 1 {
        return measurements(findings);
    }
    output::table(&rows)
}

/// Value and expanded uncertainty of what decided.
fn numbers(findings: &Findings, decided_by: Option<&(String, Judgement)>) -> [String; 2] {
    match decided_by.and_then(|by| findings.deciding(by)) {
        Some((_, measurement, judgement)) => [
            measurement.value.map_or("-".to_owned(), |v| measurement.kind.format(v)),
            measurement.kind.format(judgement.expanded_u),
        ],
        None => ["-".to_owned(), "-".to_owned()],
    }
}

/// Without requirements that apply: what was measured.
fn measurements(findings: &Findings) -> String {
    let mut rows = vec![["measurand", "conditions", "value", "u"].map(str::to_owned).to_vec()];
    for m in findings.procedures.iter().flat_map(|p| &p.measurements) {
        let conditions: Vec<String> =
            m.conditions.iter().map(|c| format!("{} {}", c.name, c.kind.format(c.requested))).collect();
        let value = match (m.value, m.inconclusive.as_deref()) {
            (Some(value), None) => m.kind.format(value),
            (Some(value), Some(reason)) => format!("{} (inconclusive: {reason})", m.kind.format(value)),
            (None, reason) => format!("inconclusive: {}", reason.unwrap_or("")),
        };
        rows.push(vec![m.measurand.clone(), conditions.join(", "), value, m.kind.format(m.u)]);
    }
    output::table(&rows)
}

/// A verdict as a word.
pub(super) fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "none",
        Verdict::Screened => "screened",
        Verdict::Pass => "pass",
        Verdict::ConditionalPass => "conditional pass",
        Verdict::Inconclusive => "inconclusive",
        Verdict::ConditionalFail => "conditional fail",
        Verdict::Fail => "fail",
    }
}

/// The overall verdict as it is printed.
pub(super) fn overall_word(findings: &Findings) -> String {
    let word = match findings.overall {
        Overall::Pass => "PASS",
        Overall::ConditionalPass => "CONDITIONAL PASS",
        Overall::Screening => "SCREENING",
        Overall::Incomplete => "INCOMPLETE",
        Overall::Inconclusive => "INCONCLUSIVE",
        Overall::ConditionalFail => "CONDITIONAL FAIL",
        Overall::Fail => "FAIL",
    };
    let word = if findings.campaign.partial { format!("{word} (PARTIAL)") } else { word.to_owned() };
    match reports::screening(findings) {
        Some(sentence) => format!("{word}: {sentence}"),
        None => word,
    }
}

/// What an overall verdict means for the exit code.
pub(super) fn exit_code(overall: Overall) -> u8 {
    match overall {
        Overall::Pass | Overall::ConditionalPass | Overall::Screening => exit::PASS,
        Overall::Incomplete | Overall::Inconclusive => exit::INCONCLUSIVE,
        Overall::ConditionalFail | Overall::Fail => exit::FAIL,
    }
}
