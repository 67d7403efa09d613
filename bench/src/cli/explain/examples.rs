//! Keys of files with type, default, what they mean, and how a shipped file uses them.

use procedures::table::{Field, Need, Shape};
use toml::{Table, Value};

use super::settings::wrapped;
use crate::files::shipped::{self, Folder};

/// Longest example; a longer list is cut.
const LONGEST: usize = 90;

/// Shipped tables to take examples from, each with the name of its file.
pub(super) struct Examples(Vec<(String, Table)>);

impl Examples {
    /// Procedures of a kind.
    pub(super) fn of_kind(kind: &str) -> Self {
        let all = tables(Folder::Procedures);
        Self(all.filter(|(_, table)| table.get("kind").and_then(Value::as_str) == Some(kind)).collect())
    }

    /// Files of a folder that are of this sort.
    pub(super) fn of_folder(folder: Folder, is: impl Fn(&Table) -> bool) -> Self {
        Self(tables(folder).filter(|(_, table)| is(table)).collect())
    }

    /// Of a sort of file of which none is shipped.
    pub(super) fn none() -> Self {
        Self(Vec::new())
    }

    /// Devices of a driver, in the shipped rigs.
    pub(super) fn of_driver(driver: &str) -> Self {
        let devices = tables(Folder::Rigs).flat_map(|(file, rig)| {
            let devices = rig.get("device").and_then(Value::as_array).cloned().unwrap_or_default();
            devices.into_iter().filter_map(move |device| match device {
                Value::Table(device) => Some((file.clone(), device)),
                _ => None,
            })
        });
        Self(
            devices
                .filter(|(_, table)| table.get("driver").and_then(Value::as_str) == Some(driver))
                .collect(),
        )
    }

    /// What most files that set the key set it to, with the first of them.
    fn find(&self, path: &str) -> Option<(&str, String)> {
        let all: Vec<(&str, String)> = self
            .0
            .iter()
            .filter_map(|(file, table)| Some((file.as_str(), written(at(table, path)?)?)))
            .collect();
        let files = |value: &str| all.iter().filter(|(_, other)| other == value).count();
        // Of several that as many files have, the first.
        all.iter().rev().max_by_key(|(_, value)| files(value)).cloned()
    }
}

fn tables(folder: Folder) -> impl Iterator<Item = (String, Table)> {
    shipped::all(folder).filter_map(|entry| Some((entry.path.to_owned(), entry.text.parse::<Table>().ok()?)))
}

/// The value at a path such as `excitation.level`; of an array of tables the first that has the key.
fn at<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    let (key, rest) = path.split_once('.').unwrap_or((path, ""));
    match table.get(key)? {
        value if rest.is_empty() => Some(value),
        Value::Array(all) => all.iter().find_map(|inside| at(inside.as_table()?, rest)),
        inside => at(inside.as_table()?, rest),
    }
}

/// A value as it stands in a file, on one line; a longer list is cut, a longer table is none.
fn written(value: &Value) -> Option<String> {
    let Value::Array(items) = value else {
        let text = value.to_string();
        return (!value.is_table() || text.len() <= LONGEST).then_some(text);
    };
    let mut text = String::from("[");
    for (index, item) in items.iter().enumerate() {
        let item = item.to_string();
        if text.len() + item.len() > LONGEST {
            text.push_str(", ...");
            break;
        }
        text.push_str(if index == 0 { "" } else { ", " });
        text.push_str(&item);
    }
    text.push(']');
    Some(text)
}

/// A key and the keys inside it.
pub(super) fn keys(prefix: &str, field: &Field, examples: &Examples) -> Vec<String> {
    let need = match field.need {
        Need::Required => "required".to_owned(),
        Need::Optional => "optional".to_owned(),
        Need::Default(text) => format!("default {text}"),
    };
    let name = format!("{prefix}{}", field.key);
    let mut lines = vec![format!("  {name} ({}; {need})", field.shape.expectation())];
    lines.extend(wrapped("      ", field.doc));
    if let Shape::Table(inside) | Shape::Tables(inside) = field.shape {
        // Its keys have examples of their own.
        lines.extend(inside.iter().flat_map(|f| keys(&format!("{name}."), f, examples)));
    } else if let Some((file, value)) = examples.find(&name) {
        lines.push(format!("      {} = {value}    ({file})", field.key));
    }
    lines
}
