//! Noise and distortion told apart.

use super::plant::Noise;
use crate::excitation::{Grid, Kind, Multisine, Offset, Phases, Selection, Spacing};
use crate::frf::C64;
use crate::periodic::{Channel, LineKind, Projection, Realisation, fast, nonlinear_rms, robust};

const LENGTH: usize = 512;
const RATE_HZ: f64 = 512.0;
const PERIODS: usize = 4;

/// Windows × lines.
type Lines = Vec<Vec<C64>>;

fn grid(kind: Kind, noise: &mut Noise) -> Grid {
    let selection = Selection { band_hz: 2.0..=60.0, kind, spacing: Spacing::Every, forbidden_hz: vec![] };
    Grid::new(1.0, Offset::Zero, RATE_HZ, &selection, &mut || noise.uniform()).expect("a sound grid")
}

/// Input and output at given lines, for y = u + c2·u² + c3·u³ and noise on y, with an input of rms 1.
fn measured(grid: &Grid, all_hz: &[f64], noise: &mut Noise, [c2, c3]: [f64; 2], sd: f64) -> [Lines; 2] {
    let phases = Phases::Random(&mut || noise.uniform());
    let level = (2.0 / grid.orders.len() as f64).sqrt();
    let multisine = Multisine::new(grid, &|_| level, phases).expect("flat");
    let input: Vec<f64> = (0..LENGTH).map(|i| multisine.at(i as f64 / RATE_HZ)).collect();
    let projection = Projection::new(RATE_HZ, LENGTH, all_hz).expect("on the grid");
    let prepared = projection.prepare(&[]).expect("offset and slope");
    let lines =
        |samples: &[f64]| prepared.amplitudes(Channel { name: "record", samples }, 0).expect("a window");
    let u = lines(&input);
    let output = (0..PERIODS)
        .map(|_| {
            let y: Vec<f64> =
                input.iter().map(|u| u + c2 * u * u + c3 * u.powi(3) + sd * noise.normal()).collect();
            lines(&y)
        })
        .collect();
    [vec![u; PERIODS], output]
}

/// rms over the lines of noise and distortion per realisation, and the part of lines flagged.
fn separated(seed: u64, cubic: f64, sd: f64) -> [f64; 3] {
    let mut noise = Noise::new(seed);
    let grid = grid(Kind::Full, &mut noise);
    let hz = grid.frequencies_hz();
    let all: Vec<[Lines; 2]> = (0..7).map(|_| measured(&grid, &hz, &mut noise, [0.0, cubic], sd)).collect();
    let realisations: Vec<Realisation<'_>> = all.iter().map(|[u, y]| Realisation { u, y }).collect();
    let lines = robust(&hz, &realisations).expect("7 realisations");
    let n = lines.len() as f64;
    let rms = |of: &dyn Fn(usize) -> f64| ((0..lines.len()).map(of).sum::<f64>() / n).sqrt();
    let flagged = lines.iter().filter(|l| l.is_distorted()).count() as f64 / n;
    [rms(&|l| lines[l].noise_variance * 7.0), rms(&|l| lines[l].nonlinear_variance), flagged]
}

/// Scatter of noise-free realisations: what the cubic makes, by brute force.
fn distortion(cubic: f64) -> f64 {
    let mut noise = Noise::new(77);
    let grid = grid(Kind::Full, &mut noise);
    let hz = grid.frequencies_hz();
    let responses: Vec<Vec<C64>> = (0..200)
        .map(|_| {
            let [u, y] = measured(&grid, &hz, &mut noise, [0.0, cubic], 0.0);
            y[0].iter().zip(&u[0]).map(|(y, u)| y / u).collect()
        })
        .collect();
    let mut sum = 0.0;
    for l in 0..hz.len() {
        let mean = responses.iter().map(|r| r[l]).sum::<C64>() / 200.0;
        sum += responses.iter().map(|r| (r[l] - mean).norm_sqr()).sum::<f64>() / 199.0;
    }
    (sum / hz.len() as f64).sqrt()
}

#[test]
fn seven_realisations_of_four_periods_tell_a_cubic_from_noise() {
    let cubic = 0.03;
    let sd = 0.2;
    let truth = distortion(cubic);
    // Variance of a line of white noise, 4σ²/N, over |U|² = 2/lines, for the mean of four periods.
    let line_noise = (4.0 * sd * sd / LENGTH as f64 / PERIODS as f64 * 59.0 / 2.0).sqrt();
    for seed in 0..5 {
        let [noise, nonlinear, flagged] = separated(seed, cubic, sd);
        assert!((noise / line_noise - 1.0).abs() < 0.10, "{noise} {line_noise}");
        assert!((nonlinear / truth - 1.0).abs() < 0.20, "{nonlinear} {truth}");
        assert!(flagged > 0.1, "{flagged}: distortion is about as large as noise; false alarms are 0.01");
    }
}

#[test]
fn a_linear_plant_is_not_called_distorted() {
    let flagged: f64 = (0..10).map(|seed| separated(100 + seed, 0.0, 0.2)[2]).sum::<f64>() / 10.0;
    assert!(flagged < 0.05, "{flagged}");
}

/// Grid with all its lines, and the fast method's findings for a plant.
fn fast_of(seed: u64, coefficients: [f64; 2], sd: f64) -> (Grid, crate::periodic::Distortion) {
    let mut noise = Noise::new(seed);
    let grid = grid(Kind::OddRandom, &mut noise);
    let mut lines: Vec<(f64, LineKind)> = vec![];
    let kinds = [
        (&grid.orders, LineKind::Excited),
        (&grid.odd_detection, LineKind::Odd),
        (&grid.even_detection, LineKind::Even),
    ];
    for (orders, kind) in kinds {
        lines.extend(orders.iter().map(|&m| (grid.frequency_hz(m), kind)));
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    let hz: Vec<f64> = lines.iter().map(|l| l.0).collect();
    let [u, y] = measured(&grid, &hz, &mut noise, coefficients, sd);
    let found = fast(&lines, &u, &y).expect("one realisation");
    (grid, found)
}

/// Expected power of even lines for c2 = 1: each pair of lines meets at its sum and difference with amplitude A².
fn even_power(grid: &Grid) -> f64 {
    let square = 2.0 / grid.orders.len() as f64;
    let mut total = 0.0;
    for &h in &grid.even_detection {
        for (i, &a) in grid.orders.iter().enumerate() {
            for &b in &grid.orders[i..] {
                let weight = if a == b { 0.25 } else { 1.0 };
                total += weight * square * square * f64::from(u8::from(a + b == h) + u8::from(b - a == h));
            }
        }
    }
    total / grid.even_detection.len() as f64
}

#[test]
fn a_square_shows_on_even_lines_only_and_with_its_size() {
    let (grid, found) = fast_of(1, [0.02, 0.0], 0.01);
    let linear = 2.0 / grid.orders.len() as f64;
    let expected = 10.0 * (0.0004 * even_power(&grid) / linear).log10();
    let even_db = found.even_db.expect("even lines");
    assert!((even_db - expected).abs() < 1.5, "{even_db} {expected}");
    assert!(found.odd_db.expect("odd lines") < even_db - 20.0, "{found:?}");
    let flagged = |kind| {
        let own: Vec<_> = found.lines.iter().filter(|l| l.kind == kind).collect();
        own.iter().filter(|l| l.is_distorted()).count() as f64 / own.len() as f64
    };
    assert!(flagged(LineKind::Even) > 0.8 && flagged(LineKind::Odd) < 0.3);
}

#[test]
fn a_cube_shows_on_odd_lines_only_and_with_its_size() {
    let mut odd = 0.0;
    for seed in 0..40 {
        let (_, found) = fast_of(seed, [0.0, 0.02], 0.002);
        let odd_db = found.odd_db.expect("odd lines");
        assert!(found.even_db.expect("even lines") < odd_db - 10.0, "{found:?}");
        odd += 10_f64.powf(0.1 * odd_db) / 40.0;
    }
    // Gaussian input: 6·c² of distortion, two thirds of it in band, on 30 odd lines, beside (1 + 3c)² on 22: −29.7 dB.
    let odd_db = 10.0 * odd.log10();
    assert!((odd_db + 29.7).abs() < 1.5, "{odd_db}");
}

/// A third of the noise of a realisation, distortion is still told in rms over 59 lines and 12 runs.
#[test]
fn distortion_below_the_noise_is_not_inflated_by_lines_where_the_noise_won() {
    let cubic = 0.03;
    let sd = 0.7;
    let truth = distortion(cubic);
    let mut mean = 0.0;
    let mut cut = 0.0;
    for seed in 0..12 {
        let mut noise = Noise::new(900 + seed);
        let grid = grid(Kind::Full, &mut noise);
        let hz = grid.frequencies_hz();
        let all: Vec<[Lines; 2]> =
            (0..7).map(|_| measured(&grid, &hz, &mut noise, [0.0, cubic], sd)).collect();
        let realisations: Vec<Realisation<'_>> = all.iter().map(|[u, y]| Realisation { u, y }).collect();
        let lines = robust(&hz, &realisations).expect("7 realisations");
        mean += nonlinear_rms(&lines).expect("lines").powi(2) / 12.0;
        cut += lines.iter().map(|l| l.nonlinear_variance).sum::<f64>() / (12 * lines.len()) as f64;
    }
    assert!((mean.sqrt() / truth - 1.0).abs() < 0.2, "{} of {truth}", mean.sqrt());
    assert!(cut.sqrt() > 1.15 * truth, "cut off line by line {} of {truth}", cut.sqrt());
    assert_eq!(nonlinear_rms(&[]), None);
}
