//! The closed velocity loop: what is read must be the loop that was put in, cogging's gap and row means or not.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use super::{
    C64, DELAY, INERTIA, KI, KP, MULTISINE, RATE_HZ, SLIDING, VISCOUS, axes, judge, of, open_loop, procedure,
};
use crate::diagnostic::SourceFile;
use crate::log::Window;
use crate::measurement::PointResult;
use crate::procedure::Procedure;

/// Truth within these, Hz and dB, at 60 s and a noise of 30 µrad/s.
const BANDWIDTH_HZ: f64 = 0.02;
const PEAK_DB: f64 = 0.03;

/// |commanded rate to rate of the shaft| in dB at the samples: the controller, the way out, the rigid body; the sensor in
/// the loop shows its mode, too, and comes late.
fn shaft_db(hz: f64) -> f64 {
    let z = C64::from_polar(1.0, TAU * hz / RATE_HZ);
    let decay = (-VISCOUS / INERTIA / RATE_HZ).exp();
    let rigid = (1.0 - decay) / VISCOUS / (z - decay) * z.powi(-(DELAY as i32));
    let controller = KP + KI / RATE_HZ * z / (z - 1.0);
    20.0 * (controller * rigid / (1.0 + open_loop(hz))).norm().log10()
}

/// |L/(1 + L)| in dB: what the sensor in the loop shows.
fn gyro_db(hz: f64) -> f64 {
    20.0 * (open_loop(hz) / (1.0 + open_loop(hz))).norm().log10()
}

/// First frequency below −3 dB, and the peak in dB with its frequency, on a grid of 1 mHz.
fn truth(db: fn(f64) -> f64) -> (f64, [f64; 2]) {
    let grid = || (1000..15_000).map(|k| 1e-3 * f64::from(k));
    let falls = grid().find(|hz| db(*hz) < -20.0 * 2_f64.sqrt().log10()).expect("it falls");
    let top = grid().max_by(|a, b| db(*a).total_cmp(&db(*b))).expect("it has a top");
    (falls, [db(top), top])
}

/// One record for all that is read of it as it is.
static PLAIN: LazyLock<PointResult> = LazyLock::new(|| judge(&procedure(MULTISINE, SLIDING), |_| {}, 1));

/// Bandwidth Hz and peak dB by both sensors, against the truth.
fn holds(result: &PointResult) {
    for (sensor, db) in [("", shaft_db as fn(f64) -> f64), ("-gyro", gyro_db)] {
        let (falls, [top, _]) = truth(db);
        for (name, expected, within) in [("bandwidth", falls, BANDWIDTH_HZ), ("peak", top, PEAK_DB)] {
            let m = of(result, &format!("closed-velocity-{name}{sensor}"));
            let value = m.value.unwrap_or_else(|| panic!("{name}{sensor}: {:?}", m.inconclusive));
            let said = format!("{name}{sensor}: {value} ± {}, truth {expected}", m.u);
            assert!((value - expected).abs() < within && (value - expected).abs() < 4.0 * m.u, "{said}");
            assert!(m.u < within, "{said}");
        }
    }
}

/// The peak, 3.755 dB at 2.76 Hz, lies below the lowest line that the first four orders of cogging leave, 3 Hz, where the gain
/// is 3.65 dB.
#[test]
fn closed_loop_of_a_linear_plant_is_the_one_that_was_put_in() {
    let (_, [top, at_hz]) = truth(shaft_db);
    let cogging_hz = 3.0 * 108.0 * 0.05 / TAU;
    assert!((at_hz - cogging_hz).abs() < 0.3 && top - shaft_db(3.0) > 0.1, "the peak lies in the gap");
    holds(&PLAIN);
}

/// A clock of the encoder that is late turns the phase and changes no gain.
#[test]
fn an_angle_that_comes_late_changes_nothing() {
    let late = |window: &mut Window| {
        let angle = &mut window.topics[0].columns[0];
        angle.rotate_right(6);
        let first = angle[6];
        angle[..6].fill(first);
    };
    holds(&judge(&procedure(MULTISINE, SLIDING), late, 1));
}

/// Both sensors show the same shaft: up to 5 Hz the mode in the gyro takes off what it takes off at 5 Hz.
#[test]
fn what_the_mode_shows_between_the_sensors_is_their_coaxiality() {
    let apart = of(&PLAIN, "sensor-coaxiality");
    let value = apart.value.unwrap_or_else(|| panic!("{:?}", apart.inconclusive));
    let expected = 10_f64.powf((gyro_db(5.0) - shaft_db(5.0)) / 20.0) - 1.0;
    assert!((value - expected).abs() < 3.0 * apart.u + 0.1 * expected, "{value} ± {}, {expected}", apart.u);
}

/// Under a torque the command answers the axis: its ratio to the angle is the position loop, turned round.
#[test]
fn under_a_torque_the_closed_loop_is_refused() {
    let text = include_str!("../../../../../fat/el-open.toml")
        .replace("\"plant\",", "\"plant\", \"velocity-position\",");
    let source = SourceFile { name: "t.toml".to_owned(), text };
    let said = Procedure::parse(source).expect_err("no closed loop from torque");
    assert!(said.iter().any(|d| d.message.contains("added to the command")), "{said:?}");
}

/// From rest the contact follows the command: its bandwidth is not the loop's.
#[test]
fn from_rest_the_closed_loop_has_no_numbers() {
    let excitation = "level = [\"4 V\"]\nfrom = \"0.5 Hz\"\nto = \"60 Hz\"\nduration = \"30 s\"";
    let result = judge(&procedure(excitation, super::REST), |_| {}, 1);
    for name in super::super::loops::CLOSED_NAMES {
        let m = of(&result, name);
        assert!(m.value.is_none() && m.inconclusive.as_deref().is_some_and(|r| r.starts_with("presliding")));
    }
    assert!(super::super::point::presliding_hz(axes().get("el").expect("elevation")) >= 7.0);
}
