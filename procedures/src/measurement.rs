//! A number with its pedigree.

use std::any::Any;
use std::fmt::Display;
use std::sync::Arc;

pub use analysis::estimate::Estimate;
use analysis::goodness::Goodness;
use analysis::uncertainty::{Component, combine};
use serde::{Deserialize, Serialize};

use crate::case::{Case, Request};
use crate::quantity::QuantityKind;
use crate::reason::Reason;
use crate::trace::Plot;

/// What was reached differs from what was asked for beyond this share of it.
const DEPARTURE_RATIO: f64 = 0.05;

/// A condition of a measurement, as asked for and as reached. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Name, e.g. `velocity`.
    pub name: String,
    /// What the procedure asked for.
    pub requested: f64,
    /// What the log shows; `None` where it was not reached or cannot be told.
    pub achieved: Option<f64>,
    /// Kind of quantity, for printing.
    pub kind: QuantityKind,
}

/// Data that was left out, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Exclusion {
    /// How many samples, lines or points.
    pub count: usize,
    /// Of what, e.g. `samples`, `points`.
    pub of: String,
    /// Why, e.g. `turn-round: outside the plateau`.
    pub reason: String,
}

/// Where in the log a number comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Log file name inside the run folder; filled in by the judge.
    pub file: String,
    /// Topics and channels, e.g. `/az position_rad`.
    pub channels: Vec<String>,
    /// Start on the log's time axis, s.
    pub t0_s: f64,
    /// End on the log's time axis, s.
    pub t1_s: f64,
}

/// On which side of a value the truth lies, where no more than that is known, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    /// The truth is the value or more.
    AtLeast(String),
    /// The truth is the value or less.
    AtMost(String),
}

/// A measured value, or the reason why there is none.
///
/// `value` and `u` are in the SI unit of `kind`. A measurement without a value is inconclusive and says why in
/// `inconclusive`; one with both was seen, but no verdict rests on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Name of the measurand, one of the kind's `MEASURANDS`.
    pub measurand: String,
    /// The axis it belongs to.
    pub axis: String,
    /// The point it was measured at; `None` if it rests on several.
    pub point: Option<String>,
    /// Conditions, asked for and reached.
    pub conditions: Vec<Condition>,
    /// The value.
    pub value: Option<f64>,
    /// Kind of quantity of value and u.
    pub kind: QuantityKind,
    /// Combined standard uncertainty.
    pub u: f64,
    /// Effective degrees of freedom; infinite is written as `None`.
    pub dof: Option<f64>,
    /// Number of observations.
    pub n: usize,
    /// Estimator and version, e.g. `hysteresis-friction/1`.
    pub estimator: String,
    /// Quality flags, e.g. `sliding`, `variance inflation 14.2`.
    pub flags: Vec<String>,
    /// What was left out.
    pub excluded: Vec<Exclusion>,
    /// Where it comes from.
    pub evidence: Vec<Evidence>,
    /// Why there is no verdict to be had from it.
    pub inconclusive: Option<String>,
    /// Why it passes no limit, whatever its value. A shortfall stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// Where the value is only a bound of the truth: it passes and fails only limits that it decides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<Bound>,
    /// First and last angle of the axis between which it was measured, rad; `None` where it does not belong to a stretch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angles_rad: Option<[f64; 2]>,
}

impl Bound {
    /// Why the truth is only known to lie on one side.
    pub fn reason(&self) -> &str {
        let (Self::AtLeast(reason) | Self::AtMost(reason)) = self;
        reason
    }

    /// Sign of print before the value.
    pub fn sign(&self) -> &'static str {
        match self {
            Self::AtLeast(_) => "≥",
            Self::AtMost(_) => "≤",
        }
    }
}

impl Condition {
    /// The conditions that a point was planned for, each beside what was reached of it.
    pub fn reached(case: &Case, achieved: impl Fn(&Request) -> Option<f64>) -> Vec<Self> {
        let condition = |request: &Request| Self {
            name: request.name.clone(),
            requested: request.value,
            achieved: achieved(request),
            kind: request.kind,
        };
        case.requested.iter().map(condition).collect()
    }

    /// Whether what was reached is what was asked for; not where nothing tells.
    pub(crate) fn is_as_requested(&self) -> bool {
        self.achieved.is_some_and(|reached| !self.departs(reached))
    }

    fn departs(&self, reached: f64) -> bool {
        // Below this neither an axis nor a person tells an angle or a rate from none.
        let least = match self.kind {
            QuantityKind::Angle => 2e-3,
            QuantityKind::AngularVelocity => 1e-3,
            _ => 0.0,
        };
        let allowed = (DEPARTURE_RATIO * self.requested.abs()).max(least);
        (reached - self.requested).abs() > allowed || reached.is_nan()
    }

    /// Both values, where what was reached is not what was asked for.
    fn departure(&self) -> Option<String> {
        let reached = self.achieved?;
        self.departs(reached).then(|| {
            let [asked, reached] = [self.requested, reached].map(|value| self.kind.format(value));
            format!("{}: {asked} requested, {reached} reached", self.name)
        })
    }
}

impl Evidence {
    /// These channels over this time; the judge fills in the file.
    pub fn new(channels: Vec<String>, [t0_s, t1_s]: [f64; 2]) -> Self {
        Self { file: String::new(), channels, t0_s, t1_s }
    }
}

impl Measurement {
    /// A measurement without conditions, exclusions or evidence yet.
    pub fn new(
        measurand: &str,
        axis: &str,
        kind: QuantityKind,
        estimate: Option<Estimate>,
        estimator: &str,
    ) -> Self {
        Self {
            measurand: measurand.to_owned(),
            axis: axis.to_owned(),
            point: None,
            conditions: Vec::new(),
            value: estimate.map(|e| e.value),
            kind,
            u: estimate.map_or(0.0, |e| e.u),
            dof: estimate.and_then(|e| e.dof.is_finite().then_some(e.dof)),
            n: estimate.map_or(0, |e| e.n),
            estimator: estimator.to_owned(),
            flags: Vec::new(),
            excluded: Vec::new(),
            evidence: Vec::new(),
            inconclusive: None,
            doubt: None,
            bound: None,
            angles_rad: None,
        }
    }

    /// Adds a known (type B) component to the uncertainty; degrees of freedom by Welch–Satterthwaite.
    pub fn add_known(&mut self, u: f64) {
        let own = Component { u: self.u, dof: self.dof.unwrap_or(f64::INFINITY) };
        let spread = combine(&[own, Component::known(u)]);
        (self.u, self.dof) = (spread.u, spread.dof.is_finite().then_some(spread.dof));
    }

    /// Says that the value is no more than a bound, in a flag, too.
    pub fn set_bound(&mut self, bound: Bound) {
        let side = match bound {
            Bound::AtLeast(_) => "at least",
            Bound::AtMost(_) => "at most",
        };
        self.flags.push(format!("{side}: {}", bound.reason()));
        self.bound = Some(bound);
    }

    /// Says how well a model describes what the value was fitted to; where it does not, no verdict rests on the value.
    pub fn rest_on(&mut self, goodness: &Goodness) {
        self.flags.extend(goodness.flag());
        self.inconclusive = goodness.check().err().map(|hopeless| hopeless.to_string());
    }

    /// Says over which angles it was measured, in a flag, too.
    pub fn set_angles(&mut self, angles_rad: [f64; 2]) {
        let [first, last] = angles_rad.map(|angle_rad| (10.0 * angle_rad.to_degrees()).round() / 10.0 + 0.0);
        self.flags.push(format!("measured from {first} deg to {last} deg"));
        self.angles_rad = Some(angles_rad);
    }

    /// Flags each condition that was not reached as it was asked for.
    pub fn flag_departures(&mut self) {
        self.flags.extend(self.conditions.iter().filter_map(Condition::departure));
    }

    /// A measurand without a value, and why.
    pub fn inconclusive(
        measurand: &str,
        axis: &str,
        kind: QuantityKind,
        estimator: &str,
        reason: impl Display,
    ) -> Self {
        Self { inconclusive: Some(reason.to_string()), ..Self::new(measurand, axis, kind, None, estimator) }
    }
}

/// What the analysis of one point gives: measurements, pictures, and numbers that `conclude` needs.
#[derive(Clone, Debug, Default)]
pub struct PointResult {
    /// Name of the point.
    pub point: String,
    /// Measurements that rest on this point alone.
    pub measurements: Vec<Measurement>,
    /// Pictures of this point.
    pub plots: Vec<Plot>,
    /// What the kind itself makes of the point; never printed.
    pub reduced: Reduced,
    /// What the report says of it below the table.
    pub remarks: Vec<String>,
    /// What was left out of this point.
    pub excluded: Vec<Exclusion>,
    /// Why the point gives no numbers.
    pub inconclusive: Option<Reason>,
}

/// What a point was reduced to, in a type of its kind's own: `analyse` leaves it, `conclude` takes it up.
#[derive(Clone, Debug, Default)]
pub struct Reduced(Option<Arc<dyn Any + Send + Sync>>);

impl PointResult {
    /// A point of which nothing is known yet.
    pub fn of(case: &Case) -> Self {
        Self { point: case.point.clone(), ..Self::default() }
    }

    /// A point that says nothing of these measurands, and why.
    pub fn without(
        case: &Case,
        measurands: &[(&str, QuantityKind)],
        estimator: &str,
        reason: impl Into<Reason>,
    ) -> Self {
        let reason = reason.into();
        let inconclusive = |&(measurand, kind): &(&str, QuantityKind)| Measurement {
            point: Some(case.point.clone()),
            ..Measurement::inconclusive(measurand, &case.axis, kind, estimator, &reason)
        };
        let measurements = measurands.iter().map(inconclusive).collect();
        Self { measurements, inconclusive: Some(reason), ..Self::of(case) }
    }

    /// The point with these conditions in each of its measurements.
    pub(crate) fn under(mut self, conditions: &[Condition]) -> Self {
        for measurement in &mut self.measurements {
            measurement.conditions = conditions.to_vec();
        }
        self
    }
}

impl Reduced {
    /// A point that was reduced to `value`.
    pub fn to<T: Any + Send + Sync>(value: T) -> Self {
        Self(Some(Arc::new(value)))
    }

    /// What it was reduced to; `None` where nothing came of the point, or something of another type.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.as_deref().and_then(<dyn Any + Send + Sync>::downcast_ref)
    }
}

/// What a procedure says in the end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conclusion {
    /// All measurements, those of the points included.
    pub measurements: Vec<Measurement>,
    /// Pictures over points; at most 2000 points a trace.
    pub plots: Vec<Plot>,
    /// Remarks that the report prints below the table, e.g. what was not determined.
    pub remarks: Vec<String>,
    /// What later procedures of the run may rely on, or not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proof>,
}

impl Conclusion {
    /// What points say by themselves: their measurements and pictures, in plan order.
    pub(crate) fn collected(points: &[PointResult]) -> Self {
        Self {
            measurements: points.iter().flat_map(|p| p.measurements.clone()).collect(),
            plots: points.iter().flat_map(|p| p.plots.clone()).collect(),
            remarks: points.iter().flat_map(|p| p.remarks.clone()).collect(),
            proof: None,
        }
    }
}

/// What a procedure proves for those that come after it, e.g. `polarity`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Proof {
    /// Name of the gate that it opens.
    pub gate: String,
    /// Why it stays closed, one sentence each, e.g. `encoder sign of az: …`; empty if it is open.
    pub faults: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flags(kind: QuantityKind, requested: f64, achieved: Option<f64>) -> Vec<String> {
        let condition = Condition { name: "dwell".to_owned(), requested, achieved, kind };
        let mut measurement = Measurement::new("x", "az", kind, None, "none");
        measurement.conditions.push(condition);
        measurement.flag_departures();
        measurement.flags
    }

    #[test]
    fn a_condition_that_was_not_reached_as_asked_for_is_flagged() {
        assert_eq!(flags(QuantityKind::Time, 1.0, Some(348.7)), ["dwell: 1 s requested, 348.7 s reached"]);
        assert_eq!(
            flags(QuantityKind::Angle, -0.174, Some(-0.115)).len(),
            1,
            "-10 deg requested, -6.6 deg reached"
        );
        assert!(!flags(QuantityKind::Time, 1.0, Some(f64::NAN)).is_empty());
        assert!(flags(QuantityKind::Time, 1.0, Some(1.04)).is_empty());
        assert!(flags(QuantityKind::Angle, 0.0, Some(2.6e-4)).is_empty(), "an angle of 15 mdeg is none");
        assert!(flags(QuantityKind::Angle, 0.7, None).is_empty(), "what was not told is not known to differ");
    }
}
