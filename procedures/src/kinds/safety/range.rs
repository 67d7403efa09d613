//! Kind `range`: the motion envelope, end to end, and that soft limits and restricted zones hold.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
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

const fn angle(name: &'static str, doc: &'static str) -> Measurand {
    Measurand { name, kind: Q::Angle, doc }
}

const SPAN: &str = "covered-span";
const LOWER: &str = "lower-end";
const UPPER: &str = "upper-end";
const FAST_SPAN: &str = "covered-span-at-full-speed";
const PAST: &str = "travel-past-soft-limit";
const INTO: &str = "travel-into-zone";

const MEASURANDS: &[Measurand] = &[
    angle(SPAN, "Angle between the ends of the motion envelope that were reached at creep."),
    angle(LOWER, "Lower end of the motion envelope that was reached."),
    angle(UPPER, "Upper end of the motion envelope that was reached."),
    angle(FAST_SPAN, "Angle between the ends of moves at full speed, inside the soft limits."),
    angle(
        PAST,
        "Farthest that the axis came past a soft limit that it was ordered past; negative short of it.",
    ),
    angle(
        INTO,
        "Farthest that the axis came into a restricted zone that it was ordered into; negative short of it.",
    ),
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "range",
    doc: include_str!("range/doc.md"),
    fields: keys::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
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
        all
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        measure::analyse(self, case, window, axes)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        let shipped = "Soft limits and zones of a point's own stand for those of the rig: interlocks and drive obey the \
                       same numbers in the same way, whatever their values.";
        let remarks = if self.has_limits() { vec![shipped.to_owned()] } else { Vec::new() };
        Conclusion {
            plots: pictures::pictures(cases, points, axes),
            remarks,
            ..Conclusion::collected(points)
        }
    }
}
