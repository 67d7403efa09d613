//! Where a target is between the frames that show it.

use crate::{Prediction, finite_or_zero};

/// α-β filter: `x̂ += α r`, `v̂ += β r/Δ` with the innovation `r = z − (x̂ + v̂ Δ)`; constant velocity in between.
///
/// The filter follows a constant rate without error; a constant acceleration a leaves `a Δ² (1 − α)/β` in the angle and
/// `a Δ (α/β − ½)` in the rate (Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and
/// Navigation*, 2001, section 6.5). Without prediction it is the newest measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetEstimate {
    alpha: f64,
    beta: f64,
    position_rad: f64,
    rate_rad_per_s: f64,
    known: bool,
}

impl TargetEstimate {
    /// An estimate of nothing yet. α is kept within 0 … 1, β within 0 … 4 − 2α, where the filter is stable.
    pub fn new(prediction: Prediction, alpha: f64, beta: f64) -> Self {
        let (alpha, beta) = match prediction {
            Prediction::Off => (1.0, 0.0),
            Prediction::ConstantVelocity => {
                let alpha = finite_or_zero(alpha).clamp(0.0, 1.0);
                (alpha, finite_or_zero(beta).clamp(0.0, 4.0 - 2.0 * alpha))
            }
        };
        Self { alpha, beta, position_rad: 0.0, rate_rad_per_s: 0.0, known: false }
    }

    /// Drops what is known.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// A measurement `interval_s` after the one before; ignored if it is not a number or not later.
    pub fn update(&mut self, position_rad: f64, interval_s: f64) {
        if !position_rad.is_finite() {
            return;
        }
        if !self.known {
            *self = Self { position_rad, rate_rad_per_s: 0.0, known: true, ..*self };
        } else if interval_s > 0.0 && interval_s.is_finite() {
            let predicted_rad = self.predicted_rad(interval_s);
            let innovation_rad = position_rad - predicted_rad;
            self.position_rad = predicted_rad + self.alpha * innovation_rad;
            self.rate_rad_per_s += self.beta * innovation_rad / interval_s;
        }
    }

    /// The target's angle `ahead_s` after its last measurement.
    pub fn predicted_rad(&self, ahead_s: f64) -> f64 {
        self.position_rad + self.rate_rad_per_s * ahead_s
    }

    /// The target's rate; 0 without prediction.
    pub fn rate_rad_per_s(&self) -> f64 {
        self.rate_rad_per_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL_S: f64 = 0.02;

    fn after_200_frames(mut estimate: TargetEstimate, target: impl Fn(f64) -> f64) -> TargetEstimate {
        (1..=200).for_each(|k| estimate.update(target(f64::from(k) * INTERVAL_S), INTERVAL_S));
        estimate
    }

    #[test]
    fn constant_rate_is_followed_without_error_and_predicted() {
        let estimate = TargetEstimate::new(Prediction::ConstantVelocity, 0.51, 0.09);
        let estimate = after_200_frames(estimate, |t| 0.1 + 0.0118 * t);
        assert!((estimate.predicted_rad(0.05) - (0.1 + 0.0118 * 4.05)).abs() < 1e-12);
        assert!((estimate.rate_rad_per_s() - 0.0118).abs() < 1e-12);
    }

    #[test]
    fn constant_acceleration_leaves_the_published_lags() {
        let a = 0.3;
        let alpha = 0.51;
        let beta = 0.09;
        let estimate = TargetEstimate::new(Prediction::ConstantVelocity, alpha, beta);
        let estimate = after_200_frames(estimate, |t| a * t * t / 2.0);
        let lag_rad = a * 8.0 - estimate.predicted_rad(0.0);
        assert!((lag_rad - a * INTERVAL_S * INTERVAL_S * (1.0 - alpha) / beta).abs() < 1e-9, "{lag_rad}");
        let lag_rad_per_s = a * 4.0 - estimate.rate_rad_per_s();
        assert!((lag_rad_per_s - a * INTERVAL_S * (alpha / beta - 0.5)).abs() < 1e-9, "{lag_rad_per_s}");
    }

    #[test]
    fn without_prediction_the_last_measurement_is_held() {
        let estimate = TargetEstimate::new(Prediction::Off, 0.51, 0.09);
        let estimate = after_200_frames(estimate, |t| 0.1 + 0.0118 * t);
        assert_eq!(estimate.predicted_rad(0.05), 0.1 + 0.0118 * 4.0);
    }

    #[test]
    fn broken_and_late_measurements_are_ignored_and_a_forgotten_target_starts_anew() {
        let mut estimate = TargetEstimate::new(Prediction::ConstantVelocity, 0.5, 0.1);
        estimate.update(1.0, 0.0);
        for (position, interval) in [(f64::NAN, 0.02), (3.0, 0.0), (3.0, -0.1), (3.0, f64::NAN)] {
            estimate.update(position, interval);
            assert_eq!(estimate.predicted_rad(1.0), 1.0);
        }
        estimate.forget();
        estimate.update(5.0, 0.02);
        assert_eq!(estimate.predicted_rad(1.0), 5.0);
    }
}
