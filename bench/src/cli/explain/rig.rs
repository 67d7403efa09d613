//! Page about the safety parameters of a rig file: key, unit, recommended value, range, meaning and reason.

use super::settings::wrapped;
use crate::cycle::interlock::INTERLOCKS;
use crate::model::safety::{SAFETY_PARAMETERS, SafetyParameter};

/// Where what is said about a key begins.
const INDENT: &str = "      ";

/// The page, where `name` asks for it.
pub(super) fn page(name: &str) -> Option<String> {
    if !["rig", "safety", "sim"].contains(&name) {
        return None;
    }
    let mut lines = vec![
        "rig files: [axis.<name>.safety], for each axis".to_owned(),
        "All of these keys are required, except `safe-pose`.".to_owned(),
    ];
    lines.extend(SAFETY_PARAMETERS.iter().flat_map(entry));
    lines.extend([
        String::new(),
        "Interlocks (if several trip in the same tick, the first in this list is reported)".to_owned(),
    ]);
    lines.extend(INTERLOCKS.iter().flat_map(|lock| wrapped(&format!("  {}: ", lock.name), lock.doc)));
    Some(lines.join("\n"))
}

fn entry(p: &SafetyParameter) -> Vec<String> {
    let unit = p.kind().map_or(String::new(), |kind| format!(" [{}]", kind.display_unit()));
    let mut lines = vec![String::new(), format!("  {}{unit}  range {}", p.key, p.range())];
    lines.extend(wrapped(INDENT, p.doc));
    lines.extend(wrapped(INDENT, &format!("recommended {}: {}", p.recommended, p.reason)));
    lines
}
