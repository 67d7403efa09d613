//! Kind `imported-response`: a frequency response from a record that somebody else took.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, ReadKeys};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

mod answer;
mod measure;
mod peaks;
mod periodic;
#[cfg(test)]
mod tests;

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        "resonance-frequency",
        Q::Frequency,
        "Undamped frequency of the mode at a maximum of the gain.",
    ),
    Measurand::new("resonance-damping", Q::Ratio, "Damping ratio of that mode."),
    Measurand::new(
        "antiresonance-frequency",
        Q::Frequency,
        "Undamped frequency of the zeros at a minimum of the gain.",
    ),
    Measurand::new(
        "relative-deviation",
        Q::Ratio,
        "Standard deviation of the complex response relative to its gain, median over the lines.",
    ),
    Measurand::new(
        "response-gain",
        Q::Decibel,
        "Gain at a line, dB re SI unit of the output per SI unit of the input.",
    ),
    Measurand::new("response-phase", Q::Angle, "Phase at a line."),
    Measurand::new(
        "odd-distortion",
        Q::Ratio,
        "Output at odd lines that are not excited, less the contribution of the input there, over the \
         output at excited lines, rms.",
    ),
    Measurand::new(
        "even-distortion",
        Q::Ratio,
        "Output at even lines that are not excited, less the contribution of the input there, over the \
         output at excited lines, rms.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("imported-response", include_str!("imported_response/doc.md"), FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        Some(MEASURANDS.iter().map(|m| m.name).filter(|name| self.gives(name)).collect())
    }

    fn plan(&self, _axis: &str, _axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        let message = "a procedure of kind `imported-response` judges imported records only";
        let help = "`frequency-response` excites an axis and measures it";
        Err(vec![Diagnostic::new(message).help(help)])
    }

    fn analyse(&self, case: &Case, window: &Window, _axes: &Axes) -> PointResult {
        measure::analyse(self, case, window)
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        measure::conclude(self, points)
    }
}

const FIELDS: &[Field] = &[
    Field::required(
        "source",
        Shape::Choice(&["periodic", "analyser"]),
        "Type of record: a periodic signal over time, or a response computed by an analyser.",
    ),
    Field::optional("record", Shape::Table(RECORD), "The periodic record."),
    Field::optional("response", Shape::Tables(RESPONSE), "Responses to read from the periodic record."),
    Field::optional(
        "band",
        Shape::Range(Q::Frequency),
        "Band in which resonances are sought; default: everywhere.",
    ),
    Field::default(
        "find",
        Shape::Choice(&["resonances", "antiresonances", "both", "nothing"]),
        "both",
        "What to look for, unless a response overrides it.",
    ),
    Field::default(
        "least-prominence",
        Shape::Quantity(Q::Ratio),
        "5 %",
        "Prominence of a maximum relative to the largest gain.",
    ),
    Field::optional("at", Shape::Quantities(Q::Frequency), "Frequencies at which gain and phase are listed."),
    Field::default(
        "least-coherence",
        Shape::Quantity(Q::Ratio),
        "0.9",
        "Smallest coherence; lines of an analyser's response below it do not count.",
    ),
    Field::optional(
        "averages",
        Shape::Integer,
        "Number of independent averages of the analyser, where stated.",
    ),
];

const RECORD: &[Field] = &[
    Field::required(
        "period",
        Shape::Quantity(Q::Time),
        "Period of the excitation, a whole number of samples.",
    ),
    Field::default(
        "dropped-periods",
        Shape::Integer,
        "1",
        "Periods at the start that contain the transient; they are dropped.",
    ),
    Field::required("input", Shape::Text, "Channel of the input, e.g. `current_a`."),
    Field::optional(
        "reference",
        Shape::Text,
        "Channel of the exact command, which repeats exactly in every period.",
    ),
    Field::required("from", Shape::Quantity(Q::Frequency), "Lowest excited line."),
    Field::required(
        "to",
        Shape::Quantity(Q::Frequency),
        "Highest excited line, at most 0.4 of the sample rate.",
    ),
    Field::optional(
        "step",
        Shape::Quantity(Q::Frequency),
        "Spacing of the excited lines; default: every line of the period.",
    ),
    Field::optional(
        "detection",
        Shape::Range(Q::Frequency),
        "Band in which lines that are not excited are evaluated for distortion.",
    ),
];

const RESPONSE: &[Field] = &[
    Field::required("name", Shape::Text, "Name for the report, e.g. `motor angle`."),
    Field::required("output", Shape::Text, "Channel of the output, e.g. `position_rad`."),
    Field::optional("input", Shape::Text, "Channel of the input; default: that of the record."),
    Field::default("reversed", Shape::Boolean, "false", "Whether the sign of the output is inverted."),
    Field::default(
        "derivative",
        Shape::Integer,
        "0",
        "Power of jω that the response is multiplied with, -2 to 2.",
    ),
    Field::optional(
        "find",
        Shape::Choice(&["resonances", "antiresonances", "both", "nothing"]),
        "What to look for in this response.",
    ),
];

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Find {
    resonances: bool,
    antiresonances: bool,
}

/// The keys, read; SI units.
#[derive(Clone, Debug, PartialEq)]
struct Keys {
    source: Source,
    band_hz: [f64; 2],
    find: Find,
    least_prominence: f64,
    at_hz: Vec<f64>,
}

/// Where the response comes from.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    Periodic { record: Record, responses: Vec<Response> },
    Analyser { least_coherence: f64, averages: Option<u32> },
}

/// A periodic record.
#[derive(Clone, Debug, PartialEq)]
struct Record {
    period_s: f64,
    dropped: u32,
    input: String,
    reference: Option<String>,
    lines_hz: [f64; 2],
    step_hz: Option<f64>,
    detection_hz: Option<[f64; 2]>,
}

/// A response to read from it.
#[derive(Clone, Debug, PartialEq)]
struct Response {
    name: String,
    output: String,
    input: Option<String>,
    reversed: bool,
    derivative: i32,
    find: Option<Find>,
}

impl ReadKeys for Keys {
    fn read(t: &mut TableReader<'_>) -> Option<Self> {
        let source = t.text("source");
        let record = t.table("record", record);
        let responses = t.tables("response", response);
        let band_hz = t.range("band");
        let at_hz = t.quantities("at");
        let find = t.text("find");
        let least_prominence = t.positive("least-prominence");
        let least_coherence = t.positive("least-coherence");
        let averages = if t.has("averages") { Some(t.count("averages", 2)?) } else { None };
        if least_coherence.is_some_and(|least| least > 1.0) {
            t.mistake("least-coherence", "give a coherence of at most 1", None);
        }
        let periodic = source? == "periodic";
        let misplaced: &[&str] =
            if periodic { &["averages", "least-coherence"] } else { &["record", "response"] };
        for key in misplaced.iter().filter(|key| t.has(key)).copied().collect::<Vec<_>>() {
            t.mistake(key, format!("`{key}` has no meaning with this `source`"), None);
        }
        let source = if periodic {
            if !t.has("record") {
                t.mistake("source", "`source = \"periodic\"` needs a table `[record]`", None);
            }
            let responses = responses.unwrap_or_default();
            if !t.has("response") {
                t.mistake("source", "`source = \"periodic\"` needs at least one `[[response]]`", None);
            }
            Source::Periodic { record: record?, responses }
        } else {
            Source::Analyser { least_coherence: least_coherence?, averages }
        };
        Some(Self {
            source,
            band_hz: band_hz.unwrap_or([0.0, f64::INFINITY]),
            find: found(&find?),
            least_prominence: least_prominence?,
            at_hz: at_hz.unwrap_or_default(),
        })
    }
}

impl Keys {
    /// Whether a measurand comes out of this procedure.
    fn gives(&self, name: &str) -> bool {
        let finds: Vec<Find> = match &self.source {
            Source::Periodic { responses, .. } => {
                responses.iter().map(|r| r.find.unwrap_or(self.find)).collect()
            }
            Source::Analyser { .. } => vec![self.find],
        };
        match name {
            "resonance-frequency" | "resonance-damping" => finds.iter().any(|f| f.resonances),
            "antiresonance-frequency" => finds.iter().any(|f| f.antiresonances),
            "response-gain" | "response-phase" => !self.at_hz.is_empty(),
            "odd-distortion" | "even-distortion" => {
                matches!(&self.source, Source::Periodic { record, .. } if record.detection_hz.is_some())
            }
            _ => true,
        }
    }
}

fn found(word: &str) -> Find {
    Find {
        resonances: matches!(word, "resonances" | "both"),
        antiresonances: matches!(word, "antiresonances" | "both"),
    }
}

fn record(t: &mut TableReader<'_>) -> Option<Record> {
    let period_s = t.positive("period");
    let dropped = t.count("dropped-periods", 0);
    let input = t.text("input");
    let reference = t.text("reference");
    let from_hz = t.positive("from");
    let to_hz = t.positive("to");
    let step_hz = if t.has("step") { Some(t.positive("step")?) } else { None };
    let detection_hz = t.range("detection");
    if let (Some(from), Some(to)) = (from_hz, to_hz)
        && from >= to
    {
        t.mistake("to", "the highest line is below the lowest", Some("`from` below `to`".to_owned()));
        return None;
    }
    Some(Record {
        period_s: period_s?,
        dropped: dropped?,
        input: input?,
        reference,
        lines_hz: [from_hz?, to_hz?],
        step_hz,
        detection_hz,
    })
}

fn response(t: &mut TableReader<'_>) -> Option<Response> {
    let name = t.text("name");
    let output = t.text("output");
    let input = t.text("input");
    let reversed = t.boolean("reversed");
    let derivative = t.integer("derivative", -2);
    let find = t.text("find");
    let derivative = derivative?;
    if derivative > 2 {
        t.mistake("derivative", format!("expected -2 to 2, found {derivative}"), None);
        return None;
    }
    Some(Response {
        name: name?,
        output: output?,
        input,
        reversed: reversed?,
        derivative: i32::try_from(derivative).ok()?,
        find: find.as_deref().map(found),
    })
}
