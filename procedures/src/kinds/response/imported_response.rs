//! Kind `imported-response`: a frequency response from a record that somebody else took.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod analyser;
mod answer;
mod distortion;
mod keys;
mod measure;
mod peaks;
mod periodic;
mod pictures;
mod reference;
#[cfg(test)]
mod tests;

use keys::Keys;

const MEASURANDS: &[Measurand] = &[
    Measurand {
        name: "resonance-frequency",
        kind: Q::Frequency,
        doc: "Undamped frequency of the mode at a maximum of the gain.",
    },
    Measurand { name: "resonance-damping", kind: Q::Ratio, doc: "Damping ratio of that mode." },
    Measurand {
        name: "antiresonance-frequency",
        kind: Q::Frequency,
        doc: "Undamped frequency of the zeros at a minimum of the gain.",
    },
    Measurand {
        name: "relative-deviation",
        kind: Q::Ratio,
        doc: "Standard deviation of the response over its gain, complex, median over the lines.",
    },
    Measurand {
        name: "response-gain",
        kind: Q::Decibel,
        doc: "Gain at a line, dB re SI unit of the output per SI unit of the input.",
    },
    Measurand { name: "response-phase", kind: Q::Angle, doc: "Phase at a line." },
    Measurand {
        name: "odd-distortion",
        kind: Q::Ratio,
        doc: "Output at odd lines that are not excited, less what the input holds there, over the output at excited lines, rms.",
    },
    Measurand { name: "even-distortion", kind: Q::Ratio, doc: "The same at even lines." },
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "imported-response",
    doc: include_str!("imported_response/doc.md"),
    fields: keys::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        MEASURANDS.iter().map(|m| m.name).filter(|name| self.gives(name)).collect()
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
