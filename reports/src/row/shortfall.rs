//! What stands in the way of a pass, one sentence a requirement.

use procedures::verdict::Verdict;

use super::Row;

/// Whether the requirement is named on the first page.
pub(crate) fn is_one(row: &Row<'_>) -> bool {
    let missing = row.evidence.is_none() && row.requirement.required;
    missing || !matches!(row.verdict, Verdict::Pass | Verdict::Screened | Verdict::None)
}

/// Every requirement that did not simply pass, the worst first, and what is required and was not measured.
pub(crate) fn all<'r, 'a>(rows: &'r [Row<'a>]) -> Vec<&'r Row<'a>> {
    let mut all: Vec<&Row<'a>> = rows.iter().filter(|r| is_one(r)).collect();
    all.sort_by_key(|row| std::cmp::Reverse(row.verdict));
    all
}

/// Why it is one.
pub(crate) fn sentence(row: &Row<'_>) -> String {
    let said = row.reason.as_deref();
    match numbers(row) {
        Some(numbers) => said.map_or(numbers.clone(), |said| format!("{numbers} Also {said}.")),
        None => said.unwrap_or("no reason is given").to_owned(),
    }
}

/// How the value lies to its limit, for verdicts that rest on one.
fn numbers(row: &Row<'_>) -> Option<String> {
    let margin = row.margin.trim_start_matches('−');
    let limit = row.decisive_limit.as_deref().unwrap_or(&row.limit);
    let u = &row.expanded_u;
    let by = match (row.margin_percent(), row.margin_in_u()) {
        (Some(percent), _) => format!("{margin} ({})", percent.trim_start_matches('−')),
        (None, Some(multiple)) => format!("{margin} ({})", multiple.trim_start_matches('−')),
        (None, None) => margin.to_owned(),
    };
    let guard = row.guard_band.as_deref().unwrap_or("0");
    let probability = row.probability_outside.as_deref().unwrap_or("not known");
    let text = match row.verdict {
        Verdict::Fail => format!("{} (U {u}) is outside {limit} by {by}.", row.value),
        Verdict::ConditionalFail => format!(
            "{} is outside {limit} by {by}, less than the guard band of {guard}; P(outside) {probability}.",
            row.value
        ),
        Verdict::ConditionalPass => format!(
            "{} is inside {limit} by {by}, less than the guard band of {guard}; P(outside) {probability}.",
            row.value
        ),
        Verdict::Inconclusive | Verdict::Pass | Verdict::Screened | Verdict::None => return None,
    };
    Some(text)
}
