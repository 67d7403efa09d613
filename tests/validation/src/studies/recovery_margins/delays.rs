//! Delays: rows 10, 11 and 12.

use std::f64::consts::TAU;

use analysis::delay::{Band, Dynamics, OnsetShape, Step, cross_correlation, joint, phase_slope, step_onset};
use analysis::frf::{C64, Line};

use super::table::{Demand, Gauss, study};

const DELAY_S: f64 = 1.25e-3;

pub(crate) fn rows(seeds: u64) {
    phase_slopes(seeds);
    with_plant(seeds);
    correlations(seeds);
    onsets(seeds);
}

fn lines(seed: u64, ratio: f64, plant: impl Fn(C64) -> C64) -> Vec<Line> {
    let mut random = Gauss::new(seed);
    let at = |hz: f64| {
        let s = C64::new(0.0, TAU * hz);
        random.line(hz, (-s * DELAY_S).exp() * plant(s), ratio)
    };
    (0..490).map(|k| 10.0 + 490.0 * f64::from(k) / 489.0).map(at).collect()
}

fn phase_slopes(seeds: u64) {
    for (snr_db, ratio, rms) in [(20, 0.1, 4.3e-6), (40, 0.01, 0.43e-6), (60, 0.001, 0.045e-6)] {
        let demand = Demand { truth: DELAY_S, rms, unit: 1e-6 };
        study(&[(format!("phase slope, {snr_db} dB, us"), demand)], seeds, |seed| {
            let found = phase_slope(&lines(seed, ratio, |_| C64::from(1.0)));
            vec![found.ok().map(|f| [f.delay_s, f.u_s, f64::INFINITY])]
        });
    }
}

fn with_plant(seeds: u64) {
    let mode = |hz: f64, zeta: f64| {
        move |s: C64| 1.0 / ((s / (TAU * hz)).powi(2) + 2.0 * zeta * s / (TAU * hz) + 1.0)
    };
    let second = Dynamics { lag: false, second_order: true };
    for (hz, zeta) in [(60.0, 0.1), (322.0, 0.36), (40.0, 0.03), (600.0, 0.7)] {
        let demand = Demand { truth: DELAY_S, rms: 2e-6, unit: 1e-6 };
        study(&[(format!("delay beside {hz} Hz, zeta {zeta}, 40 dB, us"), demand)], seeds, |seed| {
            let found = joint(&lines(seed, 0.01, mode(hz, zeta)), second, 5e-3, 0.999);
            vec![found.ok().map(|f| [f.delay_s, f.u_s, f64::INFINITY])]
        });
    }
    let demand = Demand { truth: DELAY_S, rms: 5e-6, unit: 1e-6 };
    study(&[("delay beside a lag of 159 us, 40 dB, us".to_owned(), demand)], seeds, |seed| {
        let lag = Dynamics { lag: true, second_order: false };
        let found = joint(&lines(seed, 0.01, |s| 1.0 / (1.0 + s / (TAU * 1000.0))), lag, 5e-3, 0.999);
        vec![found.ok().map(|f| [f.delay_s, f.u_s, f64::INFINITY])]
    });
}

/// Band-limited noise and the same late, by shifting the phases of a periodic record, then cut: 10 s at 4 kHz.
fn correlations(seeds: u64) {
    const RATE_HZ: f64 = 4000.0;
    const N: usize = 40_960;
    for (snr_db, ratio) in [(20, 0.1), (40, 0.01)] {
        let demands = [1.25e-3, 1.333e-3, -0.4187e-3].map(|truth| {
            let rms = if snr_db == 40 { 0.1e-6 } else { 1e-6 };
            (format!("cross correlation, {snr_db} dB, us"), Demand { truth, rms, unit: 1e-6 })
        });
        study(&demands, seeds, |seed| {
            let mut random = Gauss::new(seed);
            let spectrum: Vec<C64> = (0..=N / 2)
                .map(|k| {
                    let inside = k > 0 && k as f64 * RATE_HZ / N as f64 <= 1000.0;
                    if inside { C64::new(random.next(), random.next()) } else { C64::default() }
                })
                .collect();
            let first = record(&spectrum, 0.0, RATE_HZ, N);
            let rms = (first.iter().map(|v| v * v).sum::<f64>() / first.len() as f64).sqrt();
            let band = Band { from_hz: 5.0, to_hz: 990.0 };
            let mut late = |delay_s: f64| {
                let mut second = record(&spectrum, delay_s, RATE_HZ, N);
                second.iter_mut().for_each(|v| *v += ratio * rms * random.next());
                let found = cross_correlation(&first, &second, RATE_HZ, band, 0.01).ok()?;
                Some([found.delay_s, found.u_s, f64::INFINITY])
            };
            demands.iter().map(|(_, demand)| late(demand.truth)).collect()
        });
    }
}

fn record(spectrum: &[C64], delay_s: f64, rate_hz: f64, n: usize) -> Vec<f64> {
    let plan = fourier::inverse(n);
    let turn = |k: usize| C64::from_polar(1.0, -TAU * k as f64 * rate_hz / n as f64 * delay_s);
    let mut lines: Vec<C64> = spectrum.iter().enumerate().map(|(k, c)| c * turn(k)).collect();
    let mut out = plan.make_output_vec();
    plan.process(&mut lines, &mut out).expect("buffers fit");
    // The ends are cut off so that nothing is periodic.
    out[100..n - 860].to_vec()
}

fn onsets(seeds: u64) {
    const TS: f64 = 250e-6;
    type Rise = fn(f64) -> f64;
    let lag: Rise = |t| 1.0 - (-t / 159e-6).exp();
    let slow: Rise = |t| 1.0 - (-t / 900e-6).exp();
    let ramp: Rise = |t| (t / 5e-3).min(1.0);
    let free = OnsetShape::Exponential { time_constant_s: None };
    let known = OnsetShape::Exponential { time_constant_s: Some(159e-6) };
    let cases: [(&str, Rise, OnsetShape); 4] = [
        ("ramp", ramp, OnsetShape::Ramp),
        ("lag 159 us, known", lag, known),
        ("lag 159 us, unknown", lag, free),
        ("lag 900 us, unknown", slow, free),
    ];
    for (name, rise, shape) in cases {
        let demand = Demand { truth: 1.5e-3 / TS, rms: 0.1, unit: 1.0 };
        study(&[(format!("step onset, {name}, 10 repeats, Ts"), demand)], seeds, |seed| {
            let mut random = Gauss::new(seed);
            let repeats: Vec<Step> = (0..10)
                .map(|_| {
                    let phase = random.uniform();
                    let since_command_s: Vec<f64> = (-40..80).map(|k| (f64::from(k) + phase) * TS).collect();
                    let value = |t: &f64| 0.3 + 2.0 * rise((t - 1.5e-3).max(0.0)) + 0.02 * random.next();
                    let value = since_command_s.iter().map(value).collect();
                    Step { since_command_s, value }
                })
                .collect();
            vec![step_onset(&repeats, shape).ok().map(|f| [f.delay_s / TS, f.u_s / TS, f.dof])]
        });
    }
}
