//! What a rig file says of the external angle reference.

use std::f64::consts::TAU;

use procedures::axis::AngleReference;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape, TableReader};

use crate::model::axis::RigAxis;
use crate::model::device::ReferenceSettings;
use crate::model::rig::Gimbal;

/// Analog inputs of the autocollimators: azimuth, elevation.
const INPUTS: [usize; 2] = [5, 6];
/// Fewer faces are no polygon.
const LEAST_FACES: usize = 3;

const fn required(key: &'static str, shape: Shape, doc: &'static str) -> Field {
    Field { key, shape, need: Need::Required, doc }
}

/// Keys of `[reference]`.
pub(super) const REFERENCE_FIELDS: &[Field] = &[
    required(
        "scale",
        Shape::Quantity(K::AngleScale),
        "Angle per volt of the autocollimators on analog inputs 5 and 6; +10 V where no face is in sight.",
    ),
    required("range", Shape::Quantity(K::Angle), "Largest angle off a face that is read."),
    required(
        "uncertainty",
        Shape::Quantity(K::Angle),
        "Standard uncertainty of a place: table, autocollimator and mounting.",
    ),
    required(
        "azimuth-faces",
        Shape::Quantities(K::Angle),
        "Calibration of the polygon: by how much each face, in equal parts of a turn from 0 on, is off its place.",
    ),
    required("elevation-faces", Shape::Quantities(K::Angle), "The same for elevation."),
];

/// Reads `[reference]`: how it is wired, and what it is to outer and inner axis.
pub(super) fn read(t: &mut TableReader<'_>) -> Option<(ReferenceSettings, [AngleReference; 2])> {
    let (scale, range, u) = (t.positive("scale"), t.positive("range"), t.positive("uncertainty"));
    let faces = ["azimuth-faces", "elevation-faces"].map(|key| {
        let off = t.quantities(key)?;
        if off.len() < LEAST_FACES {
            let help = Some(format!("a polygon has at least {LEAST_FACES}"));
            t.mistake(key, format!("{} faces", off.len()), help);
            return None;
        }
        Some(off)
    });
    let [az, el] = faces;
    let (range_rad, u_rad) = (range?, u?);
    let reference = |off: Vec<f64>| {
        let part_rad = TAU / off.len() as f64;
        let place = |(face, off): (usize, f64)| {
            let angle = part_rad * face as f64 + off;
            angle - (angle / TAU).round() * TAU
        };
        AngleReference { faces_rad: off.into_iter().enumerate().map(place).collect(), range_rad, u_rad }
    };
    Some((ReferenceSettings { scale_rad_per_v: scale?, inputs: INPUTS }, [reference(az?), reference(el?)]))
}

/// Gives outer and inner axis what measures them from outside, or the first two axes of a rig without gimbal.
pub(super) fn attach(axes: &mut [RigAxis], references: [AngleReference; 2]) {
    let pair = Gimbal::of(axes).map_or([0, 1], Gimbal::both);
    for (axis, reference) in pair.into_iter().zip(references) {
        if let Some(axis) = axes.get_mut(axis) {
            axis.limits.reference = Some(reference);
        }
    }
}
