//! Verdicts on the terminal, and what they mean for the exit code.

use procedures::verdict::{Overall, Verdict};
use reports::record::Findings;

use super::output;
use crate::exit;

/// One row per judged requirement.
pub(super) fn text(findings: &Findings) -> String {
    let mut rows = vec![["requirement", "verdict", "value", "U", "limit"].map(str::to_owned).to_vec()];
    for outcome in findings.outcomes.iter().filter(|o| o.judged > 0) {
        let (value, u) = match findings.deciding(outcome) {
            Some((_, measurement, judgement)) => (
                measurement.value.map_or("-".to_owned(), |v| measurement.kind.format(v)),
                measurement.kind.format(judgement.expanded_u),
            ),
            None => ("-".to_owned(), "-".to_owned()),
        };
        let limit =
            findings.requirement(&outcome.requirement).map_or("", |r| r.limit_text.as_str()).to_owned();
        rows.push(vec![outcome.requirement.clone(), word(outcome.verdict).to_owned(), value, u, limit]);
    }
    if rows.len() == 1 {
        return measurements(findings);
    }
    output::table(&rows)
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
