use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::*;

const TURN: [f64; 2] = [-PI, PI];

fn line(order: f64, amplitude: f64, phase_rad: f64, u: f64) -> Line {
    let amplitude = Amplitude { amplitude, phase_rad, u, dof: 40.0 };
    Line { order_per_rev: order, order_u_per_rev: 0.0, amplitude }
}

fn peak(lines: &[Line]) -> Peak {
    Peak::new(lines, TURN, 0.0).expect("lines and a turn")
}

/// Largest magnitude on a grid of 10 000 points in a period of the highest order.
fn by_force(lines: &[Line], [from_rad, to_rad]: [f64; 2]) -> f64 {
    let highest = lines.iter().map(|l| l.order_per_rev).fold(0.0, f64::max);
    let count = (10_000.0 * highest * (to_rad - from_rad) / TAU).ceil() as usize;
    let at = |k: usize| from_rad + (to_rad - from_rad) * k as f64 / count as f64;
    (0..=count).map(|k| Sum(lines).at(at(k))[0].abs()).fold(0.0, f64::max)
}

/// These lines, each with noise of its own u in cosine and sine.
fn noisy(lines: &[Line], random: &mut ChaCha8Rng) -> Vec<Line> {
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
    let mut shaken = lines.to_vec();
    for line in &mut shaken {
        let radius = line.amplitude.u * (-2.0 * uniform().ln()).sqrt();
        let noise = Complex::from_polar(radius, TAU * uniform());
        line.amplitude = line.amplitude.less(noise);
    }
    shaken
}

/// Mean and standard deviation of the peaks of 2000 noisy copies, less the peak of the lines themselves.
fn scatter(lines: &[Line]) -> [f64; 2] {
    let truth = by_force(lines, [-PI / 100.0, PI / 100.0]).max(peak(lines).value);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let off: Vec<f64> = (0..2000).map(|_| peak(&noisy(lines, &mut random)).value - truth).collect();
    let mean = off.iter().sum::<f64>() / 2000.0;
    let square = off.iter().map(|o| (o - mean).powi(2)).sum::<f64>();
    [mean, (square / 1999.0).sqrt()]
}

#[test]
fn a_single_line_peaks_at_its_amplitude_and_is_as_uncertain_as_it() {
    let found = peak(&[line(144.0, 8.45, 0.7, 0.05)]);
    assert!((found.value - 8.45).abs() < 1e-9 && found.angle_rad.abs() <= PI, "{found:?}");
    assert!((found.spread.u - 0.05).abs() < 1e-12 && (found.spread.dof - 40.0).abs() < 1e-9);
    // Noise across the line lengthens it by u²/2a; a crest and a trough move by the same.
    assert!((found.excess - 0.5 * 0.05_f64.powi(2) / 8.45).abs() < 1e-6, "{found:?}");
}

#[test]
fn a_sum_peaks_where_a_search_point_by_point_finds_it() {
    for phase in [0.0, 0.4, 1.3, 2.2, 3.1, 4.0, 5.5] {
        let cogging = [line(144.0, 8.45, 1.0, 0.01), line(288.0, 0.845, phase, 0.01)];
        let ripple =
            [cogging[0], cogging[1], line(24.0, 3.0, 2.0 * phase, 0.01), line(7.0, 0.3, phase, 0.01)];
        let third = [cogging[0], line(431.7, 4.0, phase, 0.01)];
        for lines in [&cogging[..], &ripple[..], &third[..]] {
            let [found, truth] = [peak(lines).value, by_force(lines, TURN)];
            assert!((found - truth).abs() < 1e-5, "phase {phase}: {found}, point by point {truth}");
        }
    }
}

#[test]
fn a_line_and_its_half_of_the_same_sign_add_and_of_the_other_sign_do_not() {
    let sum = |phase| peak(&[line(100.0, 4.0, 0.0, 0.0), line(200.0, 2.0, phase, 0.0)]).value;
    assert!((sum(0.0) - 6.0).abs() < 1e-9 && (sum(PI) - 6.0).abs() < 1e-9);
    // sin x + sin 2x / 2 has its largest value, 3·√3/4, at 60°.
    assert!((sum(PI / 2.0) - 4.0 * 0.75 * 3.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn a_range_without_the_crest_gives_the_larger_end() {
    let lines = [line(10.0, 5.0, 0.0, 0.1)];
    let found = Peak::new(&lines, [0.02, 0.1], 0.0).expect("a range");
    assert!((found.value - 5.0 * 0.2_f64.cos()).abs() < 1e-12 && found.angle_rad == 0.02, "{found:?}");
}

#[test]
fn noise_scatters_a_peak_as_its_u_says_and_raises_it_by_no_more_than_its_excess() {
    let alone = [line(144.0, 8.45, 0.3, 0.2), line(288.0, 0.845, 0.3, 0.2)];
    let found = peak(&alone);
    let [raised, u] = scatter(&alone);
    assert!((u / found.spread.u - 1.0).abs() < 0.05, "{u}, {found:?}");
    assert!(raised < found.excess + 3.0 * u / 2000.0_f64.sqrt(), "{raised}, {found:?}");
    // A sine and its second are as high as they are deep: noise chooses.
    let even = [line(144.0, 8.45, -PI / 2.0, 0.2), line(288.0, 0.845, -PI / 2.0, 0.2)];
    let found = peak(&even);
    let [raised, u] = scatter(&even);
    assert!(u < 1.05 * found.spread.u, "{u}, {found:?}");
    assert!(raised > 0.05 && raised < found.excess + 3.0 * u / 2000.0_f64.sqrt(), "{raised}, {found:?}");
    assert!(found.excess < 2.0 * raised, "{raised}, {found:?}");
}

#[test]
fn an_order_that_is_no_whole_number_leaves_more_open_the_farther_the_peak_is_from_the_record() {
    let mut strange = line(31.3, 4.0, 0.8, 0.05);
    strange.order_u_per_rev = 0.02;
    // The range ends on the flank of the line.
    let u = |middle_rad: f64| Peak::new(&[strange], [0.02, 0.04], middle_rad).expect("a range").spread.u;
    assert!((u(0.04) - 0.05).abs() < 1e-12);
    assert!(u(3.0) > 4.0 * u(0.05), "{} and {}", u(3.0), u(0.05));
}

#[test]
fn without_lines_or_range_there_is_no_peak() {
    assert_eq!(Peak::new(&[], TURN, 0.0), None);
    for range in [[1.0, 1.0], [1.0, f64::NAN], [8.0, 9.0]] {
        assert_eq!(Peak::new(&[line(144.0, 8.45, 0.0, 0.1)], range, 0.0), None, "{range:?}");
    }
}
