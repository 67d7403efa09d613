//! The points: each axis of the mirror at each frame rate and amplitude.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment};
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames::{self, MIRROR_AXES};
use crate::quantity::QuantityKind as Q;

/// Label of the sine.
pub(super) const SINE: &str = "sine";
const SETTLE: &str = "settle";
/// Rest before the sine: the gimbal comes to rest, the tracker finds its target.
const SETTLE_S: f64 = 0.5;
/// The sine grows in this time; it does not count.
pub(super) const LEAD_S: f64 = 0.5;

/// All points, or why the rig does not allow them.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    frames::check_axes("optical-gain", axis, axes)?;
    let mut cases = Vec::new();
    for mirror_axis in 0..MIRROR_AXES.len() {
        for &frame_rate_hz in &keys.frame_rates_hz {
            for &amplitude_rad in &keys.amplitudes_rad {
                let asked = [frame_rate_hz, amplitude_rad];
                cases.push(Case {
                    axis: axis.to_owned(),
                    start_pose_rad: frames::poses(axes, keys.pose_rad),
                    ..case(keys, mirror_axis, asked)
                });
            }
        }
    }
    Ok(cases)
}

fn case(keys: &Keys, mirror_axis: usize, [frame_rate_hz, amplitude_rad]: [f64; 2]) -> Case {
    let request = |name: &str, value, kind| Request { name: name.to_owned(), value, kind };
    let sine = Segment { excited: Some(0), ..Segment::hold(SINE, Mode::Position, LEAD_S + keys.duration_s) };
    Case {
        point: format!(
            "{} {} {}",
            MIRROR_AXES[mirror_axis],
            Q::Frequency.format(frame_rate_hz),
            format_args!("{:.0} urad", 1e6 * amplitude_rad)
        ),
        requested: vec![
            request("frame-rate", frame_rate_hz, Q::Frequency),
            request("amplitude", amplitude_rad, Q::Angle),
        ],
        segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), sine],
        excitations: vec![frames::mirror_sine(mirror_axis, keys.frequency_hz, amplitude_rad, LEAD_S)],
        logs_payload_fully: true,
        target: Some(frames::star(keys.pose_rad)),
        fine_frame_rate_hz: Some(frame_rate_hz),
        ..Case::default()
    }
}
