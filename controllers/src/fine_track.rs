//! Fine track loop of one axis: the camera behind the mirror sees what error is left, an integrator moves the mirror.

use crate::camera::{Frame, TrackState, Watch};
use crate::{FineTrackGains, finite_or_zero};

/// `mirror += G·K·T·e` with each frame; G is the optical gain, mirror angle per line-of-sight angle with its sign.
///
/// With a total delay τ the loop is `K/s·e^{−sτ}`, its error rejection `1/(1 + L)` is 0 dB where `K = 2ω sin ωτ`:
/// with K = 48 1/s and 11 ms at 7.6 Hz. K does not depend on the frame rate 1/T.
///
/// The command is the integral, limited at the stroke: it cannot wind up. Without a target the mirror stands, then
/// goes back to its centre; whatever happens, the command never jumps.
#[derive(Clone, Debug, PartialEq)]
pub struct FineTracker {
    /// G·K·T.
    step_per_error: f64,
    stroke_rad: f64,
    return_step_rad: f64,
    watch: Watch,
    command_rad: f64,
}

impl FineTracker {
    /// A tracker with the mirror at its centre. `optical_gain` is that of the axis, `frame_period_s` that of the
    /// camera; it is updated every `period_s`.
    pub fn new(gains: &FineTrackGains, optical_gain: f64, frame_period_s: f64, period_s: f64) -> Self {
        Self {
            step_per_error: finite_or_zero(optical_gain * gains.gain_per_s * frame_period_s),
            stroke_rad: finite_or_zero(gains.stroke_rad).abs(),
            return_step_rad: finite_or_zero(gains.return_rate_rad_per_s * period_s).abs(),
            watch: Watch::new(gains.dropout_s, gains.hold_s, period_s),
            command_rad: 0.0,
        }
    }

    /// Goes on from this mirror angle, without a target.
    pub fn reset(&mut self, mirror_rad: f64) {
        self.watch.forget();
        self.command_rad = self.limited(finite_or_zero(mirror_rad));
    }

    /// One tick: the frame that has arrived since the last one, if any. Returns the mirror's command.
    pub fn update(&mut self, frame: Option<Frame>) -> f64 {
        let target_rad = frame.as_ref().and_then(Frame::target_rad);
        if self.watch.update(frame.map(|_| target_rad.is_some())) == TrackState::Lost {
            let step_rad = self.return_step_rad;
            self.command_rad -= self.command_rad.max(-step_rad).min(step_rad);
        }
        if let Some(error_rad) = target_rad {
            self.command_rad = self.limited(self.command_rad + self.step_per_error * error_rad);
        }
        self.command_rad
    }

    /// What is known of the target.
    pub fn state(&self) -> TrackState {
        self.watch.state()
    }

    /// Whether the command stands at the stroke's end.
    pub fn is_saturated(&self) -> bool {
        self.command_rad.abs() >= self.stroke_rad
    }

    fn limited(&self, command_rad: f64) -> f64 {
        command_rad.max(-self.stroke_rad).min(self.stroke_rad)
    }
}

#[cfg(test)]
mod tests;
