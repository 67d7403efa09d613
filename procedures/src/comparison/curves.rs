//! Differences of curves: responses over frequency, spectra, and responses to a step.
//!
//! Where both curves have an uncertainty, a point is inside where they are no farther apart than the root of the sum of both
//! half widths squared. The points of a curve share errors, so their tails are not independent. A curve differs where one point
//! in ten does, by a rule that holds whatever the points have in common: n/k times the k-th smallest tail of n points bounds
//! the probability of so many small ones by chance (B. Rüger, Metrika 25, 171, 1978), here with k a tenth of n.

use serde::Serialize;

use super::pairing::ProcedurePair;
use super::{Call, Comparison};
use crate::trace::{Plot, Scale, Series, Style};
use crate::verdict::two_sided_tail;

/// Coverage factor of the half widths in pictures.
const COVERAGE: f64 = 2.0;
/// Share of the points that must differ before their curve does.
const SHARE_OUTSIDE: f64 = 0.1;
/// Tail of a curve below which it is near a difference.
const NEAR: f64 = 0.05;
/// Band of a curve without an uncertainty where nobody said another one.
pub(super) const BAND_RATIO: f64 = 0.05;
/// Two abscissae are the same up to this share of the larger one.
const SAME_RATIO: f64 = 1e-9;

/// How wide the band is in which two curves are the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Band {
    /// The expanded uncertainty (k = 2) of the difference, point by point.
    Uncertainty,
    /// A share: of the ordinate on a logarithmic scale and in decibels, of a radian for a phase, else of the height of the curve.
    Relative(f64),
}

/// The point of two curves that is farthest apart in half widths of the band; in the units of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstPoint {
    /// Abscissa.
    pub x: f64,
    /// Ordinate of the first run.
    pub a: f64,
    /// Ordinate of the second run.
    pub b: f64,
    /// Second ordinate less first one; of a phase the shorter way around.
    pub difference: f64,
    /// Half width of the band at this point.
    pub half_width: f64,
}

/// A curve with what both runs show of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvePair {
    /// Id of the procedure.
    pub procedure: String,
    /// Id of the picture, unique in its procedure.
    pub picture: String,
    /// Heading of the picture.
    pub title: String,
    /// Name of the curve in the picture.
    pub curve: String,
    /// Abscissa.
    pub x: Scale,
    /// Ordinate.
    pub y: Scale,
    /// Points that both curves have.
    pub points: usize,
    /// Points that only one of them has.
    pub points_alone: usize,
    /// The band.
    pub band: Band,
    /// Points inside the band.
    pub inside: usize,
    /// The farthest point; `None` where they share no point.
    pub worst: Option<WorstPoint>,
    /// Probability of such a difference by chance; `None` without an uncertainty.
    pub p: Option<f64>,
    /// The same among all that is compared (Holm).
    pub p_family: Option<f64>,
    /// What the comparison says.
    pub call: Call,
}

/// A curve of a picture, by ascending abscissa; half widths where all of its pieces have them.
#[derive(PartialEq)]
struct Curve<'a> {
    label: &'a str,
    style: Style,
    points: Vec<Point>,
}

#[derive(Clone, Copy, PartialEq)]
struct Point {
    x: f64,
    y: f64,
    half_width: Option<f64>,
}

/// Two ordinates at one abscissa, and how far apart they may be.
struct Compared {
    x: f64,
    a: f64,
    b: f64,
    difference: f64,
    half_width: f64,
}

/// Adds the curves of a procedure.
pub(super) fn add(comparison: &mut Comparison, pair: &ProcedurePair<'_>, tolerance: Option<f64>) {
    let matching = |plot: &Plot| pair.b.plots.iter().find(|other| other.id == plot.id);
    for plot in pair.a.plots.iter().filter(|plot| is_compared(plot)) {
        let a = curves(plot);
        let b = matching(plot).map(curves).unwrap_or_default();
        let partners = partners(&a, &b);
        let paired = partners.iter().flatten().count();
        comparison.curves_alone += a.len() + b.len() - 2 * paired;
        for (own, k) in a.iter().zip(partners) {
            let Some(k) = k else { continue };
            comparison.curves.push(compared(pair.a.procedure, plot, own, &b[k], tolerance));
        }
    }
    let alone = |plot: &&Plot| is_compared(plot) && pair.a.plots.iter().all(|own| own.id != plot.id);
    comparison.curves_alone +=
        pair.b.plots.iter().filter(alone).map(|plot| curves(plot).len()).sum::<usize>();
}

/// Whether a picture shows properties of the unit over an abscissa that another run has, too: no course of one record, which
/// noise makes another one each time.
fn is_compared(plot: &Plot) -> bool {
    let over_frequency = plot.x.log && plot.x.label == "frequency" && !plot.y.label.starts_with("coherence");
    let step = plot.x.label == "time since the step" && plot.panel_of.is_none();
    (over_frequency || step) && plot.rows.is_empty()
}

/// The measured curves of a picture; pieces of one curve are put together.
fn curves(plot: &Plot) -> Vec<Curve<'_>> {
    let mut all: Vec<Curve<'_>> = Vec::new();
    let measured = |s: &&Series| matches!(s.style, Style::Line | Style::Markers | Style::Bars);
    for series in plot.series.iter().filter(measured) {
        let points = points(series, half_widths(plot, series));
        match all.iter_mut().find(|curve| curve.label == series.label && curve.style == series.style) {
            Some(curve) => curve.points.extend(points),
            None => all.push(Curve { label: &series.label, style: series.style, points }),
        }
    }
    for curve in &mut all {
        curve.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    all
}

/// Half widths of a series: its own, or those of the band around the same points.
fn half_widths<'a>(plot: &'a Plot, series: &'a Series) -> Option<&'a [f64]> {
    if series.u.len() == series.x.len() {
        return Some(&series.u);
    }
    let around = |s: &&Series| s.style == Style::Band && s.x == series.x && s.y == series.y;
    let band = plot.series.iter().find(around)?;
    (band.u.len() == band.x.len()).then_some(&band.u)
}

fn points(series: &Series, half_widths: Option<&[f64]>) -> Vec<Point> {
    let both = series.x.iter().zip(&series.y).enumerate();
    let point = |(k, (&x, &y))| Point { x, y, half_width: half_widths.map(|all: &[f64]| all[k]) };
    both.map(point).filter(|p| p.x.is_finite() && p.y.is_finite()).collect()
}

/// For each curve of one picture the one of the other by its name. What is left over goes by its order where there are as many.
fn partners(a: &[Curve<'_>], b: &[Curve<'_>]) -> Vec<Option<usize>> {
    let mut partners: Vec<Option<usize>> = a
        .iter()
        .map(|own| b.iter().position(|other| other.label == own.label && other.style == own.style))
        .collect();
    let left: Vec<usize> = (0..b.len()).filter(|k| !partners.contains(&Some(*k))).collect();
    let open = partners.iter().filter(|k| k.is_none()).count();
    if open == left.len() {
        let mut left = left.into_iter();
        partners.iter_mut().filter(|k| k.is_none()).for_each(|k| *k = left.next());
    }
    partners
}

fn compared(procedure: &str, plot: &Plot, a: &Curve<'_>, b: &Curve<'_>, tolerance: Option<f64>) -> CurvePair {
    let has_u = |curve: &Curve<'_>| curve.points.iter().all(|p| p.half_width.is_some());
    let band = if has_u(a) && has_u(b) {
        Band::Uncertainty
    } else {
        Band::Relative(tolerance.unwrap_or(BAND_RATIO))
    };
    let height = height(a).max(height(b));
    let shared: Vec<Compared> =
        shared(plot, a, b).into_iter().map(|pair| within(plot, band, height, pair)).collect();
    let inside = shared.iter().filter(|c| c.is_inside()).count();
    let worst = shared.iter().max_by(|c, d| c.in_half_widths().total_cmp(&d.in_half_widths()));
    let p = (band == Band::Uncertainty && !shared.is_empty()).then(|| tail(&shared));
    let few_inside = (inside as f64) < (1.0 - SHARE_OUTSIDE) * shared.len() as f64;
    let call = match (p, tolerance) {
        _ if a.points == b.points => Call::Identical,
        (Some(p), _) if p <= NEAR => Call::Near,
        (Some(_), _) => Call::Same,
        (None, None) => Call::NotJudged,
        (None, Some(_)) if few_inside => Call::Differs,
        (None, Some(_)) => Call::Same,
    };
    CurvePair {
        procedure: procedure.to_owned(),
        picture: plot.id.clone(),
        title: plot.title.clone(),
        curve: a.label.to_owned(),
        x: plot.x.clone(),
        y: plot.y.clone(),
        points: shared.len(),
        points_alone: (a.points.len() + b.points.len()).saturating_sub(2 * shared.len()),
        band,
        inside,
        worst: worst.map(Compared::point),
        p,
        p_family: None,
        call,
    }
}

/// Points of both curves: at the same abscissae on a logarithmic scale, whose points are lines of an excitation; on a linear
/// one the second curve is interpolated at the abscissae of the first.
fn shared(plot: &Plot, a: &Curve<'_>, b: &Curve<'_>) -> Vec<[Point; 2]> {
    let other = |own: &Point| {
        if plot.x.log { same_abscissa(&b.points, own.x) } else { interpolated(&b.points, own.x) }
    };
    a.points.iter().filter_map(|own| Some([*own, other(own)?])).collect()
}

fn same_abscissa(points: &[Point], x: f64) -> Option<Point> {
    let from = points.partition_point(|p| p.x < x * (1.0 - SAME_RATIO));
    points.get(from).filter(|p| p.x <= x * (1.0 + SAME_RATIO)).copied()
}

fn interpolated(points: &[Point], x: f64) -> Option<Point> {
    let after = points.partition_point(|p| p.x < x);
    let next = points.get(after)?;
    if next.x == x {
        return Some(*next);
    }
    let last = points[..after].last()?;
    let part = (x - last.x) / (next.x - last.x);
    let half_width = last.half_width.zip(next.half_width).map(|(a, b)| a.max(b));
    Some(Point { x, y: last.y + part * (next.y - last.y), half_width })
}

fn height(curve: &Curve<'_>) -> f64 {
    let ordinates = || curve.points.iter().map(|p| p.y);
    (ordinates().fold(f64::NEG_INFINITY, f64::max) - ordinates().fold(f64::INFINITY, f64::min)).max(0.0)
}

fn within(plot: &Plot, band: Band, height: f64, [a, b]: [Point; 2]) -> Compared {
    let apart = b.y - a.y;
    let is_phase = plot.y.unit == "deg";
    let difference = if is_phase { apart - 360.0 * (apart / 360.0).round() } else { apart };
    let half_width = match band {
        Band::Uncertainty => a.half_width.unwrap_or(0.0).hypot(b.half_width.unwrap_or(0.0)),
        Band::Relative(ratio) if plot.y.unit == "dB" => 20.0 * (1.0 + ratio).log10(),
        Band::Relative(ratio) if is_phase => ratio.to_degrees(),
        Band::Relative(ratio) if plot.y.log => ratio * a.y.abs().max(b.y.abs()),
        Band::Relative(ratio) => ratio * height,
    };
    Compared { x: a.x, a: a.y, b: b.y, difference, half_width }
}

impl Compared {
    fn is_inside(&self) -> bool {
        self.difference.abs() <= self.half_width
    }

    fn in_half_widths(&self) -> f64 {
        if self.difference == 0.0 { 0.0 } else { self.difference.abs() / self.half_width }
    }

    fn point(&self) -> WorstPoint {
        let Self { x, a, b, difference, half_width } = *self;
        WorstPoint { x, a, b, difference, half_width }
    }
}

/// Bound of the probability that a tenth of the points is so far apart by chance.
fn tail(shared: &[Compared]) -> f64 {
    let mut tails: Vec<f64> =
        shared.iter().map(|c| two_sided_tail(COVERAGE * c.in_half_widths(), None)).collect();
    tails.sort_by(f64::total_cmp);
    let n = tails.len() as f64;
    let k = (SHARE_OUTSIDE * n).ceil().max(1.0);
    (n / k * tails[k as usize - 1]).min(1.0)
}
