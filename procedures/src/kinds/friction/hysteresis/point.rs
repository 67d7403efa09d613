//! One point: friction with its pedigree, and what `conclude` needs of half-sum and cogging.
//!
//! A point that ran is read from its strokes (`strokes.rs`), an imported one from its branches (`static_map.rs`).

use std::borrow::Cow;
use std::f64::consts::PI;
use std::ops::Range;

use analysis::cogging::{Beside, Spectrum};
use analysis::estimate::Estimate;
use analysis::even_rows::EvenRows;
use analysis::gravity::HalfSum;
use analysis::uncertainty::{Component, combine};

use super::{FRICTION, FRICTION_CURRENT, evenness, pictures, static_map, strokes, sweep};
use crate::axis::{Axes, AxisLimits, TorqueScale};
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Condition, Evidence, Exclusion, Measurement, PointResult, Reduced};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};

/// Estimator and version of friction.
const ESTIMATOR: &str = "hysteresis-friction/3";

/// What a point whose friction stands leaves for `conclude`: both directions slid, or only one was recorded.
///
/// Efforts are torques in N·m, or currents in A where no torque constant is known; `kind` says which.
#[derive(Debug)]
pub(super) struct SlidingPoint {
    /// Name of the point.
    pub(super) name: String,
    pub(super) kind: Q,
    /// Mean speed that was reached.
    pub(super) achieved_rad_per_s: Option<f64>,
    /// `None` where only one direction was recorded.
    pub(super) friction: Option<Friction>,
    /// How well torques are known: all points share it.
    pub(super) scale: TorqueScale,
    /// Standard uncertainty that the drive's quantum leaves in a mean effort.
    pub(super) quantum_u: f64,
    /// Half the sum of the means of both directions, of a static map.
    pub(super) offset: Option<f64>,
    /// Half-sum of both directions by cogging period, where both had settled.
    pub(super) half_sum: HalfSum,
    /// Periods that are left out of it because they had not.
    pub(super) unsettled_count: usize,
    /// Growth of friction with the angle, per radian.
    pub(super) friction_slope_per_rad: f64,
    /// By how much the heat sink warmed up or cooled down on a radian of a stroke, a magnitude; 0 where the log does not hold it.
    pub(super) kelvin_per_rad: f64,
    /// `None` where periods, bins or bandwidth do not suffice for a spectrum.
    pub(super) cogging: Option<Cogging>,
    pub(super) conditions: Vec<Condition>,
    pub(super) evidence: Vec<Evidence>,
}

impl SlidingPoint {
    /// Friction of the point; 0 where only one direction was recorded.
    pub(super) fn friction_nm(&self) -> f64 {
        self.friction.map_or(0.0, |friction| friction.effort)
    }
}

/// Friction of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction {
    pub(super) effort: f64,
    /// Standard uncertainty without what all points share.
    pub(super) own_u: f64,
}

/// Cogging of a point.
#[derive(Debug)]
pub(super) struct Cogging {
    pub(super) spectrum: Spectrum,
    /// What the rate has at each of its harmonics, rad/s; empty for a static map.
    pub(super) rate_lines_rad_per_s: Vec<Beside>,
    /// Whether the spectrum is that of a static map.
    pub(super) static_map: bool,
    /// Largest relative error of J·α at the cogging order.
    pub(super) gain_error_ratio: f64,
    /// Points of both directions that the spectrum rests on.
    pub(super) points_count: usize,
    /// Whether friction is larger at a spot of the strokes.
    pub(super) has_spot: bool,
}

impl SlidingPoint {
    /// The requested value of a condition.
    pub(super) fn requested(&self, name: &str) -> Option<f64> {
        self.conditions.iter().find(|c| c.name == name).map(|c| c.requested)
    }
}

/// What the rows of one point say, in torque or current.
#[derive(Debug, Default)]
pub(super) struct Finding {
    pub(super) achieved_rad_per_s: Option<f64>,
    /// Type A only.
    pub(super) friction: Option<Estimate>,
    /// Why there is no friction.
    pub(super) trouble: Option<Reason>,
    pub(super) half_sum: HalfSum,
    /// Periods at the low and at the high end of the half-sum that do not count for unbalance and spring.
    pub(super) unsettled_counts: [usize; 2],
    pub(super) spectrum: Option<Spectrum>,
    /// See [`Cogging::rate_lines_rad_per_s`].
    pub(super) rate_lines_rad_per_s: Vec<Beside>,
    /// Whether the spectrum is that of a static map.
    pub(super) static_map: bool,
    /// Whether only one direction was recorded.
    pub(super) one_sided: bool,
    /// Standard uncertainty that the drive's quantum leaves in a mean effort.
    pub(super) quantum_u: f64,
    /// Largest relative error of J·α at the cogging order.
    pub(super) gain_error_ratio: f64,
    /// See [`SlidingPoint::kelvin_per_rad`].
    pub(super) kelvin_per_rad: f64,
    /// Half the sum of the means of both directions.
    pub(super) offset: Option<f64>,
    pub(super) forward: EffortCurve,
    pub(super) reverse: EffortCurve,
    pub(super) excluded: Vec<Exclusion>,
    pub(super) flags: Vec<String>,
    pub(super) evidence: Vec<Evidence>,
}

/// Effort over angle in one direction; empty where the direction was not recorded.
#[derive(Clone, Debug, Default)]
pub(super) struct EffortCurve {
    pub(super) angle_rad: Vec<f64>,
    /// Torque in N·m, or current in A.
    pub(super) effort: Vec<f64>,
}

/// Analyses one point.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    let Some(limits) = axes.get(&case.axis) else {
        result.inconclusive = Some(FrictionReason::NoAxis { axis: case.axis.clone() }.into());
        return result;
    };
    let record = match Record::new(&case.axis, window, limits) {
        Ok(record) => record,
        Err(reason) => {
            let mut none = Measurement::inconclusive(FRICTION, &case.axis, Q::Torque, ESTIMATOR, &reason);
            none.point = Some(case.point.clone());
            none.conditions = conditions(case, None);
            result.measurements.push(none);
            result.inconclusive = Some(reason);
            return result;
        }
    };
    let finding = if case.segments.iter().any(|s| s.label == sweep::STROKES) {
        strokes::find(case, window, &record, limits)
    } else {
        static_map::find(case, window, &record, limits)
    };
    let friction = friction(case, &record, &finding);
    result.excluded.clone_from(&finding.excluded);
    result.plots.extend(pictures::hysteresis_loop(case, record.kind, &finding));
    let evenness = evenness::measure(&finding, &friction, record.torque_scale);
    if finding.friction.is_some() || finding.one_sided {
        result.reduced = Reduced::to(sliding_point(case, &record, finding, &friction));
    } else {
        result.inconclusive = finding.trouble;
    }
    result.measurements.push(friction);
    result.measurements.extend(evenness);
    result
}

/// What the point leaves for `conclude`.
fn sliding_point(case: &Case, record: &Record<'_>, finding: Finding, friction: &Measurement) -> SlidingPoint {
    let own = |estimate: &Estimate| Friction {
        effort: estimate.value,
        own_u: own_spread(finding.quantum_u, estimate).u,
    };
    let [low, high] = finding.unsettled_counts;
    let settled = low..finding.half_sum.torque_nm.len() - high;
    let points_count = finding.forward.effort.len() + finding.reverse.effort.len();
    let periods = evenness::Periods::new(&finding);
    let has_spot = periods.has_spot(&finding);
    let friction_slope_per_rad = periods.slope_per_rad(&finding);
    let cogging = finding.spectrum.map(|spectrum| Cogging {
        spectrum,
        rate_lines_rad_per_s: finding.rate_lines_rad_per_s,
        static_map: finding.static_map,
        gain_error_ratio: finding.gain_error_ratio,
        points_count,
        has_spot,
    });
    SlidingPoint {
        name: case.point.clone(),
        kind: record.kind,
        achieved_rad_per_s: finding.achieved_rad_per_s,
        friction: finding.friction.as_ref().map(own),
        scale: record.torque_scale,
        quantum_u: finding.quantum_u,
        offset: finding.offset,
        half_sum: finding.half_sum.part(settled),
        unsettled_count: low + high,
        friction_slope_per_rad,
        kelvin_per_rad: finding.kelvin_per_rad,
        cogging,
        conditions: friction.conditions.clone(),
        evidence: finding.evidence,
    }
}

/// Friction of the point: type A with quantum and torque constant.
fn friction(case: &Case, record: &Record<'_>, finding: &Finding) -> Measurement {
    let name = if record.kind == Q::Torque { FRICTION } else { FRICTION_CURRENT };
    let mut measurement = match finding.friction {
        Some(estimate) => {
            let spread = combine(&[
                own_spread(finding.quantum_u, &estimate),
                record.torque_scale.of_torque(estimate.value),
            ]);
            let estimate = Estimate { u: spread.u, dof: spread.dof, ..estimate };
            Measurement::new(name, &case.axis, record.kind, Some(estimate), ESTIMATOR)
        }
        None => {
            let reason = finding.trouble.clone().unwrap_or_else(|| FrictionReason::NoSteadySliding.into());
            Measurement::inconclusive(name, &case.axis, record.kind, ESTIMATOR, reason)
        }
    };
    measurement.point = Some(case.point.clone());
    measurement.conditions = conditions(case, finding.achieved_rad_per_s);
    measurement.flags.clone_from(&finding.flags);
    measurement.excluded.clone_from(&finding.excluded);
    measurement.evidence.clone_from(&finding.evidence);
    if measurement.value.is_some()
        && let Some(angles_rad) = finding.half_sum.angles_rad()
    {
        measurement.set_angles(angles_rad);
    }
    measurement
}

/// Spread of a point's friction without what all points share.
fn own_spread(quantum_u: f64, friction: &Estimate) -> Component {
    combine(&[Component { u: friction.u, dof: friction.dof }, Component::known(quantum_u)])
}

/// What was asked for, with the velocity that was reached.
fn conditions(case: &Case, achieved_rad_per_s: Option<f64>) -> Vec<Condition> {
    case.requested
        .iter()
        .map(|request| Condition {
            name: request.name.clone(),
            requested: request.value,
            achieved: if request.name == "velocity" { achieved_rad_per_s } else { Some(request.value) },
            kind: request.kind,
        })
        .collect()
}

/// The axis' rows in the log: angle, and effort as torque or as current.
#[derive(Clone)]
pub(super) struct Record<'a> {
    /// Name of the axis' topic.
    topic: &'a str,
    time_s: Cow<'a, [f64]>,
    pub(super) angle_rad: Cow<'a, [f64]>,
    source: Cow<'a, [f64]>,
    scale: f64,
    /// Channel that the effort comes from.
    effort_channel: &'static str,
    /// Torque, or current where no torque constant is known.
    pub(super) kind: Q,
    /// How well the torques are known.
    pub(super) torque_scale: TorqueScale,
    /// Torque that one count of the drive is worth; 0 for currents.
    quantum_nm: f64,
}

impl<'a> Record<'a> {
    /// Effort is Kt·i where current and torque constant are there, else the torque channel, else plain current.
    pub(super) fn new(axis: &str, window: &'a Window, limits: &AxisLimits) -> Result<Self, Reason> {
        let topic = format!("/{axis}");
        let rows = window.topic(&topic)?;
        let column = |name: &str| rows.column(name);
        let angle_rad = rows.channel("position_rad")?;
        let (source, name, scale, kind) =
            match (column("current_a"), column("torque_nm"), limits.torque_constant()) {
                (Some(current), _, Some(constant)) => (current, "current_a", constant, Q::Torque),
                (_, Some(torque), _) => (torque, "torque_nm", limits.torque_ratio(), Q::Torque),
                (Some(current), None, None) => (current, "current_a", 1.0, Q::Current),
                (None, None, _) => return Err(FrictionReason::NeitherChannel { topic }.into()),
            };
        if angle_rad.iter().chain(source).any(|v| !v.is_finite()) {
            return Err(FrictionReason::NotANumber { topic, channel: name }.into());
        }
        let torque = kind == Q::Torque;
        Ok(Self {
            topic: &rows.topic.name,
            time_s: Cow::Borrowed(&rows.time_s),
            angle_rad: Cow::Borrowed(angle_rad),
            source: Cow::Borrowed(source),
            scale,
            effort_channel: name,
            kind,
            torque_scale: if torque { limits.torque_scale() } else { TorqueScale::NONE },
            quantum_nm: if torque { limits.torque_ratio() * limits.torque_quantum_nm } else { 0.0 },
        })
    }

    /// Rows in a stretch of time.
    pub(super) fn range(&self, start_s: f64, end_s: f64) -> Range<usize> {
        let before = |end_s: f64| self.time_s.partition_point(|&t| t < end_s);
        before(start_s)..before(end_s)
    }

    /// The rows of a range on an even raster, for α, and what is missing there; `None` if there are too few rows or
    /// time does not advance.
    pub(super) fn even(&self, range: Range<usize>) -> Option<EvenRecord<'a>> {
        let rows = EvenRows::over(&self.time_s[range.clone()])?;
        let record = Self {
            time_s: Cow::Owned(rows.time_s().to_vec()),
            angle_rad: Cow::Owned(rows.column(&self.angle_rad[range.clone()])),
            source: Cow::Owned(rows.column(&self.source[range])),
            ..self.clone()
        };
        Some(EvenRecord { record, rows })
    }

    /// Motor torque (or current) in a range, inertia not taken off yet.
    pub(super) fn motor(&self, range: Range<usize>) -> Vec<f64> {
        self.source[range].iter().map(|v| v * self.scale).collect()
    }

    /// Standard uncertainty that the drive's quantum q leaves in a mean over a range: q/√12, less what the noise σ
    /// dithers away, exp(−2π²·σ²/q²) (Widrow & Kollár, *Quantization Noise*, 2008, chapter 6). What is dithered
    /// scatters from sample to sample and is in the type A part already. σ comes from neighbouring samples.
    pub(super) fn quantum_u(&self, range: Range<usize>) -> f64 {
        let motor = self.motor(range);
        let pairs = motor.len().saturating_sub(1).max(1) as f64;
        let variance = motor.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / pairs / 2.0;
        let q = self.quantum_nm;
        if q > 0.0 { q / 12_f64.sqrt() * (-2.0 * (PI / q).powi(2) * variance).exp() } else { 0.0 }
    }

    /// Where the numbers of a range come from.
    pub(super) fn evidence(&self, range: &Range<usize>) -> Vec<Evidence> {
        let time = &self.time_s;
        let Some(t0_s) = time.get(range.start) else { return Vec::new() };
        let Some(t1_s) = time.get(range.end.saturating_sub(1)) else { return Vec::new() };
        let topic = self.topic;
        let channels = vec![format!("{topic} position_rad"), format!("{topic} {}", self.effort_channel)];
        vec![Evidence { file: String::new(), channels, t0_s: *t0_s, t1_s: *t1_s }]
    }
}

/// Rows of a record on an even raster.
pub(super) struct EvenRecord<'a> {
    pub(super) record: Record<'a>,
    /// The raster, and what is missing between the rows that it is made of.
    pub(super) rows: EvenRows,
}
