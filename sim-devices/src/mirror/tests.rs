use std::f64::consts::TAU;

use super::*;

mod closed;
mod line;
mod open;

const STEP_S: f64 = 50e-6;
const STEPS_PER_S: f64 = 20_000.0;

fn address() -> SeedAddress {
    SeedAddress { seed: 1, procedure: "FSM".into(), point: "1".into() }
}

fn mirror(settings: &MirrorSettings) -> Mirror {
    Mirror::new(settings, &address(), STEP_S)
}

/// The published unit and nothing else: no hysteresis, creep, coupling, noise, coarse quantum; rigid mount.
fn linear() -> MirrorSettings {
    MirrorSettings {
        hysteresis_ratio: 0.0,
        creep_per_decade_ratio: 0.0,
        cross_coupling_ratio: 0.0,
        support_coupling_ratio: 0.0,
        gauge_noise_rad: 0.0,
        resolution_rad: 1e-12,
        analog_delay_s: 0.0,
        ..MirrorSettings::default()
    }
}

fn broken_loop() -> MirrorSettings {
    MirrorSettings { strain_gauge_loop_switch: 0.0, ..MirrorSettings::default() }
}

/// Complex numbers as `[re, im]`.
fn divide(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let square = b[0] * b[0] + b[1] * b[1];
    [(a[0] * b[0] + a[1] * b[1]) / square, (a[1] * b[0] - a[0] * b[1]) / square]
}

fn decibel(z: [f64; 2]) -> f64 {
    20.0 * z[0].hypot(z[1]).log10()
}

/// What is looked at, both axes.
type Look = fn(&Mirror) -> [f64; 2];

/// Harmonics 1… of both axes' `look` under a sine on the analog input of `axis`, as complex amplitudes relative to
/// the amplitude of the command in rad; whole periods after half a second.
fn harmonics(mirror: &mut Mirror, axis: usize, hz: f64, amplitude_v: f64, look: Look) -> [[[f64; 2]; 5]; 2] {
    let per_period = STEPS_PER_S / hz;
    let settle = (0.5 * hz).ceil() * per_period;
    let total = settle + (0.2 * hz).ceil() * per_period;
    let mut sums = [[[0.0; 2]; 5]; 2];
    for k in 0..total.round() as u64 {
        let phase = TAU * hz * STEP_S * k as f64;
        // The command of this step holds until its end, where the look is taken.
        let seen = look(mirror);
        mirror.command_analog_v(axis, amplitude_v * phase.sin());
        mirror.step(k);
        if k >= settle.round() as u64 {
            for (sums, value) in sums.iter_mut().zip(seen) {
                for (order, sum) in (1_u32..).zip(sums) {
                    let (sin, cos) = (f64::from(order) * phase).sin_cos();
                    *sum = [sum[0] + value * sin, sum[1] + value * cos];
                }
            }
        }
    }
    let scale = 2.0 / (total - settle) / (amplitude_v * 500e-6);
    sums.map(|axis| axis.map(|sum| sum.map(|part| part * scale)))
}

/// Response of an axis to its own analog command.
fn response(settings: &MirrorSettings, axis: usize, hz: f64, amplitude_v: f64, look: Look) -> [f64; 2] {
    harmonics(&mut mirror(settings), axis, hz, amplitude_v, look)[axis][0]
}

#[test]
fn the_same_address_gives_the_same_mirror_and_another_one_does_not() {
    let run = |address: &SeedAddress| {
        let mut mirror = Mirror::new(&MirrorSettings::default(), address, STEP_S);
        (0..2000).map(|k| (mirror.step(k), mirror.sensed_rad()).1[0].abs()).sum::<f64>()
    };
    assert_eq!(run(&address()), run(&address()));
    assert_ne!(run(&address()), run(&SeedAddress { seed: 2, ..address() }));
}

#[test]
fn at_rest_the_gauge_shows_its_noise_and_its_quantum() {
    let mut mirror = mirror(&MirrorSettings::default());
    let mut square = 0.0;
    for k in 0..20_000 {
        mirror.step(k);
        let counts = mirror.sensed_rad()[1] / 0.2e-6;
        assert!((counts - counts.round()).abs() < 1e-9);
        square += mirror.sensed_rad()[1].powi(2);
    }
    let rms = (square / 20_000.0).sqrt();
    assert!((0.08e-6..0.2e-6).contains(&rms), "{rms:e} rad");
}
