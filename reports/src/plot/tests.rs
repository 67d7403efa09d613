use procedures::trace::{LimitLine, Mark, Series};

use super::*;
use crate::markup::tests::malformed;

fn series(label: &str, style: Style, points: &[(f64, f64)], u: &[f64]) -> Series {
    let (x, y) = points.iter().copied().unzip();
    Series { label: label.to_owned(), style, x, y, u: u.to_vec() }
}

/// Every style once.
fn every_style(log_x: bool) -> Plot {
    Plot {
        id: "all".to_owned(),
        title: "All styles <&>".to_owned(),
        x: Scale { label: "velocity".to_owned(), unit: "deg/s".to_owned(), log: log_x },
        y: Scale { label: "torque".to_owned(), unit: "N*m".to_owned(), log: false },
        series: vec![
            series("band", Style::Band, &[(1.0, 200.0), (10.0, 220.0)], &[8.0, 9.0]),
            series("fit", Style::Fit, &[(1.0, 200.0), (10.0, 220.0)], &[]),
            series("line", Style::Line, &[(1.0, 205.0), (10.0, 215.0)], &[]),
            series("measured", Style::Markers, &[(2.0, 203.0), (5.0, 212.0)], &[4.0, 5.0]),
            series("excluded", Style::Excluded, &[(3.0, 180.0)], &[]),
            series("bars", Style::Bars, &[(4.0, 20.0)], &[]),
        ],
        limits: vec![LimitLine { label: "FRC-AZ <= 260 N*m".to_owned(), y: 260.0, x: Some([0.0, 5.0]) }],
        marks: vec![Mark { label: "onset".to_owned(), x: 2.5 }],
        limits_of: None,
    }
}

#[test]
fn a_picture_of_every_style() {
    let text = svg(&every_style(true), "plot-1-1");
    assert_eq!(malformed(&text), None);
    insta::assert_snapshot!(text);
}

#[test]
fn the_same_plot_gives_the_same_bytes_and_no_minus_zero() {
    let plot = every_style(false);
    let text = svg(&plot, "a");
    assert_eq!(text, svg(&plot, "a"));
    assert!(!text.contains("-0.0"), "{text}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}

#[test]
fn excluded_points_are_hollow_and_measured_ones_filled() {
    let looks = look::looks(&every_style(true));
    let hollow: Vec<bool> = looks.iter().map(|l| l.hollow).collect();
    assert_eq!(hollow, [false, false, false, false, true, false]);
}

#[test]
fn a_band_has_the_colour_of_its_fit() {
    let looks = look::looks(&every_style(true));
    assert_eq!(looks[0].colour, looks[1].colour);
    assert_ne!(looks[1].colour, looks[2].colour);
}

#[test]
fn six_lines_differ_without_colour() {
    let mut plot = every_style(false);
    plot.series = (0..6).map(|i| series(&format!("{i}"), Style::Line, &[(0.0, 1.0)], &[])).collect();
    let mut dashes: Vec<&str> = look::looks(&plot).iter().map(|l| l.dash).collect();
    dashes.sort_unstable();
    dashes.dedup();
    assert_eq!(dashes.len(), 6);
}

#[test]
fn a_limit_is_inside_the_picture_even_far_from_the_data_and_ends_where_it_applies() {
    let mut plot = every_style(false);
    plot.limits[0].y = 5000.0;
    let (x, y) = axes(&plot);
    let at = y.place(5000.0).expect("the scale shows limits");
    assert!((TOP..TOP + HEIGHT).contains(&at), "{at}");
    let line = format!("M{} {}H{}", units(LEFT), units(at), units(x.clamped(5.0)));
    assert!(svg(&plot, "a").contains(&line), "the limit applies up to 5: {line}");
}

#[test]
fn what_a_logarithmic_scale_cannot_show_is_counted_in_the_text() {
    let mut plot = every_style(true);
    assert_eq!(shortfall(&plot), None);
    plot.series[3].x[0] = 0.0;
    assert_eq!(
        shortfall(&plot).as_deref(),
        Some("One point is not positive and cannot be shown on a logarithmic scale.")
    );
}

#[test]
fn bars_start_at_zero() {
    let (_, y) = axes(&every_style(false));
    assert!(y.range[0] <= 0.0, "{:?}", y.range);
}

#[test]
fn labels_of_near_marks_do_not_touch() {
    let mut plot = every_style(false);
    plot.marks = [2.50, 2.51, 2.52, 9.9].map(|x| Mark { label: "a long label".to_owned(), x }).to_vec();
    let (x, _) = axes(&plot);
    let labels = draw::mark_labels(&plot.marks, &x);
    assert_eq!(draw::mark_rows(&labels), 3, "three labels need three rows, the far one none of its own");
    assert!(svg(&plot, "a").contains("viewBox=\"0 -39 "));
}

proptest::proptest! {
    #![proptest_config(proptest::test_runner::Config { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn any_numbers_give_a_picture_inside_its_frame(
        xs in proptest::collection::vec(proptest::num::f64::ANY, 0..6),
        ys in proptest::collection::vec(proptest::num::f64::ANY, 0..6),
        log_x: bool,
        log_y: bool,
    ) {
        let mut plot = every_style(log_x);
        plot.y.log = log_y;
        for series in &mut plot.series {
            (series.x, series.y, series.u) = (xs.clone(), ys.clone(), xs.clone());
        }
        plot.limits[0].y = ys.first().copied().unwrap_or(1.0);
        plot.marks[0].x = xs.first().copied().unwrap_or(1.0);
        let text = svg(&plot, "a");
        let body = text.split("</desc>").nth(1).expect("a description");
        proptest::prop_assert!(!body.contains("NaN") && !body.contains("inf\""), "{}", body);
        let values = [" d=\"", " x=\"", " y=\""].map(|name| body.split(name).skip(1));
        for value in values.into_iter().flatten().filter_map(|rest| rest.split('"').next()) {
            for number in value.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')) {
                proptest::prop_assert!(number.parse().unwrap_or(0.0) < 1000.0, "{} in {}", number, value);
            }
        }
    }
}

#[test]
fn an_empty_plot_is_a_frame() {
    let mut plot = every_style(true);
    plot.series.clear();
    plot.limits.clear();
    plot.marks.clear();
    assert_eq!(malformed(&svg(&plot, "a")), None);
}

#[test]
fn the_legend_breaks_rows_inside_the_picture() {
    let mut plot = every_style(false);
    plot.series = (0..9)
        .map(|i| series(&format!("a rather long legend entry {i}"), Style::Line, &[(0.0, 1.0)], &[]))
        .collect();
    let legend = legend::Legend::new(&plot, &look::looks(&plot));
    assert!(legend.height() > 3.0 * 17.0, "{}", legend.height());
}
