//! Kind `modes`: natural frequencies of the structure behind an axis, against what was calculated.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned;
use crate::kinds::response::excited::{self, BACKGROUND, EXCITATION, Excited};
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

mod assign;
mod fit;
mod pictures;
mod point;
#[cfg(test)]
mod tests;

use assign::{EXPECTED, Expected};
pub use point::{PointModes, VisibleMode};

const FIELDS: &[Field] = &[
    Field::required(
        "elevation",
        Shape::Quantities(Q::Angle),
        "Elevations, one point each with every level; those whose strokes would leave the travel move inside it.",
    ),
    Field::required("excitation", Shape::Table(EXCITATION), "What is added, and where."),
    Field::required("background", Shape::Table(BACKGROUND), "How the axis slides meanwhile."),
    Field::required(
        "expected",
        Shape::Tables(EXPECTED),
        "Modes that are looked for, by ascending frequency.",
    ),
];

const MEASURANDS: &[Measurand] = &[
    Measurand {
        name: "mode-1-departure",
        kind: Q::Ratio,
        doc: "First frequency found over the calculated one, less one.",
    },
    Measurand { name: "mode-2-departure", kind: Q::Ratio, doc: "The same of the second." },
    Measurand { name: "mode-3-departure", kind: Q::Ratio, doc: "The same of the third." },
    Measurand { name: "mode-4-departure", kind: Q::Ratio, doc: "The same of the fourth." },
    Measurand {
        name: "first-mode-frequency",
        kind: Q::Frequency,
        doc: "Frequency of the first mode, where a band is expected.",
    },
    Measurand { name: "second-mode-frequency", kind: Q::Frequency, doc: "The same of the second." },
    Measurand { name: "third-mode-frequency", kind: Q::Frequency, doc: "The same of the third." },
    Measurand { name: "fourth-mode-frequency", kind: Q::Frequency, doc: "The same of the fourth." },
    Measurand {
        name: "mode-damping",
        kind: Q::Ratio,
        doc: "Damping ratio of a mode; the flags say of which.",
    },
    Measurand {
        name: "mode-participation",
        kind: Q::Ratio,
        doc: "Share of a mode in the gyro's rate, over that of the rigid axis; the flags say of which.",
    },
];

/// The keys, read.
#[derive(Clone, Debug, PartialEq)]
struct Keys {
    excited: Excited,
    expected: Vec<Expected>,
}

pub(in crate::kinds) const KIND: Kind =
    Kind { name: "modes", doc: include_str!("modes/doc.md"), fields: FIELDS, measurands: MEASURANDS, read };

fn read(table: &mut TableReader<'_>) -> Option<Box<dyn Experiment>> {
    let excited = Excited::read(table);
    let expected = table.tables("expected", assign::read);
    let expected = assign::checked(table, expected?)?;
    Some(Box::new(Keys { excited: excited?, expected }))
}

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        let own = self.expected.iter().map(Expected::measurand);
        own.chain([point::DAMPING, point::PARTICIPATION]).collect()
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        // Modes are told by the gyros and change with elevation.
        positioned::gimbal_for("modes", axes)?;
        excited::plan(&self.excited, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        pictures::conclude(self, cases, points, axes)
    }
}
