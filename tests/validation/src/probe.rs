//! Loops of the simulated plant, measured in the time domain with the production controllers and without the bench:
//! what the linear model must agree with.

mod closed_loop;
mod coarse;
mod multisine;
mod position;
pub mod tracking;
mod velocity;

pub use coarse::{CoarseBench, LAW_TICKS};
pub use multisine::Multisine;
pub use position::measured_step;
pub use velocity::{Background, measured_velocity_loop};

use num_complex::Complex64;

/// More torque, and more rate, than any excitation here asks for: the loops stay linear.
const UNLIMITED: f64 = 1e9;

/// A frequency response on the lines of a multisine.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Lines, ascending.
    pub frequency_hz: Vec<f64>,
    /// Value at each.
    pub value: Vec<Complex64>,
}

impl Response {
    /// The response between its lines: by a parabola through the three nearest.
    ///
    /// # Panics
    /// Never for a response of three lines or more; a multisine has hundreds.
    pub fn at(&self, frequency_hz: f64) -> Complex64 {
        let above = self.frequency_hz.partition_point(|f| *f < frequency_hz);
        let first = above.saturating_sub(if self.is_nearer_below(above, frequency_hz) { 2 } else { 1 });
        let first = first.min(self.frequency_hz.len() - 3);
        let f = &self.frequency_hz[first..first + 3];
        let v = &self.value[first..first + 3];
        let weight = |a: usize, b: usize, c: usize| {
            (frequency_hz - f[b]) * (frequency_hz - f[c]) / ((f[a] - f[b]) * (f[a] - f[c]))
        };
        v[0] * weight(0, 1, 2) + v[1] * weight(1, 0, 2) + v[2] * weight(2, 0, 1)
    }

    fn is_nearer_below(&self, above: usize, frequency_hz: f64) -> bool {
        let below = self.frequency_hz.get(above.wrapping_sub(1));
        let over = self.frequency_hz.get(above);
        matches!((below, over), (Some(b), Some(o)) if frequency_hz - b < o - frequency_hz)
    }
}

/// The study's fit, modes.md sections 2 and 5: azimuth, elevation.
#[cfg(test)]
pub(crate) fn study_gains(axis: usize) -> controllers::AxisGains {
    let [kp, ki] = [[23_600.0, 447_500.0], [18_250.0, 361_400.0]][axis];
    controllers::AxisGains {
        velocity_kp_nm_s_per_rad: kp,
        velocity_ki_nm_per_rad: ki,
        position_gain_per_s: 4.5,
        ..Default::default()
    }
}
