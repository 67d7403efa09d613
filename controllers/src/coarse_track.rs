//! Coarse track loop: PI on the target's angle, which a slow camera gives and the gyros carry on between its frames.

use crate::camera::{Frame, TrackState, Watch};
use crate::target::TargetEstimate;
use crate::{TrackGains, TrackSettings, finite_or_zero};

/// Ticks of line of sight that are kept: 256 ms at 2 kHz. Older frames are no use.
const HISTORY: usize = 512;

/// `ω_cmd = Kt (e + (1/Tt) ∫e)` with `e = θ_target − θ_LOS − Tp ω_gyro`.
///
/// θ_LOS is the integrated gyro. A frame adds its error to θ_LOS **at its exposure** and so gives the target's angle
/// among the stars, untouched by what the axis did since: the camera's latency and hold do not enter the loop's
/// margins. They do delay what is seen of the target's own motion; the prediction makes up for that. With a frame of
/// age 0 in every tick this is the plain PI on the camera's error.
///
/// The integral is made first, then used (backward Euler), and takes no step into saturation. It stands while the
/// target is missing. Whenever a target (re)appears the integral starts so that the command goes on without a jump.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseTracker {
    gains: TrackGains,
    gyro_age_s: f64,
    period_s: f64,
    rate_limit_rad_per_s: f64,
    line_of_sight: LineOfSightHistory,
    target: TargetEstimate,
    /// Since the exposure of the newest frame with a target.
    target_age_s: f64,
    watch: Watch,
    integral_rad: f64,
    integral_factor: f64,
    command_rad_per_s: f64,
}

impl CoarseTracker {
    /// A tracker without a target, updated every `period_s`, that never commands more than ± `rate_limit_rad_per_s`.
    pub fn new(
        gains: &TrackGains,
        settings: &TrackSettings,
        rate_limit_rad_per_s: f64,
        period_s: f64,
    ) -> Self {
        Self {
            gains: *gains,
            gyro_age_s: finite_or_zero(settings.gyro_age_s),
            period_s,
            rate_limit_rad_per_s: finite_or_zero(rate_limit_rad_per_s).abs(),
            line_of_sight: LineOfSightHistory::new(),
            target: TargetEstimate::new(settings.prediction, settings.alpha, settings.beta),
            target_age_s: 0.0,
            watch: Watch::new(settings.dropout_s, settings.hold_s, period_s),
            integral_rad: 0.0,
            integral_factor: 1.0,
            command_rad_per_s: 0.0,
        }
    }

    /// Forgets the target; the next one is taken up with this rate command, the one the axis has now.
    pub fn reset(&mut self, rate_rad_per_s: f64) {
        self.watch.forget();
        self.target.forget();
        self.command_rad_per_s = self.limited(finite_or_zero(rate_rad_per_s));
    }

    /// Scales the integral's steps from now on, 0 … 1: the keyhole's fade.
    pub fn fade_integral(&mut self, factor: f64) {
        self.integral_factor = finite_or_zero(factor).clamp(0.0, 1.0);
    }

    /// One tick: the frame that has arrived since the last one, if any, and the gyro's rate of this axis. Returns the
    /// rate command; 0 while there is no target. A gyro sample that is not finite counts as no rate.
    pub fn update(&mut self, frame: Option<Frame>, gyro_rad_per_s: f64) -> f64 {
        let gyro_rad_per_s = finite_or_zero(gyro_rad_per_s);
        self.line_of_sight.push(gyro_rad_per_s * self.period_s);
        self.target_age_s += self.period_s;
        let before = self.watch.state();
        let seen = frame.map(|frame| self.take(frame, before));
        if self.watch.update(seen) == TrackState::Lost {
            self.target.forget();
            if before != TrackState::Lost {
                self.command_rad_per_s = 0.0;
            }
            return 0.0;
        }
        let error_rad = self.error_rad(gyro_rad_per_s);
        if before != TrackState::Tracking && self.watch.state() == TrackState::Tracking {
            self.take_up(error_rad);
        }
        self.command_rad_per_s = self.law(error_rad);
        self.command_rad_per_s
    }

    /// What is known of the target.
    pub fn state(&self) -> TrackState {
        self.watch.state()
    }

    /// Estimated rate of the target; 0 without prediction.
    pub fn target_rate_rad_per_s(&self) -> f64 {
        self.target.rate_rad_per_s()
    }

    /// Measures the target by a frame; whether there was one.
    fn take(&mut self, frame: Frame, state: TrackState) -> bool {
        let Some(error_rad) = frame.target_rad() else { return false };
        let back = ((frame.age_s - self.gyro_age_s) / self.period_s).max(0.0);
        let Some(line_of_sight_rad) = self.line_of_sight.ago(back) else { return false };
        let interval_s = self.target_age_s - frame.age_s;
        if state != TrackState::Lost && interval_s <= 0.0 {
            return false;
        }
        self.target.update(line_of_sight_rad + error_rad, interval_s);
        self.target_age_s = frame.age_s;
        true
    }

    fn error_rad(&self, gyro_rad_per_s: f64) -> f64 {
        let target_rad = self.target.predicted_rad(self.target_age_s);
        target_rad - self.line_of_sight.now_rad - self.gains.gyro_lead_s * gyro_rad_per_s
    }

    /// Sets the integral so that the command does not jump.
    fn take_up(&mut self, error_rad: f64) {
        if self.gains.integral_time_s > 0.0 {
            let proportional_rad = self.command_rad_per_s / self.gains.gain_per_s;
            self.integral_rad = finite_or_zero(proportional_rad - error_rad - self.step_rad(error_rad));
        }
    }

    fn step_rad(&self, error_rad: f64) -> f64 {
        if self.gains.integral_time_s > 0.0 && self.watch.state() == TrackState::Tracking {
            error_rad * self.integral_factor * self.period_s / self.gains.integral_time_s
        } else {
            0.0
        }
    }

    fn law(&mut self, error_rad: f64) -> f64 {
        let step_rad = self.step_rad(error_rad);
        let wanted = self.gains.gain_per_s * (error_rad + self.integral_rad + step_rad);
        let command = self.limited(wanted);
        if command == wanted || step_rad * wanted < 0.0 {
            self.integral_rad += step_rad;
        }
        command
    }

    fn limited(&self, rate: f64) -> f64 {
        rate.max(-self.rate_limit_rad_per_s).min(self.rate_limit_rad_per_s)
    }
}

/// The integrated gyro, now and some time back.
#[derive(Clone, Debug, PartialEq)]
struct LineOfSightHistory {
    now_rad: f64,
    angles_rad: [f64; HISTORY],
    newest: usize,
    filled: usize,
}

impl LineOfSightHistory {
    fn new() -> Self {
        Self { now_rad: 0.0, angles_rad: [0.0; HISTORY], newest: 0, filled: 0 }
    }

    fn push(&mut self, step_rad: f64) {
        self.now_rad += step_rad;
        self.newest = (self.newest + 1) % HISTORY;
        self.filled = (self.filled + 1).min(HISTORY);
        self.angles_rad[self.newest] = self.now_rad;
    }

    /// The angle this many ticks ago, ≥ 0, linear in between; `None` where it is not kept.
    fn ago(&self, ticks: f64) -> Option<f64> {
        let whole = ticks as usize;
        let later = self.angles_rad[(self.newest + HISTORY - whole.min(HISTORY)) % HISTORY];
        let earlier = self.angles_rad[(self.newest + HISTORY - (whole + 1).min(HISTORY)) % HISTORY];
        let part = ticks - whole as f64;
        if whole + 1 < self.filled {
            Some(later + (earlier - later) * part)
        } else {
            // The last one kept has none before it.
            (whole < self.filled && part == 0.0).then_some(later)
        }
    }
}

#[cfg(test)]
mod tests;
