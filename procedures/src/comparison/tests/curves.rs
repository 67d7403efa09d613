use crate::comparison::*;
use crate::trace::{Plot, Scale, Series, Style};

const HALF_WIDTH_DB: f64 = 0.2;

/// A gain over frequency, `shift_db` away from what it is without at the points of this range.
fn gain(shift_db: f64, shifted: std::ops::Range<usize>) -> Plot {
    let x: Vec<f64> = (1..=60).map(f64::from).collect();
    let shift = |k: usize| if shifted.contains(&k) { shift_db } else { 0.01 };
    let y: Vec<f64> = x.iter().enumerate().map(|(k, hz)| -20.0 * hz.log10() + shift(k)).collect();
    let band = Series::new("U (k = 2)", Style::Band, x.clone(), y.clone()).with_u(vec![HALF_WIDTH_DB; 60]);
    let fit = Series::new("fit", Style::Fit, x.clone(), vec![1.0; 60]);
    Plot {
        series: vec![band, Series::new("measured", Style::Line, x, y), fit],
        ..Plot::new("gain", "Gain", Scale::logarithmic("frequency", "Hz"), Scale::linear("gain", "dB"))
    }
}

fn compared(a: &[Plot], b: &[Plot], tolerance: Option<f64>) -> Comparison {
    let found = |plots| Found { procedure: "AZ-LOOP", measurements: &[], plots };
    compare(&[found(a)], &[found(b)], tolerance)
}

#[test]
fn a_curve_differs_where_a_tenth_of_its_points_does_and_the_farthest_point_is_told() {
    let base = [gain(0.0, 0..0)];
    let against = |other: Plot| compared(&base, &[other], None).curves[0].clone();
    let few = against(gain(2.0, 10..13));
    assert_eq!((few.call, few.inside, few.points), (Call::Same, 57, 60));
    let many = against(gain(2.0, 10..20));
    assert_eq!((many.call, many.inside), (Call::Differs, 50));
    assert_eq!(many.band, Band::Uncertainty);
    let worst = many.worst.expect("they share points");
    assert!((11.0..=20.0).contains(&worst.x) && (worst.difference - 1.99).abs() < 1e-9);
    assert!((worst.half_width - HALF_WIDTH_DB * 2.0_f64.sqrt()).abs() < 1e-12);
    let identical = compared(&base, &base, None);
    assert!(identical.is_identical());
    assert_eq!(identical.curves.len(), 1, "a fit is not compared");
}

#[test]
fn a_curve_without_uncertainty_is_shown_and_judged_only_by_a_tolerance() {
    let without = |shift_db| {
        let mut plot = gain(shift_db, 0..60);
        plot.series.retain(|series| series.style != Style::Band);
        plot
    };
    let [a, near, far] = [0.0, 0.4, 1.0].map(without);
    let call = |other: &Plot, tolerance| {
        let all = compared(std::slice::from_ref(&a), std::slice::from_ref(other), tolerance);
        (all.curves[0].call, all.curves[0].inside, all.differs())
    };
    assert_eq!(call(&far, None), (Call::NotJudged, 0, false));
    // 5 % are 0.42 dB, 2 % are 0.17 dB.
    assert_eq!(call(&near, Some(0.05)), (Call::Same, 60, false));
    assert_eq!(call(&near, Some(0.02)), (Call::Differs, 0, true));
}

#[test]
fn frequencies_of_one_run_alone_are_counted_and_not_interpolated() {
    let mut other = gain(0.0, 0..0);
    for series in &mut other.series {
        for values in [&mut series.x, &mut series.y, &mut series.u].into_iter().filter(|v| !v.is_empty()) {
            values.remove(30);
        }
    }
    let comparison = compared(&[gain(0.0, 0..0)], &[other], None);
    assert_eq!((comparison.curves[0].points, comparison.curves[0].points_alone), (59, 1));
}

#[test]
fn a_response_to_a_step_is_compared_at_the_times_of_the_first_run() {
    let step = |points: u32, label: &str| {
        let x: Vec<f64> = (0..=points).map(|k| f64::from(k) / f64::from(points)).collect();
        let y = x.clone();
        let scale = Scale::linear("time since the step", "s");
        Plot {
            series: vec![Series::new(label, Style::Line, x, y)],
            ..Plot::new("step", "Step", scale, Scale::linear("position over height", "1"))
        }
    };
    let comparison = compared(&[step(50, "there, mean of 3")], &[step(37, "there, mean of 2")], Some(0.01));
    let curve = &comparison.curves[0];
    assert_eq!((curve.call, curve.points), (Call::Same, 51));
    assert!(curve.worst.is_some_and(|worst| worst.difference.abs() < 1e-12));
}

#[test]
fn courses_of_one_record_are_no_curves_and_curves_of_one_run_are_counted() {
    let mut course = gain(0.0, 0..0);
    course.x = Scale::linear("time", "s");
    assert!(compared(&[course.clone()], &[course], None).curves.is_empty());
    let comparison = compared(&[gain(0.0, 0..0)], &[], None);
    assert_eq!((comparison.curves.len(), comparison.curves_alone), (0, 1));
}
