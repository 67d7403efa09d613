//! Regular expressions (ECMA 262) for JSON Schema: what may be written where a quantity, a range or a limit stands.
//!
//! They take whatever the parser takes, and a little more: `m2` for `m^2` in any unit. Size and order of numbers are not theirs.

use super::{QuantityKind, unit};

const NUMBER: &str = r"[+\-−]?[0-9]+(?:\.[0-9]+)?(?:[eE][+\-−]?[0-9]+)?";

impl QuantityKind {
    /// `10 deg/s`
    pub fn pattern(self) -> String {
        format!(r"^\s*{}\s*$", quantity(self))
    }

    /// `-10 .. 90 deg`
    pub fn range_pattern(self) -> String {
        format!(r"^\s*{}\s*$", range(self))
    }

    /// `<= 45 N*m` or a range.
    pub fn limit_pattern(self) -> String {
        format!(r"^\s*(?:(?:<=?|>=?|≤|≥)\s*{}|{})\s*$", quantity(self), range(self))
    }

    /// A value, a limit or a range: what selects conditions.
    pub fn selection_pattern(self) -> String {
        format!(r"^\s*(?:(?:<=?|>=?|≤|≥)?\s*{}|{})\s*$", quantity(self), range(self))
    }
}

fn quantity(kind: QuantityKind) -> String {
    format!(r"{NUMBER}\s*{}", units(kind))
}

fn range(kind: QuantityKind) -> String {
    let units = units(kind);
    format!(r"{NUMBER}\s*{units}?\s*\.\.\s*{NUMBER}\s*{units}")
}

fn units(kind: QuantityKind) -> String {
    let spelled: Vec<String> = unit::of_kind(kind).map(|unit| spellings(unit.symbol)).collect();
    format!("(?:{})", spelled.join("|"))
}

/// All spellings of a symbol that [`unit::normalise`] takes.
fn spellings(symbol: &str) -> String {
    const SPELLINGS: [(&str, &str); 9] = [
        ("N*m", r"N(?:\s*[*·⋅]\s*|\s*)m"),
        ("sqrt(h)", r"(?:sqrt\(h\)|√h)"),
        ("sqrt(s)", r"(?:sqrt\(s\)|√s)"),
        ("deg", "(?:deg|°)"),
        ("^2", r"(?:\^?2|²)"),
        ("^3", r"(?:\^?3|³)"),
        ("*", r"(?:\s*[*·⋅]\s*|\s+)"),
        ("/", r"\s*/\s*"),
        ("u", "[u\u{b5}\u{3bc}]"),
    ];
    let mut pattern = String::new();
    let mut rest = symbol;
    while let Some(next) = rest.chars().next() {
        if let Some((from, to)) = SPELLINGS.iter().find(|(from, _)| rest.starts_with(from)) {
            pattern.push_str(to);
            rest = &rest[from.len()..];
            continue;
        }
        if matches!(next, '^' | '(' | ')' | '.' | '+' | '$' | '|' | '?') {
            pattern.push('\\');
        }
        pattern.push(next);
        rest = &rest[next.len_utf8()..];
    }
    pattern
}
