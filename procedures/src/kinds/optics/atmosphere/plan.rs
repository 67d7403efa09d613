//! The points: what the tracker makes of a mirror angle, then the fine loop closed, and open.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment, Tracks};
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames::{self, MIRROR_AXES};
use crate::quantity::QuantityKind as Q;

/// Label of the record.
pub(super) const RECORD: &str = "record";
/// Label of the mirror's sine before the loop is closed.
pub(super) const SINE: &str = "sine";
/// Names of the points.
pub(super) const CLOSED: &str = "closed";
pub(super) const OPEN: &str = "open";

/// Frequency of the mirror's sine: slow against the mirror.
pub(super) const SINE_HZ: f64 = 2.0;
/// Blocks of the sine, of two periods each.
pub(super) const SINE_BLOCKS: usize = 6;
pub(super) const BLOCK_S: f64 = 2.0 / SINE_HZ;
/// The sine grows in this time.
pub(super) const LEAD_S: f64 = 0.5;
/// Rest before a record: the gimbal comes to rest.
const SETTLE_S: f64 = 1.0;
/// The fine loop takes its target up in this time, and its transient is over. Whether it did shows in the record: a loop
/// that loses frames all the time never counts as locked, and what it rejects is asked for all the same.
const ACQUIRE_S: f64 = 2.0;

/// All points, or why the rig does not allow them.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    frames::check_axes("atmosphere", axis, axes)?;
    let fine = Some(Tracks { fine: true, ..Tracks::default() });
    let acquire = Segment { tracks: fine, ..Segment::hold("acquire", Mode::Position, ACQUIRE_S) };
    let closed = Segment { tracks: fine, ..Segment::hold(RECORD, Mode::Position, keys.closed_s) };
    let open = Segment::hold(RECORD, Mode::Position, keys.open_s);
    let case = |point: &str, segments: Vec<Segment>| Case {
        point: point.to_owned(),
        axis: axis.to_owned(),
        requested: vec![Request {
            name: "frame-rate".to_owned(),
            value: keys.frame_rate_hz,
            kind: Q::Frequency,
        }],
        start_pose_rad: frames::poses(axes, keys.pose_rad),
        segments: [Segment::hold("settle", Mode::Position, SETTLE_S)].into_iter().chain(segments).collect(),
        logs_payload_fully: true,
        target: Some(frames::star(keys.pose_rad)),
        fine_frame_rate_hz: Some(keys.frame_rate_hz),
        ..Case::default()
    };
    let excitation =
        |mirror_axis: usize| vec![frames::mirror_sine(mirror_axis, SINE_HZ, keys.amplitude_rad, LEAD_S)];
    let sine = |label: &str| {
        let lasts_s = LEAD_S + SINE_BLOCKS as f64 * BLOCK_S;
        Segment { excited: Some(0), ..Segment::hold(label, Mode::Position, lasts_s) }
    };
    let gains = (0..MIRROR_AXES.len()).map(|mirror_axis| {
        let excitations = excitation(mirror_axis);
        Case { excitations, ..case(&gain_point(mirror_axis), vec![sine(RECORD)]) }
    });
    // The sine shows how late the exposures are stated that the loop is closed on.
    let closed = Case { excitations: excitation(0), ..case(CLOSED, vec![sine(SINE), acquire, closed]) };
    Ok(gains.chain([case(OPEN, vec![open]), closed]).collect())
}

/// Name of the point that moves an axis of the mirror.
pub(super) fn gain_point(mirror_axis: usize) -> String {
    format!("mirror {}", MIRROR_AXES[mirror_axis])
}
