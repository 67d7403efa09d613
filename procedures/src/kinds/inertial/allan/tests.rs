use super::*;
use crate::axis::AxisLimits;
use crate::kinds::inertial::tests::imu_rows;
use crate::kinds::inertial::{body_rates, earth_rates};
use crate::log::{EndedBy, SegmentSpan};
use crate::measurement::{Bound, Measurement};
use crate::reason::Reason;
use crate::stimulus::Stimulus;
use crate::synthetic::{self, Random};

const DEG_PER_H: f64 = std::f64::consts::PI / 180.0 / 3600.0;
/// 0.01 deg/√h.
const WALK_RAD: f64 = 0.01 * std::f64::consts::PI / 180.0 / 60.0;
const PERIOD_S: f64 = 0.01;
const COUNT_RAD: f64 = std::f64::consts::TAU / (1 << 26) as f64;

fn keys() -> Keys {
    Keys {
        duration_s: 120.0,
        azimuth_rad: 0.2,
        elevation_rad: 0.7,
        latitude_rad: Some(0.7),
        heading_rad: 0.1,
        creep: vec!["az".to_owned(), "el".to_owned()],
    }
}

pub(in crate::kinds) fn axes() -> Axes {
    let limits = serde_json::json!({
        "travel_rad": [-1.0, 1.5],
        "soft_limits_rad": [-0.9, 1.4],
        "max_velocity_rad_per_s": 1.0,
        "max_acceleration_rad_per_s2": 1.0,
        "max_jerk_rad_per_s3": 10.0,
        "max_torque_nm": 1000.0,
        "torque_constant_nm_per_a": 60.0,
        "torque_constant_u_ratio": 0.005,
        "inertia_kg_m2": 1000.0,
        "torque_quantum_nm": 0.1,
        "encoder_quantum_rad": COUNT_RAD,
        "expected_static_friction_nm": 100.0,
        "loop_rate_hz": 4000.0,
        "cogging_orders_per_rev": 144.0,
    });
    let limits: AxisLimits = serde_json::from_value(limits).expect("limits of an axis");
    Axes::stacked([("az".to_owned(), limits.clone()), ("el".to_owned(), limits)])
}

/// A log of a director at rest whose axes tremble by what their loops make of noise.
struct Still {
    walk: f64,
    /// Share of each new value of the noise that a low-pass of first order lets through; 1 without one.
    passed: f64,
    /// Added to each rate: index of the gyro, time.
    added: fn(usize, f64) -> f64,
    /// What becomes of each reading.
    read: fn(f64) -> f64,
    /// Seconds that are missing in the middle.
    gap_s: f64,
    lasts_s: f64,
}

const SOUND: Still =
    Still { walk: WALK_RAD, passed: 1.0, added: |_, _| 0.0, read: |rate| rate, gap_s: 0.0, lasts_s: 120.0 };

impl Still {
    fn window(&self, case: &Case) -> Window {
        let n = (self.lasts_s / PERIOD_S) as usize;
        let mut random = Random::new(5);
        let time: Vec<f64> =
            (0..n).map(|k| k as f64 * PERIOD_S + if 5 * k > 4 * n { self.gap_s } else { 0.0 }).collect();
        // Trembling of 1 µrad at 3 Hz: 19 µrad/s, as much as the noise of 40 ms.
        let angle = |at: f64, t: f64| at + 1e-6 * (std::f64::consts::TAU * 3.0 * t).sin();
        let az: Vec<f64> = time.iter().map(|t| angle(0.2, *t)).collect();
        let el: Vec<f64> = time.iter().map(|t| angle(0.7, *t + 0.1)).collect();
        let mut rates: [Vec<f64>; 3] = Default::default();
        let mut noises = [0.0; 3];
        for k in 0..n {
            let rate = |angle: &[f64]| if k > 0 { (angle[k] - angle[k - 1]) / PERIOD_S } else { 0.0 };
            let moved = body_rates(rate(&az), rate(&el), 0.7);
            let earth = earth_rates(0.7, 0.1, 0.2, 0.7);
            for g in 0..3 {
                let white = self.walk / PERIOD_S.sqrt() * random.normal();
                noises[g] += self.passed * (white - noises[g]);
                let rate = moved[g] + earth[g] + DEG_PER_H * (g as f64 + 1.0) + noises[g];
                rates[g].push((self.read)(rate + (self.added)(g, time[k])));
            }
        }
        let imu = imu_rows(&time, rates, (0..n).map(|k| (k * 40 % 128) as f64).collect());
        // Elevation's encoder counts against the axis, and begins again half-way.
        let counts = |angle: &[f64], sign: f64| -> Vec<f64> {
            angle
                .iter()
                .map(|a| (sign * (a - angle[0]) / COUNT_RAD).round().rem_euclid(67_108_864.0))
                .collect()
        };
        let axis = |name, angle: Vec<f64>, sign| {
            let counts = counts(&angle, sign);
            synthetic::rows(name, &time, vec![("position_rad", angle), ("position_counts", counts)])
        };
        Window::completed(
            vec![imu, axis("/az", az, 1.0), axis("/el", el, -1.0)],
            spans(case, time[n - 1] + PERIOD_S),
        )
    }
}

/// The last segment of a case over the whole record.
fn spans(case: &Case, end_s: f64) -> Vec<SegmentSpan> {
    let ended_by = EndedBy::Completed;
    vec![SegmentSpan {
        segment: case.segments.len() - 1,
        start_s: 0.0,
        end_s,
        start_position_rad: 0.0,
        ended_by,
    }]
}

fn cases() -> Vec<Case> {
    keys().plan("az", &axes()).expect("the axes allow it")
}

fn of<'a>(result: &'a PointResult, measurand: &str, axis: &str) -> &'a Measurement {
    let found = result.measurements.iter().find(|m| m.measurand == measurand && m.axis == axis);
    found.expect("measured, or said why not")
}

fn analysed(still: &Still) -> PointResult {
    let case = &cases()[0];
    keys().analyse(case, &still.window(case), &axes())
}

#[test]
fn the_walk_of_each_gyro_is_found_behind_trembling_axes_and_a_turning_earth() {
    let result = analysed(&SOUND);
    assert_eq!(result.inconclusive, None);
    for (k, gyro) in ["x", "y", "z"].into_iter().enumerate() {
        let walk = of(&result, WALK, gyro);
        let value = walk.value.expect("a walk");
        assert!((value / WALK_RAD - 1.0).abs() < 0.03 && (value - WALK_RAD).abs() < 3.0 * walk.u, "{walk:?}");
        // Half of the interval is nothing less than 1.96 u, whatever u holds.
        let [low, high] = interval_deg_per_sqrt_h(walk);
        let half = 0.5 * (high - low) * DEG_PER_SQRT_H;
        assert!(half > 1.9 * walk.u, "{low} to {high}: {walk:?}");
        let bias = of(&result, BIAS, gyro);
        let value = bias.value.expect("a bias");
        assert!((value - DEG_PER_H * (k as f64 + 1.0)).abs() < 3.0 * bias.u, "{bias:?}");
        let floor = of(&result, INSTABILITY, gyro);
        let reason = floor.inconclusive.as_deref().unwrap_or_default();
        assert!(floor.value.is_none() && reason.contains("at most"), "there is none: {floor:?}");
    }
    assert_eq!(result.plots.len(), 3);
}

/// 1 deg/sqrt(h) in rad/sqrt(s).
const DEG_PER_SQRT_H: f64 = std::f64::consts::PI / 180.0 / 60.0;

/// The interval that a flag gives: "95 % from LOW UNIT to HIGH UNIT".
fn interval_deg_per_sqrt_h(walk: &Measurement) -> [f64; 2] {
    let flag = walk.flags.iter().find(|flag| flag.starts_with("95 % from ")).expect("an interval");
    let numbers: Vec<f64> = flag.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert!(flag.contains("deg/sqrt(h)") && numbers.len() == 3, "{flag}");
    [numbers[1], numbers[2]]
}

#[test]
fn three_times_the_noise_is_three_times_the_walk() {
    let result = analysed(&Still { walk: 3.0 * WALK_RAD, ..SOUND });
    let value = of(&result, WALK, "z").value.expect("a walk");
    assert!((value / WALK_RAD - 3.0).abs() < 0.09, "{value}");
}

/// A low-pass of 32 Hz takes 13 % of the scatter of single samples; averages over tenths of a second hold the walk that is there.
#[test]
fn the_low_pass_of_a_unit_makes_its_walk_no_smaller() {
    let result = analysed(&Still { passed: 1.0 - (-2.0_f64).exp(), lasts_s: 900.0, ..SOUND });
    for gyro in ["x", "y", "z"] {
        let walk = of(&result, WALK, gyro);
        let value = walk.value.expect("a walk");
        assert!((value / WALK_RAD - 1.0).abs() < 0.04, "{value:e}, true {WALK_RAD:e}: {walk:?}");
    }
}

/// Play of an encoder hides what the loop moves: drawn unit 2032 in service read 73 % of its walk behind 4.8 urad of it.
#[test]
fn motion_that_no_encoder_shows_costs_averages_and_not_the_walk() {
    let hidden = |_: usize, t: f64| 2e-5 * (std::f64::consts::TAU * 4.0 * t).sin();
    let result = analysed(&Still { added: hidden, lasts_s: 900.0, ..SOUND });
    let quiet = analysed(&Still { lasts_s: 900.0, ..SOUND });
    for gyro in ["x", "y", "z"] {
        let walk = of(&result, WALK, gyro);
        let value = walk.value.unwrap_or_else(|| panic!("{walk:?}"));
        assert!((value - WALK_RAD).abs() < 2.0 * walk.u && walk.u < 0.15 * value, "{walk:?}");
        let left_out = |m: &Measurement| m.flags.iter().any(|flag| flag.ends_with("and are left out"));
        let whole = of(&quiet, WALK, gyro);
        assert!(left_out(walk) && !left_out(whole) && whole.u < walk.u, "{whole:?}");
    }
}

/// One row in 12 000 that is off by 30 times the noise of a row, 29 µrad/s.
#[test]
fn a_single_wrong_sample_is_the_peak_and_leaves_the_walk() {
    let spiked = Still { added: |_, t| if (t - 50.0).abs() < 1e-6 { 872e-6 } else { 0.0 }, ..SOUND };
    for (still, least, most) in [(&SOUND, 3.0, 5.5), (&spiked, 20.0, 32.0)] {
        let result = analysed(still);
        let peak = of(&result, PEAK, "y").value.expect("a peak");
        assert!((least..most).contains(&peak), "{peak}");
        let walk = of(&result, WALK, "y").value.expect("a walk");
        assert!((walk / WALK_RAD - 1.0).abs() < 0.1, "{walk}");
    }
}

/// A row is the mean of 40 messages: it moves by a fortieth of their step.
#[test]
fn the_step_of_a_gyro_is_that_of_its_messages_however_small_beside_their_noise() {
    for (step, read) in [
        (1e-6, (|rate| (rate / 25e-9).round() * 25e-9) as fn(f64) -> f64),
        (1e-3, |rate| (rate / 25e-6).round() * 25e-6),
    ] {
        let result = analysed(&Still { read, ..SOUND });
        for gyro in ["x", "y", "z"] {
            let found = of(&result, STEP, gyro);
            let value = found.value.expect("a step");
            assert!((value / step - 1.0).abs() < 1e-6 && found.bound.is_none(), "{found:?}");
        }
    }
}

#[test]
fn a_step_too_small_to_see_is_a_bound_and_a_gyro_that_is_stuck_has_none() {
    let result = analysed(&SOUND);
    let found = of(&result, STEP, "z");
    let most = found.value.expect("a bound");
    assert!(most < 10e-6 && matches!(found.bound, Some(Bound::AtMost(_))), "{found:?}");
    let stuck = analysed(&Still { read: |_| 1e-5, ..SOUND });
    let reason = of(&stuck, STEP, "x").inconclusive.clone().unwrap_or_default();
    assert!(reason.contains("one value for half of the record"), "{reason}");
}

#[test]
fn drift_quanta_and_gaps_are_flagged() {
    let flags = |still: &Still| of(&analysed(still), WALK, "y").flags.join("; ");
    assert!(!flags(&SOUND).contains("drift") && !flags(&SOUND).contains("quantised"), "{}", flags(&SOUND));
    let drifting = Still { added: |_, t| 3e-7 * t, ..SOUND };
    assert!(flags(&drifting).contains("drift of"), "{}", flags(&drifting));
    let coarse = Still { read: |rate| (rate / 20e-6).round() * 20e-6, ..SOUND };
    assert!(flags(&coarse).contains("quantised: steps of"), "{}", flags(&coarse));
    let broken = Still { gap_s: 3.0, ..SOUND };
    assert!(flags(&broken).contains("gap: the longest stretch"), "{}", flags(&broken));
}

/// A hum of 0.2 mrad/s at 2 Hz that no axis made: no sum of noise processes has its ripple over the averaging time.
#[test]
fn a_record_that_no_noise_processes_describe_gives_none_of_them() {
    let hum = Still { added: |_, t| 2e-4 * (std::f64::consts::TAU * 2.0 * t).sin(), ..SOUND };
    let result = analysed(&hum);
    for gyro in ["x", "y", "z"] {
        let walk = of(&result, WALK, gyro);
        let reason = walk.inconclusive.as_deref().unwrap_or_default();
        assert!(
            walk.value.is_none() && reason.starts_with("the five noise processes do not describe"),
            "{walk:?}"
        );
    }
    assert!(of(&analysed(&SOUND), WALK, "x").value.is_some());
}

#[test]
fn what_is_no_evidence_gives_no_number() {
    let stuck = analysed(&Still { read: |_| 1e-5, ..SOUND });
    for gyro in ["x", "y", "z"] {
        let walk = of(&stuck, WALK, gyro);
        let reason = walk.inconclusive.as_deref().unwrap_or_default();
        assert!(walk.value.is_none() && reason.contains("all rates are the same"), "{walk:?}");
    }
    let case = &cases()[0];
    let empty = keys().analyse(case, &Window::completed(Vec::new(), spans(case, 1.0)), &axes());
    assert_eq!(
        empty.inconclusive.as_ref().map(Reason::to_string).as_deref(),
        Some("the log has no topic /imu")
    );
    assert_eq!(empty.measurements.len(), 18);
    assert!(empty.measurements.iter().all(|m| m.value.is_none() && m.inconclusive.is_some()));
    let unseen = keys().analyse(case, &Window::completed(Vec::new(), Vec::new()), &axes());
    assert_eq!(
        unseen.inconclusive.as_ref().map(Reason::to_string).as_deref(),
        Some("the segment `still` did not run")
    );
}

fn crept(counts: impl Fn(f64) -> f64) -> PointResult {
    let case = &cases()[1];
    let time: Vec<f64> = (0..2400).map(|k| f64::from(k) * PERIOD_S).collect();
    let counts = time.iter().map(|t| counts((0.2 + 5e-6 * t) / COUNT_RAD)).collect();
    let topics = vec![synthetic::rows("/az", &time, vec![("position_counts", counts)])];
    keys().analyse(case, &Window::completed(topics, spans(case, 24.0)), &axes())
}

#[test]
fn the_least_count_is_what_the_encoder_shows() {
    let result = crept(f64::round);
    let step = of(&result, RESOLUTION, "az").value.expect("a step");
    assert!((step / COUNT_RAD - 1.0).abs() < 1e-12, "{step}");
    assert!((of(&result, BITS, "az").value.expect("bits") - 26.0).abs() < 1e-12);
    // An encoder of 23 bit behind a drive that hands on 26.
    let eight = crept(|count| (count / 8.0).round() * 8.0);
    assert!((of(&eight, BITS, "az").value.expect("bits") - 23.0).abs() < 1e-12);
    // One of 20 bit does not show enough of itself within 100 urad.
    let coarse = crept(|count| (count / 64.0).round() * 64.0);
    let reason = of(&coarse, RESOLUTION, "az").inconclusive.clone().unwrap_or_default();
    assert!(reason.contains("the encoder showed 20 steps"), "{reason}");
    let stuck = crept(|_| 7.0);
    assert!(of(&stuck, BITS, "az").value.is_none() && stuck.inconclusive.is_some());
    let smooth = crept(|count| count + 0.1 * (100.0 * count).sin());
    assert!(
        of(&smooth, RESOLUTION, "az").inconclusive.as_deref().is_some_and(|r| r.contains("not multiples"))
    );
}

#[test]
fn the_plan_stands_still_and_creeps_inside_its_limits() {
    let cases = cases();
    assert_eq!(cases.iter().map(|c| c.point.as_str()).collect::<Vec<_>>(), ["still", "creep az", "creep el"]);
    assert_eq!(cases[0].planned_s(), keys().duration_s + 2.0);
    let reach = cases[2].envelope();
    assert!(reach.position_rad[1] - reach.position_rad[0] < 101e-6, "{reach:?}");
    // An axis that came to its pose may stand 60 urad beside it: on drawn unit 2040 that was where the creep was to end.
    for case in &cases[1..] {
        let begins = &case.segments[0].stimulus;
        let pose_rad = case.start_pose_rad[&case.axis];
        assert!(
            matches!(begins, Stimulus::Move { target_rad, .. } if *target_rad == pose_rad),
            "{}: {begins:?}",
            case.point
        );
    }
    let unknown = Keys { creep: vec!["roll".to_owned()], ..keys() }.plan("az", &axes());
    assert_eq!(unknown.expect_err("no such axis").len(), 1);
}
