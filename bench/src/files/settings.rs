//! Reads settings that a crate describes as a table of parameters (key, kind of quantity, range, default).

use procedures::quantity::QuantityKind;
use procedures::table::{Field, Need, Shape, TableReader};

/// One parameter, stripped of what it is set on.
#[derive(Clone, Copy, Debug)]
pub struct Described {
    /// Dotted key, e.g. `az.coulomb-torque`.
    pub key: &'static str,
    /// Kind of quantity by its kebab-case name.
    pub quantity: &'static str,
    /// Smallest allowed SI value.
    pub min_si: f64,
    /// Largest allowed SI value.
    pub max_si: f64,
    /// One sentence.
    pub doc: &'static str,
}

impl Described {
    fn table_and_key(&self) -> (&'static str, &'static str) {
        self.key.split_once('.').unwrap_or(("", self.key))
    }
}

/// The tables that the keys name, each once.
fn tables(parameters: &[Described]) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = parameters.iter().map(|p| p.table_and_key().0).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The kind of quantity of this kebab-case name.
pub fn quantity_kind(name: &str) -> Option<QuantityKind> {
    serde_json::from_value(serde_json::Value::String(name.to_owned())).ok()
}

/// The fields of a file with these parameters: one table per first word of the keys, every key optional.
pub fn fields(head: &[Field], parameters: &[Described]) -> &'static [Field] {
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
pub fn read(t: &mut TableReader<'_>, parameters: &[Described]) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    for table in tables(parameters) {
        if table.is_empty() {
            found.extend(read_table(t, parameters, table));
        } else {
            found.extend(t.table(table, |t| Some(read_table(t, parameters, table))).unwrap_or_default());
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
        if (parameter.min_si..=parameter.max_si).contains(&value_si) {
            found.push((index, value_si));
        } else {
            t.mistake(key, out_of_range(parameter, value_si), Some(parameter.doc.to_owned()));
        }
    }
    found
}

fn out_of_range(parameter: &Described, value_si: f64) -> String {
    let kind = quantity_kind(parameter.quantity).unwrap_or(QuantityKind::Ratio);
    format!(
        "expected {} to {}, found {}",
        kind.format(parameter.min_si),
        kind.format(parameter.max_si),
        kind.format(value_si)
    )
}
