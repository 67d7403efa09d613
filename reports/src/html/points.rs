//! The table of points: what was asked for, what was reached, what was found.

use procedures::measurement::{Condition, Measurement};
use procedures::quantity::QuantityKind;

use super::{badge, table_head};
use crate::markup::Markup;
use crate::number;
use crate::record::{PointRow, ProcedureFindings, Status};
use crate::row::{exclusion, measurement_notes, value_cells};
use crate::words;

/// So many conditions have columns of their own; more stand in one, or the table would be wider than a sheet.
const APART: usize = 2;

/// The table, if there are points.
pub(super) fn write(m: &mut Markup, procedure: &ProcedureFindings) {
    if procedure.points.is_empty() {
        return;
    }
    let conditions = columns(procedure);
    m.element("h3", &[], "Points");
    m.open("table", &[("class", "points")]);
    head(m, &conditions);
    for point in &procedure.points {
        // One body a point: it is not torn apart where a page ends.
        m.within("tbody", &[], |m| rows(m, procedure, point, &conditions));
    }
    m.close();
}

/// Names and kinds of all conditions, in order of appearance.
fn columns(procedure: &ProcedureFindings) -> Vec<(&str, QuantityKind)> {
    let mut columns: Vec<(&str, QuantityKind)> = Vec::new();
    for condition in procedure.points.iter().flat_map(|p| &p.conditions) {
        if columns.iter().all(|(name, _)| *name != condition.name) {
            columns.push((&condition.name, condition.kind));
        }
    }
    columns
}

const LAST: [(&str, &str); 5] =
    [("", "Measurand"), ("n", "Value"), ("n", "U"), ("", "Verdict"), ("", "Flags, exclusions, reasons")];

fn head(m: &mut Markup, conditions: &[(&str, QuantityKind)]) {
    if conditions.len() > APART {
        let first = [("", "Point"), ("", "Condition: asked, reached")];
        return table_head(m, &[&first[..], &LAST[..]].concat());
    }
    m.open("thead", &[]);
    m.open("tr", &[]);
    m.element("th", &[("rowspan", "2")], "Point");
    for (name, kind) in conditions {
        let unit = number::typeset(kind.display_unit());
        let text = if unit.is_empty() { (*name).to_owned() } else { format!("{name}, {unit}") };
        m.element("th", &[("colspan", "2"), ("class", "group")], &text);
    }
    for (class, text) in LAST {
        m.element("th", &[("rowspan", "2"), ("class", class)], text);
    }
    m.close();
    m.open("tr", &[]);
    for _ in conditions {
        m.element("th", &[("class", "n")], "asked");
        m.element("th", &[("class", "n")], "reached");
    }
    m.close();
    m.close();
}

fn rows(
    m: &mut Markup,
    procedure: &ProcedureFindings,
    point: &PointRow,
    conditions: &[(&str, QuantityKind)],
) {
    let own: Vec<&Measurement> =
        point.measurements.iter().filter_map(|&i| procedure.measurements.get(i)).collect();
    let span = own.len().max(1).to_string();
    m.open("tr", &[]);
    m.within("th", &[("scope", "row"), ("rowspan", &span)], |m| {
        m.text(&point.point);
        if point.status != Status::Completed {
            m.element("small", &[("class", "status")], point.status.word());
        }
    });
    if conditions.len() > APART {
        m.within("td", &[("rowspan", &span), ("class", "conditions")], |m| {
            notes(m, &point.conditions.iter().map(condition_line).collect::<Vec<String>>());
        });
    } else {
        for (name, _) in conditions {
            condition_cells(m, point.conditions.iter().find(|c| c.name == *name), &span);
        }
    }
    let mut indices = point.measurements.iter().filter(|&&i| i < procedure.measurements.len());
    match indices.next() {
        None => empty_cells(m, point),
        Some(&first) => {
            measurement_cells(m, procedure, first, Some(point));
            for &index in indices {
                m.close();
                m.open("tr", &[]);
                measurement_cells(m, procedure, index, None);
            }
        }
    }
    m.close();
}

/// Asked for and reached, as printed.
fn condition_texts(c: &Condition) -> [String; 2] {
    let shown = |si: f64, digits: fn(f64, i32) -> String| number::typeset(&digits(c.kind.to_display(si), 4));
    let reached = c.achieved.map_or("—".to_owned(), |a| shown(a, number::significant));
    [shown(c.requested, number::short), reached]
}

/// `rate, A/s: 1, 0.9998`.
fn condition_line(c: &Condition) -> String {
    let [asked, reached] = condition_texts(c);
    let unit = number::typeset(c.kind.display_unit());
    let name = if unit.is_empty() { c.name.clone() } else { format!("{}, {unit}", c.name) };
    format!("{name}: {asked}, {reached}")
}

fn condition_cells(m: &mut Markup, condition: Option<&Condition>, span: &str) {
    let texts = condition.map_or_else(|| [String::new(), String::new()], condition_texts);
    for text in texts {
        m.element("td", &[("class", "n"), ("rowspan", span)], &text);
    }
}

fn empty_cells(m: &mut Markup, point: &PointRow) {
    for class in ["", "n", "n"] {
        m.element("td", &[("class", class)], "—");
    }
    m.within("td", &[], |m| badge(m, words::verdict(point.verdict)));
    m.within("td", &[("class", "notes")], |m| notes(m, &point_notes(point)));
}

fn measurement_cells(m: &mut Markup, procedure: &ProcedureFindings, index: usize, point: Option<&PointRow>) {
    let Some(measurement) = procedure.measurements.get(index) else { return };
    let (value, uncertainty) = value_cells(procedure, index, measurement);
    m.within("td", &[], |m| {
        m.text(&measurement.measurand);
        if let Some(axis) = other_axis(procedure, measurement) {
            m.element("small", &[], axis);
        }
    });
    m.element("td", &[("class", "n")], &value);
    m.element("td", &[("class", "n")], &uncertainty);
    m.within("td", &[], |m| verdicts(m, procedure, index));
    let mut texts = point.map(point_notes).unwrap_or_default();
    texts.extend(measurement_notes(measurement));
    m.within("td", &[("class", "notes")], |m| notes(m, &texts));
}

/// The axis of a measurement that is not its procedure's, e.g. one of three gyros.
pub(super) fn other_axis<'a>(procedure: &ProcedureFindings, m: &'a Measurement) -> Option<&'a str> {
    (m.axis != procedure.axis).then_some(m.axis.as_str())
}

/// The verdict of every requirement that judged the measurement.
pub(super) fn verdicts(m: &mut Markup, procedure: &ProcedureFindings, index: usize) {
    let mut first = true;
    for judgement in procedure.judgements_of(index) {
        if !first {
            m.empty("br", &[]);
        }
        first = false;
        badge(m, words::verdict(judgement.verdict));
        m.text(" ");
        m.element("span", &[("class", "by")], &judgement.requirement);
    }
    if first {
        m.text("–");
    }
}

fn point_notes(point: &PointRow) -> Vec<String> {
    point.reason.iter().cloned().chain(point.excluded.iter().map(exclusion)).collect()
}

fn notes(m: &mut Markup, texts: &[String]) {
    let mut seen: Vec<&str> = Vec::new();
    for text in texts {
        if seen.contains(&text.as_str()) {
            continue;
        }
        if !seen.is_empty() {
            m.empty("br", &[]);
        }
        m.text(text);
        seen.push(text);
    }
}
