//! What a requirement claims: the axes and the stretches of conditions over which it must have been measured.
//!
//! A verdict holds for conditions that were measured. A requirement that claims more than was reached has no verdict, however
//! good the measured part is.

use super::Requirement;
use super::read::limit;
use crate::condition;
use crate::measurement::Measurement;
use crate::quantity::QuantityKind;
use crate::table::{Field, Shape, TableReader, suggestion};

/// In place of a condition: the angles of the axis between which a value was measured.
pub(crate) const ANGLE: &str = "angle";

/// A stretch of a condition that measurements must cover, by the values that were reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// Measurand that must cover it; every one with a limit if `None`.
    pub measurand: Option<String>,
    /// Axis on which it must be covered; each one if `None`.
    pub axis: Option<String>,
    /// Name of the condition, e.g. `elevation`, or `angle`.
    pub condition: String,
    /// Ends of the stretch, SI; equal for a single value.
    pub range: [f64; 2],
    /// Largest distance between neighbouring values, SI.
    pub largest_gap: f64,
    /// How far from each end of the stretch the nearest value may lie, SI.
    pub ends: f64,
    /// The stretch as a person wrote it.
    pub text: String,
}

/// Differences below this part of the larger end of a stretch are rounding.
const ROUNDING_RATIO: f64 = 1e-9;

/// Keys of a stretch that must be covered.
pub(super) const FIELDS: &[Field] = &[
    Field::optional(
        "measurand",
        Shape::Text,
        "Measurand that must cover it; default: every one with a limit.",
    ),
    Field::optional("axis", Shape::Text, "Axis on which it must be covered; default: each axis."),
    Field::required(
        "condition",
        Shape::Text,
        "Condition, e.g. `elevation`, by the values that were reached; `angle`: the angles of the axis between which a value was \
         measured.",
    ),
    Field::optional("range", Shape::Text, "Range, e.g. `-6 deg .. 86 deg`."),
    Field::optional(
        "gap",
        Shape::Text,
        "Largest distance between neighbouring values of the range, e.g. `11 deg`.",
    ),
    Field::optional("at", Shape::Text, "In place of `range` and `gap`: a single value, e.g. `0 deg`."),
    Field::required(
        "ends",
        Shape::Text,
        "How far from each end of the range, or from the single value, the nearest value may lie, e.g. `1 deg`.",
    ),
];

/// Reads an entry of `covers`.
pub(super) fn read(table: &mut TableReader<'_>) -> Option<Cover> {
    let measurand = table.text("measurand");
    let axis = table.text("axis");
    let condition = table.text("condition")?;
    let Some(kind) = kind_of(&condition) else {
        let help = suggestion(&condition, condition::names().chain([ANGLE]));
        table.mistake("condition", format!("unknown condition `{condition}`"), Some(help));
        return None;
    };
    let ends = length(table, "ends", kind)?;
    let [range, gap, at] = ["range", "gap", "at"].map(|key| table.has(key));
    if range != gap || range == at {
        let help = "write `range` with `gap` for a stretch, or `at` for a single value";
        let message = "a claim needs either a range with its largest gap or a single value";
        table.mistake("condition", message, Some(help.to_owned()));
        return None;
    }
    if let Some(text) = table.text("at") {
        let value =
            kind.parse(&text).map_err(|e| table.mistake("at", format!("`at`: {e}"), e.help())).ok()?;
        return Some(Cover { measurand, axis, condition, range: [value; 2], largest_gap: 0.0, ends, text });
    }
    let range = limit(table, "range", kind)?;
    let (Some(low), Some(high)) = (range.low, range.high) else {
        let help = format!("write both ends, e.g. `{} .. …`", kind.example());
        table.mistake("range", "a range needs two ends", Some(help));
        return None;
    };
    let largest_gap = length(table, "gap", kind)?;
    Some(Cover { measurand, axis, condition, range: [low, high], largest_gap, ends, text: range.text })
}

/// The kind of quantity of what must be covered.
fn kind_of(condition: &str) -> Option<QuantityKind> {
    if condition == ANGLE { Some(QuantityKind::Angle) } else { condition::kind_of(condition) }
}

fn length(table: &mut TableReader<'_>, key: &'static str, kind: QuantityKind) -> Option<f64> {
    let text = table.text(key)?;
    let value = kind.parse(&text).map_err(|e| table.mistake(key, format!("`{key}`: {e}"), e.help())).ok()?;
    if value < 0.0 {
        table.mistake(key, format!("`{key}` must not be negative"), None);
        return None;
    }
    Some(value)
}

impl Requirement {
    /// The axes and stretches over which it must have been measured, a phrase each.
    pub fn claims(&self) -> Vec<String> {
        let axes = (!self.axes.is_empty()).then(|| format!("axes {}", self.axes.join(", ")));
        axes.into_iter().chain(self.covers.iter().map(Cover::text)).collect()
    }

    /// What it claims and what the measurements do not cover, a phrase each. `seen` are those that are judged by a limit.
    pub fn not_covered(&self, seen: &[&Measurement]) -> Vec<String> {
        let with_value: Vec<&Measurement> = seen.iter().copied().filter(|m| m.value.is_some()).collect();
        let mut missing = Vec::new();
        for judged in self.judges.iter().filter(|j| j.is_limited()) {
            let own: Vec<&Measurement> =
                with_value.iter().copied().filter(|m| m.measurand == judged.measurand).collect();
            // A measurand of which nothing was measured is told as such.
            if own.is_empty() {
                continue;
            }
            let axes = self.axes_to_cover(&judged.measurand, &own);
            for axis in &axes {
                let on_axis: Vec<&Measurement> = own.iter().copied().filter(|m| m.axis == *axis).collect();
                let place = if axes.len() > 1 { format!(" on {axis}") } else { String::new() };
                if on_axis.is_empty() {
                    missing.push(format!("{}{place}", judged.measurand));
                    continue;
                }
                let covers = self.covers.iter().filter(|c| c.is_about(&judged.measurand, axis));
                let lacking = covers.filter_map(|cover| cover.lacking(&on_axis));
                missing.extend(lacking.map(|lacking| format!("{}{place}: {lacking}", judged.measurand)));
            }
        }
        missing
    }

    /// Axes that must be covered: those that the requirement names, else every one that was measured or has a stretch of its own.
    fn axes_to_cover(&self, measurand: &str, measured: &[&Measurement]) -> Vec<String> {
        if !self.axes.is_empty() {
            return self.axes.clone();
        }
        let named = self.covers.iter().filter(|cover| cover.is_of(measurand));
        let named = named.filter_map(|cover| cover.axis.as_ref());
        let mut axes: Vec<String> = Vec::new();
        for axis in measured.iter().map(|m| &m.axis).chain(named) {
            if !axes.contains(axis) {
                axes.push(axis.clone());
            }
        }
        axes
    }
}

impl Cover {
    /// `elevation -6 deg .. 86 deg, gaps up to 11 deg`.
    pub fn text(&self) -> String {
        let axis = self.axis.as_ref().map_or_else(String::new, |axis| format!("{axis}: "));
        let measurand = self.measurand.as_ref().map_or_else(String::new, |name| format!("{name}: "));
        let gaps = match kind_of(&self.condition) {
            Some(kind) if !self.is_single() => format!(", gaps up to {}", kind.format(self.largest_gap)),
            _ => String::new(),
        };
        format!("{axis}{measurand}{}{gaps}", self.stretch())
    }

    /// `elevation -6 deg .. 86 deg`, or `elevation 0 deg`.
    fn stretch(&self) -> String {
        format!("{} {}", self.condition, self.text)
    }

    fn is_single(&self) -> bool {
        self.range[0] == self.range[1]
    }

    fn is_of(&self, measurand: &str) -> bool {
        self.measurand.as_ref().is_none_or(|own| own == measurand)
    }

    fn is_about(&self, measurand: &str, axis: &str) -> bool {
        self.is_of(measurand) && self.axis.as_ref().is_none_or(|own| own == axis)
    }

    /// The part of the condition that each of these measurements reached, by its lower end: a single value has two equal ends.
    fn reached(&self, kind: QuantityKind, measurements: &[&Measurement]) -> Vec<[f64; 2]> {
        let mut reached: Vec<[f64; 2]> = if self.condition == ANGLE {
            measurements.iter().filter_map(|m| m.angles_rad).collect()
        } else {
            let all = measurements.iter().flat_map(|m| &m.conditions).filter(|c| c.name == self.condition);
            all.filter_map(|c| c.achieved).map(|value| [condition::compared(kind, value); 2]).collect()
        };
        reached.retain(|ends| ends.iter().all(|end| end.is_finite()));
        reached.sort_by(|a, b| a[0].total_cmp(&b[0]));
        reached
    }

    /// What of the stretch these measurements leave out; `None` if nothing.
    fn lacking(&self, measurements: &[&Measurement]) -> Option<String> {
        let kind = kind_of(&self.condition)?;
        let reached = self.reached(kind, measurements);
        let [low, high] = self.range;
        // Values were parsed from degrees and come back from sums: equal up to rounding is equal.
        let rounding = ROUNDING_RATIO * low.abs().max(high.abs());
        let Some(&[least, first_end]) = reached.first() else {
            return Some(format!("{}, reached nowhere", self.stretch()));
        };
        let mut most = first_end;
        let mut gaps = Vec::new();
        for &[from, to] in &reached[1..] {
            gaps.push([most, from]);
            most = most.max(to);
        }
        // A gap beyond the nearest end that may be left out is none.
        let widest = gaps.into_iter().filter(|[a, b]| *b > low + self.ends && *a < high - self.ends);
        let widest = widest.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        let format = |value: f64| shown(kind, value);
        let reaches_ends = least <= low + self.ends + rounding && most >= high - self.ends - rounding;
        let lacking = if !reaches_ends && most - least <= self.ends {
            format!("reached {} only", format(least))
        } else if !reaches_ends {
            format!("reached {} to {}", format(least), format(most))
        } else if let Some([from, to]) = widest.filter(|[a, b]| b - a > self.largest_gap + rounding) {
            format!("nothing between {} and {}", format(from), format(to))
        } else {
            return None;
        };
        Some(format!("{}, {lacking}", self.stretch()))
    }
}

/// A reached value to three digits: where it was, not how exactly.
fn shown(kind: QuantityKind, value_si: f64) -> String {
    let value = kind.to_display(value_si);
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    format!("{rounded} {}", kind.display_unit()).trim_end().to_owned()
}
