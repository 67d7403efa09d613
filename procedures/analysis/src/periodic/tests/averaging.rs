//! Windows on the plateaus of strokes, averaged with errors in both channels.

use std::f64::consts::TAU;

use super::plant::{Mode, Noise};
use crate::excitation::{Grid, Kind, Multisine, Offset, Phases, Selection, Sine, Spacing};
use crate::frf::C64;
use crate::periodic::{
    Channel, Prepared, Projection, Windows, errors_in_variables, snr_db, spectra, transfer, transient,
};

const RATE_HZ: f64 = 200.0;
const WINDOW_S: f64 = 2.0;
const LENGTH: usize = 400;
const COGGING_ORDER: f64 = 24.0;
/// 24·v/2π = 4.77 Hz of cogging.
const SPEED_RAD_S: f64 = 1.25;

fn excitation(offset: Offset) -> Multisine {
    let selection = Selection {
        band_hz: 1.5..=40.0,
        kind: Kind::Full,
        spacing: Spacing::Linear(24),
        forbidden_hz: vec![4.47..=5.07],
    };
    let grid = Grid::new(WINDOW_S, offset, RATE_HZ, &selection, &mut || 0.0).expect("a sound grid");
    Multisine::new(&grid, &|_| 1.0, Phases::Schroeder).expect("flat")
}

fn frequencies(multisine: &Multisine) -> Vec<f64> {
    multisine.lines.iter().map(|l| l.frequency_hz).collect()
}

/// Steady-state answer to a multisine.
fn answer(multisine: &Multisine, response: impl Fn(f64) -> C64) -> Multisine {
    let line = |l: &Sine| {
        let g = response(l.frequency_hz);
        Sine { amplitude: l.amplitude * g.norm(), phase_rad: l.phase_rad + g.arg(), ..*l }
    };
    Multisine { lines: multisine.lines.iter().map(line).collect(), ..multisine.clone() }
}

fn actuator(f: f64) -> C64 {
    C64::new(1.0, f / 30.0).inv()
}

fn plant(f: f64) -> C64 {
    Mode { natural_hz: 15.0, zeta: 0.05 }.at(f)
}

/// A record of two strokes there and back: reference, current, angle, and the cogging columns.
struct Strokes {
    channels: [Vec<f64>; 3],
    cogging: [Vec<f64>; 2],
    windows: Windows,
}

fn strokes(multisine: &Multisine) -> Strokes {
    let current = answer(multisine, actuator);
    let angle = answer(multisine, |f| actuator(f) * plant(f));
    // Reversals at 7, 14, 21 s; the plateaus leave half a second beside each.
    let mut slow = vec![0.3_f64];
    for i in 0..5600 {
        let direction = if (i / 1400) % 2 == 0 { 1.0 } else { -1.0 };
        slow.push(slow[i] + direction * SPEED_RAD_S / RATE_HZ);
    }
    let time = |i: usize| i as f64 / RATE_HZ;
    let sampled = |m: &Multisine| -> Vec<f64> { (0..slow.len()).map(|i| m.at(time(i))).collect() };
    let [cos, sin] = [f64::cos, f64::sin]
        .map(|f| -> Vec<f64> { slow.iter().map(|theta| f(COGGING_ORDER * theta)).collect() });
    let mut current = sampled(&current);
    let mut moved = sampled(&angle);
    for i in 0..slow.len() {
        current[i] += 0.8 + 0.5 * sin[i];
        moved[i] += slow[i] + 0.2 * cos[i];
    }
    let stretches: Vec<_> = (0..4).map(|k| 1400 * k + 101..1400 * k + 1290).collect();
    let length = (WINDOW_S * RATE_HZ).round() as usize;
    let windows_of = |stretch: &std::ops::Range<usize>| {
        let from = stretch.start;
        (0..stretch.len() / length).map(move |k| from + k * length)
    };
    let windows =
        Windows { sample_rate_hz: RATE_HZ, length, starts: stretches.iter().flat_map(windows_of).collect() };
    Strokes { channels: [sampled(multisine), current, moved], cogging: [cos, sin], windows }
}

#[test]
fn windows_anywhere_on_the_plateaus_give_the_response_in_spite_of_motion_and_cogging() {
    for offset in [Offset::Zero, Offset::Quarter, Offset::Half, Offset::ThreeQuarters] {
        let multisine = excitation(offset);
        let found = strokes(&multisine);
        assert_eq!(found.windows.starts[..3], [101, 501, 1501], "no start is a whole period");
        let [reference, current, angle] = &found.channels;
        let channels =
            [Channel { name: "current", samples: current }, Channel { name: "angle", samples: angle }];
        let nuisance: Vec<&[f64]> = found.cogging.iter().map(Vec::as_slice).collect();
        let grid_hz = frequencies(&multisine);
        let z = transfer(&found.windows, &grid_hz, reference, &channels, &nuisance).expect("a record");
        assert_eq!((z.len(), z[0].len(), z[0][0].len()), (2, 8, grid_hz.len()));
        let frf = errors_in_variables(&grid_hz, &z[0], &z[1]).expect("8 windows");
        for (line, u) in frf.iter().zip(&z[0][5]) {
            let truth = plant(line.frequency_hz);
            assert!((line.value / truth - 1.0).norm() < 1e-8, "{offset:?} {line:?}");
            assert!((u - actuator(line.frequency_hz)).norm() < 1e-8, "{offset:?}");
        }
    }
}

#[test]
fn without_its_column_cogging_spoils_the_lines() {
    let multisine = excitation(Offset::Zero);
    let found = strokes(&multisine);
    let [reference, current, angle] = &found.channels;
    let channels = [Channel { name: "current", samples: current }, Channel { name: "angle", samples: angle }];
    let grid_hz = frequencies(&multisine);
    let z = transfer(&found.windows, &grid_hz, reference, &channels, &[]).expect("a record");
    let frf = errors_in_variables(&grid_hz, &z[0], &z[1]).expect("8 windows");
    let worst = frf.iter().map(|l| (l.value / plant(l.frequency_hz) - 1.0).norm()).fold(0.0, f64::max);
    assert!(worst > 1e-3, "{worst}");
}

const WINDOWS: usize = 8;
const NOISE: [f64; 2] = [0.3, 0.4];

/// Noise-free windows of input and output, and the reference's lines.
fn clean(multisine: &Multisine) -> (Vec<[Vec<f64>; 2]>, Vec<usize>) {
    let u = answer(multisine, actuator);
    let y = answer(multisine, |f| actuator(f) * plant(f));
    let starts: Vec<usize> = (0..WINDOWS).map(|w| 537 * w).collect();
    let cut =
        |m: &Multisine, s: usize| -> Vec<f64> { (s..s + LENGTH).map(|i| m.at(i as f64 / RATE_HZ)).collect() };
    (starts.iter().map(|&s| [cut(&u, s), cut(&y, s)]).collect(), starts)
}

fn noisy_lines(
    prepared: &Prepared<'_>,
    clean: &[f64],
    noise: &mut Noise,
    sd: f64,
    turns: &[C64],
) -> Vec<C64> {
    let samples: Vec<f64> = clean.iter().map(|v| v + sd * noise.normal()).collect();
    let lines = prepared.amplitudes(Channel { name: "noisy", samples: &samples }, 0).expect("a window");
    lines.iter().zip(turns).map(|(x, t)| x * t).collect()
}

#[test]
fn the_scatter_of_eight_windows_is_the_cramer_rao_bound_and_its_circles_cover() {
    let multisine = excitation(Offset::Half);
    let grid_hz = frequencies(&multisine);
    let projection = Projection::new(RATE_HZ, LENGTH, &grid_hz).expect("on the grid");
    let prepared = projection.prepare(&[]).expect("offset and slope");
    let (windows, starts) = clean(&multisine);
    let runs = 100;
    let mut inside = 0;
    let mut sums = vec![(C64::new(0.0, 0.0), 0.0); grid_hz.len()];
    for seed in 0..runs {
        let mut noise = Noise::new(seed);
        let mut u = vec![];
        let mut y = vec![];
        for (window, start) in windows.iter().zip(&starts) {
            let begin_s = *start as f64 / RATE_HZ;
            let turns: Vec<C64> = grid_hz.iter().map(|f| C64::from_polar(1.0, -TAU * f * begin_s)).collect();
            u.push(noisy_lines(&prepared, &window[0], &mut noise, NOISE[0], &turns));
            y.push(noisy_lines(&prepared, &window[1], &mut noise, NOISE[1], &turns));
        }
        for (line, sum) in errors_in_variables(&grid_hz, &u, &y).expect("8 windows").iter().zip(&mut sums) {
            let error = line.value - plant(line.frequency_hz);
            inside += usize::from(error.norm() <= line.circle_radius(0.95));
            *sum = (sum.0 + error, sum.1 + error.norm_sqr());
        }
    }
    let n = runs as f64;
    let mut ratios: Vec<[f64; 2]> = vec![];
    for ((sum, square), f) in sums.into_iter().zip(&grid_hz) {
        let g = plant(*f).norm_sqr();
        let u = actuator(*f).norm_sqr();
        let bound = 4.0 / LENGTH as f64 * (NOISE[1].powi(2) + g * NOISE[0].powi(2)) / (u * WINDOWS as f64);
        ratios.push([square / n / bound, (sum / n).norm() / bound.sqrt()]);
    }
    let median = |k: usize| {
        let mut all: Vec<f64> = ratios.iter().map(|r| r[k]).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    assert!((0.92..1.08).contains(&median(0)), "{}", median(0));
    assert!(median(1) < 0.15, "{}", median(1));
    let covered = inside as f64 / (n * grid_hz.len() as f64);
    assert!((0.935..0.965).contains(&covered), "{covered}");
}

#[test]
fn the_variance_is_that_of_the_textbook_and_coherence_is_free_of_bias() {
    let mut noise = Noise::new(9);
    let mut draw = |sd: f64| C64::new(sd * noise.normal(), sd * noise.normal());
    let mut coherence = 0.0;
    let runs = 2000;
    for run in 0..runs {
        let mut u = vec![];
        let mut y = vec![];
        for _ in 0..5 {
            let common = draw(0.05);
            u.push(vec![C64::new(1.0, 0.0) + common + draw(0.02)]);
            y.push(vec![C64::new(0.0, 2.0) + common * C64::new(0.0, 2.0) + draw(0.5)]);
        }
        let line = errors_in_variables(&[1.0], &u, &y).expect("5 windows")[0];
        coherence += line.coherence.expect("a coherence");
        if run > 0 {
            continue;
        }
        let mean = |v: &[Vec<C64>]| v.iter().map(|w| w[0]).sum::<C64>() / 5.0;
        let mu = mean(&u);
        let my = mean(&y);
        let of_mean = |f: &dyn Fn(usize) -> C64| (0..5).map(f).sum::<C64>() / 20.0;
        let su = of_mean(&|w| C64::from((u[w][0] - mu).norm_sqr())).re;
        let sy = of_mean(&|w| C64::from((y[w][0] - my).norm_sqr())).re;
        let cross = of_mean(&|w| (y[w][0] - my) * (u[w][0] - mu).conj());
        let bracket = sy / my.norm_sqr() + su / mu.norm_sqr() - 2.0 * (cross / (my * mu.conj())).re;
        let expected = (my / mu).norm_sqr() * bracket;
        assert!((line.variance / expected - 1.0).abs() < 1e-10);
        assert_eq!(line.dof, 4.0);
    }
    // Output 4 + 4·2·0.02² of power that U does not explain + 2·0.5² of noise.
    let noise_power = 0.5 + 4.0 * 2.0 * 0.0004;
    let truth = 4.0 / (4.0 + noise_power);
    assert!((coherence / f64::from(runs) - truth).abs() < 0.01, "{coherence} {truth}");
    assert!((snr_db(truth) - 10.0 * (4.0 / noise_power).log10()).abs() < 1e-9);
}

#[test]
fn a_plant_that_starts_from_rest_shows_its_transient_in_the_first_window_only() {
    let multisine = excitation(Offset::Half);
    let grid_hz = frequencies(&multisine);
    let input: Vec<f64> = (0..8 * LENGTH).map(|i| multisine.at(i as f64 / RATE_HZ)).collect();
    let mode = Mode { natural_hz: 15.0, zeta: 0.02 };
    let clean = mode.run(&input, RATE_HZ);
    let mut alarms = 0;
    let mut mean = 0.0;
    for seed in 0..100 {
        let mut noise = Noise::new(seed);
        let output: Vec<f64> = clean.iter().map(|v| v + 0.05 * noise.normal()).collect();
        let windows = |from: usize| Windows {
            sample_rate_hz: RATE_HZ,
            length: LENGTH,
            starts: (from..8).map(|k| k * LENGTH).collect(),
        };
        let test = |from: usize| {
            let channel = [Channel { name: "output", samples: &output }];
            let lines = spectra(&windows(from), &grid_hz, &channel, &[]).expect("a record");
            transient(&lines[0]).expect("windows")
        };
        let first = test(0);
        assert!(!first.is_settled() && first.difference_ratio > 0.01, "{first:?}");
        let third = test(2);
        alarms += usize::from(!third.is_settled());
        mean += third.probability / 100.0;
    }
    assert!(alarms <= 5, "{alarms} alarms of 100 at 1 %");
    assert!((0.4..0.6).contains(&mean), "{mean}");
}
