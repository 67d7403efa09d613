//! Criteria from their file.

use super::measurands::{scale_of, worse_of};
use super::{Criteria, Criterion, FIELDS, Scale, Worse};
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds;
use crate::quantity::QuantityKind;
use crate::requirement::{Judged, Requirement, Requirements};
use crate::table::{TableReader, quoted, read_file, suggestion};

/// Most looks of a sequential comparison: the level of the intervals is made for four.
const MOST_LOOKS: usize = 4;

impl Criteria {
    /// Parses a criteria file whose requirements are those of the campaign.
    ///
    /// # Errors
    /// All mistakes at once: unknown requirements and measurands, missing margins, margins that are not above zero or of
    /// another quantity, a measurand that stands twice, looks that do not ascend or more than double.
    pub fn parse(source: &SourceFile, requirements: &Requirements) -> Result<Self, Vec<Diagnostic>> {
        read_file(source, FIELDS, |table| {
            table.schema();
            let looks = looks(table);
            let mut read: Vec<Criterion> = Vec::new();
            let all = table.tables("criterion", |entry| {
                let criterion = criterion(entry, requirements)?;
                let is_same = |other: &&Criterion| {
                    other.requirement == criterion.requirement && other.measurand == criterion.measurand
                };
                if let Some(twice) = read.iter().find(is_same) {
                    let message = format!(
                        "criterion {} ({}) is defined twice in this file",
                        twice.requirement, twice.measurand
                    );
                    entry.mistake("requirement", message, Some("remove one of the two".to_owned()));
                    return None;
                }
                read.push(criterion.clone());
                Some(criterion)
            });
            if all.as_ref().is_some_and(Vec::is_empty) && table.mistakes() == 0 {
                table.mistake("criterion", "the file has no criterion", None);
            }
            Some(Self { looks: looks?, all: all? })
        })
    }
}

/// Numbers of units at which a sequential comparison looks.
fn looks(table: &mut TableReader<'_>) -> Option<Vec<u32>> {
    const KEY: &str = "looks";
    let written = table.integers(KEY)?;
    let help = "at most four looks, from 2 units on, each at most twice the one before: the intervals of a look are made \
                for that";
    if written.is_empty() || written.len() > MOST_LOOKS {
        let message = format!("`{KEY}` has {} entries; expected 1 to {MOST_LOOKS}", written.len());
        table.mistake(KEY, message, Some(help.to_owned()));
        return None;
    }
    let mut looks: Vec<u32> = Vec::with_capacity(written.len());
    for (units, span) in written {
        let fits = |units: &u32| match looks.last() {
            Some(&before) => *units > before && *units <= before.saturating_mul(2),
            None => *units >= 2,
        };
        let Some(units) = u32::try_from(units).ok().filter(fits) else {
            let expected = match looks.last() {
                Some(&before) => format!("{} to {}", before.saturating_add(1), before.saturating_mul(2)),
                None => "2 or more".to_owned(),
            };
            let message = format!("a look at {units} units; expected {expected}");
            table.mistake_at(span, message, Some(help.to_owned()));
            return None;
        };
        looks.push(units);
    }
    Some(looks)
}

fn criterion(table: &mut TableReader<'_>, requirements: &Requirements) -> Option<Criterion> {
    let scale = table.text("scale").as_deref().and_then(scale_named);
    let worse = table.text("worse").as_deref().and_then(worse_named);
    let blocking = table.boolean("blocking");
    let has_margin = table.text("margin").is_some();
    let requirement = requirement(table, requirements)?;
    let judged = judged(table, requirement)?;
    let kind = kind_of(judged)?;
    let scale = scale.unwrap_or_else(|| scale_of(&judged.measurand));
    let margin = if has_margin { margin(table, kind, scale) } else { None };
    let worse = worse.or_else(|| worse_of(judged));
    if worse.is_none() && !table.has("worse") {
        let message = format!("the limits of {} do not say which way it becomes worse", requirement.id);
        let help = "write `worse = \"higher\"` or `worse = \"lower\"`";
        table.mistake("requirement", message, Some(help.to_owned()));
    }
    Some(Criterion {
        requirement: requirement.id.clone(),
        measurand: judged.measurand.clone(),
        place: String::new(),
        kind,
        margin: margin?,
        scale,
        worse: worse?,
        blocking: blocking?,
    })
}

fn scale_named(name: &str) -> Option<Scale> {
    [Scale::Difference, Scale::LogRatio].into_iter().find(|scale| scale.name() == name)
}

fn worse_named(name: &str) -> Option<Worse> {
    [Worse::Higher, Worse::Lower].into_iter().find(|worse| worse.name() == name)
}

/// The kind of quantity of a measurand that a requirement judges.
pub(super) fn kind_of(judged: &Judged) -> Option<QuantityKind> {
    let limit = judged.limit.as_ref().map(|limit| limit.kind);
    limit.or_else(|| Some(kinds::measurand(&judged.measurand)?.1.kind))
}

/// The requirement that a criterion names.
fn requirement<'r>(table: &mut TableReader<'_>, requirements: &'r Requirements) -> Option<&'r Requirement> {
    const KEY: &str = "requirement";
    let id = table.text(KEY)?;
    let found = requirements.get(&id);
    match found {
        None => {
            let help = suggestion(&id, requirements.all.iter().map(|r| r.id.as_str()));
            table.mistake(KEY, format!("unknown requirement `{id}`"), Some(help));
        }
        Some(requirement) if requirement.judges.is_empty() => {
            let help = "name a requirement with a measurand";
            table.mistake(KEY, format!("nothing measures requirement `{id}`"), Some(help.to_owned()));
            return None;
        }
        Some(_) => {}
    }
    found
}

/// The measurand of the requirement that a criterion is about.
fn judged<'r>(table: &mut TableReader<'_>, requirement: &'r Requirement) -> Option<&'r Judged> {
    const KEY: &str = "measurand";
    if !table.has(KEY) {
        if let [only] = requirement.judges.as_slice() {
            return Some(only);
        }
        let message =
            format!("requirement {} judges several measurands, and `{KEY}` is missing", requirement.id);
        let help = format!("one of {}", quoted(requirement.measurands()));
        table.mistake("requirement", message, Some(help));
        return None;
    }
    let name = table.text(KEY)?;
    let found = requirement.judged(&name);
    if found.is_none() {
        let message = format!("requirement {} does not judge the measurand `{name}`", requirement.id);
        table.mistake(KEY, message, Some(suggestion(&name, requirement.measurands())));
    }
    found
}

/// A margin in the SI unit of the measurand, or as the logarithm of a ratio.
fn margin(table: &mut TableReader<'_>, kind: QuantityKind, scale: Scale) -> Option<f64> {
    const KEY: &str = "margin";
    let text = table.text(KEY)?;
    let kind = match scale {
        Scale::Difference => kind,
        Scale::LogRatio => QuantityKind::Ratio,
    };
    match kind.parse(&text) {
        Ok(margin) if margin > 0.0 => match scale {
            Scale::Difference => Some(margin),
            Scale::LogRatio => Some(margin.ln_1p()),
        },
        Ok(_) => {
            table.mistake(KEY, format!("`{KEY}` must be above zero, found {text}"), None);
            None
        }
        Err(error) => {
            let of_ratio = "this measurand is compared by its log-ratio, whose margin is a percentage such as `5 %`; a margin \
                            in its own unit needs `scale = \"difference\"`";
            let help = if scale == Scale::LogRatio { Some(of_ratio.to_owned()) } else { error.help() };
            table.mistake(KEY, format!("`{KEY}`: {error}"), help);
            None
        }
    }
}
