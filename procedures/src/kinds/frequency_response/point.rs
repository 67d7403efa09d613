//! One point: a record becomes responses, these become measurements.

use super::honest::{self, Judged};
use super::{Keys, Response, coaxiality, coupling, current, plant, track, velocity};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::excited::{Channel, Course, ELEVATION, LEVEL, Measured, Record, measure};
use crate::log::Window;
use crate::measurement::{Condition, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

/// Everything about a point that its measurements share.
pub(super) struct Point<'a> {
    pub(super) case: &'a Case,
    pub(super) limits: &'a AxisLimits,
    pub(super) measured: Measured,
    pub(super) conditions: Vec<Condition>,
    evidence: Vec<crate::measurement::Evidence>,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult { point: case.point.clone(), ..PointResult::default() };
    match read(keys, case, window, axes) {
        Ok(point) => {
            result.excluded = point.measured.excluded.clone();
            for response in &keys.responses {
                point.evaluate(*response, &mut result);
            }
        }
        Err(reason) => {
            result.measurements = keys
                .responses
                .iter()
                .flat_map(|r| r.measurands())
                .map(|name| without(name, case, &reason))
                .collect();
            result.inconclusive = Some(reason);
        }
    }
    result
}

/// A measurand of a point without a record that can be read.
fn without(name: &str, case: &Case, reason: &str) -> Measurement {
    let kind = super::MEASURANDS.iter().find(|m| m.name == name).map_or(Q::Ratio, |m| m.kind);
    Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, None),
        ..Measurement::inconclusive(name, &case.axis, kind, "frequency-response/1", reason)
    }
}

fn read<'a>(keys: &Keys, case: &'a Case, window: &Window, axes: &'a Axes) -> Result<Point<'a>, String> {
    let axis = case.axis.as_str();
    let limits = axes.get(axis).ok_or_else(|| format!("the log's rig has no axis `{axis}`"))?;
    let record = Record::new(axis, window, limits)?;
    let middle = middle_rad(keys, case);
    let level_v = case.requested(LEVEL).ok_or("the plan of the point has no level")?;
    let course = Course::new(&keys.excited, limits, middle, level_v).map_err(|d| d.message)?;
    let measured = measure(&keys.excited, case, window, &record, &course, limits)?;
    let elevation = match axis {
        "el" => Some(measured.angle_rad[2]),
        _ => window.rows("/el").and_then(|rows| rows.column("position_rad")).map(mean),
    };
    let conditions = conditions(case, elevation);
    Ok(Point { case, limits, measured, conditions, evidence: record.evidence() })
}

/// Middle of the strokes that were planned.
fn middle_rad(keys: &Keys, case: &Case) -> f64 {
    match case.axis.as_str() {
        "el" => case.requested(ELEVATION).unwrap_or(0.0),
        _ => keys.excited.background.middle_rad,
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn conditions(case: &Case, elevation: Option<f64>) -> Vec<Condition> {
    let achieved = |name: &str, requested: f64| match name {
        ELEVATION => elevation,
        _ => Some(requested),
    };
    let of = |r: &crate::case::Request| Condition {
        name: r.name.clone(),
        requested: r.value,
        achieved: achieved(&r.name, r.value),
        kind: r.kind,
    };
    case.requested.iter().map(of).collect()
}

impl Point<'_> {
    fn evaluate(&self, response: Response, result: &mut PointResult) {
        match response {
            Response::VelocityLoop => velocity::evaluate(self, result),
            Response::TrackLoop => track::evaluate(self, result),
            Response::CrossAxis => coupling::evaluate(self, result),
            Response::Plant => plant::evaluate(self, result),
            Response::CurrentLoop => current::evaluate(self, result),
            Response::Coaxiality => coaxiality::evaluate(self, result),
        }
    }

    /// A response with its lines judged.
    pub(super) fn response(&self, from: Channel, to: Channel) -> Result<Judged, String> {
        let lines = self.measured.response(from, to)?;
        Ok(honest::judge(lines, &self.measured, self.limits))
    }

    /// The same where friction has no part in it.
    pub(super) fn response_while_holding(&self, from: Channel, to: Channel) -> Result<Judged, String> {
        let lines = self.measured.response(from, to)?;
        Ok(honest::judge_noise(lines))
    }

    /// The point's name, fit for an id.
    pub(super) fn slug(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '.') { c } else { '-' };
        self.case.point.chars().map(plain).collect()
    }

    /// A measurement of this point.
    pub(super) fn measurement(&self, measurement: Measurement) -> Measurement {
        let mut flags = measurement.flags.clone();
        let state = if self.measured.slides { "sliding" } else { "presliding" };
        flags.push(format!("{state}, {} windows", self.measured.windows));
        Measurement {
            point: Some(self.case.point.clone()),
            conditions: self.conditions.clone(),
            evidence: self.evidence.clone(),
            flags,
            ..measurement
        }
    }
}
