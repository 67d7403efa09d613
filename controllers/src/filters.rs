//! Filters: biquads designed by the bilinear transform with prewarping, and a rate limiter.

use core::f64::consts::PI;

/// A second-order section `(b0 + b1 z⁻¹ + b2 z⁻²)/(1 + a1 z⁻¹ + a2 z⁻²)`, transposed direct form II.
///
/// Each design maps `s` to `K (z − 1)/(z + 1)` with `K = 1/tan(π f/f_s)`, so that the analog response at its own
/// frequency `f` is met exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Biquad {
    b: [f64; 3],
    /// a1, a2.
    a: [f64; 2],
    state: [f64; 2],
}

impl Biquad {
    /// First-order low-pass `1/(1 + s)`: −3.01 dB and −45° at the cut-off.
    ///
    /// `None` unless `0 < cutoff_hz < sample_rate_hz / 2`.
    pub fn first_order_low_pass(cutoff_hz: f64, sample_rate_hz: f64) -> Option<Self> {
        let k = prewarp(cutoff_hz, sample_rate_hz)?;
        let a0 = 1.0 + k;
        Some(Self { b: [1.0 / a0, 1.0 / a0, 0.0], a: [(1.0 - k) / a0, 0.0], state: [0.0; 2] })
    }

    /// Second-order low-pass `1/(s² + 2ζs + 1)`: gain `1/(2ζ)` and −90° at the cut-off; ζ = 1/√2 is Butterworth.
    ///
    /// `None` unless `0 < cutoff_hz < sample_rate_hz / 2` and ζ > 0.
    pub fn low_pass(cutoff_hz: f64, damping_ratio: f64, sample_rate_hz: f64) -> Option<Self> {
        let k = prewarp(cutoff_hz, sample_rate_hz)?;
        Self::second_order([1.0, 2.0, 1.0], k, damping_ratio)
    }

    /// Notch `(s² + 2ζ_n s + 1)/(s² + 2ζ_d s + 1)`: gain `ζ_n/ζ_d` at the centre, 1 far from it.
    ///
    /// `None` unless `0 < centre_hz < sample_rate_hz / 2`, ζ_n ≥ 0 and ζ_d > 0.
    pub fn notch(
        centre_hz: f64,
        numerator_damping_ratio: f64,
        denominator_damping_ratio: f64,
        sample_rate_hz: f64,
    ) -> Option<Self> {
        let k = prewarp(centre_hz, sample_rate_hz)?;
        if !(numerator_damping_ratio.is_finite() && numerator_damping_ratio >= 0.0) {
            return None;
        }
        let square = k * k + 1.0;
        let linear = 2.0 * numerator_damping_ratio * k;
        Self::second_order(
            [square + linear, 2.0 * (1.0 - k * k), square - linear],
            k,
            denominator_damping_ratio,
        )
    }

    /// A numerator in z⁻¹ over `s² + 2ζs + 1`.
    fn second_order(b: [f64; 3], k: f64, damping_ratio: f64) -> Option<Self> {
        if !(damping_ratio.is_finite() && damping_ratio > 0.0) {
            return None;
        }
        let square = k * k + 1.0;
        let linear = 2.0 * damping_ratio * k;
        let a0 = square + linear;
        let a = [2.0 * (1.0 - k * k) / a0, (square - linear) / a0];
        Some(Self { b: b.map(|b| b / a0), a, state: [0.0; 2] })
    }

    /// Puts the filter into the steady state of a constant input: no transient when it is switched in.
    pub fn settle(&mut self, input: f64) {
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let output = input * (b0 + b1 + b2) / (1.0 + a1 + a2);
        self.state = [output - b0 * input, b2 * input - a2 * output];
    }

    /// One sample in, one out. A sample that is not finite is left out: the filter then answers as to 0.
    pub fn update(&mut self, input: f64) -> f64 {
        let input = crate::finite_or_zero(input);
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let output = b0 * input + self.state[0];
        self.state = [b1 * input - a1 * output + self.state[1], b2 * input - a2 * output];
        output
    }
}

fn prewarp(frequency_hz: f64, sample_rate_hz: f64) -> Option<f64> {
    let inside = frequency_hz > 0.0 && frequency_hz < sample_rate_hz / 2.0 && sample_rate_hz.is_finite();
    inside.then(|| 1.0 / libm::tan(PI * frequency_hz / sample_rate_hz))
}

/// Follows its input no faster than a given rate, in units of the input.
#[derive(Clone, Debug, PartialEq)]
pub struct RateLimiter {
    step: f64,
    output: f64,
}

impl RateLimiter {
    /// Starts at `output`; changes by at most `rate_per_s · period_s` per update.
    pub fn new(rate_per_s: f64, period_s: f64, output: f64) -> Self {
        Self { step: crate::finite_or_zero(rate_per_s * period_s).abs(), output }
    }

    /// One tick towards the input; an input that is not a number leaves the output where it is.
    pub fn update(&mut self, input: f64) -> f64 {
        if !input.is_nan() {
            self.output += (input - self.output).max(-self.step).min(self.step);
        }
        self.output
    }
}

#[cfg(test)]
mod tests;
