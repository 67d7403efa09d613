//! The servo: margins, bandwidth, what it removes.

use super::*;

/// Crossover and phase margin from closed-loop responses, L = T/(1 − T): Hz, degrees.
fn margin(settings: &MirrorSettings, axis: usize, amplitude_v: f64) -> [f64; 2] {
    let open_loop = |hz: f64| {
        let t = response(settings, axis, hz, amplitude_v, Mirror::sensed_rad);
        divide(t, [1.0 - t[0], -t[1]])
    };
    // Periods of whole steps, around the crossover.
    let grid = [50.0, 62.5, 80.0, 100.0].map(|hz| (hz, open_loop(hz)));
    for pair in grid.windows(2) {
        let [(low_hz, low), (high_hz, high)] = [pair[0], pair[1]];
        if decibel(low) >= 0.0 && decibel(high) < 0.0 {
            let ratio = decibel(low) / (decibel(low) - decibel(high));
            let phase = |z: [f64; 2]| z[1].atan2(z[0]).to_degrees();
            return [
                low_hz * (high_hz / low_hz).powf(ratio),
                180.0 + phase(low) + ratio * (phase(high) - phase(low)),
            ];
        }
    }
    [f64::NAN; 2]
}

/// Phase margin of `(P + I/s + I²/s²)·ω0²·e^(−s·delay)/(s + ω0)²` at a frequency: the notch's zeros cancel the mode.
fn published_margin_deg(mode_hz: f64, delay_s: f64, hz: f64) -> f64 {
    let omega = TAU * hz;
    let law = (-500.0 / omega).atan2(0.08 - 1.0e5 / (omega * omega));
    180.0 + (law - 2.0 * (hz / mode_hz).atan() - omega * delay_s).to_degrees()
}

#[test]
fn the_published_gains_leave_44_to_47_degrees_and_half_a_millisecond_leaves_30_to_32() {
    for (axis, mode_hz) in [(0, 322.0), (1, 350.0)] {
        for (delay_s, least, most) in [(0.0, 44.0, 47.0), (0.5e-3, 30.0, 32.5)] {
            let settings = MirrorSettings { loop_delay_s: delay_s, ..linear() };
            let [hz, degrees] = margin(&settings, axis, 0.1);
            assert!((least..=most).contains(&degrees), "{axis}: {degrees} deg at {hz} Hz, {delay_s} s");
            let expected = published_margin_deg(mode_hz, delay_s, hz);
            assert!((degrees - expected).abs() < 0.5, "{axis}: {degrees} deg, published {expected}");
            assert!((hz - 79.5).abs() < 1.0, "{axis}: crossover at {hz} Hz");
        }
    }
}

#[test]
fn hysteresis_costs_phase_as_the_amplitude_grows_but_the_loop_stays_sound() {
    for axis in [0, 1] {
        let margins = [0.02, 0.5, 1.0].map(|volts| margin(&MirrorSettings::default(), axis, volts)[1]);
        assert!(margins[0] > margins[1] && margins[1] > margins[2], "{margins:?}");
        assert!(margins[2] > 35.0, "{margins:?}");
    }
}

#[test]
fn the_nominal_unit_attenuates_less_than_3_decibels_up_to_100_hertz_at_every_level() {
    for axis in [0, 1] {
        // 20 µrad, and the two levels of acceptance: 500 and 1000 µrad peak to peak.
        for amplitude_v in [0.02, 0.5, 1.0] {
            for hz in [20.0, 50.0, 80.0, 100.0] {
                let gain =
                    decibel(response(&MirrorSettings::default(), axis, hz, amplitude_v, Mirror::sensed_rad));
                // A phase margin of 39° alone makes a peak of 1/(2·sin(39°/2)) = 3.5 dB.
                assert!((-3.0..4.0).contains(&gain), "{axis}: {gain} dB at {hz} Hz, {amplitude_v} V");
            }
        }
    }
}

#[test]
fn open_loop_the_axis_is_the_published_second_order() {
    let settings = MirrorSettings { strain_gauge_loop_switch: 0.0, ..linear() };
    for (axis, mode_hz) in [(0, 322.0), (1, 350.0)] {
        for hz in [50.0, 200.0, mode_hz, 500.0] {
            let ratio = hz / mode_hz;
            let expected = divide([1.0, 0.0], [1.0 - ratio * ratio, 2.0 * 0.36 * ratio]);
            // The amplifier's lag and the hold of the command come on top.
            let lag = hz / 20_000.0;
            let expected = divide(expected, [1.0, lag]);
            let hold = -std::f64::consts::PI * hz * STEP_S;
            let found = response(&settings, axis, hz, 0.1, Mirror::angle_rad);
            let error = divide(found, expected);
            let degrees = (error[1].atan2(error[0]) - hold).to_degrees();
            assert!(
                decibel(error).abs() < 0.1 && degrees.abs() < 0.5,
                "{hz} Hz: {} dB {degrees} deg",
                decibel(error)
            );
        }
    }
}

#[test]
fn a_step_settles_on_the_command_and_never_saturates_for_good() {
    let mut mirror = mirror(&MirrorSettings::default());
    for (from, volts) in [(0, 1.0), (1, -2.0), (2, 9.0), (3, 0.5)] {
        mirror.command_analog_v(0, volts);
        (0..4000).for_each(|k| mirror.step(4000 * from + k));
        let expected = (volts * 500e-6_f64).clamp(-1.05e-3, 1.05e-3);
        let found = mirror.angle_rad()[0];
        assert!((found - expected).abs() < 2e-6, "{found} after {volts} V");
    }
    assert!(mirror.angle_rad()[1].abs() < 2e-6, "the other axis is held against the coupling");
}

#[test]
fn the_amplifier_cannot_charge_the_stacks_faster_than_its_current() {
    let mut mirror = mirror(&broken_loop());
    mirror.command_analog_v(0, 2.0);
    let mut before = 0.0;
    for k in 0..40 {
        mirror.step(k);
        let ampere = (mirror.drive_v()[0] - before) / STEP_S * 30.2e-6;
        before = mirror.drive_v()[0];
        assert!(ampere <= 2.4 * (1.0 + 1e-9), "{ampere} A at step {k}");
    }
    assert!((before - 1000.0 / 14.0).abs() < 1e-6, "{before} V at last");
}
