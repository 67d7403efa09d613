//! The unit file of a twin: what was found with uncertainty and evidence, what is the base's.

use std::fmt::Write as _;

use procedures::quantity::QuantityKind;
use sim_devices::unit::{CURVES, Curve, FieldOfPart, PARAMETERS, Setting, UnitSettings};

use super::{Identified, IdentifiedCurve, IdentifiedSetting, Standing};
use crate::files::settings;

/// Columns of a line of comments.
const WIDTH: usize = 120;
/// Column in which the comments of settings begin.
const COMMENT_COLUMN: usize = 44;

/// A value of a setting in the unit that people write it in, to six digits.
pub(super) fn of_setting(setting: &Setting<FieldOfPart<UnitSettings>>, value_si: f64) -> String {
    settings::text(&setting.described(), value_si)
}

/// An uncertainty of a setting: two digits.
fn uncertainty(setting: &Setting<FieldOfPart<UnitSettings>>, u_si: f64) -> String {
    two_digits(&of_setting(setting, u_si))
}

/// The quantity with two significant digits.
fn two_digits(quantity: &str) -> String {
    let (number, unit) = quantity.split_once(' ').map_or((quantity, ""), |(number, unit)| (number, unit));
    let rounded = number.parse().and_then(|number: f64| format!("{number:.1e}").parse());
    let number =
        rounded.map_or_else(|_| number.to_owned(), |rounded: f64| QuantityKind::Count.format(rounded));
    format!("{number} {unit}").trim_end().to_owned()
}

/// What is said of a setting that is not simply determined.
fn word(standing: Standing) -> &'static str {
    match standing {
        Standing::Measured => "",
        Standing::Magnitude => "magnitude",
        Standing::InPart => "in part",
    }
}

/// A value of a curve.
fn of_curve(curve: &Curve, value_si: f64) -> String {
    let kind = settings::quantity_kind(curve.quantity).unwrap_or(QuantityKind::Ratio);
    // Ratios of structures are plain numbers in every text about them: damping 0.03, not 3 %.
    let unit = if kind == QuantityKind::Ratio { "" } else { kind.display_unit() };
    settings::in_unit(curve.quantity, unit, value_si)
}

/// What is found of a curve at each elevation, e.g. `38.5 Hz ± 0.02 Hz at 45 deg`.
fn points(found: &IdentifiedCurve) -> String {
    let curve = CURVES.iter().find(|c| c.table == found.table && c.key == found.key);
    let Some(curve) = curve else { return String::new() };
    let point = |(elevation_rad, value): &(f64, super::Value)| {
        let u = two_digits(&of_curve(curve, value.expanded_u_si()));
        format!("{} ± {u} at {:.1} deg", of_curve(curve, value.value_si), elevation_rad.to_degrees())
    };
    found.points.iter().map(point).collect::<Vec<_>>().join(", ")
}

/// The file. `said` are lines about the run for its head, `base` is how the file names its base.
pub fn unit_file(found: &Identified, id: &str, title: &str, base: &str, said: &[String]) -> String {
    let mut file = String::new();
    for line in said {
        comment(&mut file, line);
    }
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let _ =
        write!(file, "schema = 1\nid = {}\ntitle = {}\nbase = {}\n", quoted(id), quoted(title), quoted(base));
    let mut tables: Vec<&str> = found.settings.iter().map(|own| table_of(own.key).0).collect();
    tables.dedup();
    for table in tables {
        let _ = write!(file, "\n[{table}]\n");
        for own in found.settings.iter().filter(|own| table_of(own.key).0 == table) {
            setting_line(&mut file, found, own);
        }
    }
    let mut tables: Vec<&str> = found.curves.iter().map(|own| own.table).collect();
    tables.dedup();
    for table in tables {
        let _ = write!(file, "\n[{table}]\n");
        for own in found.curves.iter().filter(|own| own.table == table) {
            curve_lines(&mut file, found, own);
        }
    }
    let _ = writeln!(file);
    for (head, lines) in [("Contradictions:", &found.contradictions), ("Remarks:", &found.remarks)] {
        if !lines.is_empty() {
            comment(&mut file, head);
            lines.iter().for_each(|line| comment(&mut file, &format!("- {line}")));
        }
    }
    comment(
        &mut file,
        &format!("Not measured by this run, as in `{base}`: {}.", found.not_measured().join(", ")),
    );
    file
}

fn table_of(key: &str) -> (&str, &str) {
    key.split_once('.').unwrap_or(("", key))
}

fn setting_line(file: &mut String, found: &Identified, own: &IdentifiedSetting) {
    let Some(setting) = PARAMETERS.iter().find(|p| p.key == own.key) else { return };
    let value = of_setting(setting, setting.get(&found.unit));
    let line = format!("{} = \"{value}\"", table_of(own.key).1);
    let u = uncertainty(setting, own.value.expanded_u_si());
    let word = word(own.standing);
    let comma = if word.is_empty() { "" } else { ", " };
    let _ = writeln!(file, "{line:<COMMENT_COLUMN$}# {word}{comma}± {u}: {}", own.evidence.join(", "));
}

fn curve_lines(file: &mut String, found: &Identified, own: &IdentifiedCurve) {
    let Some(curve) = CURVES.iter().find(|c| c.table == own.table && c.key == own.key) else { return };
    let _ = writeln!(file, "# {}: {}", points(own), own.evidence.join(", "));
    let values: Vec<String> =
        curve.get(&found.unit).iter().map(|value| format!("\"{}\"", of_curve(curve, *value))).collect();
    let _ = writeln!(file, "{} = [", own.key);
    for line in wrapped(values.iter().map(|value| format!("{value},")), WIDTH - 20) {
        let _ = writeln!(file, "    {line}");
    }
    let _ = writeln!(file, "]");
}

impl Identified {
    /// Keys of settings and curves of which the run says nothing.
    pub(crate) fn not_measured(&self) -> Vec<String> {
        let settings = PARAMETERS.iter().map(|p| p.key.to_owned());
        let settings = settings.filter(|key| self.settings.iter().all(|own| own.key != key));
        let is_found =
            |c: &&Curve| self.curves.iter().any(|own| (own.table, own.key) == (c.table, c.key.as_str()));
        let curves = CURVES.iter().filter(|c| !c.get(&self.unit).is_empty() && !is_found(c));
        settings.chain(curves.map(|c| format!("{}.{}", c.table, c.key))).collect()
    }

    /// A row for each setting and curve: key, the base's value, that of the twin, U, a word, evidence.
    pub(crate) fn rows(&self, base: &UnitSettings) -> Vec<Vec<String>> {
        let scalar = |own: &IdentifiedSetting| {
            let setting = PARAMETERS.iter().find(|p| p.key == own.key)?;
            Some(vec![
                own.key.to_owned(),
                of_setting(setting, setting.get(base)),
                of_setting(setting, setting.get(&self.unit)),
                uncertainty(setting, own.value.expanded_u_si()),
                word(own.standing).to_owned(),
                own.evidence.join(", "),
            ])
        };
        let curve = |own: &IdentifiedCurve| {
            let nothing = String::new();
            let key = format!("{}.{}", own.table, own.key);
            vec![key, "curve".to_owned(), points(own), nothing.clone(), nothing, own.evidence.join(", ")]
        };
        self.settings.iter().filter_map(scalar).chain(self.curves.iter().map(curve)).collect()
    }
}

/// A comment, over several lines if it is long.
fn comment(file: &mut String, text: &str) {
    for line in wrapped(text.split_whitespace().map(str::to_owned), WIDTH - 2) {
        let _ = writeln!(file, "# {line}");
    }
}

/// Words in lines of at most so many characters; a longer word has a line of its own.
fn wrapped(words: impl Iterator<Item = String>, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in words {
        let last = lines.last_mut().expect("there is a line");
        if last.is_empty() {
            last.push_str(&word);
        } else if last.chars().count() + 1 + word.chars().count() <= width {
            last.push(' ');
            last.push_str(&word);
        } else {
            lines.push(word);
        }
    }
    lines
}
