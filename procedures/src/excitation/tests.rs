use super::*;

fn sine(frequency_hz: f64, amplitude: f64) -> Sine {
    Sine { frequency_hz, amplitude, phase_rad: 0.3 * frequency_hz }
}

fn steady(signal: Signal) -> Excitation {
    Excitation { into: Injection::Torque, signal, fade_s: 0.0, every_ticks: 1 }
}

#[test]
fn nothing_exceeds_the_peak_and_the_peak_is_near() {
    let lines = (1..40).map(|k| sine(f64::from(k), 1.0)).collect();
    let signal = Signal::Multisine { period_s: 1.0, lines };
    let most = (0..100_000).map(|k| signal.at(f64::from(k) * 1e-5).abs()).fold(0.0, f64::max);
    assert!(most <= signal.peak() && signal.peak() < 1.05 * most, "{most} {}", signal.peak());
}

#[test]
fn a_multisine_repeats_after_its_period() {
    let signal = Signal::Multisine { period_s: 2.0, lines: vec![sine(0.5, 1.0), sine(7.5, 0.3)] };
    for k in 0..50 {
        let t = 0.04 * f64::from(k);
        assert!((signal.at(t) - signal.at(t + 2.0)).abs() < 1e-12);
    }
}

#[test]
fn a_logarithmic_sweep_passes_the_geometric_mean_in_the_middle() {
    let sweep =
        Signal::Sweep { from_hz: 1.0, to_hz: 100.0, duration_s: 50.0, logarithmic: true, amplitude: 1.0 };
    // Zero crossings around the middle are half a period of 10 Hz apart.
    let crossings: Vec<f64> = (0..4000)
        .map(|k| 24.8 + 1e-4 * f64::from(k))
        .filter(|t| sweep.at(*t) < 0.0 && sweep.at(t + 1e-4) >= 0.0)
        .collect();
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    assert!((period - 0.1).abs() < 2e-3, "{period}");
}

#[test]
fn steps_follow_each_other_and_then_there_is_silence() {
    let step = |frequency_hz, for_s| Step { frequency_hz, amplitude: 2.0, for_s };
    let stepped = Signal::Stepped { steps: vec![step(1.0, 1.0), step(5.0, 1.0)] };
    assert!((stepped.at(0.25) - 2.0).abs() < 1e-12 && (stepped.at(1.05) - 2.0).abs() < 1e-12);
    assert!(stepped.at(2.1).abs() < 1e-12);
}

#[test]
fn an_excitation_grows_from_zero() {
    let square = Signal::Square { amplitude: 1.0, period_s: 0.5 };
    let faded = Excitation { fade_s: 2.0, ..steady(square) };
    assert!((faded.at(1.3) - 0.65).abs() < 1e-12 && faded.at(-1.0) == 0.0 && faded.at(3.3) == 1.0);
}
