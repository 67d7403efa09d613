//! Requirements from their file.

use std::ops::Range;

use super::{Band, FIELDS, Judged, Mask, Requirement, Requirements, Rule, Take, Where, cover};
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
                    entry.mistake("id", format!("requirement `{id}` is defined twice in this file"), None);
                }
                ids.push(id);
            }
            read
        });
        Some(Requirements { all: all? })
    })
}

fn requirement(table: &mut TableReader<'_>, known: &[Measurand]) -> Option<Requirement> {
    let id = table.text("id");
    let text = table.text("text");
    let source = table.text("source");
    let method = table.text("method");
    let axis = table.text("axis");
    let conditions = conditions(table);
    table.text("take");
    let rule = rule(table).unwrap_or(Rule::GuardedU);
    let (judges, limit_text, goal_text) = limits(table, known, rule);
    let axes = table.texts("axes").unwrap_or_default();
    let covers = table.tables("covers", cover::read).unwrap_or_default();
    for cover in &covers {
        let Some(name) = cover.measurand.as_ref().filter(|name| judges.iter().all(|j| j.measurand != **name))
        else {
            continue;
        };
        let help = suggestion(name, judges.iter().map(|j| j.measurand.as_str()));
        table.mistake("covers", format!("the requirement does not judge the measurand `{name}`"), Some(help));
    }
    let evidence = table.text("evidence");
    if evidence.is_some() && (!judges.is_empty() || method.as_deref().is_some_and(|m| m == "test")) {
        let help = "give either `measurand` or `judge` for a measured requirement, or `evidence` (by \
                    analysis or inspection) for a declared one";
        table.mistake("evidence", "`evidence` for a requirement that is measured", Some(help.to_owned()));
    }
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
        axes,
        covers,
        evidence,
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
        let text = joined(
            judges.iter().flat_map(|j| j.limit_texts().into_iter().map(|t| (j.measurand.as_str(), t))),
        );
        let goal =
            joined(judges.iter().filter_map(|j| Some((j.measurand.as_str(), j.goal.as_ref()?.text.clone()))));
        return (judges, text, Some(goal).filter(|goal| !goal.is_empty()));
    }
    let mut judges = Vec::new();
    for (name, span) in table.spanned_texts("measurand").unwrap_or_default() {
        let Some(kind) = measurand_kind(table, &name, span, known) else { continue };
        let [limit, goal] = limit_and_goal(table, kind);
        judges.push(Judged { measurand: name, limit, bands: Vec::new(), mask: None, goal, rule });
    }
    if !table.has("measurand") {
        if table.has("allowance") {
            table.mistake("allowance", "`allowance` needs a measurand", None);
        }
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
    let [limit, goal] = limit_and_goal(table, kind);
    let bands = table.tables("bands", |entry| band(entry, kind)).unwrap_or_default();
    for (index, one) in bands.iter().enumerate() {
        if let Some(other) = bands[..index].iter().find(|other| other.overlaps(one)) {
            let message = format!("contradictory bands: `{}` and `{}` overlap", other.text(), one.text());
            let help = "let one begin where the other ends, e.g. `<= 20 deg` and `> 20 deg`";
            table.mistake("bands", message, Some(help.to_owned()));
        }
    }
    let mask = table.table("mask", |entry| mask(entry, kind));
    Some(Judged { measurand, limit, bands, mask, goal, rule })
}

fn conditions(table: &mut TableReader<'_>) -> Vec<Where> {
    let entries = table.lists("where").unwrap_or_default();
    let read = |entry: crate::table::MapEntry| {
        let meets = condition::read_meets(table, &entry)?;
        Some(Where { condition: entry.key, meets })
    };
    entries.into_iter().filter_map(read).collect()
}

fn band(table: &mut TableReader<'_>, kind: QuantityKind) -> Option<Band> {
    let conditions = conditions(table);
    if conditions.is_empty() && table.mistakes() == 0 {
        let help = "write a limit that applies everywhere as `limit` of the measurand";
        table.mistake("where", "a band without a condition", Some(help.to_owned()));
    }
    Some(Band { conditions, limit: limit(table, "limit", kind)? })
}

fn mask(table: &mut TableReader<'_>, kind: QuantityKind) -> Option<Mask> {
    let (over, of) = named_condition(table, "over")?;
    let at = table.spanned_texts("at")?;
    let limits = table.spanned_texts("limit")?;
    let mut corners: Vec<(f64, Limit)> = Vec::new();
    if at.len() != limits.len() || at.len() < 2 {
        let message = format!(
            "corners: {}, limits: {}; expected the same number of both, at least two",
            at.len(),
            limits.len()
        );
        table.mistake("limit", message, None);
        return None;
    }
    for ((x, x_span), (text, span)) in at.into_iter().zip(limits) {
        let x = of
            .parse(&x)
            .map_err(|e| table.mistake_at(x_span.clone(), format!("`at`: {e}"), e.help()))
            .ok()?;
        let found = kind.parse_limit(&text);
        let found =
            found.map_err(|e| table.mistake_at(span.clone(), format!("`limit`: {e}"), e.help())).ok()?;
        if x <= corners.last().map_or(0.0, |(last, _)| *last) {
            table.mistake_at(x_span, "corner points must be positive and ascend", None);
            return None;
        }
        if corners.first().is_some_and(|(_, first)| first.comparator != found.comparator) {
            table.mistake_at(span, "all limits of a mask need the same comparator", None);
            return None;
        }
        corners.push((x, found));
    }
    Some(Mask { condition: over, corners })
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

/// The condition that a key names, with the kind of its quantity.
fn named_condition(table: &mut TableReader<'_>, key: &'static str) -> Option<(String, QuantityKind)> {
    let name = table.text(key)?;
    let kind = condition::kind_of(&name);
    if kind.is_none() {
        let help = suggestion(&name, condition::names());
        table.mistake(key, format!("unknown condition `{name}`"), Some(help));
    }
    Some((name, kind?))
}

pub(super) fn limit(table: &mut TableReader<'_>, key: &'static str, kind: QuantityKind) -> Option<Limit> {
    let text = table.text(key)?;
    let limit = kind.parse_limit(&text);
    limit.map_err(|error| table.mistake(key, format!("`{key}`: {error}"), error.help())).ok()
}

/// The limit of a measurand, met by what is nearer to it than its allowance, and its goal.
fn limit_and_goal(table: &mut TableReader<'_>, kind: QuantityKind) -> [Option<Limit>; 2] {
    let allowance = allowance(table, kind);
    let limit = limit(table, "limit", kind).map(|limit| limit.met_within(allowance.unwrap_or(0.0)));
    [limit, self::limit(table, "goal", kind)]
}

/// How near to a limit counts as meeting it; 0 where nothing is said.
fn allowance(table: &mut TableReader<'_>, kind: QuantityKind) -> Option<f64> {
    const KEY: &str = "allowance";
    let Some(text) = table.text(KEY) else { return Some(0.0) };
    match kind.parse(&text) {
        Ok(allowance) if allowance > 0.0 => Some(allowance),
        Ok(_) => {
            table.mistake(KEY, format!("`{KEY}` must be above zero, found {text}"), None);
            None
        }
        Err(error) => {
            table.mistake(KEY, format!("`{KEY}`: {error}"), error.help());
            None
        }
    }
}

/// A limit that nothing is held against yet: it must be one of some quantity.
fn any_limit(table: &mut TableReader<'_>, key: &'static str) {
    let Some(text) = table.text(key) else { return };
    if QuantityKind::ALL.iter().all(|kind| kind.parse_limit(&text).is_err()) {
        let help = "write e.g. `<= 45 N*m`; write limits in words as `limit-text`";
        table.mistake(key, format!("`{text}` is not a limit of any quantity"), Some(help.to_owned()));
    }
}

fn only_one_of(table: &mut TableReader<'_>, keys: &[&'static str]) {
    let written: Vec<&str> = keys.iter().copied().filter(|key| table.has(key)).collect();
    if let [first, second, ..] = written.as_slice() {
        table.mistake(second, format!("`{second}` and `{first}` cannot be given together"), None);
    }
}

/// `cogging-order 143.5 .. 144.5 1/rev; cogging-amplitude <= 12 N*m`.
fn joined<'a>(limits: impl Iterator<Item = (&'a str, String)>) -> String {
    let each = limits.map(|(name, limit)| format!("{name} {limit}"));
    each.collect::<Vec<_>>().join("; ")
}
