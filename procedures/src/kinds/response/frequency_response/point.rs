//! One point: a record becomes responses, these become measurements.

use analysis::frf::Line;

use super::coupling::Coupling;
use super::honest::{self, Judged};
use super::{Keys, Response, angle, closed, coaxiality, coupling, current, plant, track, velocity};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::response::excited::{self, Channel, Measured, conditions};
use crate::log::Window;
use crate::measurement::{Condition, Measurement, PointResult, Reduced};
use crate::quantity::QuantityKind as Q;

/// Everything about a point that its measurements share.
pub(super) struct Point<'a> {
    pub(super) case: &'a Case,
    pub(super) limits: &'a AxisLimits,
    pub(super) measured: Measured,
    pub(super) conditions: Vec<Condition>,
    evidence: Vec<crate::measurement::Evidence>,
}

/// What a point hands on for what is said over several points.
#[derive(Default)]
pub(super) struct Kept {
    pub(super) coupling: Option<Coupling>,
    /// Lines of torque to rate, where points differ in the gains of the loop around it.
    pub(super) plant: Vec<Line>,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult::of(case);
    match read(keys, case, window, axes) {
        Ok(point) => {
            result.excluded = point.measured.excluded.clone();
            let mut kept = Kept::default();
            for response in &keys.responses {
                point.evaluate(*response, &mut result, &mut kept);
            }
            result.reduced = Reduced::to(kept);
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
        conditions: conditions(case, None, None),
        ..Measurement::inconclusive(name, &case.axis, kind, "frequency-response/1", reason)
    }
}

fn read<'a>(keys: &Keys, case: &'a Case, window: &Window, axes: &'a Axes) -> Result<Point<'a>, String> {
    let reading = excited::read(&keys.excited, case, window, axes)?;
    let limits = axes.limits(&case.axis)?;
    let conditions = conditions(case, reading.elevation_rad, Some(&reading.measured));
    Ok(Point { case, limits, measured: reading.measured, conditions, evidence: reading.evidence })
}

impl Point<'_> {
    fn evaluate(&self, response: Response, result: &mut PointResult, kept: &mut Kept) {
        match response {
            Response::VelocityLoop => velocity::evaluate(self, result),
            Response::TrackLoop => track::evaluate(self, result),
            Response::CrossAxis => kept.coupling = coupling::evaluate(self, result),
            Response::Plant => kept.plant = plant::evaluate(self, result),
            Response::CurrentLoop => current::evaluate(self, result),
            Response::Coaxiality => coaxiality::evaluate(self, result),
            Response::TorqueAngle => angle::evaluate(self, result),
            Response::VelocityPosition => closed::evaluate(self, result),
        }
    }

    /// A response with its lines judged.
    pub(super) fn response(&self, from: Channel, to: Channel) -> Result<Judged, String> {
        let lines = self.measured.response(from, to)?;
        Ok(honest::judge(lines, &self.measured, self.limits))
    }

    /// A response with its lines judged, where friction has no part in it.
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
