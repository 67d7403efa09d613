use analysis::estimate::Estimate;

use super::*;
use crate::measurement::Evidence;
use crate::quantity::QuantityKind as Q;

fn measured(name: &str, axis: &str, channels: &[&str], value: Option<f64>) -> Measurement {
    let estimate = value.map(|value| Estimate { value, u: 1e-6, dof: 30.0, n: 3000 });
    let channels = channels.iter().map(|&c| c.to_owned()).collect();
    let evidence = vec![Evidence { file: String::new(), channels, t0_s: 0.0, t1_s: 3.0 }];
    Measurement { evidence, ..Measurement::new(name, axis, Q::AngularVelocity, estimate, "test/1") }
}

const X: &str = "/imu rate_x_rad_per_s";
const Y: &str = "/imu rate_y_rad_per_s";

/// Offsets of two gyros at a self-check that allows a change of 1e-4 rad/s.
fn check(x: Option<f64>, y: Option<f64>) -> Vec<Measurement> {
    let gyro = |axis, channel, value| Measurement {
        conditions: vec![allowed(1e-4, Q::AngularVelocity)],
        ..measured("gyro-offset", axis, &[channel], value)
    };
    vec![gyro("x", X, x), gyro("y", Y, y)]
}

#[test]
fn a_change_inside_what_is_allowed_is_written_down_and_puts_nothing_in_doubt() {
    let mut later = check(Some(5.9e-5), Some(-4e-5));
    assert_eq!(compare(&check(Some(5e-5), Some(5e-5)), &mut later), []);
    let change = later[1].conditions[0].achieved.expect("compared");
    assert!((change - 9e-5).abs() < 1e-12);
}

#[test]
fn a_step_of_one_gyro_puts_in_doubt_what_rests_on_it_and_nothing_else() {
    let drifts = compare(&check(Some(5e-5), Some(5e-5)), &mut check(Some(2.5e-4), Some(5e-5)));
    assert_eq!(drifts.len(), 1);
    assert_eq!(drifts[0].channel, X);
    let mut between = vec![
        measured("gyro-scale-error", "az", &[X, Y, "/az position_counts"], Some(1e-4)),
        measured("friction-torque", "az", &["/az position_rad", "/az current_a"], Some(200.0)),
    ];
    assert!(put_in_doubt(&mut between, &drifts));
    assert_eq!(between[0].inconclusive, Some(drifts[0].reason.clone()));
    assert_eq!(between[0].value, Some(1e-4), "what was seen stays");
    assert_eq!(between[1].inconclusive, None);
    assert!(!put_in_doubt(&mut between[1..], &drifts));
}

#[test]
fn a_channel_that_one_check_reads_and_the_other_does_not_has_drifted_and_one_that_none_reads_is_not_compared()
{
    let mut silent = check(None, None);
    silent[0].inconclusive = Some("no new message came".to_owned());
    let drifts = compare(&check(Some(5e-5), None), &mut silent);
    assert_eq!(drifts.len(), 1);
    assert!(drifts[0].reason.ends_with("gyro-offset: no new message came"), "{drifts:?}");
    let drifts = compare(&silent, &mut check(Some(5e-5), None));
    assert_eq!(drifts.len(), 1);
    assert!(drifts[0].reason.contains("was not read by the self-check before"), "{drifts:?}");
    assert_eq!(compare(&[], &mut check(Some(1.0), Some(1.0))), []);
}

#[test]
fn what_is_told_from_a_drifted_channel_is_in_doubt_and_the_other_axis_is_not() {
    let drift = |channel: &str| [Drift { channel: channel.to_owned(), reason: "it drifted".to_owned() }];
    let doubted = |used: &str, drifted: &str| {
        put_in_doubt(&mut [measured("m", "az", &[used], Some(1.0))], &drift(drifted))
    };
    assert!(doubted("/az torque_nm", "/az current_a"));
    assert!(!doubted("/az torque_nm", "/el current_a"));
    assert!(!doubted("/az torque_command_nm", "/az current_a"), "what is sent is not what is read");
    assert!(doubted("/az position_counts", "/az position_rad"));
    assert!(doubted("/el velocity_feedback_rad_per_s", "/imu rate_x_rad_per_s"));
    assert!(!doubted("/el velocity_feedback_rad_per_s", "/imu acceleration_x_m_per_s2"));
}

#[test]
fn what_has_no_allowance_is_reported_only_and_an_earlier_reason_stays() {
    let mut free = check(Some(1.0), Some(1.0));
    free.iter_mut().for_each(|m| m.conditions.clear());
    assert_eq!(compare(&check(Some(0.0), Some(0.0)), &mut free), []);
    let mut done = vec![measured("angle-random-walk", "x", &[X], None)];
    done[0].inconclusive = Some("too short".to_owned());
    put_in_doubt(&mut done, &[Drift { channel: X.to_owned(), reason: "drifted".to_owned() }]);
    assert_eq!(done[0].inconclusive.as_deref(), Some("too short"));
}

#[test]
fn what_rests_on_a_torque_constant_was_told_from_the_current_of_its_axis_and_is_a_torque() {
    let torque = Measurement {
        kind: Q::Torque,
        ..measured("friction-torque", "az", &["/az position_rad", "/az current_a"], Some(267.0))
    };
    let angle = measured("position-noise", "az", &["/az position_rad"], Some(1e-6));
    assert!(rests_on_torque_constant(&torque, "az") && !rests_on_torque_constant(&torque, "el"));
    assert!(!rests_on_torque_constant(&angle, "az"));
    let shown = Measurement { kind: Q::Torque, ..measured("effort", "az", &["/az torque_nm"], Some(3.0)) };
    assert!(rests_on_torque_constant(&shown, "az"), "a drive's torque is its current times its constant");
}
