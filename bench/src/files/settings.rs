//! Reads settings that a crate describes as a table of parameters (key, kind of quantity, range, default).

use controllers::parameter::Parameter;
use procedures::quantity::QuantityKind;
use procedures::table::{Field, Need, Shape, TableReader};
use sim_devices::unit::Setting;

/// One setting or gain, without the place where its value lies.
pub(crate) type Described = Setting<()>;

/// What a file may say of a gain.
pub(crate) fn of_gain<S>(gain: &Parameter<S>) -> Described {
    let &Parameter { key, quantity, range_si, default, doc, source, .. } = gain;
    Described { key, quantity, range_si, default, doc, source, field: () }
}

/// A value of a setting as text, in the unit that its default is written in.
pub(crate) fn text(setting: &Described, value_si: f64) -> String {
    let unit = setting.default.split_once(' ').map_or("", |(_, unit)| unit);
    in_unit(setting.quantity, unit, value_si)
}

/// The value as text in this unit; plain for a ratio or count without one.
pub(crate) fn in_unit(quantity: &str, unit: &str, value_si: f64) -> String {
    match number_in(quantity, unit, value_si) {
        Some(number) if unit.is_empty() => number,
        Some(number) => format!("{number} {unit}"),
        None => quantity_kind(quantity).unwrap_or(QuantityKind::Ratio).format(value_si),
    }
}

/// The number alone, with up to six significant digits; nothing if the quantity has no such unit.
pub(crate) fn number_in(quantity: &str, unit: &str, value_si: f64) -> Option<String> {
    let one_si = quantity_kind(quantity)?.parse(&format!("1 {unit}")).ok()?;
    Some(QuantityKind::Count.format(value_si / one_si))
}

/// The tables that the keys name, each once.
fn tables(parameters: &[Described]) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = parameters.iter().map(|p| p.table_and_key().0).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The kind of quantity of this kebab-case name.
pub(crate) fn quantity_kind(name: &str) -> Option<QuantityKind> {
    serde_json::from_value(serde_json::Value::String(name.to_owned())).ok()
}

/// The fields of a file with these parameters: one table per first word of the keys, every key optional.
pub(crate) fn fields(head: &[Field], parameters: &[Described]) -> &'static [Field] {
    let mut all = head.to_vec();
    for table in tables(parameters) {
        let inside: Vec<Field> = parameters
            .iter()
            .filter(|p| p.table_and_key().0 == table)
            .map(|p| Field {
                key: p.table_and_key().1,
                shape: Shape::Quantity(quantity_kind(p.quantity).unwrap_or(QuantityKind::Ratio)),
                need: Need::Optional,
                doc: p.doc,
            })
            .collect();
        if table.is_empty() {
            all.extend(inside);
        } else {
            let shape = Shape::Table(Vec::leak(inside));
            all.push(Field { key: table, shape, need: Need::Optional, doc: "Settings of one part." });
        }
    }
    Vec::leak(all)
}

/// Reads the parameters that the file gives, as (index, SI value), checking each one's range.
pub(crate) fn read(t: &mut TableReader<'_>, parameters: &[Described]) -> Vec<(usize, f64)> {
    read_with(t, parameters, |_, _| {})
}

/// Reads the parameters as [`read`] does. `also` reads the further keys of a table, whose name it gets.
pub(crate) fn read_with(
    t: &mut TableReader<'_>,
    parameters: &[Described],
    mut also: impl FnMut(&mut TableReader<'_>, &'static str),
) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    for table in tables(parameters) {
        if table.is_empty() {
            found.extend(read_table(t, parameters, table));
        } else {
            let read = |t: &mut TableReader<'_>| {
                also(t, table);
                Some(read_table(t, parameters, table))
            };
            found.extend(t.table(table, read).unwrap_or_default());
        }
    }
    found
}

fn read_table(t: &mut TableReader<'_>, parameters: &[Described], table: &str) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    for (index, parameter) in parameters.iter().enumerate() {
        let (of, key) = parameter.table_and_key();
        if of != table {
            continue;
        }
        let Some(value_si) = t.quantity(key) else { continue };
        if parameter.allows(value_si) {
            found.push((index, value_si));
        } else {
            t.mistake(key, out_of_range(parameter, value_si), Some(parameter.doc.to_owned()));
        }
    }
    found
}

fn out_of_range(parameter: &Described, value_si: f64) -> String {
    let [least, most] = parameter.range_si.map(|limit_si| text(parameter, limit_si));
    let found = text(parameter, value_si);
    format!("`{}` must be {least} to {most}, found {found}", parameter.table_and_key().1)
}
