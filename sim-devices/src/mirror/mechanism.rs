//! One axis of the mirror on its support, stepped exactly.

use std::f64::consts::TAU;

use crate::physics::piezo::exponential;
use crate::unit::MirrorSettings;

const STATES: usize = 4;
/// Mirror angle and rate relative to the support, support angle and rate.
const ANGLE: usize = 0;
const RATE: usize = 1;
const SUPPORT: usize = 2;
const SUPPORT_RATE: usize = 3;

/// Mirror and support about one axis; the actuator demand u holds over a step.
///
/// ```text
/// θ̈ + φ̈ = ω0²·(u − θ) − 2ζ·ω0·θ̇            θ: mirror relative to its support, what the strain gauge feels
/// φ̈ = −ω_s²·φ − 2ζ_s·ω_s·φ̇ − ρ·(θ̈ + φ̈)      φ: support; ρ: moving inertia over the support's
/// ```
/// With a rigid mount (ρ = 0) that is the published `ω0²/(s² + 2ζω0·s + ω0²)`.
#[derive(Clone, Debug)]
pub(super) struct Mechanism {
    /// By column, so that a step is a sum of scaled columns; the last one belongs to the demand.
    columns: [[f64; STATES]; STATES + 1],
    state: [f64; STATES],
    /// −J/T.
    torque_per_rate: f64,
    torque_nm: f64,
}

impl Mechanism {
    pub(super) fn new(settings: &MirrorSettings, axis: usize, step_s: f64) -> Self {
        let omega = TAU * settings.frequency_hz[axis];
        let support_omega = TAU * settings.support_frequency_hz;
        let stiffness_per_s2 = omega * omega;
        let damping_per_s = 2.0 * settings.damping_ratio[axis] * omega;
        let coupling = settings.support_coupling_ratio;
        let inertial = [-stiffness_per_s2, -damping_per_s, 0.0, 0.0, stiffness_per_s2];
        let mut a = [[0.0; STATES + 1]; STATES + 1];
        a[ANGLE][RATE] = 1.0;
        a[SUPPORT][SUPPORT_RATE] = 1.0;
        a[SUPPORT_RATE] = inertial.map(|term| -coupling * term);
        a[SUPPORT_RATE][SUPPORT] -= support_omega * support_omega;
        a[SUPPORT_RATE][SUPPORT_RATE] -= 2.0 * settings.support_damping_ratio * support_omega;
        a[RATE] = std::array::from_fn(|k| inertial[k] - a[SUPPORT_RATE][k]);
        let map = exponential(&a, step_s);
        Self {
            columns: std::array::from_fn(|column| std::array::from_fn(|row| map[row][column])),
            state: [0.0; STATES],
            torque_per_rate: -settings.inertia_kg_m2 / step_s,
            torque_nm: 0.0,
        }
    }

    #[inline]
    pub(super) fn step(&mut self, demand_rad: f64) {
        // The demand comes last: it is known last, the rest need not wait for it.
        let mut next = [0.0; STATES];
        for (column, x) in self.columns.iter().zip(self.state.iter().chain([&demand_rad])) {
            next.iter_mut().zip(column).for_each(|(sum, factor)| *sum += factor * x);
        }
        let rate_change = next[RATE] + next[SUPPORT_RATE] - self.state[RATE] - self.state[SUPPORT_RATE];
        self.torque_nm = self.torque_per_rate * rate_change;
        self.state = next;
    }

    /// Mirror relative to its support.
    pub(super) fn relative_rad(&self) -> f64 {
        self.state[ANGLE]
    }

    /// Mirror in the frame of the structure that carries the support.
    pub(super) fn absolute_rad(&self) -> f64 {
        self.state[ANGLE] + self.state[SUPPORT]
    }

    /// Mean torque on the support during the step.
    pub(super) fn reaction_nm(&self) -> f64 {
        self.torque_nm
    }
}
