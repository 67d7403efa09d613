//! How the line of a reader looks: text, and numbers in braces, `X{azimuth} Y{elevation}`.

use std::fmt;

use super::Measured;

/// What a line shows: numbers as they stand in it, or nothing where the instrument has no reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown([Option<f64>; Measured::ALL.len()]);

impl Shown {
    /// The number of a value; `None` where it has none.
    pub fn number(&self, which: Measured) -> Option<f64> {
        self.0[which as usize]
    }

    /// With this number for a value.
    #[must_use]
    pub fn with(mut self, which: Measured, number: Option<f64>) -> Self {
        self.0[which as usize] = number;
        self
    }
}

/// Why a text is no pattern.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct PatternError {
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    /// These characters.
    Text(String),
    /// One blank or more.
    Blanks,
    /// A number.
    Number(Measured),
    /// Anything up to the text that follows, or to the end.
    Any,
}

/// The line of a reader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    parts: Vec<Part>,
    text: String,
}

/// Numbers from this on are marks of an overload (SCPI-1999, 7.2.1.4).
const OVERLOAD: f64 = 9.9e37;

impl Pattern {
    /// Reads a pattern. `{azimuth}`, `{elevation}` and `{force}` stand for numbers, `{*}` for anything up to the text that
    /// follows it, a blank for one blank or more, everything else for itself. Blanks around a line do not count.
    ///
    /// # Errors
    /// An unknown name in braces, a brace without its other one, the same value twice, two fields without text between them, no
    /// value at all.
    pub fn parse(text: &str) -> Result<Self, PatternError> {
        let mut parts = Vec::new();
        let mut rest = text.trim();
        while let Some(first) = rest.chars().next() {
            let length = match first {
                '{' => {
                    let end = rest.find('}').ok_or_else(|| wrong("a `{` without its `}`"))?;
                    let part = field(&rest[1..end])?;
                    if matches!(parts.last(), Some(Part::Number(_) | Part::Any)) {
                        return Err(wrong("two fields without text between them"));
                    }
                    parts.push(part);
                    end + 1
                }
                '}' => return Err(wrong("a `}` without its `{`")),
                ' ' => {
                    parts.push(Part::Blanks);
                    rest.len() - rest.trim_start_matches(' ').len()
                }
                _ => {
                    let end = rest.find(['{', '}', ' ']).unwrap_or(rest.len());
                    parts.push(Part::Text(rest[..end].to_owned()));
                    end
                }
            };
            rest = &rest[length..];
        }
        let count = |which: Measured| parts.iter().filter(|part| **part == Part::Number(which)).count();
        if let Some(twice) = Measured::ALL.into_iter().find(|which| count(*which) > 1) {
            return Err(wrong(&format!("`{{{}}}` stands in it twice", twice.name())));
        }
        if Measured::ALL.into_iter().all(|which| count(which) == 0) {
            return Err(wrong("it has no value"));
        }
        Ok(Self { parts, text: text.trim().to_owned() })
    }

    /// Whether a value is in the line.
    pub fn has(&self, which: Measured) -> bool {
        self.parts.contains(&Part::Number(which))
    }

    /// What a line shows; `None` if it does not fit. `nothing` stands where the instrument has no reading.
    pub fn decode(&self, line: &[u8], nothing: &str) -> Option<Shown> {
        let mut rest = line.trim_ascii();
        let mut shown = Shown::default();
        for (k, part) in self.parts.iter().enumerate() {
            match part {
                Part::Text(text) => rest = rest.strip_prefix(text.as_bytes())?,
                Part::Blanks => rest = rest.strip_prefix(b" ")?.trim_ascii_start(),
                Part::Any => {
                    let length = match self.parts.get(k + 1) {
                        None => rest.len(),
                        Some(Part::Text(text)) => {
                            rest.windows(text.len()).position(|here| here == text.as_bytes())?
                        }
                        Some(_) => rest.iter().position(|byte| *byte == b' ')?,
                    };
                    rest = &rest[length..];
                }
                Part::Number(which) => {
                    let after_nothing =
                        (!nothing.is_empty()).then(|| rest.strip_prefix(nothing.as_bytes())).flatten();
                    if let Some(after) = after_nothing {
                        rest = after;
                        continue;
                    }
                    let (number, length) = number(rest)?;
                    shown.0[*which as usize] = Some(number).filter(|number| number.abs() < OVERLOAD);
                    rest = &rest[length..];
                }
            }
        }
        rest.is_empty().then_some(shown)
    }

    /// A line, without its terminator, that shows these numbers with so many decimals, in the order of [`Measured::ALL`]; what
    /// has none shows `nothing`.
    pub fn encode(&self, shown: &Shown, decimals: [usize; Measured::ALL.len()], nothing: &str) -> String {
        let mut line = String::new();
        for part in &self.parts {
            match part {
                Part::Text(text) => line.push_str(text),
                Part::Blanks => line.push(' '),
                Part::Any => line.push('0'),
                Part::Number(which) => match shown.number(*which) {
                    Some(number) => line.push_str(&format!("{number:+.*}", decimals[*which as usize])),
                    None => line.push_str(nothing),
                },
            }
        }
        line
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn field(name: &str) -> Result<Part, PatternError> {
    if name == "*" {
        return Ok(Part::Any);
    }
    let which = Measured::ALL.into_iter().find(|which| which.name() == name);
    which.map(Part::Number).ok_or_else(|| wrong(&format!("there is no value `{{{name}}}`")))
}

fn wrong(message: &str) -> PatternError {
    PatternError {
        message: message.to_owned(),
        help: "write text with `{azimuth}`, `{elevation}` or `{force}` for numbers and `{*}` for what does not matter, e.g. \
               `{azimuth},{elevation}`"
            .to_owned(),
    }
}

/// The number that bytes begin with, and its length: sign, digits with at most one point, exponent. Blanks may stand behind the
/// sign and before the number, as columns of a display have them.
fn number(bytes: &[u8]) -> Option<(f64, usize)> {
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let blanks = |from: usize| bytes[from..].iter().take_while(|byte| **byte == b' ').count();
    let mut at = blanks(0);
    let is_negative = bytes.get(at) == Some(&b'-');
    if matches!(bytes.get(at), Some(b'+' | b'-')) {
        at += 1;
        at += blanks(at);
    }
    let begins = at;
    let whole = digits(at);
    at += whole;
    let mut count = whole;
    if bytes.get(at) == Some(&b'.') {
        let fraction = digits(at + 1);
        count += fraction;
        at += 1 + fraction;
    }
    if count == 0 {
        return None;
    }
    if matches!(bytes.get(at), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
        let exponent = if at + 1 + sign <= bytes.len() { digits(at + 1 + sign) } else { 0 };
        if exponent > 0 {
            at += 1 + sign + exponent;
        }
    }
    let value: f64 = std::str::from_utf8(&bytes[begins..at]).ok()?.parse().ok()?;
    value.is_finite().then_some((if is_negative { -value } else { value }, at))
}
