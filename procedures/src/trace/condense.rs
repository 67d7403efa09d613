//! Curves as short as their pictures: what a report keeps of a trace. The log keeps all of it.
//!
//! Points of a line that lie on the line through the others to within [`TOLERANCE`] of the picture are left out
//! (Ramer 1972, Douglas and Peucker 1973), and numbers are cut to [`DIGITS`] digits of what the picture spans. Short
//! series, among them all measured values, stay as they are: nothing is judged by a picture.

use std::collections::BTreeSet;

use super::{Plot, Series, Style};

/// Series of no more points stay as they are.
const SHORT: usize = 100;
/// What nobody sees, as part of the height of a picture; zoomed in ten times it is still less than the line is wide.
const TOLERANCE: f64 = 3e-4;
/// A picture is so much wider than high.
const WIDTH: f64 = 2.5;
/// Places of decimals of what a picture spans: a hundred-thousandth of it.
const DIGITS: i32 = 5;

/// Condenses the pictures of a procedure. Meant to be done once: done twice, it may leave out a little more.
pub fn condense(plots: &mut [Plot]) {
    let windows: Vec<Option<[f64; 2]>> = plots.iter().map(|plot| window(plots, plot)).collect();
    for (plot, window) in plots.iter_mut().zip(windows) {
        let x_log = plot.x.log;
        let y_log = plot.y.log;
        let y_range = plot.y_range;
        for series in plot.series.iter_mut().filter(|s| s.x.len() > SHORT && s.x.len() == s.y.len()) {
            let x = Span::of(&series.x, x_log, window);
            let y = Span::of(&series.y, y_log, y_range);
            let is_band = series.style == Style::Band && series.u.len() == series.x.len();
            let is_line = matches!(series.style, Style::Line | Style::Fit) && series.u.is_empty();
            if is_line || is_band {
                simplify(series, &x, &y);
            }
            series.x.iter_mut().for_each(|v| *v = x.rounded(*v));
            series.y.iter_mut().for_each(|v| *v = y.rounded(*v));
            series.u.iter_mut().for_each(|v| *v = y.rounded(*v));
        }
    }
}

/// The stretch of the abscissa that is shown: that of a panel is its picture's.
fn window(plots: &[Plot], plot: &Plot) -> Option<[f64; 2]> {
    let head = plot.panel_of.as_ref().and_then(|id| plots.iter().find(|p| p.id == *id));
    head.unwrap_or(plot).x_range
}

/// What is seen of a coordinate.
struct Span {
    log: bool,
    /// Smallest value, or its logarithm.
    low: f64,
    /// Largest less smallest; 1 where they are equal.
    width: f64,
    /// Decimal places of a linear scale; `None` where nothing is spanned.
    places: Option<i32>,
}

impl Span {
    /// Of these values, or of the part of them that is shown.
    fn of(values: &[f64], log: bool, shown: Option<[f64; 2]>) -> Self {
        let visible = |v: &&f64| v.is_finite() && (!log || **v > 0.0);
        let all = || values.iter().filter(visible).copied();
        let [mut low, mut high] =
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
        if let Some([from, to]) = shown.filter(|[from, to]| from < to && (!log || *from > 0.0)) {
            (low, high) = (low.max(from), high.min(to));
        }
        // Nothing that can be shown, or all of it in one place.
        if low.partial_cmp(&high) != Some(std::cmp::Ordering::Less) {
            return Self { log, low: 0.0, width: 1.0, places: None };
        }
        let [from, to] = if log { [low.ln(), high.ln()] } else { [low, high] };
        let places = DIGITS - (high - low).log10().ceil() as i32;
        Self { log, low: from, width: to - from, places: Some(places) }
    }

    /// Where a value lies: 0 at the low end and 1 at the high one. Not finite where it cannot be shown.
    fn place(&self, value: f64) -> f64 {
        ((if self.log { value.ln() } else { value }) - self.low) / self.width
    }

    /// The nearest number of fewer digits.
    fn rounded(&self, value: f64) -> f64 {
        let text = match self.places {
            _ if !value.is_finite() => return value,
            None => return value,
            Some(_) if self.log => format!("{value:.*e}", DIGITS as usize - 1),
            Some(places @ 0..=300) => format!("{value:.*}", places as usize),
            Some(_) => format!("{value:.*e}", DIGITS as usize + 2),
        };
        // Adding zero takes the sign from a negative one.
        text.parse::<f64>().map_or(value, |v| v + 0.0)
    }
}

/// Leaves out points that lie on the line through the others; of a band, those that do so on both of its edges.
fn simplify(series: &mut Series, x: &Span, y: &Span) {
    let edge = |sign: f64| -> Vec<[f64; 2]> {
        let points = series.x.iter().zip(&series.y).enumerate();
        let place = |(i, (&a, &b)): (usize, (&f64, &f64))| match series.u.get(i) {
            // The lower edge of a band may leave a logarithmic scale.
            Some(u) => [WIDTH * x.place(a), y.place(b + sign * u).max(-1.0)],
            None => [WIDTH * x.place(a), y.place(b)],
        };
        points.map(place).collect()
    };
    let edges = if series.u.is_empty() { vec![edge(0.0)] } else { vec![edge(-1.0), edge(1.0)] };
    // What a scale cannot show has no place on a line; the reader is told how many of those there are.
    if edges.iter().flatten().flatten().any(|v| !v.is_finite()) {
        return;
    }
    let kept: BTreeSet<usize> = edges.iter().flat_map(|edge| outline(edge, TOLERANCE)).collect();
    let whole = series.whole();
    for values in [&mut series.x, &mut series.y, &mut series.u] {
        if !values.is_empty() {
            *values = kept.iter().map(|&i| values[i]).collect();
        }
    }
    series.whole = (whole > kept.len()).then_some(whole);
}

/// Indices of the points of a line that stand for all: the ends, and wherever the line through these misses one by more
/// than `tolerance`, the one that it misses most. Coordinates are finite.
pub fn outline(at: &[[f64; 2]], tolerance: f64) -> Vec<usize> {
    if at.is_empty() {
        return Vec::new();
    }
    let mut keep = vec![false; at.len()];
    (keep[0], keep[at.len() - 1]) = (true, true);
    let mut open = vec![(0, at.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let mut farthest = (tolerance * tolerance, None);
        for i in from + 1..to {
            let square = off_square(at[i], at[from], at[to]);
            if square > farthest.0 {
                farthest = (square, Some(i));
            }
        }
        if let Some(i) = farthest.1 {
            keep[i] = true;
            open.extend([(from, i), (i, to)]);
        }
    }
    (0..at.len()).filter(|&i| keep[i]).collect()
}

/// Square of the distance of a point from the straight piece between two others.
fn off_square([px, py]: [f64; 2], [ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    let dx = bx - ax;
    let dy = by - ay;
    let rx = px - ax;
    let ry = py - ay;
    let length_square = dx * dx + dy * dy;
    let along = if length_square > 0.0 { ((rx * dx + ry * dy) / length_square).clamp(0.0, 1.0) } else { 0.0 };
    let ox = rx - along * dx;
    let oy = ry - along * dy;
    ox * ox + oy * oy
}

#[cfg(test)]
mod tests {
    use super::super::Scale;
    use super::*;

    fn plot(series: Vec<Series>) -> Plot {
        Plot { series, ..Plot::new("a", "a", Scale::linear("x", "s"), Scale::linear("y", "A")) }
    }

    fn condensed(plot: Plot) -> Series {
        let mut plots = [plot];
        condense(&mut plots);
        plots[0].series[0].clone()
    }

    fn curve(n: usize, y: impl Fn(f64) -> f64) -> Series {
        let x: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64).collect();
        let values = x.iter().map(|&x| y(x)).collect();
        Series::new("curve", Style::Line, x, values)
    }

    /// Of a condensed curve at `x`.
    fn between(s: &Series, x: f64) -> f64 {
        let i = s.x.partition_point(|v| *v < x).clamp(1, s.x.len() - 1);
        let part = (x - s.x[i - 1]) / (s.x[i] - s.x[i - 1]);
        s.y[i - 1] + part * (s.y[i] - s.y[i - 1])
    }

    #[test]
    fn a_smooth_curve_keeps_its_course_with_a_tenth_of_its_points() {
        let whole = curve(2000, |x| 3.0 * (9.0 * x).sin());
        let few = condensed(plot(vec![whole.clone()]));
        assert!(few.x.len() < 200, "{} points", few.x.len());
        assert_eq!((few.whole(), few.x[0], few.x[few.x.len() - 1]), (2000, 0.0, 1.0));
        let misses = whole.x.iter().zip(&whole.y).map(|(&x, y)| (between(&few, x) - y).abs());
        let worst = misses.fold(0.0, f64::max);
        assert!(worst < 6.0 * 9e-4, "{worst}");
        assert!(few.x.len() > 20, "a sine is no straight line");
    }

    #[test]
    fn a_spike_of_one_point_stays() {
        let few = condensed(plot(vec![curve(2001, |x| if x == 0.5 { 7.25 } else { 0.0 })]));
        assert_eq!(few.y.iter().copied().fold(0.0, f64::max), 7.25);
        assert!(few.x.len() <= 6, "{:?}", few.x);
    }

    #[test]
    fn numbers_end_at_a_hundred_thousandth_of_what_the_picture_spans() {
        let few = condensed(plot(vec![curve(500, |x| 1000.0 + 2e-3 * (7919.0 * x).sin())]));
        for y in &few.y {
            assert!(y.to_string().len() <= "1000.0012345".len(), "{y}");
        }
        let coarse = (0..few.y.len()).filter(|&i| (between(&few, few.x[i]) - few.y[i]).abs() > 2e-8).count();
        assert_eq!(coarse, 0);
        assert!(few.y.iter().any(|y| *y != few.y[0]), "an offset does not take the detail away");
    }

    #[test]
    fn measured_values_and_error_bars_of_short_series_keep_every_bit() {
        let third = Series::new("m", Style::Markers, vec![1.0 / 3.0; 100], vec![2.0 / 3.0; 100]);
        let third = third.with_u(vec![1.0 / 7.0; 100]);
        assert_eq!(condensed(plot(vec![third.clone()])), third);
    }

    #[test]
    fn markers_and_bands_lose_digits_and_no_points() {
        for style in [Style::Markers, Style::Excluded, Style::Band, Style::Bars] {
            let straight = Series { style, ..curve(300, |x| x) };
            let few = condensed(plot(vec![straight]));
            assert_eq!((few.x.len(), few.whole), (300, None));
            assert_eq!(few.x[100], 0.334_45);
        }
    }

    #[test]
    fn a_band_keeps_the_course_of_both_edges() {
        let width = curve(2000, |x| 0.2 + 0.1 * (7.0 * x).sin());
        let band = Series { style: Style::Band, ..curve(2000, |x| x) }.with_u(width.y.clone());
        let few = condensed(plot(vec![band]));
        assert!((10..200).contains(&few.x.len()) && few.u.len() == few.x.len(), "{} points", few.x.len());
        let edge = |s: &Series, u: &[f64]| Series::new("", Style::Line, s.x.clone(), u.to_vec());
        let widths = edge(&few, &few.u);
        let worst = width.x.iter().zip(&width.y).map(|(&x, u)| (between(&widths, x) - u).abs());
        assert!(worst.fold(0.0, f64::max) < 2e-3);
        let mut below_zero = plot(vec![curve(300, |x| 1.0 + x).with_u(vec![2.0; 300])]);
        (below_zero.series[0].style, below_zero.y.log) = (Style::Band, true);
        assert!(
            condensed(below_zero).x.len() < 300,
            "an edge that no scale shows is no reason to keep points"
        );
    }

    #[test]
    fn what_lies_outside_of_a_window_does_not_make_its_inside_coarse() {
        let mut far = curve(1000, |x| (20.0 * x).sin());
        far.x.iter_mut().for_each(|x| *x *= 1e6);
        far.y[0] = 1e9;
        let mut shown = plot(vec![far.clone()]);
        (shown.x_range, shown.y_range) = (Some([0.0, 1e5]), Some([-1.0, 1.0]));
        let few = condensed(shown);
        let worst = far.x.iter().zip(&far.y).skip(1).filter(|(x, _)| **x < 1e5);
        let worst = worst.map(|(&x, y)| (between(&few, x) - y).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{worst}");
    }

    #[test]
    fn logarithmic_scales_keep_their_small_numbers() {
        let mut spectrum = curve(400, |x| 1e-12 * (1.0 + x));
        spectrum.y[0] = 1e3;
        let mut shown = plot(vec![Series { style: Style::Markers, ..spectrum.clone() }]);
        shown.y.log = true;
        let few = condensed(shown);
        assert!(few.y.iter().zip(&spectrum.y).all(|(a, b)| (a / b - 1.0).abs() < 1e-4), "{:?}", few.y);
    }

    #[test]
    fn no_number_that_is_none_or_beyond_all_bounds_stops_it() {
        for bad in [f64::NAN, f64::INFINITY, 1e308, -1e308, 5e-324, 0.0] {
            let mut odd = curve(300, |x| x - 0.5);
            odd.y[7] = bad;
            for log in [false, true] {
                let mut shown = plot(vec![odd.clone()]);
                shown.y.log = log;
                let few = condensed(shown);
                assert!(few.x.len() == few.y.len() && few.whole() == 300, "{bad}");
            }
        }
    }
}
