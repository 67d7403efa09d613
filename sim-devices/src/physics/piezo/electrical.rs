//! The equivalent circuit in time: voltage in, current out.

use super::circuit::{Circuit, RELAXATIONS};
use super::exponential;

/// Voltage of the stacks, of each relaxation, of the motional capacitance; motional current.
const STATES: usize = RELAXATIONS + 3;
/// States, source voltage and its slope.
const AUGMENTED: usize = STATES + 2;
const STACK: usize = 0;
const MOTIONAL_V: usize = RELAXATIONS + 1;
const MOTIONAL_A: usize = RELAXATIONS + 2;
const SOURCE: usize = STATES;
const SLOPE: usize = STATES + 1;

/// One axis at the terminals of an analyser.
///
/// Between samples the source voltage moves linearly (a first-order hold), for which the discretisation is exact.
/// The images of a sampled sine above the sampling rate fall back into the sampled current: they pass the series
/// resistance alone, so the impedance at f is off by about `(f·step)²·|Z|/R_s`; [`Circuit::sampling_step_s`] turns
/// that around.
#[derive(Clone, Debug)]
pub struct ElectricalPort {
    map: [[f64; AUGMENTED]; STATES],
    states: [f64; STATES],
    source_v: f64,
    step_s: f64,
    series_ohm: f64,
}

impl ElectricalPort {
    /// A discharged axis whose terminals are driven every `step_s`.
    pub fn new(circuit: &Circuit, step_s: f64) -> Self {
        let map = exponential(&derivative(circuit), step_s);
        Self {
            map: std::array::from_fn(|row| map[row]),
            states: [0.0; STATES],
            source_v: 0.0,
            step_s,
            series_ohm: circuit.series_ohm,
        }
    }

    /// Brings the source to `source_v` over one step; returns the current at its end, A.
    pub fn step(&mut self, source_v: f64) -> f64 {
        let slope = (source_v - self.source_v) / self.step_s;
        let before = self.states;
        for (state, row) in self.states.iter_mut().zip(&self.map) {
            let carried: f64 = before.iter().zip(row).map(|(x, factor)| x * factor).sum();
            *state = carried + row[SOURCE] * self.source_v + row[SLOPE] * slope;
        }
        self.source_v = source_v;
        (source_v - self.states[STACK]) / self.series_ohm
    }
}

/// Kirchhoff's laws: rows are derivatives.
fn derivative(circuit: &Circuit) -> [[f64; AUGMENTED]; AUGMENTED] {
    let mut a = [[0.0; AUGMENTED]; AUGMENTED];
    let stack_f = circuit.fast_capacitance_f;
    a[STACK][SOURCE] = 1.0 / (circuit.series_ohm * stack_f);
    a[STACK][STACK] = -(1.0 / circuit.series_ohm + 1.0 / circuit.leak_ohm) / stack_f;
    for (k, branch) in circuit.relaxations.iter().enumerate().filter(|(_, b)| b.capacitance_f > 0.0) {
        let state = k + 1;
        a[STACK][STACK] -= 1.0 / (branch.resistance_ohm * stack_f);
        a[STACK][state] = 1.0 / (branch.resistance_ohm * stack_f);
        a[state][STACK] = 1.0 / (branch.resistance_ohm * branch.capacitance_f);
        a[state][state] = -a[state][STACK];
    }
    if circuit.motional_f > 0.0 {
        a[STACK][MOTIONAL_A] = -1.0 / stack_f;
        a[MOTIONAL_V][MOTIONAL_A] = 1.0 / circuit.motional_f;
        a[MOTIONAL_A][STACK] = 1.0 / circuit.motional_h;
        a[MOTIONAL_A][MOTIONAL_V] = -1.0 / circuit.motional_h;
        a[MOTIONAL_A][MOTIONAL_A] = -circuit.motional_ohm / circuit.motional_h;
    }
    a[SOURCE][SLOPE] = 1.0;
    a
}
