//! Requirements from their file.

use std::ops::Range;

use super::{FIELDS, Judged, Requirement, Requirements, Rule, Take, Where};
use crate::condition;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::Measurand;
use crate::quantity::{Limit, QuantityKind};
use crate::table::{TableReader, read_file, suggestion};

/// Reads a file whose measurands must be among `known`.
pub(super) fn requirements(
    source: &SourceFile,
    known: &[Measurand],
) -> Result<Requirements, Vec<Diagnostic>> {
    read_file(source, FIELDS, |table| {
        table.schema();
        let mut ids: Vec<String> = Vec::new();
        let all = table.tables("requirement", |entry| {
            let read = requirement(entry, known);
            // The id is compared even where the rest is wrong.
            if let Some(id) = entry.has("id").then(|| entry.text("id")).flatten() {
                if ids.contains(&id) {
                    entry.mistake("id", format!("requirement `{id}` stands twice in this file"), None);
                }
                ids.push(id);
            }
            read
        });
        Some(Requirements { all: all? })
    })
}

fn requirement(table: &mut TableReader<'_>, known: &[Measurand]) -> Option<Requirement> {
    let (id, text, source) = (table.text("id"), table.text("text"), table.text("source"));
    let method = table.text("method");
    let axis = table.text("axis");
    let conditions = table.lists("where").unwrap_or_default().into_iter().filter_map(|entry| {
        let meets = condition::read_meets(table, &entry)?;
        Some(Where { condition: entry.key, meets })
    });
    let conditions = conditions.collect();
    table.text("take");
    let rule = rule(table).unwrap_or(Rule::GuardedU);
    let (judges, limit_text, goal_text) = limits(table, known, rule);
    Some(Requirement {
        id: id?,
        text: text?,
        source: source?,
        method: method?,
        judges,
        limit_text,
        goal_text,
        axis,
        conditions,
        take: Take::Worst,
        rule,
    })
}

fn rule(table: &mut TableReader<'_>) -> Option<Rule> {
    let name = table.text("rule")?;
    [Rule::Simple, Rule::GuardedNinetyFive, Rule::GuardedU].into_iter().find(|rule| rule.name() == name)
}

type Limits = (Vec<Judged>, String, Option<String>);

/// The limits of a requirement: one for all its measurands, or one each, or words while nothing measures it.
fn limits(table: &mut TableReader<'_>, known: &[Measurand], rule: Rule) -> Limits {
    only_one_of(table, &["judge", "limit", "limit-text"]);
    only_one_of(table, &["judge", "measurand"]);
    if table.has("judge") {
        let judges = table.tables("judge", |entry| judge(entry, known, rule)).unwrap_or_default();
        for (index, judge) in judges.iter().enumerate() {
            if judges[..index].iter().any(|other| other.measurand == judge.measurand) {
                table.mistake("judge", format!("measurand `{}` is judged twice", judge.measurand), None);
            }
        }
        let text = joined(judges.iter().map(|j| (j.measurand.as_str(), j.limit.as_ref())));
        let goal = joined(judges.iter().map(|j| (j.measurand.as_str(), j.goal.as_ref())));
        return (judges, text, Some(goal).filter(|goal| !goal.is_empty()));
    }
    let mut judges = Vec::new();
    for (name, span) in table.spanned_texts("measurand").unwrap_or_default() {
        let Some(kind) = measurand_kind(table, &name, span, known) else { continue };
        let (limit, goal) = (limit(table, "limit", kind), limit(table, "goal", kind));
        judges.push(Judged { measurand: name, limit, goal, rule });
    }
    if !table.has("measurand") {
        any_limit(table, "limit");
        any_limit(table, "goal");
    } else if table.has("limit-text") {
        let help = "a measured requirement needs a `limit`, or `judge` with one limit for each measurand";
        table.mistake("limit-text", "`limit-text` cannot be judged", Some(help.to_owned()));
    }
    let text = table.text("limit").or_else(|| table.text("limit-text"));
    (judges, text.unwrap_or_default().trim().to_owned(), table.text("goal"))
}

fn judge(table: &mut TableReader<'_>, known: &[Measurand], of_requirement: Rule) -> Option<Judged> {
    let rule = rule(table).unwrap_or(of_requirement);
    let measurand = table.text("measurand")?;
    let kind = measurand_kind(table, &measurand, table.span("measurand"), known)?;
    let (limit, goal) = (limit(table, "limit", kind), limit(table, "goal", kind));
    Some(Judged { measurand, limit, goal, rule })
}

fn measurand_kind(
    table: &mut TableReader<'_>,
    name: &str,
    span: Range<usize>,
    known: &[Measurand],
) -> Option<QuantityKind> {
    let found = known.iter().find(|m| m.name == name);
    if found.is_none() {
        let help = suggestion(name, known.iter().map(|m| m.name));
        table.mistake_at(span, format!("unknown measurand `{name}`"), Some(help));
    }
    found.map(|m| m.kind)
}

fn limit(table: &mut TableReader<'_>, key: &'static str, kind: QuantityKind) -> Option<Limit> {
    let text = table.text(key)?;
    let limit = kind.parse_limit(&text);
    limit.map_err(|error| table.mistake(key, format!("`{key}`: {error}"), error.help())).ok()
}

/// A limit that nothing is held against yet: it must be one of some quantity.
fn any_limit(table: &mut TableReader<'_>, key: &'static str) {
    let Some(text) = table.text(key) else { return };
    if QuantityKind::ALL.iter().all(|kind| kind.parse_limit(&text).is_err()) {
        let help = "write e.g. `<= 45 N*m`; limits in words belong into `limit-text`";
        table.mistake(key, format!("`{text}` is not a limit of any quantity"), Some(help.to_owned()));
    }
}

fn only_one_of(table: &mut TableReader<'_>, keys: &[&'static str]) {
    let written: Vec<&str> = keys.iter().copied().filter(|key| table.has(key)).collect();
    if let [first, second, ..] = written.as_slice() {
        table.mistake(second, format!("`{second}` and `{first}` exclude each other"), None);
    }
}

/// `cogging-order 143.5 .. 144.5 1/rev; cogging-amplitude <= 12 N*m`.
fn joined<'a>(limits: impl Iterator<Item = (&'a str, Option<&'a Limit>)>) -> String {
    let each = limits.filter_map(|(name, limit)| Some(format!("{name} {}", limit?.text)));
    each.collect::<Vec<_>>().join("; ")
}
