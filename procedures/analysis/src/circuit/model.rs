//! The circuit as numbers, and as the parameters that are searched.

use std::f64::consts::TAU;

use super::super::frf::C64;

/// Motional branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    pub(super) motional_f: f64,
    pub(super) series_hz: f64,
    pub(super) damping: f64,
}

impl Motion {
    pub(super) fn resistance_ohm(&self) -> f64 {
        2.0 * self.damping / (TAU * self.series_hz * self.motional_f)
    }

    pub(super) fn inductance_h(&self) -> f64 {
        1.0 / ((TAU * self.series_hz).powi(2) * self.motional_f)
    }

    /// jω·C_1·ω_s²/(ω_s² − ω² + 2jζω_sω).
    pub(super) fn admittance(&self, frequency_hz: f64) -> C64 {
        let x = frequency_hz / self.series_hz;
        C64::new(0.0, TAU * frequency_hz * self.motional_f) / C64::new(1.0 - x * x, 2.0 * self.damping * x)
    }
}

/// The circuit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Values {
    /// |C_0| at the reference frequency.
    pub(super) capacitance_f: f64,
    pub(super) series_ohm: f64,
    /// 2δ/π.
    pub(super) loss_exponent: f64,
    pub(super) resonance: Option<Motion>,
    pub(super) reference_hz: f64,
}

impl Values {
    /// Unknowns with a resonance.
    pub(super) const COUNT: usize = 6;

    /// ln C_0, R_s, exponent; then ln C_1, ln f_s, ln ζ: what cannot be negative by its logarithm.
    pub(super) fn parameters(&self) -> Vec<f64> {
        let plain = [self.capacitance_f.ln(), self.series_ohm, self.loss_exponent];
        let motion = self.resonance.map(|r| [r.motional_f.ln(), r.series_hz.ln(), r.damping.ln()]);
        plain.into_iter().chain(motion.into_iter().flatten()).collect()
    }

    /// Scale on which each parameter moves.
    pub(super) fn scales(&self) -> Vec<f64> {
        let ohm = 0.01 / (TAU * self.reference_hz * self.capacitance_f);
        let plain = [1.0, ohm, 0.01];
        plain.into_iter().chain(self.resonance.map(|_| [1.0; 3]).into_iter().flatten()).collect()
    }

    pub(super) fn from_parameters(p: &[f64], reference_hz: f64) -> Self {
        let motion =
            |p: &[f64]| Motion { motional_f: p[0].exp(), series_hz: p[1].exp(), damping: p[2].exp() };
        Self {
            capacitance_f: p[0].exp(),
            series_ohm: p[1],
            loss_exponent: p[2],
            resonance: p.get(3..Self::COUNT).map(motion),
            reference_hz,
        }
    }

    /// C_0 with its loss, C_0·(jω/ω_ref)^(−n).
    fn complex_capacitance_f(&self, frequency_hz: f64) -> C64 {
        let n = self.loss_exponent;
        let size = self.capacitance_f * (frequency_hz / self.reference_hz).powf(-n);
        C64::from_polar(size, -n * std::f64::consts::FRAC_PI_2)
    }

    pub(super) fn impedance(&self, frequency_hz: f64) -> C64 {
        let clamped = C64::new(0.0, TAU * frequency_hz) * self.complex_capacitance_f(frequency_hz);
        let motional = self.resonance.map_or(C64::default(), |r| r.admittance(frequency_hz));
        (clamped + motional).inv() + self.series_ohm
    }

    pub(super) fn coupling(&self) -> f64 {
        self.resonance.map_or(0.0, |r| {
            let clamped_f = self.complex_capacitance_f(r.series_hz).re;
            r.motional_f / (clamped_f + r.motional_f)
        })
    }

    pub(super) fn parallel_hz(&self) -> f64 {
        self.resonance.map_or(0.0, |r| r.series_hz / (1.0 - self.coupling()).sqrt())
    }
}
