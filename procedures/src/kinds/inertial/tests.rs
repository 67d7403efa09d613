use super::*;
use crate::synthetic::rows;

fn axes() -> Axes {
    crate::kinds::inertial::allan::tests::axes()
}

/// Rows of an inertial unit with these rates and sample numbers.
pub(super) fn imu_rows(time_s: &[f64], rates: [Vec<f64>; 3], sequence: Vec<f64>) -> Rows {
    let [x, y, z] = rates;
    let columns = vec![
        ("rate_x_rad_per_s", x),
        ("rate_y_rad_per_s", y),
        ("rate_z_rad_per_s", z),
        ("temperature_degc", vec![45.0; time_s.len()]),
        ("sequence", sequence),
    ];
    rows(TOPIC, time_s, columns)
}

fn logged(counter: &[f64], time_s: &[f64]) -> Window {
    let n = counter.len();
    let rate = |k: f64| (0..n).map(|i| k + i as f64).collect::<Vec<f64>>();
    let imu = imu_rows(time_s, [0.0, 1000.0, 2000.0].map(rate), counter.to_vec());
    let axis =
        |name| rows(name, time_s, vec![("position_rad", vec![0.5; n]), ("position_counts", vec![7.0; n])]);
    Window::completed(vec![imu, axis("/az"), axis("/el")], Vec::new())
}

#[test]
fn each_sample_counts_once_however_often_the_log_repeats_it() {
    let counter: Vec<f64> = (0..400).map(|k| f64::from(k / 4 % 128)).collect();
    let time: Vec<f64> = (0..400).map(|k| f64::from(k) / 4000.0).collect();
    let found = Samples::read(&logged(&counter, &time), &axes(), 0.0, 1.0).expect("a hundred samples");
    assert_eq!(found.len(), 99, "the first row's sample may be older");
    assert!((found.period_s - 1e-3).abs() < 1e-12);
    assert_eq!(found.rate_rad_per_s[1][..2], [1004.0, 1008.0]);
    assert_eq!(found.flags, [""; 0]);
    assert_eq!(found.excluded.iter().map(|e| e.count).sum::<usize>(), 300);
    assert_eq!((found.messages_in_most(), found.rates_of_messages(1, 2.0).len()), (1.0, 0));
}

#[test]
fn the_longer_side_of_a_gap_is_used_and_said() {
    let counter: Vec<f64> = (0..400).map(|k| f64::from(k * 8 % 128)).collect();
    let time: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k) + if k < 100 { 0.0 } else { 0.5 }).collect();
    let found = Samples::read(&logged(&counter, &time), &axes(), 0.0, 10.0).expect("three hundred samples");
    assert_eq!(found.len(), 300);
    assert!(
        found.flags[0].contains("gap: the longest stretch holds 300 of 399 samples"),
        "{:?}",
        found.flags
    );
}

#[test]
fn a_few_lost_messages_are_said_and_many_are_too_many() {
    let time: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
    let after = |every: i32| -> Vec<f64> {
        (0..400).map(|k| f64::from((k * 8 + if every > 0 { k / every } else { 0 }) % 128)).collect()
    };
    let few = Samples::read(&logged(&after(100), &time), &axes(), 0.0, 10.0).expect("3 of 3200 missing");
    assert_eq!(few.flags, ["3 messages missing"]);
    let many = Samples::read(&logged(&after(4), &time), &axes(), 0.0, 10.0);
    assert_eq!(
        many.map_err(|reason| reason.to_string()),
        Err("99 of 3192 messages of the inertial unit are missing".to_owned())
    );
    let none = Samples::read(&logged(&[7.0; 400], &time), &axes(), 0.0, 10.0);
    assert_eq!(
        none.map_err(|reason| reason.to_string()),
        Err("0 samples of the gyros, at least 16 are needed".to_owned())
    );
}

#[test]
fn the_turning_axes_and_the_turning_earth_are_seen_where_the_mount_puts_them() {
    for elevation in [0.0_f64, 0.7, 1.5] {
        // The matrix of director.md §6 takes them back.
        let [x, y, z] = body_rates(0.3, 0.2, elevation);
        let (sin, cos) = elevation.sin_cos();
        assert!((FRAC_1_SQRT_2 * (x - y) + 0.2).abs() < 1e-15);
        assert!((FRAC_1_SQRT_2 * cos * (x + y) + sin * z - 0.3).abs() < 1e-15);
        let earth = earth_rates(0.7, 0.3, -0.4, elevation);
        let size = earth.iter().map(|r| r * r).sum::<f64>().sqrt();
        assert!((size / 7.292_115e-5 - 1.0).abs() < 1e-12);
        let vertical = FRAC_1_SQRT_2 * cos * (earth[0] + earth[1]) + sin * earth[2];
        assert!((vertical / (7.292_115e-5 * 0.7_f64.sin()) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn counters_that_begin_again_turn_on() {
    let count_rad = TAU / 67_108_864.0;
    assert_eq!(nearest(5.0, count_rad), 5.0);
    assert_eq!(nearest(5.0 - 67_108_864.0, count_rad), 5.0);
    assert_eq!(nearest(67_108_860.0, count_rad), -4.0);
}
