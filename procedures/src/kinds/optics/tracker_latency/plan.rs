//! The point: sines of mirror or axis before a target that stands.

use super::keys::Keys;
use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment};
use crate::diagnostic::Diagnostic;
use crate::excitation::{Excitation, Injection, Signal, Sine};
use crate::kinds::optics::frames;
use crate::kinds::position::positioned::{self, gimbal_for};
use crate::quantity::QuantityKind as Q;
use crate::table::quoted;

/// Label of the sines.
pub(super) const SINES: &str = "sines";
/// Rest before the sines: the gimbal comes to rest.
const SETTLE_S: f64 = 1.0;
/// The last frames of the last period are still on their way when it ends.
const TAIL_S: f64 = 0.2;

/// The point, or why the rig does not allow it.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let gimbal = gimbal_for("tracker-latency", axes)?;
    let Some(moved) = gimbal.index_of(axis) else {
        let message = format!("no tracker looks along axis `{axis}`");
        let help = format!("the trackers look along {}", quoted(gimbal.names()));
        return Err(vec![Diagnostic::new(message).help(help)]);
    };
    let (into, amplitude) = if keys.is_fine {
        ([Injection::MirrorAz, Injection::MirrorEl][moved], keys.amplitude_rad)
    } else {
        (Injection::Velocity, keys.rate_rad_per_s)
    };
    let count = keys.frequencies_hz.len() as f64;
    // Phases after Schroeder for lines of equal power keep the peaks low.
    let phase = |k: usize| -std::f64::consts::PI * (k * k) as f64 / count;
    let line = |(k, &frequency_hz): (usize, &f64)| Sine { frequency_hz, amplitude, phase_rad: phase(k) };
    let lines = keys.frequencies_hz.iter().enumerate().map(line).collect();
    let signal = Signal::Multisine { period_s: keys.period_s, lines };
    let lasts_s = f64::from(keys.periods + 1) * keys.period_s + TAIL_S;
    let sines = Segment { excited: Some(0), ..Segment::hold(SINES, Mode::Position, lasts_s) };
    let rate = |value| Request { name: "frame-rate".to_owned(), value, kind: Q::Frequency };
    Ok(vec![Case {
        point: format!("{} tracker", keys.tracker()),
        axis: axis.to_owned(),
        requested: keys.frame_rate_hz.map(rate).into_iter().collect(),
        start_pose_rad: positioned::poses(axes, keys.pose_rad),
        segments: vec![Segment::hold("settle", Mode::Position, SETTLE_S), sines],
        excitations: vec![Excitation { into, signal, fade_s: 0.5 * keys.period_s, every_ticks: 1 }],
        logs_payload_fully: true,
        target: Some(frames::star(keys.pose_rad)),
        fine_frame_rate_hz: keys.frame_rate_hz.filter(|_| keys.is_fine),
        ..Case::default()
    }])
}
