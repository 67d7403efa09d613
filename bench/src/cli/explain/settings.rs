//! Pages about units and controller parameters: every setting with its value, range, default, meaning and source.

use controllers::parameter::{PARAMETERS as GAINS, VELOCITY_LAW};
use controllers::velocity::{LAWS, VelocityLaw};
use procedures::quantity::QuantityKind;
use procedures::table::quoted;
use sim_devices::unit::{
    AXIS_PARAMETERS, CURVES, Curve, PARAMETERS, TABLE_PARAMETERS, TableAxis, TableSettings, UnitSettings,
};

use crate::files::parameters;
use crate::files::settings::{Described, in_unit, number_in, quantity_kind, text};
use crate::files::unit;
use crate::site::unit::{Unit, World};

/// Widest line of a page.
const WIDTH: usize = 110;
/// Where what is said about a setting begins.
const INDENT: &str = "      ";
const LEGEND: &str = "* differs from the default";

/// The page of a unit.
pub(super) fn of_unit(unit: &Unit) -> String {
    let mut lines = head(unit);
    lines.extend(from_base(unit));
    lines.push(LEGEND.to_owned());
    lines.extend(match &unit.world {
        World::Director(settings) => of_director(settings),
        World::Table(settings) => of_table(settings),
    });
    lines.join("\n")
}

/// What differs from the unit's base, before the long list of all settings.
fn from_base(unit: &Unit) -> Vec<String> {
    let Some(base) = unit.sources.get(1).and_then(|source| unit::load_unit(&source.name).ok()) else {
        return Vec::new();
    };
    let mut lines = vec![String::new(), format!("Differs from its base {}:", unit.sources[1].name)];
    let rows = match (&unit.world, &base.world) {
        (World::Director(own), World::Director(base)) => director_differences(own, base),
        (World::Table(own), World::Table(base)) => table_differences(own, base),
        _ => Vec::new(),
    };
    if rows.is_empty() {
        lines.push("  nothing".to_owned());
    }
    lines.extend(rows);
    lines.push(String::new());
    lines
}

fn director_differences(own: &UnitSettings, base: &UnitSettings) -> Vec<String> {
    let settings = unit::described().iter().zip(PARAMETERS.iter());
    let mut rows: Vec<String> =
        settings.filter_map(|(d, p)| difference("", d, [p.get(own), p.get(base)])).collect();
    for curve in CURVES.iter().filter(|curve| curve.get(own) != curve.get(base)) {
        let [own, base] = [own, base].map(|settings| listed(curve, curve.get(settings)));
        rows.extend(wrapped(
            &format!("  [{}] {} = ", curve.table, curve.key),
            &format!("{own} (base: {base})"),
        ));
    }
    rows
}

fn table_differences(own: &TableSettings, base: &TableSettings) -> Vec<String> {
    let settings = unit::described_table().iter().zip(TABLE_PARAMETERS.iter());
    let mut rows: Vec<String> =
        settings.filter_map(|(d, p)| difference("", d, [p.get(own), p.get(base)])).collect();
    for axis in &own.axes {
        let there = base.axes.iter().find(|there| there.name == axis.name);
        let there = there.map_or_else(|| TableAxis::new(&axis.name).settings, |there| there.settings.clone());
        let table = format!("axis.{}", axis.name);
        let settings = unit::described_axis().iter().zip(AXIS_PARAMETERS.iter());
        rows.extend(
            settings.filter_map(|(d, p)| difference(&table, d, [p.get(&axis.settings), p.get(&there)])),
        );
    }
    rows
}

/// A setting that differs between a unit and its base; `table` where its own name does not say it.
fn difference(table: &str, described: &Described, [own_si, base_si]: [f64; 2]) -> Option<String> {
    if !differs(own_si, base_si) {
        return None;
    }
    let (own_table, key) = described.table_and_key();
    let table = if own_table.is_empty() { table } else { own_table };
    let place = if table.is_empty() { String::new() } else { format!("[{table}] ") };
    Some(format!("  {place}{key} = {} (base: {})", text(described, own_si), text(described, base_si)))
}

fn of_director(settings: &UnitSettings) -> Vec<String> {
    let nominal = UnitSettings::default();
    let rows = unit::described().iter().zip(PARAMETERS.iter()).map(|(described, p)| {
        let value_si = p.get(settings);
        Row { described, value_si, differs: differs(value_si, p.get(&nominal)) }
    });
    let mut lines = groups(&rows.collect::<Vec<_>>());
    for table in unit::structure_tables() {
        lines.extend([String::new(), format!("[{table}]")]);
        let of_table = CURVES.iter().filter(|c| c.table == table);
        lines.extend(of_table.flat_map(|c| of_curve(c, c.get(settings), c.get(&nominal))));
    }
    lines
}

fn of_table(settings: &TableSettings) -> Vec<String> {
    let built_in = TableSettings::without_axes();
    let rows = unit::described_table().iter().zip(TABLE_PARAMETERS.iter()).map(|(described, p)| {
        let value_si = p.get(settings);
        Row { described, value_si, differs: differs(value_si, p.get(&built_in)) }
    });
    let mut lines = groups(&rows.collect::<Vec<_>>());
    for axis in &settings.axes {
        lines.extend([String::new(), format!("[axis.{}]", axis.name)]);
        let built_in = TableAxis::new(&axis.name);
        let rows = unit::described_axis().iter().zip(AXIS_PARAMETERS.iter()).map(|(described, p)| {
            let value_si = p.get(&axis.settings);
            Row { described, value_si, differs: differs(value_si, p.get(&built_in.settings)) }
        });
        let rows: Vec<Row<'_>> = rows.collect();
        lines.extend(group(&rows.iter().collect::<Vec<_>>()));
    }
    lines
}

/// The page of a set of controller parameters.
pub(super) fn of_gains(name: &str) -> Option<String> {
    let (id, gains) = parameters::named(name, None).ok()?;
    let rows = parameters::described().iter().zip(GAINS).map(|(described, p)| {
        let value_si = (p.get)(&gains);
        let kind = quantity_kind(p.quantity);
        let differs = kind.and_then(|k| k.parse(p.default).ok()).is_none_or(|d| differs(value_si, d));
        Row { described, value_si, differs }
    });
    let mut lines = vec![format!("controller parameters {id}"), LEGEND.to_owned()];
    let rows: Vec<Row<'_>> = rows.collect();
    for table in tables(&rows) {
        lines.extend(group_under(table, &rows));
        match table {
            "az" => lines.extend(law(gains.az.velocity_law)),
            "el" => lines.extend(law(gains.el.velocity_law)),
            _ => {}
        }
    }
    Some(lines.join("\n"))
}

/// The law of a velocity loop, as the settings around it.
fn law(own: VelocityLaw) -> Vec<String> {
    let mark = if own == VelocityLaw::DEFAULT { ' ' } else { '*' };
    let (value, default) = (own.name(), VelocityLaw::DEFAULT.name());
    let words = quoted(LAWS.iter().map(|law| law.name));
    let mut lines = vec![format!("{mark} {VELOCITY_LAW} = {value}  default {default}  one of {words}")];
    lines.extend(wrapped(INDENT, parameters::law_doc()));
    lines
}

/// By more than the rounding of unit conversions.
fn differs(value_si: f64, default_si: f64) -> bool {
    (value_si - default_si).abs() > 1e-12 * default_si.abs()
}

fn head(unit: &Unit) -> Vec<String> {
    let mut lines = vec![format!("unit {}: {}", unit.id, unit.title)];
    let bases: Vec<&str> = unit.sources.iter().map(|s| s.name.as_str()).collect();
    lines.push(format!("  files: {}", bases.join(", on ")));
    lines.extend(unit.reason.iter().flat_map(|r| wrapped("  reason: ", r)));
    if !unit.must_flip.is_empty() {
        lines.push(format!("  must make fail: {}", unit.must_flip.join(" ")));
    }
    if !unit.may_flip.is_empty() {
        lines.push(format!("  may change the verdict of: {}", unit.may_flip.join(" ")));
    }
    lines.extend(unit.must_trip.iter().map(|trip| format!("  must trip: {trip}")));
    lines
}

/// One setting as a unit or parameter set has it.
struct Row<'a> {
    described: &'a Described,
    value_si: f64,
    differs: bool,
}

/// Settings under a heading per table, the columns of each table aligned.
fn groups(rows: &[Row<'_>]) -> Vec<String> {
    tables(rows).into_iter().flat_map(|table| group_under(table, rows)).collect()
}

/// The tables of these rows, each once.
fn tables<'a>(rows: &[Row<'a>]) -> Vec<&'a str> {
    let mut tables: Vec<&str> = Vec::new();
    for row in rows {
        let table = row.described.table_and_key().0;
        if !tables.contains(&table) {
            tables.push(table);
        }
    }
    tables
}

/// The rows of a table under its heading.
fn group_under(table: &str, rows: &[Row<'_>]) -> Vec<String> {
    let mut lines = vec![String::new()];
    if !table.is_empty() {
        lines.push(format!("[{table}]"));
    }
    let inside: Vec<&Row<'_>> = rows.iter().filter(|r| r.described.table_and_key().0 == table).collect();
    lines.extend(group(&inside));
    lines
}

fn group(rows: &[&Row<'_>]) -> Vec<String> {
    let cells: Vec<[String; 4]> = rows.iter().map(|row| row.cells()).collect();
    let width = |column: usize| cells.iter().map(|c| c[column].chars().count()).max().unwrap_or(0);
    let key_width = width(0);
    let value_width = width(1);
    let default_width = width(2);
    let mut lines = Vec::new();
    for (row, [key, value, default, range]) in rows.iter().zip(&cells) {
        let mark = if row.differs { '*' } else { ' ' };
        let columns =
            format!("{mark} {key:key_width$} = {value:value_width$}  {default:default_width$}  {range}");
        lines.push(columns.trim_end().to_owned());
        let Described { doc, source, .. } = row.described;
        lines.extend(wrapped(INDENT, &format!("{doc} Source: {source}")));
    }
    lines
}

impl Row<'_> {
    fn cells(&self) -> [String; 4] {
        let d = self.described;
        let value = if self.differs { text(d, self.value_si) } else { d.default.to_owned() };
        let [least, most] = d.range_si.map(|limit_si| text(d, limit_si));
        [
            d.table_and_key().1.to_owned(),
            value,
            format!("default {}", d.default),
            format!("range {least} .. {most}"),
        ]
    }
}

fn of_curve(curve: &Curve, values: &[f64], nominal: &[f64]) -> Vec<String> {
    let unit = unit_of(curve);
    let [least, most] = curve.range_si.map(|end| in_unit(curve.quantity, unit, end));
    let differs = values != nominal;
    let mark = if differs { '*' } else { ' ' };
    let mut lines = wrapped(&format!("{mark} {:16} = ", curve.key), &listed(curve, values));
    let default = if differs { listed(curve, nominal) } else { "the same".to_owned() };
    lines.extend(wrapped(INDENT, &format!("default {default}")));
    lines.push(format!("{INDENT}range {least} .. {most}"));
    lines.extend(wrapped(INDENT, &format!("{} Source: {}", curve.doc, curve.source)));
    lines
}

/// The unit that the values of a curve are printed in; ratios are plain numbers.
fn unit_of(curve: &Curve) -> &'static str {
    match quantity_kind(curve.quantity) {
        None | Some(QuantityKind::Ratio) => "",
        Some(kind) => kind.display_unit(),
    }
}

fn listed(curve: &Curve, values: &[f64]) -> String {
    if values.is_empty() {
        return "absent".to_owned();
    }
    let unit = unit_of(curve);
    let number = |&value: &f64| number_in(curve.quantity, unit, value).unwrap_or_else(|| value.to_string());
    let numbers: Vec<String> = values.iter().map(number).collect();
    format!("{} {unit}", numbers.join(" ")).trim_end().to_owned()
}

/// Words after a first part, on as many lines as they need; the further ones indented.
pub(super) fn wrapped(first: &str, text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = first.to_owned();
    let mut begun = false;
    for word in text.split_whitespace() {
        if begun && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(std::mem::replace(&mut line, INDENT.to_owned()));
            begun = false;
        }
        if begun {
            line.push(' ');
        }
        line.push_str(word);
        begun = true;
    }
    lines.push(line);
    lines
}
