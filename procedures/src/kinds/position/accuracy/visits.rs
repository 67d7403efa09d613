//! Where the axis was at each visit: by the encoder, by the reference.

use analysis::positioning::Target;

use super::plan::{Keys, visit};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::device::MIRROR_AXES;
use crate::kinds::position::positioned::Record;
use crate::log::Window;
use crate::reason::{PositionReason, Reason};

/// Topic of the external reference.
pub(super) const REFERENCE: &str = "/reference";
/// Why the reference says nothing.
/// Part of the rows in which a face must be in sight.
const SEEN_RATIO: f64 = 0.99;

/// Deviations of all visits: by the encoder, and by the reference or why not.
pub(super) struct Visits {
    pub(super) by_encoder: Vec<Target>,
    pub(super) by_reference: Result<Vec<Target>, Reason>,
}

/// Collects the visits of these targets.
pub(super) fn visits(
    keys: &Keys,
    targets_rad: &[f64],
    case: &Case,
    window: &Window,
    axes: &Axes,
) -> Result<Visits, Reason> {
    let record = Record::new(&case.axis, window)?;
    let sensor = Sensor::new(&case.axis, window, axes);
    let mut by_encoder = Vec::new();
    let mut by_reference = sensor.as_ref().map(|_| Vec::new()).map_err(Clone::clone);
    for (k, &target_rad) in targets_rad.iter().enumerate() {
        let mut seen =
            [Target { target_rad, ..Target::default() }, Target { target_rad, ..Target::default() }];
        for upwards in [true, false] {
            for span in Record::spans(case, window, &visit(k, upwards)) {
                let stretch_s = [span.end_s - keys.measure_s, span.end_s];
                let place_rad =
                    record.mean_rad(stretch_s[0], stretch_s[1]).ok_or(PositionReason::RowsMissingAtTarget)?;
                push(&mut seen[0], upwards, place_rad - target_rad);
                let true_rad =
                    sensor.as_ref().map_err(Clone::clone).and_then(|s| s.place_rad(place_rad, stretch_s));
                match true_rad {
                    Ok(true_rad) => push(&mut seen[1], upwards, true_rad - target_rad),
                    Err(reason) => by_reference = Err(reason),
                }
            }
        }
        let [encoder, reference] = seen;
        by_encoder.push(encoder);
        if let Ok(all) = &mut by_reference {
            all.push(reference);
        }
    }
    Ok(Visits { by_encoder, by_reference })
}

fn push(target: &mut Target, upwards: bool, deviation_rad: f64) {
    if upwards { target.up_rad.push(deviation_rad) } else { target.down_rad.push(deviation_rad) }
}

/// Columns of the reference.
struct Sensor<'a> {
    rows: &'a crate::log::Rows,
    deviation_rad: &'a [f64],
    sees_face: &'a [f64],
    limits: &'a AxisLimits,
}

impl<'a> Sensor<'a> {
    fn new(axis: &str, window: &'a Window, axes: &'a Axes) -> Result<Self, Reason> {
        let missing = || PositionReason::NoReference;
        let limits = axes.get(axis).filter(|limits| limits.reference.is_some()).ok_or_else(missing)?;
        let place = axes.pair().iter().position(|own| own.is_some_and(|own| own.name == axis));
        let word = MIRROR_AXES[place.ok_or_else(missing)?];
        let rows = window.rows(REFERENCE).ok_or_else(missing)?;
        let column = |name: String| rows.channel(&name);
        let deviation_rad = column(format!("deviation_{word}_rad"))?;
        Ok(Self { rows, deviation_rad, sees_face: column(format!("sees_face_{word}"))?, limits })
    }

    /// Where the axis was over a stretch of time; the encoder tells which face was in sight.
    fn place_rad(&self, near_rad: f64, [from_s, to_s]: [f64; 2]) -> Result<f64, Reason> {
        let rows = self.rows.range(from_s, to_s);
        let deviations = &self.deviation_rad[rows.clone()];
        let seen = &self.sees_face[rows];
        let count = deviations.len() as f64;
        let sees = seen.iter().filter(|s| **s > 0.5).count() as f64;
        let near_deg = near_rad.to_degrees();
        if deviations.is_empty() || sees < SEEN_RATIO * count || deviations.iter().any(|d| !d.is_finite()) {
            return Err(PositionReason::NoFaceInSight { near_deg }.into());
        }
        let sum: f64 = deviations.iter().zip(seen).filter(|(_, s)| **s > 0.5).map(|(d, _)| d).sum();
        let reference = self.limits.reference.as_ref().ok_or(PositionReason::NoReference)?;
        reference.angle_rad(near_rad, sum / sees).ok_or_else(|| PositionReason::NoFaces.into())
    }
}
