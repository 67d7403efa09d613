//! Margins of known loops measured at 40 dB a line: PI, delay, rigid body and three modes, and a textbook loop.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line};
use analysis::margins::{Margins, Settings, margins};

use super::table::{Demand, Estimate, Gauss, study};

/// A velocity loop: J_eff, b, then frequency, damping and gain of each mode; gains of the controller.
pub(crate) struct Axis {
    name: &'static str,
    inertia: [f64; 2],
    modes: [[f64; 3]; 3],
    gains: [f64; 2],
}

const AXES: [Axis; 4] = [
    Axis {
        name: "el 0",
        inertia: [1018.49, 68.4],
        modes: [[17.250, 0.035, -2.0714e-4], [18.0, 0.03, 9.2308e-5], [46.0, 0.03, 1.5385e-4]],
        gains: [18_250.0, 361_400.0],
    },
    Axis {
        name: "el 40",
        inertia: [979.70, 68.4],
        modes: [[17.865, 0.035, -1.7201e-4], [20.380, 0.03, 1.0872e-4], [48.4, 0.03, 1.5385e-4]],
        gains: [18_250.0, 361_400.0],
    },
    Axis {
        name: "az 20",
        inertia: [1138.95, 273.6],
        modes: [[40.851, 0.03, -4.1771e-4], [53.733, 0.03, 2.0833e-4], [85.527, 0.03, 1.6667e-4]],
        gains: [23_600.0, 447_500.0],
    },
    Axis {
        name: "az 40",
        inertia: [1319.55, 273.6],
        modes: [[38.5, 0.03, -3.3177e-4], [50.5, 0.03, 2.0833e-4], [82.0, 0.03, 1.6667e-4]],
        gains: [23_600.0, 447_500.0],
    },
];

impl Axis {
    fn open(&self, hz: f64) -> C64 {
        let s = C64::new(0.0, TAU * hz);
        let mode = |[f, zeta, c]: &[f64; 3]| {
            let w = TAU * f;
            c * s / (s * s + 2.0 * zeta * w * s + w * w)
        };
        let plant = 1.0 / (self.inertia[0] * s + self.inertia[1]) + self.modes.iter().map(mode).sum::<C64>();
        (self.gains[0] + self.gains[1] / s) * (-s * 0.003125).exp() * plant
    }
}

/// 20·e^(−0.01·s)/(s·(1 + s/40)).
fn textbook(hz: f64) -> C64 {
    let s = C64::new(0.0, TAU * hz);
    20.0 * (-s * 0.01).exp() / (s * (1.0 + s / 40.0))
}

fn grids() -> Vec<(&'static str, Vec<f64>)> {
    let uniform = |from: u32, to: u32, step: f64| (from..=to).map(|k| f64::from(k) * step).collect();
    let log = |from: f64, to: f64, n: u32| {
        (0..n).map(|k| from * (to / from).powf(f64::from(k) / f64::from(n - 1))).collect()
    };
    vec![
        ("0.25 Hz", uniform(2, 301, 0.25)),
        ("0.5 Hz", uniform(1, 160, 0.5)),
        ("1 Hz", uniform(1, 100, 1.0)),
        ("150 log", log(0.3, 150.0, 150)),
    ]
}

pub(crate) fn rows(seeds: u64) {
    for (name, grid) in grids() {
        for axis in &AXES {
            one(&format!("{}, {name}", axis.name), &|hz| axis.open(hz), &grid, seeds);
        }
        one(&format!("textbook, {name}"), &textbook, &grid, seeds);
    }
}

fn one(name: &str, open: &(dyn Fn(f64) -> C64 + Sync), grid: &[f64], seeds: u64) {
    let exact: Vec<f64> = truth(open, [grid[0], grid[grid.len() - 1]]);
    let row = |k: usize, what: &str, rms: f64, unit: f64| {
        (format!("{name}: {what}"), Demand { truth: exact[k], rms, unit })
    };
    let free = f64::INFINITY;
    let demands = [
        row(0, "w_gc, %", 0.003 * exact[0], 0.01 * exact[0]),
        row(1, "PM, deg", 0.5_f64.to_radians(), 1_f64.to_radians()),
        row(2, "GM, dB", 0.1, 1.0),
        row(3, "GM at, %", free, 0.01 * exact[3]),
        row(4, "delay margin, %", free, 0.01 * exact[4]),
        row(5, "modulus margin", free, 1.0),
        row(6, "disk alpha", free, 1.0),
        row(7, "0 dB crossings listed", 0.0, 1.0),
    ];
    study(&demands, seeds, |seed| {
        let mut random = Gauss::new(seed);
        let lines: Vec<Line> = grid.iter().map(|&hz| random.line(hz, open(hz), 0.01)).collect();
        margins(&lines, &Settings::default()).map_or_else(|_| vec![None; 8], |m| estimates(&m))
    });
}

fn estimates(m: &Margins) -> Vec<Estimate> {
    let known = |value: f64, u: f64| Some([value, u, f64::INFINITY]);
    let gain = m.bandwidth().ok();
    let phase = m.gain_margin().ok();
    vec![
        gain.and_then(|c| known(c.frequency_hz, c.frequency_u_hz)),
        gain.and_then(|c| known(c.phase_margin_rad, c.phase_margin_u_rad)),
        phase.and_then(|c| known(c.gain_margin_db, c.gain_margin_u_db)),
        phase.and_then(|c| known(c.frequency_hz, c.frequency_u_hz)),
        gain.and_then(|c| known(c.delay_margin_s, c.delay_margin_u_s)),
        known(m.modulus.value, m.modulus.u),
        known(m.disk.alpha.value, m.disk.alpha.u),
        known(m.gain_crossings.len() as f64, 0.0),
    ]
}

/// First 0 dB crossing and its margins, the smallest gain margin and where, modulus and disk margin, number of 0 dB crossings.
fn truth(open: &dyn Fn(f64) -> C64, [from, to]: [f64; 2]) -> Vec<f64> {
    const N: u32 = 200_000;
    let at = |k: u32| from * (to / from).powf(f64::from(k) / f64::from(N));
    let mut gains = Vec::new();
    let mut phases = Vec::new();
    let mut modulus = f64::INFINITY;
    let mut alpha = f64::INFINITY;
    let mut before = open(at(0));
    for k in 1..=N {
        let now = open(at(k));
        modulus = modulus.min((1.0 + now).norm());
        alpha = alpha.min(2.0 * (1.0 + now).norm() / (1.0 - now).norm());
        if (before.norm() > 1.0) != (now.norm() > 1.0) {
            let part = before.norm().ln() / (before.norm() / now.norm()).ln();
            gains.push(at(k - 1) * (at(k) / at(k - 1)).powf(part));
        }
        if (before.im > 0.0) != (now.im > 0.0) && now.re < 0.0 {
            let hz = at(k - 1) * (at(k) / at(k - 1)).powf(before.im / (before.im - now.im));
            phases.push((-20.0 * open(hz).norm().log10(), hz));
        }
        before = now;
    }
    phases.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (db, hz) = phases.first().copied().unwrap_or((f64::NAN, f64::NAN));
    let margin = (-open(gains[0])).arg();
    vec![gains[0], margin, db, hz, margin / (TAU * gains[0]), modulus, alpha, gains.len() as f64]
}
