//! Kind `modes`: natural frequencies of the structure behind an axis, against what was calculated.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::position::positioned;
use crate::kinds::response::excited::{self, BACKGROUND, EXCITATION, Excited};
use crate::kinds::{Experiment, Kind, Measurand, ReadKeys};
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
    Measurand::new("mode-1-departure", Q::Ratio, "First frequency found over the calculated one, less one."),
    Measurand::new("mode-2-departure", Q::Ratio, "The same of the second."),
    Measurand::new("mode-3-departure", Q::Ratio, "The same of the third."),
    Measurand::new("mode-4-departure", Q::Ratio, "The same of the fourth."),
    Measurand::new(
        "first-mode-frequency",
        Q::Frequency,
        "Frequency of the first mode, where a band is expected.",
    ),
    Measurand::new("second-mode-frequency", Q::Frequency, "The same of the second."),
    Measurand::new("third-mode-frequency", Q::Frequency, "The same of the third."),
    Measurand::new("fourth-mode-frequency", Q::Frequency, "The same of the fourth."),
    Measurand::new("mode-damping", Q::Ratio, "Damping ratio of a mode; the flags say of which."),
    Measurand::new(
        "mode-participation",
        Q::Ratio,
        "Share of a mode in the gyro's rate, over that of the rigid axis; the flags say of which.",
    ),
    Measurand::new(
        point::UNEXPECTED,
        Q::Ratio,
        "Largest share in a sensor, over that of the rigid axis, of a mode that was not expected, up to a fifth above the last expected one.",
    ),
];

/// The keys, read.
#[derive(Clone, Debug, PartialEq)]
struct Keys {
    excited: Excited,
    expected: Vec<Expected>,
}

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("modes", include_str!("modes/doc.md"), FIELDS, MEASURANDS);

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let excited = Excited::read(table);
        let expected = table.tables("expected", assign::read);
        let expected = assign::checked(table, expected?)?;
        Some(Self { excited: excited?, expected })
    }
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let own = self.expected.iter().map(Expected::measurand);
        Some(own.chain([point::DAMPING, point::PARTICIPATION, point::UNEXPECTED]).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        // Modes are told by the gyros and change with elevation.
        positioned::gimbal_for("modes", axes)?;
        excited::plan(&self.excited, axis, axes)
    }

    fn cuts(&self, axis: &str, axes: &Axes) -> Vec<String> {
        excited::moved(&self.excited, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        pictures::conclude(self, cases, points, axes)
    }
}
