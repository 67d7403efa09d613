use super::keys::Slow;
use super::*;
use crate::kinds::inertial::body_rates;
use crate::kinds::inertial::tests::imu_rows;
use crate::log::{EndedBy, SegmentSpan};
use crate::measurement::Measurement;
use crate::reason::Reason;
use crate::synthetic;

const PERIOD_S: f64 = 2e-3;
const DELAY_S: f64 = 1e-3;
const COUNT_RAD: f64 = std::f64::consts::TAU / (1 << 26) as f64;

/// A rest of this, then the spin.
const REST_S: f64 = 1.0;

/// A rest and a spin of an axis at an elevation; `turned` makes of true body rates what the gyros say, `coupled` of the true
/// angles of azimuth what its encoder does. The other axis follows by `follows` times the angle.
fn window_of(
    axis: &str,
    elevation: f64,
    follows: f64,
    turned: fn([f64; 3]) -> [f64; 3],
    coupled: fn(&[f64]) -> Vec<f64>,
) -> Window {
    let n: usize = 8500;
    // Two frequencies: of one alone the acceleration is a multiple of the angle.
    let swing = |t: f64| {
        let t = (t - REST_S).max(0.0);
        0.3 * (1.0 - (1.3 * t).cos()) + 0.06 * (1.0 - (3.1 * t).cos())
    };
    let time: Vec<f64> = (0..n).map(|k| k as f64 * PERIOD_S).collect();
    let angles = |t: f64| match axis {
        "az" => [swing(t), elevation + follows * swing(t)],
        _ => [0.1 + follows * swing(t), elevation + swing(t)],
    };
    let mut rates: [Vec<f64>; 3] = Default::default();
    for &t in &time {
        let mean = |k: usize| (angles(t - DELAY_S)[k] - angles(t - DELAY_S - PERIOD_S)[k]) / PERIOD_S;
        let at = angles(t - DELAY_S - 0.5 * PERIOD_S)[1];
        let body = turned(body_rates(mean(0), mean(1), at));
        for (rates, rate) in rates.iter_mut().zip(body) {
            // A grain that is no noise, so that uncertainties are not zero.
            rates.push(rate + 1e-6 * (77.0 * t).sin());
        }
    }
    let imu = imu_rows(&time, rates, (0..n).map(|k| (k * 8 % 128) as f64).collect());
    let axis = |name, k: usize| {
        let angle: Vec<f64> = time.iter().map(|t| angles(*t)[k]).collect();
        let angle = if k == 0 { coupled(&angle) } else { angle };
        let counts = angle.iter().map(|a| (a / COUNT_RAD).round()).collect();
        synthetic::rows(name, &time, vec![("position_rad", angle), ("position_counts", counts)])
    };
    let end_s = n as f64 * PERIOD_S;
    let ended_by = EndedBy::Completed;
    let span =
        |segment, start_s, end_s| SegmentSpan { segment, start_s, end_s, start_position_rad: 0.0, ended_by };
    let spans = vec![span(0, 0.0, REST_S), span(1, REST_S, end_s)];
    Window::completed(vec![imu, axis("/az", 0), axis("/el", 1)], spans)
}

fn window(axis: &str, elevation: f64, turned: fn([f64; 3]) -> [f64; 3]) -> Window {
    window_of(axis, elevation, 0.0, turned, <[f64]>::to_vec)
}

fn keys() -> Keys {
    Keys {
        elevations_rad: vec![0.0, 0.7],
        velocity_rad_per_s: 0.2,
        acceleration_rad_per_s2: 0.3,
        span_rad: [-0.5, 0.5],
        elevation_span_rad: Some([0.1, 1.2]),
        cycles: 2,
        slow: None,
    }
}

fn analysed(index: usize, turned: fn([f64; 3]) -> [f64; 3]) -> PointResult {
    let cases = keys().plan("az", &crate::kinds::inertial::allan::tests::axes()).expect("the axes allow it");
    let case = &cases[index];
    let elevation = if case.axis == "el" { 0.65 } else { keys().elevations_rad[index] };
    point::analyse(
        case,
        &window(&case.axis, elevation, turned),
        &crate::kinds::inertial::allan::tests::axes(),
    )
}

fn of<'a>(result: &'a PointResult, measurand: &str) -> &'a Measurement {
    result.measurements.iter().find(|m| m.measurand == measurand).expect("measured, or said why not")
}

fn value(result: &PointResult, measurand: &str) -> f64 {
    of(result, measurand).value.expect("a number")
}

#[test]
fn a_sound_unit_agrees_at_every_elevation_and_in_both_axes() {
    for index in 0..3 {
        let result = analysed(index, |rates| rates);
        assert!(value(&result, SCALE).abs() < 5e-6, "{index}: {}", value(&result, SCALE));
        assert!(value(&result, MAPPING) < 2e-5, "{index}: {}", value(&result, MAPPING));
        assert!((value(&result, DELAY) - DELAY_S).abs() < 5e-6, "{index}: {}", value(&result, DELAY));
        assert_eq!(result.remarks, [""; 0]);
        assert_eq!(result.plots.len(), 2);
    }
}

#[test]
fn what_the_other_axis_moves_is_no_error_of_the_mapping() {
    let axes = crate::kinds::inertial::allan::tests::axes();
    let cases = keys().plan("az", &axes).expect("the axes allow it");
    for (index, elevation) in [(1, 0.7), (2, 0.65)] {
        let case = &cases[index];
        let window = window_of(&case.axis, elevation, 3e-4, |rates| rates, <[f64]>::to_vec);
        let found = point::analyse(case, &window, &axes);
        assert!(value(&found, MAPPING) < 2e-5, "{index}: {}", value(&found, MAPPING));
        assert!(value(&found, SCALE).abs() < 5e-6, "{index}: {}", value(&found, SCALE));
    }
}

#[test]
fn a_scale_error_of_all_gyros_is_the_scale_error_of_the_rate() {
    let result = analysed(1, |rates| rates.map(|r| 1.0002 * r));
    assert!((value(&result, SCALE) - 2e-4).abs() < 5e-6);
}

/// An encoder with 100 µrad of play that loses 0.1 % of the travel to larger angles, and one that does neither.
#[test]
fn play_and_slip_of_a_coupling_are_found_and_a_rigid_one_has_none() {
    fn loose(angle_rad: &[f64]) -> Vec<f64> {
        let mut seen = angle_rad[0];
        let mut lost = 0.0;
        let mut last = angle_rad[0];
        let follow = |&angle: &f64| {
            lost += 1e-3 * (angle - last).max(0.0);
            last = angle;
            seen = seen.clamp(angle - lost - 50e-6, angle - lost + 50e-6);
            seen
        };
        angle_rad.iter().map(follow).collect()
    }
    let axes = crate::kinds::inertial::allan::tests::axes();
    let cases = keys().plan("az", &axes).expect("the axes allow it");
    let found = point::analyse(&cases[1], &window_of("az", 0.7, 0.0, |rates| rates, loose), &axes);
    assert!((value(&found, PLAY) - 100e-6).abs() < 3e-6, "{:?}", of(&found, PLAY));
    assert!((value(&found, SLIP) - 1e-3).abs() < 1e-5, "{:?}", of(&found, SLIP));
    for index in 0..3 {
        let rigid = analysed(index, |rates| rates.map(|r| 1.0002 * r + 1e-5));
        assert!(value(&rigid, PLAY).abs() < 2e-6, "{index}: {:?}", of(&rigid, PLAY));
        assert!(value(&rigid, SLIP).abs() < 5e-6, "{index}: {:?}", of(&rigid, SLIP));
    }
}

#[test]
fn signs_and_mappings_that_are_wrong_are_named() {
    let inverted = analysed(1, |rates| rates.map(|r| -r));
    assert!((value(&inverted, MAPPING) - std::f64::consts::PI).abs() < 1e-3);
    let [remark] = inverted.remarks.as_slice() else { panic!("one remark, found {:?}", inverted.remarks) };
    assert!(remark.contains("the gyros show rotation opposite to the encoder"), "{remark}");
    // Z the other way round: off by twice the elevation, and nothing at elevation 0.
    let mirrored = analysed(1, |[x, y, z]| [x, y, -z]);
    assert!((value(&mirrored, MAPPING) - 1.4).abs() < 1e-3, "{}", value(&mirrored, MAPPING));
    assert!(of(&mirrored, MAPPING).flags.contains(&"mapping wrong".to_owned()));
    assert!(value(&analysed(0, |[x, y, z]| [x, y, -z]), MAPPING) < 1e-4);
    // X and Y exchanged: azimuth does not notice, elevation turns round.
    assert!(value(&analysed(0, |[x, y, z]| [y, x, z]), MAPPING) < 1e-4);
    assert!((value(&analysed(2, |[x, y, z]| [y, x, z]), MAPPING) - std::f64::consts::PI).abs() < 1e-3);
}

/// Azimuth creeps over its pitches; its encoder errs by `error_rad`, zero to peak, within each.
fn creeping(error_rad: f64) -> Window {
    let rate_rad_per_s = 1.745e-3;
    let pitch_rad = std::f64::consts::TAU / 32_768.0;
    let time: Vec<f64> = (0..8000).map(|k| f64::from(k) * PERIOD_S).collect();
    let shown = |t: f64| {
        let angle = rate_rad_per_s * t;
        angle + error_rad * (std::f64::consts::TAU * angle / pitch_rad).sin()
    };
    let body = body_rates(rate_rad_per_s, 0.0, 0.0);
    let rates = body.map(|rate| time.iter().map(|t| rate + 20e-6 * (1e5 * t).sin()).collect());
    let imu = imu_rows(&time, rates, (0..time.len()).map(|k| (k * 8 % 128) as f64).collect());
    let axis = |name, angle: Vec<f64>| {
        let counts = angle.iter().map(|a| (a / COUNT_RAD).round()).collect();
        synthetic::rows(name, &time, vec![("position_rad", angle), ("position_counts", counts)])
    };
    let azimuth = axis("/az", time.iter().map(|&t| shown(t)).collect());
    let elevation = axis("/el", vec![0.0; time.len()]);
    let end_s = time.len() as f64 * PERIOD_S;
    let ended_by = EndedBy::Completed;
    let span = SegmentSpan { segment: 1, start_s: 0.0, end_s, start_position_rad: 0.0, ended_by };
    Window::completed(vec![imu, azimuth, elevation], vec![span])
}

#[test]
fn an_error_within_the_pitches_of_the_encoder_shows_against_the_gyros() {
    let slow = Slow { pitches_per_rev: 32_768.0, velocity_rad_per_s: 1.745e-3, span_rad: 0.017 };
    let keys = Keys { slow: Some(slow), ..keys() };
    let axes = crate::kinds::inertial::allan::tests::axes();
    let cases = keys.plan("az", &axes).expect("the axes allow it");
    let names: Vec<&str> = cases.iter().map(|case| case.point.as_str()).collect();
    assert_eq!(names[3..], ["azimuth, slow", "elevation, slow"]);
    for error_rad in [0.3e-6, 6e-6] {
        let result = keys.analyse(&cases[3], &creeping(error_rad), &axes);
        let found = of(&result, RIPPLE);
        let value = found.value.expect("a number");
        assert!(
            (value - error_rad).abs() < 0.03e-6 + 2.0 * found.u,
            "{value} ± {}, true {error_rad}",
            found.u
        );
        assert_eq!(found.axis, "az");
    }
}

#[test]
fn what_is_no_evidence_gives_no_number() {
    let silent = analysed(1, |_| [0.0; 3]);
    assert_eq!(
        silent.inconclusive.as_ref().map(Reason::to_string).as_deref(),
        Some("the gyros show no motion of the axis")
    );
    assert!(silent.measurements.len() == 5 && silent.measurements.iter().all(|m| m.value.is_none()));
    let cases = keys().plan("az", &crate::kinds::inertial::allan::tests::axes()).expect("the axes allow it");
    let none = point::analyse(
        &cases[0],
        &Window::completed(Vec::new(), Vec::new()),
        &crate::kinds::inertial::allan::tests::axes(),
    );
    assert_eq!(
        none.inconclusive.as_ref().map(Reason::to_string).as_deref(),
        Some("the segment `spin` did not run")
    );
}

#[test]
fn the_plan_spins_inside_its_spans() {
    let cases = keys().plan("az", &crate::kinds::inertial::allan::tests::axes()).expect("the axes allow it");
    let names: Vec<&str> = cases.iter().map(|c| c.point.as_str()).collect();
    assert_eq!(names, ["azimuth, elevation=0 deg", "azimuth, elevation=40.107 deg", "elevation"]);
    assert_eq!(cases[2].start_pose_rad["el"], 0.1);
    for case in &cases {
        let reach = case.envelope().position_rad;
        assert!(reach[0] >= -0.5 - 1e-9 && reach[1] <= 1.2 + 1e-9, "{reach:?}");
    }
    let nowhere = keys().plan("az", &Axes::default()).expect_err("no axes");
    assert!(nowhere[0].message.contains("the rig has no axis `az`"), "{nowhere:?}");
}
