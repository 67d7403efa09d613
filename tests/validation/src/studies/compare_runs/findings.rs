//! Findings of two runs of one campaign.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

/// Keys that name an element of a list, so that one element more does not shift all behind it.
const NAMING: [&str; 4] = ["id", "requirement", "name", "what"];

/// One line a value that differs.
///
/// # Errors
/// When a file cannot be read or is no JSON.
pub(crate) fn compare(before: &Path, after: &Path) -> Result<Vec<String>, String> {
    let mut lines = Vec::new();
    differ("", &read(before)?["findings"], &read(after)?["findings"], &mut lines);
    Ok(lines)
}

fn read(path: &Path) -> Result<Value, String> {
    let said = |reason: String| format!("{}: {reason}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| said(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| said(e.to_string()))
}

fn differ(place: &str, before: &Value, after: &Value, lines: &mut Vec<String>) {
    match (before, after) {
        (Value::Object(was), Value::Object(is)) => {
            let keys: BTreeSet<&String> = was.keys().chain(is.keys()).collect();
            // A hash stands for a file, and a file may change by design.
            for key in keys.into_iter().filter(|key| !key.ends_with("sha256")) {
                differ(
                    &format!("{place}.{key}"),
                    was.get(key).unwrap_or(&Value::Null),
                    is.get(key).unwrap_or(&Value::Null),
                    lines,
                );
            }
        }
        (Value::Array(was), Value::Array(is)) => differing_lists(place, was, is, lines),
        _ if before == after => {}
        _ => lines.push(format!("{place}: {after}, before {before}{}", relative(before, after))),
    }
}

fn differing_lists(place: &str, before: &[Value], after: &[Value], lines: &mut Vec<String>) {
    let names = |list: &[Value]| list.iter().map(name).collect::<Option<Vec<String>>>();
    if let (Some(was), Some(is)) = (names(before), names(after)) {
        let all: BTreeSet<&String> = was.iter().chain(&is).collect();
        if all.len() == was.len().max(is.len()) {
            for key in all {
                let find = |names: &[String], list: &[Value]| {
                    names.iter().position(|n| n == key).map_or(Value::Null, |k| list[k].clone())
                };
                differ(&format!("{place}[{key}]"), &find(&was, before), &find(&is, after), lines);
            }
            return;
        }
    }
    if before.len() != after.len() {
        lines.push(format!("{place}: {} elements, before {}", after.len(), before.len()));
    }
    for (k, (was, is)) in before.iter().zip(after).enumerate() {
        differ(&format!("{place}[{k}]"), was, is, lines);
    }
}

fn name(element: &Value) -> Option<String> {
    NAMING.iter().find_map(|key| Some(element.get(key)?.as_str()?.to_owned()))
}

/// How large a difference of two numbers is beside the larger of them.
fn relative(before: &Value, after: &Value) -> String {
    let (Some(was), Some(is)) = (before.as_f64(), after.as_f64()) else { return String::new() };
    format!(" ({:+.1e} of it)", (is - was) / was.abs().max(is.abs()))
}
