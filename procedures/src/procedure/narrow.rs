//! A plan narrowed to the points that a campaign wants.

use crate::case::Case;
use crate::condition::{kind_of, not_in_sweep, same};
use crate::diagnostic::Diagnostic;
use crate::quantity::QuantityKind;
use crate::table::suggestion;

/// A subset of a procedure's sweep: condition name and the SI values to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// E.g. `velocity`.
    pub condition: String,
    /// Values to keep, SI.
    pub values: Vec<f64>,
}

impl Subset {
    /// `velocity = 10 deg/s, 20 deg/s`, for messages and reports.
    pub fn text(&self) -> String {
        let kind = kind_of(&self.condition).unwrap_or(QuantityKind::Ratio);
        let values: Vec<String> = self.values.iter().map(|&value| kind.format(value)).collect();
        format!("{} = {}", self.condition, values.join(", "))
    }
}

/// Keeps the cases whose conditions are among the values of every subset. A case that was not asked for under a
/// subset's condition is no part of that sweep and stays.
pub(super) fn narrow(cases: Vec<Case>, subsets: &[Subset]) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let mut mistakes: Vec<Diagnostic> = subsets.iter().flat_map(|subset| missing(&cases, subset)).collect();
    mistakes.extend(repeated(&cases));
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let wanted = |case: &Case, subset: &Subset| {
        case.requested(&subset.condition)
            .is_none_or(|has| subset.values.iter().any(|&value| same(value, has)))
    };
    let left: Vec<Case> =
        cases.into_iter().filter(|case| subsets.iter().all(|subset| wanted(case, subset))).collect();
    if left.is_empty() {
        let subsets: Vec<String> = subsets.iter().map(Subset::text).collect();
        let none = Diagnostic::new("no point is left to run");
        return Err(vec![if subsets.is_empty() {
            none
        } else {
            none.help(format!("selected by the campaign: {}", subsets.join(" and ")))
        }]);
    }
    Ok(left)
}

/// Values of a subset that no case has.
fn missing(cases: &[Case], subset: &Subset) -> Vec<Diagnostic> {
    let name = &subset.condition;
    let mut has: Vec<f64> = Vec::new();
    for value in cases.iter().filter_map(|case| case.requested(name)) {
        if !has.iter().any(|&other| same(other, value)) {
            has.push(value);
        }
    }
    if has.is_empty() {
        let mut known: Vec<&str> = cases.iter().flat_map(|c| &c.requested).map(|r| r.name.as_str()).collect();
        known.sort_unstable();
        known.dedup();
        let unknown = Diagnostic::new(format!("the procedure has no sweep over `{name}`"));
        return vec![unknown.help(suggestion(name, known))];
    }
    let absent = subset.values.iter().filter(|&&value| !has.iter().any(|&other| same(other, value)));
    absent.map(|&value| not_in_sweep(name, value, &has)).collect()
}

/// Points are told apart by name: in the log, on resume, in the report.
fn repeated(cases: &[Case]) -> Vec<Diagnostic> {
    let mut names: Vec<&str> = cases.iter().map(|case| case.point.as_str()).collect();
    names.sort_unstable();
    let mut twice: Vec<&str> =
        names.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    twice.dedup();
    let message = |name| Diagnostic::new(format!("point `{name}` is planned more than once"));
    twice.into_iter().map(|name| message(name).help("write each value of a sweep once")).collect()
}
