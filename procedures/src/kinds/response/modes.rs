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
        "Elevations, one point each with every level; an elevation whose strokes would leave the travel is \
         shifted inside it.",
    ),
    Field::required("excitation", Shape::Table(EXCITATION), "Excitation signal, and where it is injected."),
    Field::required(
        "background",
        Shape::Table(BACKGROUND),
        "Sliding motion of the axis during the excitation.",
    ),
    Field::required("expected", Shape::Tables(EXPECTED), "Modes to look for, by ascending frequency."),
];

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        "mode-1-departure",
        Q::Ratio,
        "Measured frequency of the first mode over the calculated one, less 1.",
    ),
    Measurand::new(
        "mode-2-departure",
        Q::Ratio,
        "Measured frequency of the second mode over the calculated one, less 1.",
    ),
    Measurand::new(
        "mode-3-departure",
        Q::Ratio,
        "Measured frequency of the third mode over the calculated one, less 1.",
    ),
    Measurand::new(
        "mode-4-departure",
        Q::Ratio,
        "Measured frequency of the fourth mode over the calculated one, less 1.",
    ),
    Measurand::new(
        "first-mode-frequency",
        Q::Frequency,
        "Frequency of the first mode, where a band is given for it.",
    ),
    Measurand::new(
        "second-mode-frequency",
        Q::Frequency,
        "Frequency of the second mode, where a band is given for it.",
    ),
    Measurand::new(
        "third-mode-frequency",
        Q::Frequency,
        "Frequency of the third mode, where a band is given for it.",
    ),
    Measurand::new(
        "fourth-mode-frequency",
        Q::Frequency,
        "Frequency of the fourth mode, where a band is given for it.",
    ),
    Measurand::new("mode-damping", Q::Ratio, "Damping ratio of a mode; the flags name the mode."),
    Measurand::new(
        "mode-participation",
        Q::Ratio,
        "Participation of a mode in the gyro's rate, relative to the rigid axis; the flags name the mode.",
    ),
    Measurand::new(
        point::UNEXPECTED,
        Q::Ratio,
        "Largest participation in a sensor, relative to the rigid axis, of an unexpected mode, up to a \
         fifth above the last expected mode.",
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
