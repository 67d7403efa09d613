//! How wide text is drawn, without a font at hand.

/// Width of a text at 11 units, estimated on the safe side.
pub(super) fn text_width(text: &str) -> f64 {
    text.chars()
        .map(|c| match c {
            'i' | 'l' | 'j' | 't' | 'f' | 'I' | '.' | ',' | ':' | '|' | ' ' | '(' | ')' => 3.4,
            'm' | 'w' | 'M' | 'W' | '%' | '@' => 9.6,
            c if c.is_uppercase() => 8.0,
            _ => 6.4,
        })
        .sum()
}
