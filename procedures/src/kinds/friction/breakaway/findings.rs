//! What every conclusion of the kind rests on: points with their plan, the load near the pose, pictures.

use std::fmt::Display;

use analysis::breakaway::{FROM_ONSET, Peak};
use analysis::dwell::{DwellLaw, Repeats};
use analysis::estimate::Estimate;
use analysis::load_map::LoadMap;
use analysis::multisine::Presliding;
use analysis::uncertainty::Component;

use super::plan::STROKE;
use super::point::{BreakawayPoint, TimeSpan};
use super::{Direction, Keys};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::measurement::{Conclusion, Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};
use crate::trace::{MAX_POINTS, Mark, Plot, Scale, Series, Style};

/// Points of a ramp: there are hundreds of them.
const RAMP_POINTS: usize = MAX_POINTS / 2;

/// What concluding rests on.
pub(super) struct Findings<'a> {
    pub(super) keys: &'a Keys,
    axis: &'a str,
    pub(super) limits: &'a AxisLimits,
    cases: &'a [Case],
    points: &'a [PointResult],
    /// Load near the pose, or why it is not known.
    pub(super) map: Result<LoadMap, Reason>,
}

fn load_map(cases: &[Case], points: &[PointResult], limits: &AxisLimits) -> Result<LoadMap, Reason> {
    let place = cases.iter().position(|case| has_segment(case, STROKE)).ok_or(FrictionReason::NoStroke)?;
    let result = points.get(place).ok_or(FrictionReason::StrokeNotRun)?;
    if let Some(reason) = &result.inconclusive {
        return Err(FrictionReason::NoMap { reason: Box::new(reason.clone()) }.into());
    }
    let stroke = result.reduced.get::<BreakawayPoint>().and_then(|point| point.stroke.as_ref());
    let map = stroke
        .and_then(|stroke| {
            let orders_per_rev = limits.cogging_orders_per_rev;
            LoadMap::new(&stroke.position_rad, &stroke.velocity_rad_per_s, &stroke.effort_nm, orders_per_rev)
        })
        .ok_or(FrictionReason::StrokeTooShort)?;
    let described = map.goodness.check();
    described.map_err(|hopeless| FrictionReason::NoMap { reason: Box::new(hopeless.into()) })?;
    Ok(map)
}

/// Whether a case has a segment of this label.
fn has_segment(case: &Case, label: &str) -> bool {
    case.segments.iter().any(|s| s.label == label)
}

/// A point with its plan.
#[derive(Clone, Copy)]
pub(super) struct Planned<'a> {
    pub(super) case: &'a Case,
    result: &'a PointResult,
}

impl<'a> Planned<'a> {
    /// What the point was reduced to.
    ///
    /// # Errors
    /// Why the point gives nothing.
    pub(super) fn reduced(&self) -> Result<&'a BreakawayPoint, Reason> {
        match &self.result.inconclusive {
            Some(reason) => Err(reason.clone()),
            None => self.result.reduced.get().ok_or_else(|| FrictionReason::NothingReduced.into()),
        }
    }
}

impl<'a> Findings<'a> {
    /// Points with their plan, and the load near the pose that their stroke shows.
    pub(super) fn new(
        keys: &'a Keys,
        axis: &'a str,
        limits: &'a AxisLimits,
        cases: &'a [Case],
        points: &'a [PointResult],
    ) -> Self {
        Self { keys, axis, limits, cases, points, map: load_map(cases, points, limits) }
    }

    /// All points with their plan.
    pub(super) fn planned(&self) -> impl Iterator<Item = Planned<'a>> {
        self.cases.iter().zip(self.points).map(|(case, result)| Planned { case, result })
    }

    /// The points whose case has a segment of this label.
    pub(super) fn having(&self, label: &str) -> impl Iterator<Item = Planned<'a>> {
        self.planned().filter(move |planned| has_segment(planned.case, label))
    }

    pub(super) fn remark_on_map(&self, conclusion: &mut Conclusion) {
        match &self.map {
            Ok(map) => conclusion.remarks.push(format!(
                "Load near the pose, from the slow stroke: cogging {:.2} N·m; the fitted load map deviates \
                 from the half sum by {:.3} N·m rms{}.",
                map.cogging_amplitude_nm(),
                map.misfit_nm,
                map.goodness.flag().map(|flag| format!(" ({flag})")).unwrap_or_default()
            )),
            Err(reason) if self.keys.map.is_some() => conclusion.remarks.push(reason.to_string()),
            Err(_) => {}
        }
    }

    /// Torque constant's share of the uncertainty of a torque, or of a value in units of torque that was told from torques
    /// below breakaway.
    pub(super) fn torque_constant(&self, value: f64) -> Component {
        let largest_nm = self.limits.expected_static_friction_nm;
        self.limits.torque_scale().share(value, largest_nm)
    }

    /// The drive's torque quantum as a rectangular distribution.
    pub(super) fn quantum(&self) -> Component {
        Component::known(self.limits.torque_ratio() * self.limits.torque_quantum_nm / 12.0_f64.sqrt())
    }

    /// A measurement of this axis.
    pub(super) fn measurement(
        &self,
        measurand: &str,
        kind: Q,
        value: f64,
        spread: Component,
        n: usize,
        id: &str,
    ) -> Measurement {
        let estimate = Estimate { value, u: spread.u, dof: spread.dof, n };
        Measurement::new(measurand, self.axis, kind, Some(estimate), id)
    }

    /// A measurement of this axis that has no value, and why.
    pub(super) fn none(&self, measurand: &str, kind: Q, id: &str, reason: impl Display) -> Measurement {
        Measurement::inconclusive(measurand, self.axis, kind, id, reason)
    }

    /// Where in the log a number comes from.
    pub(super) fn evidence(&self, span: TimeSpan) -> Evidence {
        let channels = ["position_rad", "current_a"].map(|c| format!("/{} {c}", self.axis)).to_vec();
        Evidence { file: String::new(), channels, t0_s: span.start_s, t1_s: span.end_s }
    }
}

/// A condition that was asked for, and what was reached.
pub(super) fn condition(case: &Case, name: &str, achieved: Option<f64>) -> Option<Condition> {
    let request = case.requested.iter().find(|r| r.name == name)?;
    Some(Condition { name: name.to_owned(), requested: request.value, achieved, kind: request.kind })
}

pub(super) fn scale(label: &str, unit: &str, log: bool) -> Scale {
    Scale { label: label.to_owned(), unit: unit.to_owned(), log }
}

pub(super) fn series(label: &str, style: Style, x: Vec<f64>, y: Vec<f64>, u: Vec<f64>) -> Series {
    Series::new(label, style, x, y).with_u(u)
}

pub(super) fn plot(id: String, title: String, x: Scale, y: Scale, series: Vec<Series>) -> Plot {
    Plot { series, ..Plot::new(id, title, x, y) }
}

/// A name without spaces and signs.
fn slug(text: &str) -> String {
    let mut slug = String::new();
    for c in text.chars() {
        match c {
            '+' => slug.push_str("plus"),
            '-' if slug.ends_with('-') => slug.push_str("minus"),
            c if c.is_ascii_alphanumeric() => slug.push(c.to_ascii_lowercase()),
            _ if !slug.ends_with('-') => slug.push('-'),
            _ => {}
        }
    }
    slug.trim_matches('-').to_owned()
}

/// Torque over displacement, the stretch that is judged, where the contact has given way, and the maximum.
pub(super) fn ramp_plot(case: &Case, x_rad: &[f64], effort_nm: &[f64], peak: &Peak, z_ss_rad: f64) -> Plot {
    let millirad: Vec<f64> = x_rad.iter().map(|x| 1e3 * x).collect();
    let effort = [&millirad[..], effort_nm];
    let ramp = Series::thinned("torque less inertia and load", Style::Line, effort, RAMP_POINTS);
    let [low, high] = FROM_ONSET.judged;
    let inside = |x: &f64| (low * z_ss_rad..=high * z_ss_rad).contains(&(1e-3 * x));
    let points = ramp.x.iter().copied().zip(ramp.y.iter().copied());
    let (judged_x, judged_y) = points.filter(|(x, _)| inside(x)).unzip();
    let breakaway_u = vec![2.0 * peak.u_nm];
    let mut plot = plot(
        slug(&case.point),
        format!("Torque ramp: {}", case.point),
        scale("displacement", "mrad", false),
        scale("friction torque", "N*m", false),
        vec![
            ramp,
            series("0.5 … 8 z_ss", Style::Line, judged_x, judged_y, Vec::new()),
            series("breakaway", Style::Markers, vec![1e3 * peak.at_rad], vec![peak.torque_nm], breakaway_u),
        ],
    );
    plot.marks = vec![Mark { label: "3 z_ss".to_owned(), x: 1e3 * x_rad[peak.given_way] }];
    plot.limits_of = Some("breakaway-torque".to_owned());
    plot
}

/// Breakaway torque over time at rest, with the law.
pub(super) fn dwell_plot(rate: f64, groups: &[Repeats], law: &DwellLaw) -> Plot {
    let mut all = Vec::new();
    for direction in Direction::BOTH {
        let label = format!("{} direction", direction.word());
        let own = || groups.iter().filter(|g| g.direction_ratio == direction.ratio());
        let x: Vec<f64> = own().flat_map(|g| g.rest_s.iter().copied()).collect();
        let y: Vec<f64> = own().flat_map(|g| g.torque_nm.iter().copied()).collect();
        let u = vec![2.0 * law.repeatability_nm; x.len()];
        if !x.is_empty() {
            all.push(series(&label, Style::Markers, x, y, u));
        }
    }
    let times = || groups.iter().flat_map(|g| g.rest_s.iter().copied());
    let low = times().fold(f64::INFINITY, f64::min).max(1e-3);
    let high = times().fold(low, f64::max);
    let x: Vec<f64> = (0..=100).map(|k| low * (high / low).powf(f64::from(k) / 100.0)).collect();
    let y = x.iter().map(|t| law.at(*t)).collect();
    all.push(series("T0 + slope·ln(1 + t/τ)", Style::Fit, x, y, Vec::new()));
    let mut plot = plot(
        slug(&format!("dwell-{rate} A/s")),
        format!("Breakaway over time at rest, {rate} A/s"),
        scale("time at rest", "s", true),
        scale("breakaway torque", "N*m", false),
        all,
    );
    plot.limits_of = Some("breakaway-torque".to_owned());
    plot
}

/// Magnitude of friction torque over displacement, with the model.
pub(super) fn presliding_plot(found: &Presliding) -> Plot {
    let x: Vec<f64> = found.lines.iter().map(|l| l.frequency_hz).collect();
    let magnitude = found.lines.iter().map(|l| l.stiffness.norm()).collect();
    let model = found.lines.iter().map(|l| l.model.norm()).collect();
    let u = found.lines.iter().map(|l| 2.0 * l.u).collect();
    plot(
        "presliding-response".to_owned(),
        "Presliding: friction torque over displacement, magnitude".to_owned(),
        scale("frequency", "Hz", true),
        scale("dynamic stiffness", "N*m/rad", true),
        vec![
            series("measured lines", Style::Markers, x.clone(), magnitude, u),
            series("(σ0 + jω(σ1 + σ2))·Z/X", Style::Fit, x, model, Vec::new()),
        ],
    )
}
