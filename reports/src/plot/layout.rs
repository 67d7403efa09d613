//! Where everything of a figure lies: panels with their scales.

use procedures::trace::{LimitCurve, Plot, Side, Style};

use super::axis::{Axis, Kind, range};
use super::figure::Figure;
use super::look::{Look, looks};
use super::mask;
use super::text::text_width;
use super::{FOOT, RIGHT, TOP};

/// Left edge of the data area; farther right where tick labels need it.
pub(super) const LEFT: f64 = 62.0;
/// Height of the data area of a picture alone, of the first of several panels, of the others, and of a plane.
const HEIGHT: f64 = 236.0;
const FIRST_HEIGHT: f64 = 210.0;
const NEXT_HEIGHT: f64 = 140.0;
const PLANE_HEIGHT: f64 = 430.0;
/// Height of a row of a list.
const LIST_ROW: f64 = 23.0;
/// Between two panels.
const GAP: f64 = 14.0;
/// Room left of the tick labels: the label of the ordinate.
const MARGIN: f64 = 22.0;
/// Paper between two major ticks of an ordinate and of an abscissa.
const ROW: f64 = 45.0;
const COLUMNS: usize = 9;

/// Part of an ordinate that a mask leaves free on its forbidden side.
const MASK_AIR: f64 = 0.12;

/// Data area on the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// One panel: what is drawn, how it looks, and where.
#[derive(Clone, Debug)]
pub(super) struct Panel<'a> {
    pub(super) plot: &'a Plot,
    pub(super) looks: Vec<Look>,
    pub(super) area: Area,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl Panel<'_> {
    /// Place of a point; `None` if one of the scales cannot show it.
    pub(super) fn place(&self, point: (f64, f64)) -> Option<(f64, f64)> {
        Some((self.x.place(point.0)?, self.y.place(point.1)?))
    }

    /// Whether the picture shows a stretch that was asked for, beyond which drawings are cut off.
    pub(super) fn is_window(&self) -> bool {
        let asked = |range: Option<[f64; 2]>, axis: &Axis| range == Some(axis.range);
        asked(self.plot.y_range, &self.y) || self.plot.x_range.is_some() || self.plot.panel_of.is_some()
    }

    /// How many points, and ends of their error bars, lie in a box of the paper: left, top, right, bottom.
    pub(super) fn crowd(&self, [left, top, right, bottom]: [f64; 4]) -> usize {
        let inside = |x: f64, y: f64| (left..=right).contains(&x) && (top..=bottom).contains(&y);
        let mut count = 0;
        for s in self.plot.series.iter() {
            for (i, (&a, &b)) in s.x.iter().zip(&s.y).enumerate() {
                let Some((px, py)) = self.place((a, b)) else { continue };
                let u = s.u.get(i).copied().unwrap_or(0.0);
                let ends = [py, self.y.clamped(b - u), self.y.clamped(b + u)];
                count += ends.into_iter().filter(|y| inside(px, *y)).count();
            }
        }
        count
    }

    /// Points that the scales cannot show (zero or negative on a logarithmic one), and those beyond the window.
    pub(super) fn missing(&self) -> [usize; 2] {
        let mut hidden = 0;
        let mut outside = 0;
        for s in &self.plot.series {
            for (&a, &b) in s.x.iter().zip(&s.y) {
                let nothing = s.style == Style::Histogram && b == 0.0;
                match self.place((a, b)) {
                    None if !nothing => hidden += 1,
                    Some(_) if !self.x.shows(a) || !self.y.shows(b) => outside += 1,
                    _ => {}
                }
            }
        }
        [hidden, outside]
    }
}

/// All panels of a figure, from top to bottom.
pub(super) fn panels<'a>(figure: &Figure<'a>) -> Vec<Panel<'a>> {
    let head = figure.head();
    let plots = figure.panels();
    let x_range = range(abscissae(plots).into_iter(), head.x.log, head.x_range);
    let mut top = TOP;
    let mut rows: Vec<(Area, Axis)> = Vec::new();
    for (i, plot) in plots.iter().enumerate() {
        let bottom = top + height(plots, i);
        rows.push((
            Area { left: LEFT, right: RIGHT, top, bottom },
            ordinate(plot, x_range, head.x.log, [top, bottom]),
        ));
        top = bottom + GAP;
    }
    let widest = rows.iter().map(|(_, y)| label_width(y)).fold(0.0, f64::max);
    let left = LEFT.max(MARGIN + widest + 6.0);
    let x = Axis::new(x_range, Kind::of(&head.x), [left, RIGHT], COLUMNS);
    plots
        .iter()
        .zip(rows)
        .zip(looks(plots))
        .map(|((plot, (area, y)), looks)| {
            let panel = Panel { plot, looks, area: Area { left, ..area }, x: x.clone(), y };
            if is_plane(plots) { with_equal_units(panel) } else { panel }
        })
        .collect()
}

/// The scale of the ordinate of a panel.
fn ordinate(plot: &Plot, x_range: [f64; 2], log_x: bool, [top, bottom]: [f64; 2]) -> Axis {
    if !plot.rows.is_empty() {
        return Axis::rows(&plot.rows, [top, bottom]);
    }
    let y_range = range(ordinates(plot, x_range, log_x).into_iter(), plot.y.log, plot.y_range);
    let count = ((bottom - top) / ROW).round() as usize;
    Axis::new(y_range, Kind::of(&plot.y), [bottom, top], count)
}

/// Below the last panel with its tick labels and the label of the abscissa.
pub(super) fn foot(panels: &[Panel<'_>]) -> f64 {
    panels.last().map_or(TOP, |p| p.area.bottom) + FOOT
}

fn is_plane(plots: &[&Plot]) -> bool {
    plots.len() == 1 && plots[0].equal && plots[0].rows.is_empty() && !plots[0].x.log && !plots[0].y.log
}

fn height(plots: &[&Plot], index: usize) -> f64 {
    match (plots.len(), index) {
        _ if !plots[index].rows.is_empty() => LIST_ROW * (plots[index].rows.len() + 1) as f64,
        (1, _) if is_plane(plots) => PLANE_HEIGHT,
        (1, _) => HEIGHT,
        (_, 0) => FIRST_HEIGHT,
        _ => NEXT_HEIGHT,
    }
}

/// Widens one of the ranges until units are equally long.
fn with_equal_units(panel: Panel<'_>) -> Panel<'_> {
    let Area { left, right, top, bottom } = panel.area;
    let per_unit = |axis: &Axis, paper: f64| paper / (axis.range[1] - axis.range[0]);
    let scale = per_unit(&panel.x, right - left).min(per_unit(&panel.y, bottom - top));
    let around = |[low, high]: [f64; 2], paper: f64| {
        let middle = 0.5 * low + 0.5 * high;
        let half = 0.5 * paper / scale;
        [middle - half, middle + half]
    };
    let x = around(panel.x.range, right - left);
    let y = around(panel.y.range, bottom - top);
    let count = ((bottom - top) / (right - left) * COLUMNS as f64).round() as usize;
    Panel {
        x: Axis::new(x, Kind::of(&panel.plot.x), [left, right], COLUMNS),
        y: Axis::new(y, Kind::of(&panel.plot.y), [bottom, top], count),
        ..panel
    }
}

/// What the abscissa has to show: points with what is wide, marks, circles, names; masks where there is nothing else.
fn abscissae(plots: &[&Plot]) -> Vec<f64> {
    let mut all = Vec::new();
    for plot in plots {
        for s in &plot.series {
            let wide = matches!(s.style, Style::Histogram | Style::Circles);
            all.extend((s.style == Style::Bars && !plot.rows.is_empty()).then_some(0.0));
            for (i, &x) in s.x.iter().enumerate() {
                let u = s.u.get(i).copied().filter(|_| wide).unwrap_or(0.0);
                all.extend([x, x - u, x + u]);
            }
        }
        all.extend(plot.marks.iter().map(|m| m.x));
        all.extend(plot.circles.iter().flat_map(|c| [c.centre[0] - c.radius, c.centre[0] + c.radius]));
        all.extend(plot.notes.iter().map(|n| n.at[0]));
    }
    if all.is_empty() {
        all.extend(plots.iter().flat_map(|p| &p.masks).flat_map(|m| &m.points).map(|p| p[0]));
    }
    all
}

/// What the ordinate has to show, including limits, and masks as far as they reach over the abscissa.
fn ordinates(plot: &Plot, x_range: [f64; 2], log_x: bool) -> Vec<f64> {
    let mut all: Vec<f64> = plot.limits.iter().map(|l| l.y).collect();
    for s in &plot.series {
        for (i, &y) in s.y.iter().enumerate() {
            let u = s.u.get(i).copied().filter(|_| s.style != Style::Histogram).unwrap_or(0.0);
            all.extend([y, y - u, y + u]);
        }
        if matches!(s.style, Style::Bars | Style::Histogram) {
            all.push(0.0);
        }
    }
    all.extend(plot.circles.iter().flat_map(|c| [c.centre[1] - c.radius, c.centre[1] + c.radius]));
    all.extend(plot.notes.iter().map(|n| n.at[1]));
    let masks = plot.masks.iter().flat_map(|m| mask::within(&m.points, x_range, [log_x, plot.y.log]));
    all.extend(masks.map(|p| p[1]));
    let room = mask_room(plot, &all);
    all.extend(room);
    all
}

/// Room for hatching and label where a mask would lie at the edge of the picture.
fn mask_room(plot: &Plot, values: &[f64]) -> Vec<f64> {
    let shown = values.iter().copied().filter(|v| v.is_finite() && (!plot.y.log || *v > 0.0));
    let map = |v: f64| if plot.y.log { v.ln() } else { v };
    let back = |v: f64| if plot.y.log { v.exp() } else { v };
    let (low, high) = shown.map(map).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if plot.masks.is_empty() || low >= high {
        return Vec::new();
    }
    let air = MASK_AIR * (high - low);
    let edge = |mask: &LimitCurve| {
        let at: Vec<f64> = mask.points.iter().map(|p| map(p[1])).collect();
        match mask.forbidden {
            Side::Above => at.iter().any(|v| *v > high - air).then_some(high + air),
            Side::Below => at.iter().any(|v| *v < low + air).then_some(low - air),
        }
    };
    plot.masks.iter().filter_map(edge).map(back).collect()
}

/// Width of the widest label of a tick.
fn label_width(axis: &Axis) -> f64 {
    axis.ticks
        .iter()
        .filter_map(|t| t.label.as_ref())
        .map(|l| text_width(&l.text()) * 0.9)
        .fold(0.0, f64::max)
}
