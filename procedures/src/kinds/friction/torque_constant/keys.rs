//! What a procedure says.

use crate::kinds::ReadKeys;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::default(
        "velocity",
        Shape::Quantity(Q::AngularVelocity),
        "2 deg/s",
        "Velocity of the axis, both pulled and driven.",
    ),
    Field::default("pose", Shape::Quantity(Q::Angle), "0 deg", "Middle of the strokes."),
    Field::default("way", Shape::Quantity(Q::Angle), "14 deg", "Angle through which the axis is pulled."),
    Field::default(
        "other-pose",
        Shape::Quantity(Q::Angle),
        "40 deg",
        "Pose of the other axis, which its friction alone must hold.",
    ),
    Field::required("pull", Shape::Quantity(Q::Torque), "Largest torque of the pull."),
    Field::required("arm", Shape::Quantity(Q::Length), "Lever arm of the force gauge."),
    Field::required("arm-uncertainty", Shape::Quantity(Q::Length), "Standard uncertainty of the arm."),
    Field::required(
        "gauge-uncertainty",
        Shape::Quantity(Q::Ratio),
        "Standard uncertainty of the gauge's scale, relative.",
    ),
    Field::required(
        "ampere",
        Shape::Choice(&["rms", "peak"]),
        "Whether the drive reports the phase current as root mean square or as peak.",
    ),
    Field::default(
        "allowed",
        Shape::Quantity(Q::Ratio),
        "5 %",
        "Deviation from the rig's constant beyond which torques of the run are called suspicious.",
    ),
];

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) velocity_rad_per_s: f64,
    pub(super) pose_rad: f64,
    pub(super) way_rad: f64,
    pub(super) other_pose_rad: f64,
    pub(super) pull_nm: f64,
    pub(super) arm_m: f64,
    pub(super) arm_u_m: f64,
    pub(super) gauge_u_ratio: f64,
    pub(super) ampere: String,
    pub(super) allowed_ratio: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let velocity = table.positive("velocity");
        let way = table.positive("way");
        let pose = table.quantity("pose");
        let other = table.quantity("other-pose");
        let pull = table.positive("pull");
        let arm = table.positive("arm");
        let arm_u = table.positive("arm-uncertainty");
        let gauge_u = table.positive("gauge-uncertainty");
        let ampere = table.text("ampere");
        let allowed = table.positive("allowed");
        Some(Self {
            velocity_rad_per_s: velocity?,
            pose_rad: pose?,
            way_rad: way?,
            other_pose_rad: other?,
            pull_nm: pull?,
            arm_m: arm?,
            arm_u_m: arm_u?,
            gauge_u_ratio: gauge_u?,
            ampere: ampere?,
            allowed_ratio: allowed?,
        })
    }
}
