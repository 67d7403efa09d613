//! Margins of a servo in closed form.

use std::f64::consts::TAU;

use analysis::frf::{C64, Line};

use super::keys;
use crate::case::Case;
use crate::kinds::mirror::fsm_response::keys::{DelayKeys, Keys};
use crate::kinds::mirror::fsm_response::response::{loop_margins, loop_plots};
use crate::kinds::mirror::fsm_response::spectra::{LineQuality, MirrorLine};

/// P + I/s + I²/s² behind a lag and a delay.
fn servo(hz: f64) -> C64 {
    let s = C64::new(0.0, TAU * hz);
    let law = 0.08 + 500.0 / s + 1e5 / (s * s);
    law * (-s * 300e-6).exp() / (1.0 + s / (TAU * 350.0))
}

/// The response of that servo with a relative error of a line, drawn from its index, and a delay that nobody took off.
fn closed(error: f64, late_s: f64) -> Vec<MirrorLine> {
    let line = |k: u32| {
        let hz = 4.0 * 1.03_f64.powi(k as i32);
        let open = servo(hz);
        let turn = C64::from_polar(1.0, 2.4 * f64::from(k * k)) * error + 1.0;
        let late = C64::from_polar(1.0, -TAU * hz * late_s);
        let value = open / (1.0 + open) * turn * late;
        let variance = (error * value.norm()).powi(2);
        MirrorLine {
            line: Line { variance, dof: 9.0, ..Line::exact(hz, value) },
            quality: LineQuality::Counts,
        }
    };
    (0..190).map(line).collect()
}

fn case() -> Case {
    Case { point: "az 1 V analog".to_owned(), ..Case::default() }
}

/// 0 dB, −180° and the least |1 + L| on a fine grid.
fn truth() -> [f64; 4] {
    let grid_hz = (0..200_000).map(|k| 20.0 * 1.000_02_f64.powi(k));
    let grid: Vec<(f64, C64)> = grid_hz.map(|hz| (hz, servo(hz))).collect();
    let (hz, open) = *grid.iter().find(|(_, l)| l.norm() < 1.0).expect("it falls");
    let crossed =
        grid.windows(2).find(|pair| pair[0].1.im < 0.0 && pair[1].1.im >= 0.0 && pair[0].1.re < 0.0);
    let turned = crossed.expect("it turns")[0].1;
    let least = grid.iter().map(|(_, l)| (1.0 + l).norm()).fold(f64::INFINITY, f64::min);
    [hz, -20.0 * turned.norm().log10(), (-open).arg(), least]
}

#[test]
fn margins_of_a_servo_come_out_of_its_closed_response_within_their_uncertainty() {
    let all = loop_margins(&keys(), &case(), &closed(1e-3, 0.0));
    for (m, expected) in all.iter().zip(truth()) {
        let value = m.value.unwrap_or_else(|| panic!("{}: {:?}", m.measurand, m.inconclusive));
        assert!((value - expected).abs() < 2.5 * m.u, "{}: {value} ± {} {expected}", m.measurand, m.u);
        assert!(m.u < 0.02 * expected, "{}: u {}", m.measurand, m.u);
    }
}

#[test]
fn what_the_channels_delay_is_off_by_stands_in_the_uncertainty() {
    let sharp = loop_margins(&keys(), &case(), &closed(1e-4, 0.0));
    let keys = Keys { delays: DelayKeys { u_s: 50e-6, ..keys().delays }, ..keys() };
    let late = loop_margins(&keys, &case(), &closed(1e-4, 50e-6));
    for (late, sharp) in late.iter().zip(&sharp) {
        let off = (late.value.expect("a value") - sharp.value.expect("a value")).abs();
        assert!(off > 3.0 * sharp.u, "{}: 50 us do not show", late.measurand);
        assert!(off < 2.0 * late.u, "{}: {off} of {}", late.measurand, late.u);
    }
}

#[test]
fn a_mirror_that_does_not_follow_has_no_margins() {
    let still = |l: &MirrorLine| MirrorLine { quality: LineQuality::Noise, ..*l };
    let lines: Vec<MirrorLine> = closed(1e-3, 0.0).iter().map(still).collect();
    for m in loop_margins(&keys(), &case(), &lines) {
        assert_eq!(m.value, None);
        assert!(m.inconclusive.as_deref().is_some_and(|reason| reason.contains("lines")), "{m:?}");
    }
    assert!(loop_plots(&case(), &lines).is_empty());
}
