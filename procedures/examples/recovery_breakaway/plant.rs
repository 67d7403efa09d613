//! A one-axis plant with LuGre friction that ages: the truth against which the estimators are held.
//!
//! Equations: director.md §3 (LuGre, corrected) and §8 (ageing). The bristle and the age are advanced exactly for
//! constant speed over a step, so any step is stable; inertia by semi-implicit Euler.

use std::f64::consts::TAU;

/// Parameters of an axis, SI units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plant {
    pub(crate) inertia: f64,
    pub(crate) coulomb: f64,
    pub(crate) static_friction: f64,
    pub(crate) stribeck: f64,
    pub(crate) shape: f64,
    pub(crate) viscous: f64,
    pub(crate) sigma0: f64,
    pub(crate) sigma1: f64,
    /// ΔT per unit of ln(1 + φ/τ_d), with τ_d = 1 s.
    pub(crate) ageing: f64,
    /// Cogging: amplitude, order per revolution, phase.
    pub(crate) cogging: [f64; 3],
    pub(crate) unbalance: f64,
    /// Cable spring: stiffness and rest angle.
    pub(crate) spring: [f64; 2],
}

/// Azimuth of director.md §3 and §8.
pub(crate) const AZIMUTH: Plant = Plant {
    inertia: 1200.0,
    coulomb: 167.75,
    static_friction: 210.0,
    stribeck: 0.12,
    shape: 2.5,
    viscous: 273.6,
    sigma0: 90_000.0,
    sigma1: 16_354.0,
    ageing: 4.2,
    cogging: [8.45, 144.0, 0.4],
    unbalance: 0.0,
    spring: [0.0, 0.0],
};

/// Elevation of director.md §3 and §8, unit `nominal`.
pub(crate) const ELEVATION: Plant = Plant {
    inertia: 975.0,
    coulomb: 34.5,
    static_friction: 43.125,
    stribeck: 0.012,
    shape: 0.85,
    viscous: 68.4,
    sigma0: 50_000.0,
    sigma1: 8_322.0,
    ageing: 0.8625,
    cogging: [5.07, 108.0, 0.4],
    unbalance: 14.0,
    spring: [20.0, 40.0 * TAU / 360.0],
};

/// State of the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) theta: f64,
    pub(crate) omega: f64,
    pub(crate) z: f64,
    pub(crate) age: f64,
}

impl Plant {
    /// Steady-state bristle deflection T_S/σ0.
    pub(crate) fn z_ss(&self) -> f64 {
        self.static_friction / self.sigma0
    }

    /// Torque of cogging, unbalance and spring on the axis.
    pub(crate) fn load(&self, theta: f64) -> f64 {
        let [amplitude, order, phase] = self.cogging;
        let [stiffness, rest] = self.spring;
        amplitude * (order * theta + phase).sin() + self.unbalance * theta.cos() - stiffness * (theta - rest)
    }

    /// Advances bristle and age over a step at constant speed; gives the friction torque.
    pub(crate) fn friction(&self, state: &mut State, dt: f64) -> f64 {
        let speed = state.omega.abs();
        let aged = self.ageing * (1.0 + state.age).ln();
        let fall = (-(speed / self.stribeck).powf(self.shape)).exp();
        let level = self.coulomb + (self.static_friction + aged - self.coulomb) * fall;
        let rate = self.sigma0 * speed / level;
        let target = level / self.sigma0 * state.omega.signum();
        let before = state.z;
        state.z = target + (before - target) * (-rate * dt).exp();
        let decay = speed / self.z_ss();
        state.age = if decay * dt > 1e-12 {
            (state.age - 1.0 / decay) * (-decay * dt).exp() + 1.0 / decay
        } else {
            state.age + dt
        };
        state.age = state.age.min(1000.0);
        self.sigma0 * state.z + self.sigma1 * (state.z - before) / dt + self.viscous * state.omega
    }

    /// One step under a motor torque; gives the friction torque in force.
    pub(crate) fn step(&self, state: &mut State, torque: f64, dt: f64) -> f64 {
        let friction = self.friction(state, dt);
        state.omega += (torque - friction + self.load(state.theta)) / self.inertia * dt;
        state.theta += state.omega * dt;
        friction
    }
}
