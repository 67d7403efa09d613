//! A procedure from its file.

use super::{FIELDS, GATES, Procedure, ValidIf, WrittenPose, prompt};
use crate::condition;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::Kind;
use crate::quantity::{Limit, QuantityKind};
use crate::table::{TableReader, read_file, suggestion};

/// A point must begin while the answers to its safety prompts, given before it cools down, still hold (30 min).
const LONGEST_COOL_DOWN_S: f64 = 25.0 * 60.0;
/// Keys of kinds that say where the axes of a gimbal stand.
const POSE_KEYS: [&str; 2] = ["azimuth", "elevation"];
/// How long an id may be: it names files.
const LONGEST_ID: usize = 64;

pub(super) fn procedure(source: SourceFile, kinds: &'static [Kind]) -> Result<Procedure, Vec<Diagnostic>> {
    let unnamed = read_file(&source, FIELDS, |table| {
        table.schema();
        let id = id(table);
        let title = table.text("title");
        let axis = table.text("axis");
        let axis_span = table.span("axis");
        let log_rate_hz = if table.has("log-rate") { table.positive("log-rate") } else { None };
        let gates = gates(table);
        let valid_if = valid_if(table);
        let cool_down_s = if table.has("cool-down") { table.positive("cool-down") } else { None };
        if cool_down_s.is_some() && gates.iter().all(|(name, _)| name != HEAT_SINK) {
            let help = "add `heat-sink = \"< 60 degC\"` under `[gate]`, or remove `cool-down`".to_owned();
            table.mistake(
                "cool-down",
                format!("`cool-down` waits for the gate `{HEAT_SINK}`, which is not given"),
                Some(help),
            );
        }
        if cool_down_s.is_some_and(|s| s > LONGEST_COOL_DOWN_S) {
            let most = format!("expected at most {} min, found more", LONGEST_COOL_DOWN_S / 60.0);
            let help = "an answer to a safety prompt, given before the wait, is valid for 30 min: use more \
                        points with a shorter duty each";
            table.mistake("cool-down", most, Some(help.to_owned()));
        }
        let prompts = prompt::read(table);
        let kind = kind(table, kinds);
        let experiment = kind.and_then(|kind| {
            table.extend(kind.fields);
            (kind.read)(table)
        });
        let poses = POSE_KEYS.into_iter().filter(|key| table.has(key));
        let poses = poses.map(|key| WrittenPose { key, span: table.span(key) }).collect();
        let source = SourceFile { name: String::new(), text: String::new() };
        let kind = kind?;
        let experiment = experiment?;
        Some(Procedure {
            id: id?,
            title: title?,
            kind: kind.name,
            axis: axis?,
            log_rate_hz,
            gates,
            cool_down_s,
            valid_if,
            prompts,
            yields: experiment.yields().unwrap_or_else(|| kind.measurands.iter().map(|m| m.name).collect()),
            experiment,
            source,
            axis_span,
            poses,
        })
    })?;
    Ok(Procedure { source, ..unnamed })
}

fn id(table: &mut TableReader<'_>) -> Option<String> {
    let id = table.text("id")?;
    if is_harmless(&id) {
        return Some(id);
    }
    let message = format!("`id` must be 1 to {LONGEST_ID} letters, digits, `-` and `_`, found `{id}`");
    table.mistake("id", message, Some("files are named after it".to_owned()));
    None
}

/// Whether a name can name a file and be typed.
pub(crate) fn is_harmless(id: &str) -> bool {
    let harmless = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    !id.is_empty() && id.len() <= LONGEST_ID && id.chars().all(harmless)
}

/// The kind; without one it cannot be told which other keys belong to the file.
fn kind(table: &mut TableReader<'_>, kinds: &'static [Kind]) -> Option<&'static Kind> {
    let name = table.text("kind");
    let found = name.as_deref().and_then(|name| kinds.iter().find(|kind| kind.name == name));
    if found.is_none() {
        table.accept_any_key();
        if let Some(name) = name {
            let help = suggestion(&name, kinds.iter().map(|kind| kind.name));
            table.mistake("kind", format!("unknown kind `{name}`"), Some(help));
        }
    }
    found
}

fn gates(table: &mut TableReader<'_>) -> Vec<(String, Limit)> {
    let mut gates = Vec::new();
    for entry in table.lists("gate").unwrap_or_default() {
        let Some((_, kind)) = GATES.iter().find(|(name, _)| *name == entry.key) else {
            let help = suggestion(&entry.key, GATES.iter().map(|(name, _)| *name));
            table.mistake_at(entry.key_span, format!("unknown gate `{}`", entry.key), Some(help));
            continue;
        };
        for (text, span) in entry.texts {
            match kind.parse_limit(&text) {
                Ok(limit) => gates.push((entry.key.clone(), limit)),
                Err(error) => table.mistake_at(span, format!("`{}`: {error}", entry.key), error.help()),
            }
        }
    }
    gates
}

/// The gate that cooling down opens.
const HEAT_SINK: &str = "heat-sink";

const DROPPED_CYCLES: &str = "dropped-cycles";

fn valid_if(table: &mut TableReader<'_>) -> Vec<ValidIf> {
    let mut all = Vec::new();
    for (key, text, span) in table.map("valid-if").unwrap_or_default() {
        let (read, example) = if key == DROPPED_CYCLES {
            (dropped_cycles(&text), "< 0.1 %, longest < 5 ms")
        } else if condition::kind_of(&key).is_some() {
            (near(&key, &text), "within 5 % of requested")
        } else {
            let help = suggestion(&key, condition::names().chain([DROPPED_CYCLES]));
            table.mistake_at(span, format!("unknown condition `{key}`"), Some(help));
            continue;
        };
        match read {
            Some(valid) => all.push(valid),
            None => {
                let message = format!("`{key}` must be such as `\"{example}\"`, found `{text}`");
                table.mistake_at(span, message, None);
            }
        }
    }
    all
}

/// `within 5 % of requested`
fn near(condition: &str, text: &str) -> Option<ValidIf> {
    let ratio = text.trim().strip_prefix("within ")?.trim_end().strip_suffix("of requested")?;
    let ratio = QuantityKind::Ratio.parse(ratio).ok().filter(|ratio| *ratio > 0.0)?;
    Some(ValidIf::Near { condition: condition.to_owned(), ratio })
}

/// `< 0.1 %, longest < 5 ms`
fn dropped_cycles(text: &str) -> Option<ValidIf> {
    let (ratio, longest) = text.split_once(',')?;
    let below = |kind: QuantityKind, text: &str| kind.parse_limit(text).ok()?.high.filter(|high| *high > 0.0);
    let ratio = below(QuantityKind::Ratio, ratio)?;
    let longest_s = below(QuantityKind::Time, longest.trim().strip_prefix("longest")?)?;
    Some(ValidIf::DroppedCycles { ratio, longest_s })
}
