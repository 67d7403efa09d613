//! Reader profiles: instruments that send their readings as lines of text, as data (`drivers/readers/*.toml`).

use std::sync::Arc;

use drivers::reader::{Measured, Pattern, ReaderProfile, Terminator, ValueScale};
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, SCHEMA_FIELD, Shape, TableReader, read_file};

use super::shipped::{self, Folder, sort};

#[cfg(test)]
mod tests;

/// Keys of a reader profile.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name of the profile."),
    Field::required("title", Shape::Text, "Heading: the instruments that it is for."),
    Field::required(
        "source",
        Shape::Text,
        "Where its facts come from: a manual, an instrument that was tried.",
    ),
    Field::optional(
        "identify",
        Shape::Text,
        "Query whose answer says who the instrument is, e.g. `*IDN?`; only together with `query`.",
    ),
    Field::optional(
        "query",
        Shape::Text,
        "Query for a reading, e.g. `MEAS:ANGL?`; without it the instrument sends by itself.",
    ),
    Field::required(
        "terminator",
        Shape::Choice(&["lf", "cr", "cr-lf"]),
        "What ends a query and a line: line feed, carriage return, or both.",
    ),
    Field::required(
        "period",
        Shape::Quantity(K::Time),
        "Shortest time from query to query; for an instrument that sends by itself, the time between two lines.",
    ),
    Field::required(
        "timeout",
        Shape::Quantity(K::Time),
        "Longest wait for an answer. A reading that is older than period and timeout together counts as none.",
    ),
    Field::required(
        "pattern",
        Shape::Text,
        "How a line looks: text with `{azimuth}`, `{elevation}` or `{force}` for numbers and `{*}` for what does not \
         matter, e.g. `{azimuth},{elevation}`. A blank stands for one or more.",
    ),
    Field::default(
        "nothing",
        Shape::Text,
        "9.9E37",
        "What stands in the place of a number when the instrument has no reading. Numbers from 9.9E37 on are none anyway.",
    ),
    Field::optional(
        "azimuth",
        Shape::Table(ANGLE_FIELDS),
        "Angle off the nearest face of the polygon on the first axis.",
    ),
    Field::optional("elevation", Shape::Table(ANGLE_FIELDS), "The same of the second axis."),
    Field::optional("force", Shape::Table(FORCE_FIELDS), "Force of a gauge on a lever arm."),
];

const DECIMALS: Field = Field::required(
    "decimals",
    Shape::Integer,
    "Places behind the decimal point, which make the smallest step; 0 to 12.",
);
const RANGE_DOC: &str = "Range of the instrument; a reading outside it counts as none.";
const U_DOC: &str = "Standard uncertainty of a reading of the instrument alone.";

/// Keys of a value that is an angle.
const ANGLE_FIELDS: &[Field] = &[
    Field::required(
        "scale",
        Shape::Quantity(K::Angle),
        "Angle that a 1 in the line is worth; negative where signs differ.",
    ),
    Field::required("range", Shape::Range(K::Angle), RANGE_DOC),
    Field::required("uncertainty", Shape::Quantity(K::Angle), U_DOC),
    DECIMALS,
];

/// Keys of a value that is a force.
const FORCE_FIELDS: &[Field] = &[
    Field::required(
        "scale",
        Shape::Quantity(K::Force),
        "Force that a 1 in the line is worth; negative where signs differ.",
    ),
    Field::required("range", Shape::Range(K::Force), RANGE_DOC),
    Field::required("uncertainty", Shape::Quantity(K::Force), U_DOC),
    DECIMALS,
];

/// Most places behind a decimal point.
const MOST_DECIMALS: i64 = 12;
/// Periods and timeouts that an instrument can have.
const TIMES_S: [f64; 2] = [1e-3, 60.0];

/// Reads a reader profile.
///
/// # Errors
/// All mistakes at once.
pub fn read_reader(source: &SourceFile) -> Result<ReaderProfile, Vec<Diagnostic>> {
    read_file(source, FIELDS, read)
}

/// The reader profile of this name; `beside` is the file that names it, if one does.
///
/// # Errors
/// All mistakes of the profile at once, or that there is none.
pub fn load(name: &str, beside: Option<&str>) -> Result<Arc<ReaderProfile>, Vec<Diagnostic>> {
    let source = shipped::find(Folder::Readers, name, beside)?;
    let source = sort::expect(source, Folder::Readers)?;
    read_reader(&source).map(Arc::new)
}

fn read(t: &mut TableReader<'_>) -> Option<ReaderProfile> {
    let schema = t.schema();
    let id = t.text("id");
    t.text("title");
    t.text("source");
    let identify = query(t, "identify");
    let asked = query(t, "query");
    if identify.is_some() && asked.is_none() {
        let help =
            "add `query`, or remove `identify`: among lines that come unasked its answer could not be told"
                .to_owned();
        t.mistake("identify", "an instrument that sends by itself is not asked who it is", Some(help));
    }
    let terminator = t.text("terminator").map(|word| match word.as_str() {
        "cr" => Terminator::Cr,
        "cr-lf" => Terminator::CrLf,
        _ => Terminator::Lf,
    });
    let period_s = time(t, "period");
    let timeout_s = time(t, "timeout");
    let pattern = t.text("pattern");
    let pattern = pattern.and_then(|text| match Pattern::parse(&text) {
        Ok(pattern) => Some(pattern),
        Err(error) => {
            t.mistake("pattern", format!("`{text}` is no pattern: {error}"), Some(error.help));
            None
        }
    });
    let nothing = t.text("nothing");
    let before = t.mistakes();
    let values =
        Measured::ALL.map(|which| t.has(which.name()).then(|| t.table(which.name(), read_value)).flatten());
    if let (Some(pattern), true) = (&pattern, t.mistakes() == before) {
        check_values(t, pattern, &values);
    }
    Some(ReaderProfile {
        id: schema.and(id)?,
        identify,
        query: asked,
        terminator: terminator?,
        period_s: period_s?,
        timeout_s: timeout_s?,
        pattern: pattern?,
        nothing: nothing?,
        values,
    })
}

/// A query: something that can be sent on one line.
fn query(t: &mut TableReader<'_>, key: &'static str) -> Option<String> {
    let text = t.has(key).then(|| t.text(key)).flatten()?;
    if text.trim().is_empty() || text.chars().any(char::is_control) {
        let help = "write the query without its terminator, e.g. `MEAS:ANGL?`".to_owned();
        t.mistake(key, format!("`{key}` is no query"), Some(help));
        return None;
    }
    Some(text.trim().to_owned())
}

fn time(t: &mut TableReader<'_>, key: &'static str) -> Option<f64> {
    let time_s = t.quantity(key)?;
    let [least_s, most_s] = TIMES_S;
    if (least_s..=most_s).contains(&time_s) {
        return Some(time_s);
    }
    let format = |time_s| K::Time.format(time_s);
    let message =
        format!("`{key}` must be from {} to {}, found {}", format(least_s), format(most_s), format(time_s));
    t.mistake(key, message, None);
    None
}

fn read_value(t: &mut TableReader<'_>) -> Option<ValueScale> {
    let scale = t.quantity("scale");
    if scale == Some(0.0) {
        t.mistake("scale", "`scale` must not be zero", None);
    }
    let range = t.range("range");
    let u = t.positive("uncertainty");
    let decimals = t.integer("decimals", 0);
    if decimals.is_some_and(|decimals| decimals > MOST_DECIMALS) {
        t.mistake("decimals", format!("`decimals` must be from 0 to {MOST_DECIMALS}"), None);
    }
    Some(ValueScale {
        scale_si: scale?,
        range_si: range?,
        u_si: u?,
        decimals: usize::try_from(decimals?).ok()?,
    })
}

/// Values of the pattern and tables belong together, and angles and forces come from different instruments.
fn check_values(t: &mut TableReader<'_>, pattern: &Pattern, values: &[Option<ValueScale>; 3]) {
    for (which, value) in Measured::ALL.into_iter().zip(values) {
        let name = which.name();
        match (pattern.has(which), value) {
            (true, None) => {
                let help = format!("add `[{name}]` with scale, range, uncertainty and decimals");
                t.mistake(
                    "pattern",
                    format!("the pattern has `{{{name}}}`, but there is no table `[{name}]`"),
                    Some(help),
                );
            }
            (false, Some(_)) => {
                let help = format!("add `{{{name}}}` to the pattern, or remove the table");
                t.mistake(name, format!("`{{{name}}}` is not in the pattern"), Some(help));
            }
            _ => {}
        }
    }
    let has_angle = values[..2].iter().any(Option::is_some);
    if has_angle && values[2].is_some() {
        let help = "make two profiles and two devices of them".to_owned();
        t.mistake("force", "one reader is either an angle reference or a force gauge", Some(help));
    }
}
