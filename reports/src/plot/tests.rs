use procedures::trace::{LimitLine, Mark, Plot, Series, Style};

use super::layout::{LEFT, panels};
use super::*;
use crate::markup::tests::malformed;
use crate::sample::{responses, tracking};

fn svg(plot: &Plot, id: &str) -> String {
    super::svg(&Figure::of(plot), id)
}

fn looks_of(plot: &Plot) -> Vec<look::Look> {
    look::looks(&[plot]).remove(0)
}

fn panel(plot: &Plot) -> Panel<'_> {
    panels(&Figure::of(plot)).remove(0)
}

fn series(label: &str, style: Style, points: &[(f64, f64)], u: &[f64]) -> Series {
    let (x, y) = points.iter().copied().unzip();
    Series::new(label, style, x, y).with_u(u.to_vec())
}

/// Every style once.
fn every_style(log_x: bool) -> Plot {
    let x = Scale { log: log_x, ..Scale::linear("velocity", "deg/s") };
    Plot {
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
        ..Plot::new("all", "All styles <&>", x, Scale::linear("torque", "N*m"))
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
    let looks = looks_of(&every_style(true));
    let hollow: Vec<bool> = looks.iter().map(|l| l.hollow).collect();
    assert_eq!(hollow, [false, false, false, false, true, false]);
}

#[test]
fn a_band_has_the_colour_of_its_fit() {
    let looks = looks_of(&every_style(true));
    assert_eq!(looks[0].colour, looks[1].colour);
    assert_ne!(looks[1].colour, looks[2].colour);
}

#[test]
fn six_lines_differ_without_colour() {
    let mut plot = every_style(false);
    plot.series = (0..6).map(|i| series(&format!("{i}"), Style::Line, &[(0.0, 1.0)], &[])).collect();
    let mut dashes: Vec<&str> = looks_of(&plot).iter().map(|l| l.dash).collect();
    dashes.sort_unstable();
    dashes.dedup();
    assert_eq!(dashes.len(), 6);
}

#[test]
fn a_limit_is_inside_the_picture_even_far_from_the_data_and_ends_where_it_applies() {
    let mut plot = every_style(false);
    plot.limits[0].y = 5000.0;
    let panel = panel(&plot);
    let at = panel.y.place(5000.0).expect("the scale shows limits");
    assert!((TOP..panel.area.bottom).contains(&at), "{at}");
    let line = format!("M{} {}H{}", units(LEFT), units(at), units(panel.x.clamped(5.0)));
    assert!(svg(&plot, "a").contains(&line), "the limit applies up to 5: {line}");
}

#[test]
fn what_a_logarithmic_scale_cannot_show_is_counted_in_the_text() {
    let mut plot = every_style(true);
    assert_eq!(shortfall(&Figure::of(&plot)), None);
    plot.series[3].x[0] = 0.0;
    assert_eq!(
        shortfall(&Figure::of(&plot)).as_deref(),
        Some("One point is not positive and cannot be shown on a logarithmic scale.")
    );
}

#[test]
fn bars_start_at_zero() {
    let plot = every_style(false);
    let range = panel(&plot).y.range;
    assert!(range[0] <= 0.0, "{range:?}");
}

#[test]
fn labels_of_near_marks_do_not_touch() {
    let mut plot = every_style(false);
    plot.marks = [2.50, 2.51, 2.52, 9.9].map(|x| Mark { label: "a long label".to_owned(), x }).to_vec();
    let marks: Vec<&Mark> = plot.marks.iter().collect();
    let labels = mark::labels(&marks, &panel(&plot).x);
    assert_eq!(mark::rows(&labels), 3, "three labels need three rows, the far one none of its own");
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
            for number in value.split(|c: char| !(c.is_ascii_digit() || c == '.')) {
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
    let legend = legend::Legend::new(&panels(&Figure::of(&plot)));
    assert!(legend.height() > 3.0 * 17.0, "{}", legend.height());
}

/// The figure of these pictures: one SVG, well-formed, with every panel in it.
fn drawn(plots: &[Plot]) -> String {
    let figures = Figure::all(plots);
    assert_eq!((figures.len(), figures[0].panels().len()), (1, plots.len()));
    let text = super::svg(&figures[0], "figure");
    assert_eq!(malformed(&text), None);
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    text
}

#[test]
fn bode_with_mask_band_excluded_lines_coherence_and_limits() {
    insta::assert_snapshot!(drawn(&responses::bode()));
}

#[test]
fn nyquist_with_disk_and_circles_of_confidence() {
    insta::assert_snapshot!(drawn(&[responses::nyquist()]));
}

#[test]
fn margins_over_elevation_with_limits() {
    insta::assert_snapshot!(drawn(&responses::margins()));
}

#[test]
fn mode_map_with_computed_bands_and_error_bars() {
    insta::assert_snapshot!(drawn(&[responses::modes()]));
}

#[test]
fn impedance_with_circuit() {
    insta::assert_snapshot!(drawn(&responses::impedance()));
}

#[test]
fn latency_histogram() {
    insta::assert_snapshot!(drawn(&[responses::latency()]));
}

#[test]
fn panels_share_their_abscissa_and_its_labels_stand_once() {
    let plots = responses::bode();
    let figures = Figure::all(&plots);
    let all = panels(&figures[0]);
    for (upper, lower) in all.iter().zip(&all[1..]) {
        assert_eq!(upper.x, lower.x);
        assert!(upper.area.bottom < lower.area.top, "{:?} {:?}", upper.area, lower.area);
    }
    assert_eq!(drawn(&plots).matches(">frequency in Hz<").count(), 1);
}

#[test]
fn a_series_of_two_panels_stands_in_the_legend_once_and_looks_the_same_in_both() {
    let plots = responses::bode();
    let figures = Figure::all(&plots);
    let all = panels(&figures[0]);
    assert_eq!(all[0].looks, all[1].looks, "gain and phase have the same series");
    assert!(all[2].looks.iter().all(|l| !all[0].looks.contains(l)), "coherence is another");
    assert_eq!(drawn(&plots).matches(">measured lines<").count(), 1);
}

#[test]
fn a_panel_without_its_picture_is_a_figure_of_its_own() {
    let mut plots = responses::bode();
    plots[2].panel_of = Some("closed-loop-phase".to_owned());
    let ids = |figure: &Figure<'_>| figure.panels().iter().map(|p| p.id.clone()).collect::<Vec<_>>();
    let figures: Vec<Vec<String>> = Figure::all(&plots).iter().map(ids).collect();
    assert_eq!(
        figures,
        [vec!["closed-loop", "closed-loop-phase"], vec!["closed-loop-coherence"]],
        "a panel has no panels"
    );
    assert_eq!(Figure::all(&plots[1..]).len(), 2, "the first picture is gone");
}

#[test]
fn units_of_a_plane_are_equally_long() {
    let plot = responses::nyquist();
    let panel = panel(&plot);
    let per_unit =
        |axis: &axis::Axis| (axis.place(1.0).expect("linear") - axis.place(0.0).expect("linear")).abs();
    assert!((per_unit(&panel.x) - per_unit(&panel.y)).abs() < 1e-9);
    assert!(panel.x.range[0] <= -2.5 && panel.x.range[1] >= 1.5, "what was asked for is shown");
}

#[test]
fn what_lies_outside_of_a_window_is_cut_off_and_counted() {
    let mut plot = every_style(false);
    plot.x_range = Some([0.0, 4.5]);
    assert_eq!(
        shortfall(&Figure::of(&plot)).as_deref(),
        Some("4 points lie outside of what the figure shows."),
        "the ends of three curves and one marker"
    );
    let panel = panel(&plot);
    assert!(panel.is_window() && panel.x.range == [0.0, 4.5]);
    let window = format!("<svg x=\"{}\"", units(LEFT));
    assert!(svg(&plot, "a").contains(&window), "drawings end at the frame");
}

#[test]
fn labels_of_an_abscissa_do_not_touch() {
    for plots in [responses::bode(), responses::impedance(), vec![every_style(true)]] {
        for text in plots.iter().map(|p| svg(p, "a")) {
            let labels = text.split("<g text-anchor=\"middle\"").nth(1).and_then(|t| t.split("</g>").next());
            let ends: Vec<[f64; 2]> = labels
                .expect("tick labels")
                .split("<text x=\"")
                .skip(1)
                .map(|t| {
                    let x: f64 = t.split('"').next().and_then(|x| x.parse().ok()).expect("a place");
                    let label = t.split('>').nth(1).and_then(|l| l.split('<').next()).expect("a label");
                    let half = 0.5 * text::text_width(label);
                    [x - half, x + half]
                })
                .collect();
            assert!(ends.len() >= 2 && ends.windows(2).all(|w| w[0][1] < w[1][0]), "{ends:?}");
        }
    }
}

#[test]
fn boxes_without_widths_meet_halfway() {
    let series = Series::new("a", Style::Histogram, vec![3.0, 1.0, 2.0], vec![1.0; 3]);
    assert_eq!(draw::half_widths(&series), [0.5; 3]);
    assert_eq!(draw::half_widths(&series.with_u(vec![0.2, 0.3, 0.4])), [0.2, 0.3, 0.4]);
}

#[test]
fn track_error_with_events_windows_a_gap_limits_and_a_panel() {
    insta::assert_snapshot!(drawn(&tracking::errors()));
}

#[test]
fn histogram_of_errors_with_the_normal_distribution() {
    insta::assert_snapshot!(drawn(&[tracking::histogram()]));
}

#[test]
fn spectrum_of_errors_on_logarithmic_scales() {
    insta::assert_snapshot!(drawn(&[tracking::spectrum()]));
}

#[test]
fn list_of_approaches_to_a_limit() {
    insta::assert_snapshot!(drawn(&[tracking::approaches()]));
}

#[test]
fn pieces_of_a_line_look_alike_stand_in_the_legend_once_and_nothing_bridges_the_gap() {
    let plots = tracking::errors();
    let looks = looks_of(&plots[0]);
    assert_eq!(looks[0], looks[1]);
    let text = drawn(&plots);
    assert_eq!(text.matches(">elevation</text>").count(), 1);
    let lines = |plot: &Plot| svg(plot, "a").matches("fill=\"none\" stroke=\"#0072b2\"").count();
    let mut bridged = plots[0].clone();
    let rest = bridged.series.remove(1);
    bridged.series[0].x.extend(rest.x);
    bridged.series[0].y.extend(rest.y);
    assert_eq!(lines(&plots[0]), lines(&bridged) + 1, "two lines instead of one");
}

#[test]
fn a_window_is_shaded_over_its_stretch_and_named_once() {
    let plots = tracking::errors();
    let figures = Figure::all(&plots);
    let all = panels(&figures[0]);
    let text = drawn(&plots);
    let left = units(all[0].x.place(5.8).expect("linear"));
    assert!(text.contains(&format!("<rect x=\"{left}\" y=\"{}\"", units(all[0].area.top))), "{left}");
    assert_eq!(text.matches(">left out: target accelerates<").count(), 1);
    let mut away = plots[0].clone();
    away.spans.iter_mut().for_each(|s| s.x = [100.0, 120.0]);
    assert!(panel(&away).x.range[1] < 30.0, "a window makes no abscissa longer");
}

#[test]
fn rows_of_a_list_stand_from_top_to_bottom_with_their_names() {
    let plot = tracking::approaches();
    let panel = panel(&plot);
    let at: Vec<f64> = (1..=3).map(|row| panel.y.place(f64::from(row)).expect("a row")).collect();
    assert!(at[0] < at[1] && at[1] < at[2], "{at:?}");
    assert!(panel.x.shows(0.0), "bars begin at zero");
    let text = svg(&plot, "a");
    for name in ["soft-bench, 60\u{a0}°/s", "soft-bench, −60\u{a0}°/s"] {
        assert!(text.contains(name), "{name}");
    }
}

#[test]
fn a_figure_says_how_many_points_its_curves_stand_for() {
    let mut plot = every_style(false);
    assert_eq!(thinned(&Figure::of(&plot)), None);
    let drawn = plot.series[0].x.len();
    plot.series[0].whole = Some(120_000);
    assert_eq!(
        thinned(&Figure::of(&plot)),
        Some(format!(
            "{drawn} of 120\u{202f}000 points of its long curves are drawn; extremes and shape are kept."
        ))
    );
}

#[test]
fn a_path_says_steps_of_tenths_and_far_points_by_their_place() {
    let d = |points: &[(f64, f64)]| draw::path(points.iter().copied());
    assert_eq!(d(&[(62.0, 10.04), (62.3, 10.0), (62.3, 9.96), (61.0, 30.5)]), "M62 10l.3 0-1.3 20.5");
    assert_eq!(d(&[(0.0, 0.0), (5000.0, 0.0), (1.0, 0.0), (2.0, 0.5)]), "M0 0L5000 0 1 0l1 .5");
    assert_eq!(d(&[]), "");
}
