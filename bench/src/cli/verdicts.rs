//! Verdicts on the terminal, and what they mean for the exit code.

use procedures::verdict::Overall;
use reports::record::Findings;
use reports::terminal;

use super::output;
use crate::exit;

/// A row for each judged requirement and limit, shortfalls first.
pub(super) fn text(findings: &Findings) -> String {
    let judged = terminal::requirements(findings);
    if judged.is_empty() {
        return measurements(findings);
    }
    let head = terminal::HEAD.map(str::to_owned);
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(judged).map(Vec::from).collect();
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
