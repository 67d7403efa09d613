//! Where in a procedure's file a mistake lies that only planning finds.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, SourceFile};

/// The mistake at the first key of the file that its message names; at `kind` where it names none.
pub(super) fn found(mistake: Diagnostic, source: &SourceFile) -> Diagnostic {
    let keys = keys(&source.text);
    let is_named = |key: &str| words(&mistake.message).any(|word| word == key);
    // What a table holds says more than the head of the file, which messages often name besides.
    let named = keys.iter().filter(|(key, _)| !HEAD.contains(key)).find(|(key, _)| is_named(key));
    let named = named.or_else(|| keys.iter().find(|(key, _)| is_named(key)));
    let place = named.or_else(|| keys.iter().find(|(key, _)| *key == "kind"));
    match place {
        Some((_, span)) => mistake.at(source, span.clone()),
        None => mistake.in_file(source),
    }
}

/// Keys that every procedure has.
const HEAD: [&str; 5] = ["schema", "id", "title", "kind", "axis"];

/// Keys at the beginnings of lines, each with the place of what stands behind its sign of equality.
fn keys(text: &str) -> Vec<(&str, Range<usize>)> {
    let mut all = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        if let Some((key, value)) = line.split_once('=') {
            let key = key.trim();
            let is_key =
                !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'));
            let from = start + line.len() - value.trim_start().len();
            let value = value.trim_start().trim_end();
            let value = value.split(" #").next().unwrap_or(value).trim_end();
            if is_key {
                all.push((key, from..from + value.len()));
            }
        }
        start += line.len();
    }
    all
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-' || c == '_')).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "id = \"P\"\nkind = \"hysteresis\"\naxis = \"az\"\n\n[sweep]\nvelocity = [\"1 deg/s\"] # slow\nspan = \"-1 deg .. 1 deg\"\n";

    #[test]
    fn a_mistake_of_the_plan_points_at_the_key_that_it_names() {
        let source = SourceFile::new("p.toml", FILE);
        let at = |message: &str| {
            found(Diagnostic::new(message), &source).excerpt.map(|(line, columns)| {
                line.chars().skip(columns.start).take(columns.len()).collect::<String>()
            })
        };
        assert_eq!(
            at("span -1 deg .. 1 deg exceeds the soft limits of axis `az`").as_deref(),
            Some("\"-1 deg .. 1 deg\"")
        );
        assert_eq!(at("velocity 90 deg/s is above the axis' 62 deg/s").as_deref(), Some("[\"1 deg/s\"]"));
        assert_eq!(at("the rig has no camera").as_deref(), Some("\"hysteresis\""));
        assert_eq!(at("axis `az` has no encoder").as_deref(), Some("\"az\""));
    }
}
