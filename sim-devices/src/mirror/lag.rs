//! First-order lag and pure delay.

/// First-order lag with exact time behaviour for inputs that hold or move linearly over a step.
#[derive(Clone, Debug)]
pub(super) struct Lag {
    /// exp(−T/τ).
    decay: f64,
    /// Mean of exp(−t/τ) over a step.
    mean: f64,
    output: f64,
    input: f64,
}

impl Lag {
    pub(super) fn new(cutoff_hz: f64, step_s: f64) -> Self {
        let steps = std::f64::consts::TAU * cutoff_hz * step_s;
        Self { decay: (-steps).exp(), mean: -(-steps).exp_m1() / steps, output: 0.0, input: 0.0 }
    }

    /// The mean output over a step in which the input holds: what a slower stage after it feels.
    #[inline]
    pub(super) fn hold(&mut self, input: f64) -> f64 {
        let mean = self.mean * self.output + (1.0 - self.mean) * input;
        self.output = self.decay * self.output + (1.0 - self.decay) * input;
        mean
    }

    /// The output at the end of a step in which the input moves linearly to `input`.
    #[inline]
    pub(super) fn ramp(&mut self, input: f64) -> f64 {
        let carried = self.decay * self.output + (self.mean - self.decay) * self.input;
        self.output = carried + (1.0 - self.mean) * input;
        self.input = input;
        self.output
    }
}

/// A delay of any time, linear between steps; both axes go through it together.
#[derive(Clone, Debug)]
pub(super) struct Delay {
    /// As long as a power of two.
    past: Vec<[f64; 2]>,
    at: usize,
    whole: usize,
    fraction: f64,
}

impl Delay {
    pub(super) fn new(delay_s: f64, step_s: f64) -> Self {
        let steps = (delay_s / step_s).max(0.0);
        let nearest = steps.round();
        // 150 µs are three steps of 50 µs, whatever the division says.
        let steps = if (steps - nearest).abs() < 1e-6 { nearest } else { steps };
        let whole = steps.floor() as usize;
        let length = (whole + 2).next_power_of_two();
        Self { past: vec![[0.0; 2]; length], at: 0, whole, fraction: steps - steps.floor() }
    }

    #[inline]
    pub(super) fn update(&mut self, input: [f64; 2]) -> [f64; 2] {
        if self.whole == 0 && self.fraction == 0.0 {
            return input;
        }
        let mask = self.past.len() - 1;
        self.at = (self.at + 1) & mask;
        self.past[self.at] = input;
        let newer = self.past[self.at.wrapping_sub(self.whole) & mask];
        if self.fraction == 0.0 {
            return newer;
        }
        let older = self.past[self.at.wrapping_sub(self.whole + 1) & mask];
        [0, 1].map(|axis| newer[axis] + self.fraction * (older[axis] - newer[axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_comes_out_late_by_the_time_constant_however_coarse_the_step() {
        let cutoff_hz = 20_000.0;
        let step_s = 50e-6;
        let late_s = 1.0 / (std::f64::consts::TAU * cutoff_hz);
        let mut held = Lag::new(cutoff_hz, step_s);
        let mut moved = Lag::new(cutoff_hz, step_s);
        let mut mean = 0.0;
        let mut end = 0.0;
        for k in 0..200_u32 {
            mean = held.hold(f64::from(k) * step_s);
            end = moved.ramp(f64::from(k) * step_s);
        }
        assert!((end - (199.0 * step_s - late_s)).abs() < 1e-12);
        assert!((mean - (199.0 * step_s - late_s)).abs() < 1e-12);
    }

    #[test]
    fn a_delay_of_two_and_a_half_steps_lies_between_the_second_and_the_third() {
        let mut delay = Delay::new(2.5e-4, 1e-4);
        let outputs: Vec<f64> =
            (0..6_u32).map(|k| delay.update([if k == 0 { 1.0 } else { 0.0 }, 0.0])[0]).collect();
        assert_eq!(outputs, [0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
        assert_eq!(Delay::new(0.0, 1e-4).update([3.0, 4.0]), [3.0, 4.0]);
    }
}
