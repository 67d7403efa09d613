//! Kind `range`: the motion envelope, end to end, and that soft limits and restricted zones hold.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod keys;
mod measure;
mod pictures;
mod plan;
#[cfg(test)]
mod tests;

use keys::{Keys, Stage};

const SPAN: &str = "covered-span";
const LOWER: &str = "lower-end";
const UPPER: &str = "upper-end";
const FAST_SPAN: &str = "covered-span-at-full-speed";
const PAST: &str = "travel-past-soft-limit";
const INTO: &str = "travel-into-zone";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(SPAN, Q::Angle, "Angle between the ends of the motion envelope, reached at creep speed."),
    Measurand::new(LOWER, Q::Angle, "Lower end reached in the motion envelope."),
    Measurand::new(UPPER, Q::Angle, "Upper end reached in the motion envelope."),
    Measurand::new(
        FAST_SPAN,
        Q::Angle,
        "Angle between the ends of moves at full speed, inside the soft limits.",
    ),
    Measurand::new(
        PAST,
        Q::Angle,
        "Largest travel past a soft limit that the axis was ordered to pass; negative if it stopped short of it.",
    ),
    Measurand::new(
        INTO,
        Q::Angle,
        "Largest travel into a restricted zone that the axis was ordered to enter; negative if it stopped \
         short of it.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("range", include_str!("range/doc.md"), keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let mut all = Vec::new();
        for stage in &self.stages {
            let more: &[&'static str] = match stage {
                Stage::Ends => &[SPAN, LOWER, UPPER],
                Stage::FullSpeed => &[FAST_SPAN],
                Stage::SoftBench | Stage::SoftDrive => &[PAST],
                Stage::Zone => &[INTO],
            };
            all.extend(more.iter().filter(|name| !all.contains(*name)).copied().collect::<Vec<_>>());
        }
        Some(all)
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        measure::analyse(case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        let shipped = "Soft limits and zones of the point represent those of the rig: interlocks and drive \
                       treat them in the same way, whatever their values.";
        let remarks = if self.has_limits() { vec![shipped.to_owned()] } else { Vec::new() };
        Conclusion {
            plots: pictures::pictures(cases, points, axes),
            remarks,
            ..Conclusion::collected(points)
        }
    }
}
