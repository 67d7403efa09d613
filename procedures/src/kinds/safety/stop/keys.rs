//! What a procedure says.

use crate::case::Case;
use crate::kinds::ReadKeys;
use crate::log::StopManner;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader, name_of, value_of};

pub(super) const FIELDS: &[Field] = &[
    Field::required("manners", Shape::Texts, "Stops to make: `quick-stop`, `soft-limit`, `torque-off`."),
    Field::default(
        "speed",
        Shape::Quantity(Q::AngularVelocity),
        "60 deg/s",
        "Speed from which the axis is stopped.",
    ),
    Field::default(
        "torque-off-speed",
        Shape::Quantity(Q::AngularVelocity),
        "15 deg/s",
        "Speed at which the torque is switched off.",
    ),
    Field::required(
        "span",
        Shape::Range(Q::Angle),
        "Ends at which runs begin, each run towards the other end.",
    ),
    Field::required(
        "fence",
        Shape::Range(Q::Angle),
        "Soft limits for the points `soft-limit`, inside `span`.",
    ),
];

/// A way to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    QuickStop,
    SoftLimit,
    TorqueOff,
}

const WAYS: [(&str, Way); 3] =
    [("quick-stop", Way::QuickStop), ("soft-limit", Way::SoftLimit), ("torque-off", Way::TorqueOff)];

impl Way {
    /// Name of this manner of stop, with which the names of its points begin.
    pub(super) fn name(self) -> &'static str {
        name_of(&WAYS, &self)
    }

    /// Manner of stop of a planned point.
    pub(super) fn of(case: &Case) -> Option<Self> {
        value_of(&WAYS, case.point.split(',').next()?)
    }

    /// How the log names it.
    pub(super) fn manner(self) -> StopManner {
        match self {
            Self::QuickStop => StopManner::QuickStop,
            Self::SoftLimit => StopManner::Controlled,
            Self::TorqueOff => StopManner::TorqueOff,
        }
    }
}

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) ways: Vec<Way>,
    pub(super) speed_rad_per_s: f64,
    pub(super) torque_off_rad_per_s: f64,
    pub(super) span_rad: [f64; 2],
    pub(super) fence_rad: [f64; 2],
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let ways = table.named_values("manners", "manner", &WAYS);
        let speed = table.positive("speed");
        let off = table.positive("torque-off-speed");
        let span = table.range("span");
        let fence = table.range("fence");
        let span_rad = span?;
        let fence_rad = fence?;
        if fence_rad[0] <= span_rad[0] || fence_rad[1] >= span_rad[1] {
            let help = "choose limits inside `span`: runs begin outside the limit behind them and inside \
                        the one ahead"
                .to_owned();
            table.mistake("fence", "`fence` does not lie inside `span`", Some(help));
        }
        Some(Self { ways: ways?, speed_rad_per_s: speed?, torque_off_rad_per_s: off?, span_rad, fence_rad })
    }
}
