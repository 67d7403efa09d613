//! A frequency response with its uncertainty, as every estimator gives it and every reader takes it.

pub(crate) mod pooled;

/// A complex number.
pub type C64 = nalgebra::Complex<f64>;

/// 20·lg e: what a relative deviation of a gain is in dB.
pub const DB_PER_NEPER: f64 = 8.685_889_638_065_037;

/// A response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Output over input, in the ratio of their units.
    pub value: C64,
    /// Variance of the value, E|Ĝ − G|²: real and imaginary part together. 0 if it is known exactly.
    pub variance: f64,
    /// Complex degrees of freedom of the variance (independent observations less one); infinite if it is known.
    pub dof: f64,
    /// Coherence of input and output, 0…1, corrected for its bias, where the estimator has one.
    pub coherence: Option<f64>,
}

/// A frequency response: lines in ascending frequency.
pub type Frf = Vec<Line>;

impl Line {
    /// A value that is known exactly.
    pub fn exact(frequency_hz: f64, value: C64) -> Self {
        Self { frequency_hz, value, variance: 0.0, dof: f64::INFINITY, coherence: None }
    }

    /// |G| in dB.
    pub fn gain_db(&self) -> f64 {
        20.0 * self.value.norm().log10()
    }

    /// Phase in rad, −π…π.
    pub fn phase_rad(&self) -> f64 {
        self.value.arg()
    }

    /// Relative standard deviation of |G|, which is that of the phase in rad: √(var/2)/|G| (Pintelon & Schoukens,
    /// *System Identification*, 2nd ed., §2.4). 0 for what is known exactly; infinite for a value of 0 that is not.
    pub fn relative_sd(&self) -> f64 {
        if self.variance > 0.0 { (0.5 * self.variance).sqrt() / self.value.norm() } else { 0.0 }
    }

    /// Radius of the circle around the value that holds the true one with a probability: r² = var·F_p(2, 2·dof),
    /// var·(−ln(1 − p)) where the variance is known (Pintelon & Schoukens, §2.5). Infinite without a degree of freedom
    /// and for a probability of 1; 0 for one of 0.
    ///
    /// With two degrees above the fraction line the quantile has a closed form, F_p(2, 2ν) = ν·((1 − p)^(−1/ν) − 1):
    /// the general one, of the incomplete beta function, takes minutes for some 10⁹ degrees.
    pub fn circle_radius(&self, probability: f64) -> f64 {
        if self.dof.is_nan() || self.dof <= 0.0 || probability.is_nan() || probability >= 1.0 {
            return f64::INFINITY;
        }
        let known = -(-probability.max(0.0)).ln_1p();
        let quantile = if self.dof.is_infinite() { known } else { self.dof * (known / self.dof).exp_m1() };
        (self.variance * quantile).sqrt()
    }
}

/// Phases of lines without jumps: each within π of the one before.
pub fn unwrapped_rad(lines: &[Line]) -> Vec<f64> {
    let mut phases: Vec<f64> = Vec::with_capacity(lines.len());
    for line in lines {
        let phase = line.phase_rad();
        let turns = phases.last().map_or(0.0, |last| ((last - phase) / std::f64::consts::TAU).round());
        phases.push(phase + turns * std::f64::consts::TAU);
    }
    phases
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With two complex degrees of freedom F_p(2, 4) has the closed form 2·((1 − p)^(−1/2) − 1).
    #[test]
    fn circle_radius_follows_the_f_distribution() {
        let line = Line { variance: 4.0, dof: 2.0, ..Line::exact(1.0, C64::new(1.0, 0.0)) };
        let expected = (4.0 * 2.0 * (0.05_f64.powf(-0.5) - 1.0)).sqrt();
        assert!((line.circle_radius(0.95) - expected).abs() < 1e-6 * expected);
    }

    #[test]
    fn a_variance_that_is_known_gives_the_circle_of_a_complex_normal() {
        let line = Line { variance: 4.0, ..Line::exact(1.0, C64::new(1.0, 0.0)) };
        assert!((line.circle_radius(0.95) - (4.0 * 20_f64.ln()).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn without_a_degree_of_freedom_the_circle_has_no_end() {
        let line = Line { variance: 1.0, dof: 0.0, ..Line::exact(1.0, C64::new(1.0, 0.0)) };
        assert!(line.circle_radius(0.95).is_infinite());
    }

    #[test]
    fn a_thousand_million_degrees_of_freedom_take_no_time_and_any_probability_has_a_radius() {
        let line = Line { variance: 4.0, dof: 1e9, ..Line::exact(1.0, C64::new(1.0, 0.0)) };
        assert!((line.circle_radius(0.95) - (4.0 * 20_f64.ln()).sqrt()).abs() < 1e-8);
        assert!(line.circle_radius(-0.1) <= 0.0 && line.circle_radius(1.5).is_infinite());
        assert!(line.circle_radius(f64::NAN).is_infinite());
        let exact = Line { dof: 0.0, ..Line::exact(1.0, C64::default()) };
        assert!(exact.circle_radius(0.95).is_infinite() && exact.relative_sd() <= 0.0);
    }

    #[test]
    fn phase_of_a_delay_unwraps_to_a_straight_line() {
        let line = |k: i32| Line::exact(f64::from(k), C64::from_polar(1.0, -0.9 * f64::from(k)));
        let phases = unwrapped_rad(&(0..20).map(line).collect::<Vec<_>>());
        assert!(phases.iter().enumerate().all(|(k, p)| (p + 0.9 * k as f64).abs() < 1e-9));
    }
}
