//! Electrical equivalent circuit of one piezo axis (Butterworth–Van Dyke, IEEE Std 176-1987).
//!
//! ```text
//!  o── R_s ──┬───────┬──────────┬───────────┬──────────── … ─┐
//!            C_∞    R_leak   R_1─C_1 …   R_m─L_m─C_m         │
//!  o─────────┴───────┴──────────┴───────────┴──────────── … ─┘
//! ```
//! The clamped capacitance has a loss tangent that hardly depends on frequency: a ladder of Debye relaxations, two
//! per decade. The motional branch resonates with the short-circuited mechanism; C_m/(C_0 + C_m) = k².

use std::f64::consts::{LN_10, PI, TAU};

/// Debye relaxations of the dielectric.
pub(super) const RELAXATIONS: usize = 10;
/// Relaxation frequencies: two per decade from here on, wider than what is measured (20 Hz … 2 kHz).
const FIRST_RELAXATION_HZ: f64 = 2.0;
const RELAXATIONS_PER_DECADE: f64 = 2.0;
/// Where the capacitance is stated: the dielectric loses (2/π)·ln 10·tan δ of it per decade above, 2.9 % for tan δ = 0.02.
const REFERENCE_HZ: f64 = 20.0;

/// A branch R–C in series.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Relaxation {
    pub(super) resistance_ohm: f64,
    pub(super) capacitance_f: f64,
}

/// A complex impedance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impedance {
    /// Real part.
    pub resistance_ohm: f64,
    /// Imaginary part.
    pub reactance_ohm: f64,
}

impl Impedance {
    /// Absolute value, Ω.
    pub fn magnitude_ohm(&self) -> f64 {
        self.resistance_ohm.hypot(self.reactance_ohm)
    }

    /// Phase of voltage before current, rad.
    pub fn phase_rad(&self) -> f64 {
        self.reactance_ohm.atan2(self.resistance_ohm)
    }
}

/// The circuit of one axis.
#[derive(Clone, Debug)]
pub struct Circuit {
    pub(super) series_ohm: f64,
    pub(super) leak_ohm: f64,
    pub(super) fast_capacitance_f: f64,
    pub(super) relaxations: [Relaxation; RELAXATIONS],
    pub(super) motional_ohm: f64,
    pub(super) motional_h: f64,
    pub(super) motional_f: f64,
}

/// What the circuit is made from.
#[derive(Clone, Debug)]
pub struct CircuitValues {
    /// Capacitance at 20 Hz, motional branch included.
    pub capacitance_f: f64,
    /// Electromechanical coupling k².
    pub coupling_ratio: f64,
    /// Loss tangent of the dielectric.
    pub loss_tangent_ratio: f64,
    /// Resonance of the short-circuited mechanism.
    pub frequency_hz: f64,
    /// Damping ratio of the resonance.
    pub damping_ratio: f64,
    /// Leads and electrodes.
    pub series_ohm: f64,
    /// Leakage.
    pub leak_ohm: f64,
}

impl Circuit {
    /// The circuit with these values.
    pub fn new(values: &CircuitValues) -> Self {
        let omega = TAU * values.frequency_hz;
        let motional_f = values.coupling_ratio * values.capacitance_f;
        let clamped_f = values.capacitance_f - motional_f;
        // A step ΔC per relaxation, `n` of them per decade, loses ΔC·n/ln 10·π/2 at every frequency between.
        let relaxing_f = values.loss_tangent_ratio * clamped_f * LN_10 / RELAXATIONS_PER_DECADE * 2.0 / PI;
        let corner_hz = |k: usize| FIRST_RELAXATION_HZ * 10_f64.powf(k as f64 / RELAXATIONS_PER_DECADE);
        let relaxed_count: f64 =
            (0..RELAXATIONS).map(|k| 1.0 / (1.0 + (REFERENCE_HZ / corner_hz(k)).powi(2))).sum();
        let relaxations = std::array::from_fn(|k| {
            let corner_hz = corner_hz(k);
            let resistance_ohm = if relaxing_f > 0.0 { 1.0 / (TAU * corner_hz * relaxing_f) } else { 1.0 };
            Relaxation { resistance_ohm, capacitance_f: relaxing_f }
        });
        Self {
            series_ohm: values.series_ohm,
            leak_ohm: values.leak_ohm,
            fast_capacitance_f: clamped_f - relaxing_f * relaxed_count,
            relaxations,
            motional_ohm: 2.0 * values.damping_ratio / (omega * motional_f),
            motional_h: 1.0 / (omega * omega * motional_f),
            motional_f,
        }
    }

    /// Impedance at a frequency above 0.
    pub fn impedance(&self, frequency_hz: f64) -> Impedance {
        let omega = TAU * frequency_hz;
        let mut conductance = 1.0 / self.leak_ohm;
        let mut susceptance = omega * self.fast_capacitance_f;
        for branch in &self.relaxations {
            let product = omega * branch.resistance_ohm * branch.capacitance_f;
            let scale = omega * branch.capacitance_f / (1.0 + product * product);
            conductance += scale * product;
            susceptance += scale;
        }
        if self.motional_f > 0.0 {
            let reactance_ohm = omega * self.motional_h - 1.0 / (omega * self.motional_f);
            let square = self.motional_ohm * self.motional_ohm + reactance_ohm * reactance_ohm;
            conductance += self.motional_ohm / square;
            susceptance -= reactance_ohm / square;
        }
        let square = conductance * conductance + susceptance * susceptance;
        Impedance {
            resistance_ohm: self.series_ohm + conductance / square,
            reactance_ohm: -susceptance / square,
        }
    }
}
