//! Acceleration of an axis out of the rate that its drive sends.

/// Time constant of the smoothing: one count per millisecond of the rate is 0.02 rad/s² then.
const SMOOTHING_S: f64 = 0.004;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Acceleration {
    last_rad_per_s: Option<f64>,
    rad_per_s2: f64,
}

impl Acceleration {
    /// A fresh sample, `span_s` after the one before.
    pub(super) fn take(&mut self, rate_rad_per_s: f64, span_s: f64) {
        if let Some(last) = self.last_rad_per_s {
            let slope = (rate_rad_per_s - last) / span_s;
            let share = span_s / (span_s + SMOOTHING_S);
            // What is not a number must show, but not for ever.
            let before = if self.rad_per_s2.is_nan() { 0.0 } else { self.rad_per_s2 };
            self.rad_per_s2 = before + share * (slope - before);
        }
        self.last_rad_per_s = Some(rate_rad_per_s);
    }

    /// Smoothed.
    pub(super) fn rad_per_s2(&self) -> f64 {
        self.rad_per_s2
    }
}
