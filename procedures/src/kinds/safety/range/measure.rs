//! One point.

use analysis::estimate::Estimate;

use super::keys::Stage;
use super::plan::{BESIDE, HIGH_END, LOW_END, PAST as PAST_SEGMENT};
use super::{FAST_SPAN, INTO, LOWER, PAST, SPAN, UPPER};
use crate::axis::Axes;
use crate::case::{Case, Fence};
use crate::log::{Rows, Window};
use crate::measurement::{Condition, Evidence, Measurement, PointResult, Reduced};
use crate::missing::Missing;
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, SafetyReason};
use crate::trace::{MAX_POINTS, Series, Style};

const ESTIMATOR: &str = "range/2";
/// A drive that stops farther than this from its limit was stopped by something else.
const NEAR_RAD: f64 = 1.0 * std::f64::consts::PI / 180.0;
const CHANNEL: &str = "position_rad";
const RATE: &str = "velocity_rad_per_s";

/// What a point says, or why not.
pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let Some(stage) = Stage::of(case) else { return PointResult::default() };
    let found = Record::new(case, window, axes).map_err(Reason::from).and_then(|record| match stage {
        Stage::Ends => record.ends(),
        Stage::FullSpeed => record.full_speed(),
        Stage::SoftBench | Stage::SoftDrive => record.soft_limit(stage),
        Stage::Zone if case.point.ends_with(BESIDE) => record.beside(),
        Stage::Zone => record.zone(),
    });
    let names: &[&str] = match stage {
        Stage::Ends => &[SPAN, LOWER, UPPER],
        Stage::FullSpeed => &[FAST_SPAN],
        Stage::SoftBench | Stage::SoftDrive => &[PAST],
        Stage::Zone => &[INTO],
    };
    let result = match found {
        Ok(measurements) => PointResult { measurements, ..PointResult::of(case) },
        Err(reason) => {
            let all: Vec<_> = names.iter().map(|name| (*name, Q::Angle)).collect();
            PointResult::without(case, &all, ESTIMATOR, reason)
        }
    };
    match Record::new(case, window, axes) {
        Ok(record) => PointResult { reduced: Reduced::to(record.course()), ..result },
        Err(_) => result,
    }
}

struct Record<'a> {
    case: &'a Case,
    window: &'a Window,
    rows: &'a Rows,
    position_rad: &'a [f64],
    quantum_rad: f64,
    tick_s: f64,
    /// Index of the axis in a zone.
    own: usize,
}

impl<'a> Record<'a> {
    fn new(case: &'a Case, window: &'a Window, axes: &Axes) -> Result<Self, Missing> {
        let limits = axes.limits(&case.axis)?;
        let rows = window.topic_with_rows(&format!("/{}", case.axis))?;
        let position_rad = rows.finite_channel(CHANNEL)?;
        let own = axes.gimbal_index(&case.axis).unwrap_or(0);
        let (quantum_rad, tick_s) = (limits.encoder_quantum_rad, limits.tick_s());
        Ok(Self { case, window, rows, position_rad, quantum_rad, tick_s, own })
    }

    /// Mean angle over the second half of a rest.
    fn rest_rad(&self, label: &str) -> Result<f64, Reason> {
        let span = self.window.segment(self.case, label)?;
        let rows = self.rows.range(0.5 * (span.start_s + span.end_s), span.end_s);
        let values = self.position_rad.get(rows).filter(|values| !values.is_empty());
        let values = values.ok_or_else(|| SafetyReason::NoRestRows { label: label.to_owned() })?;
        Ok(values.iter().sum::<f64>() / values.len() as f64)
    }

    fn ends(&self) -> Result<Vec<Measurement>, Reason> {
        if let Some(trip) = self.first_trip() {
            return Err(SafetyReason::EndsTripped { trip: trip.to_owned() }.into());
        }
        let fence = self.case.fence.as_ref().and_then(|fence| fence.bench_rad.get(&self.case.axis));
        let &[low, high] = fence.ok_or(SafetyReason::NoEnds)?;
        let lower_rad = self.rest_rad(LOW_END)?;
        let upper_rad = self.rest_rad(HIGH_END)?;
        let flags = |off_rad: f64| vec![format!("rests {:.1} urad beyond the end", 1e6 * off_rad)];
        let [at_low, at_high] = [flags(low - lower_rad), flags(upper_rad - high)];
        let u = self.quantum_rad;
        Ok(vec![
            self.measurement(
                SPAN,
                upper_rad - lower_rad,
                u.hypot(u),
                [at_low.clone(), at_high.clone()].concat(),
            ),
            self.measurement(LOWER, lower_rad, u, at_low),
            self.measurement(UPPER, upper_rad, u, at_high),
        ])
    }

    fn full_speed(&self) -> Result<Vec<Measurement>, Reason> {
        let value = self.rest_rad(HIGH_END)? - self.rest_rad(LOW_END)?;
        Ok(vec![self.measurement(FAST_SPAN, value, self.quantum_rad, Vec::new())])
    }

    /// Direction of the segment that leads past the limit.
    fn ahead(&self) -> f64 {
        self.case.requested("velocity").unwrap_or(0.0).signum()
    }

    /// The farthest angle in a direction, and the highest rate.
    fn farthest(&self) -> f64 {
        let ahead = self.ahead();
        ahead * self.position_rad.iter().map(|angle| ahead * angle).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Name of the interlock that ended the point first.
    fn first_trip(&self) -> Option<&str> {
        self.window.trips.first().and_then(|trip| trip.split(':').next())
    }

    fn soft_limit(&self, stage: Stage) -> Result<Vec<Measurement>, Reason> {
        let of =
            |fence: &'a Fence| if stage == Stage::SoftBench { &fence.bench_rad } else { &fence.drive_rad };
        let limits = self.case.fence.as_ref().and_then(|fence| of(fence).get(&self.case.axis));
        let &[low, high] = limits.ok_or(SafetyReason::NoLimits)?;
        let ahead = self.ahead();
        let limit_rad = if ahead > 0.0 { high } else { low };
        let past_rad = ahead * (self.farthest() - limit_rad);
        let tripped = self.first_trip();
        let held = match (stage, tripped) {
            (Stage::SoftBench, Some("braking curve" | "position")) => true,
            (Stage::SoftDrive, None) => past_rad.abs() < NEAR_RAD,
            _ => false,
        };
        // What went past did so, whatever ended it.
        if !held && past_rad <= self.quantum_rad {
            return Err(not_tested(past_rad, tripped).into());
        }
        let how = if held { self.how(tripped) } else { vec!["not held".to_owned()] };
        // A drive controls its velocity down to nothing at its limit; the bench stops the axis at a tick.
        let u = if stage == Stage::SoftBench { self.u_of_trip() } else { self.quantum_rad };
        Ok(vec![self.measurement(PAST, past_rad, u, how)])
    }

    /// Uncertainty of where a trip leaves an axis: the encoder's resolution, and the angle turned in a tick (rectangular), because
    /// the axis may pass a limit anywhere between two ticks.
    fn u_of_trip(&self) -> f64 {
        let rate_rad_per_s = self.fastest_rad_per_s().unwrap_or(0.0);
        self.quantum_rad.hypot(rate_rad_per_s * self.tick_s / 12.0_f64.sqrt())
    }

    fn zone(&self) -> Result<Vec<Measurement>, Reason> {
        let zone = self.case.fence.as_ref().and_then(|fence| fence.zones.first());
        let zone = zone.ok_or(SafetyReason::NoZone)?;
        let into_rad = -zone.gap_rad(self.own, self.farthest()).0;
        let tripped = self.first_trip();
        if tripped != Some("restricted zone") && into_rad <= self.quantum_rad {
            return Err(not_tested(into_rad, tripped).into());
        }
        Ok(vec![self.measurement(INTO, into_rad, self.u_of_trip(), self.how(tripped))])
    }

    /// The move must reach its end: a zone that stopped it here would be a limit of one axis and no zone.
    fn beside(&self) -> Result<Vec<Measurement>, Reason> {
        let zone = self.case.fence.as_ref().and_then(|fence| fence.zones.first());
        let zone = zone.ok_or(SafetyReason::NoZone)?;
        if let Some(trip) = self.first_trip() {
            return Err(SafetyReason::Hindered { trip: trip.to_owned() }.into());
        }
        if zone.gap_rad(self.own, self.farthest()).0 > 0.0 {
            return Err(SafetyReason::BesideNotReached.into());
        }
        Ok(Vec::new())
    }

    fn how(&self, tripped: Option<&str>) -> Vec<String> {
        let by = tripped.map_or("held by the drive".to_owned(), |trip| format!("held by interlock `{trip}`"));
        vec![by]
    }

    fn measurement(&self, name: &str, value: f64, u: f64, flags: Vec<String>) -> Measurement {
        let estimate = Estimate { value, u, dof: f64::INFINITY, n: self.position_rad.len() };
        Measurement {
            point: Some(self.case.point.clone()),
            conditions: self.conditions(),
            flags,
            evidence: self.evidence(),
            ..Measurement::new(name, &self.case.axis, Q::Angle, Some(estimate), ESTIMATOR)
        }
    }

    /// Highest speed of the move that leads past a limit.
    fn fastest_rad_per_s(&self) -> Option<f64> {
        let segment = self.window.segment(self.case, PAST_SEGMENT).ok().or(self.window.segments.first())?;
        let rates = self.rows.column(RATE)?;
        let rows = self.rows.range(segment.start_s, segment.end_s);
        Some(rates.get(rows).unwrap_or(&[]).iter().fold(0.0, |most: f64, rate| most.max(rate.abs())))
    }

    /// The rate that was asked for, and the highest one that was reached.
    fn conditions(&self) -> Vec<Condition> {
        let fastest = self.fastest_rad_per_s();
        Condition::reached(self.case, |asked| fastest.map(|rate| rate.copysign(asked.value)))
    }

    fn evidence(&self) -> Vec<Evidence> {
        let [Some(&t0_s), Some(&t1_s)] = [self.rows.time_s.first(), self.rows.time_s.last()] else {
            return Vec::new();
        };
        let channels = vec![format!("/{} {CHANNEL}", self.case.axis)];
        vec![Evidence::new(channels, [t0_s, t1_s])]
    }

    /// Angle in degrees over the time since the first row, thinned, for the pictures.
    fn course(&self) -> Series {
        let start_s = self.rows.time_s.first().copied().unwrap_or(0.0);
        let time: Vec<f64> = self.rows.time_s.iter().map(|t| t - start_s).collect();
        let angle: Vec<f64> = self.position_rad.iter().map(|angle| Q::Angle.to_display(*angle)).collect();
        Series::thinned(self.case.axis.clone(), Style::Line, [&time, &angle], MAX_POINTS)
    }
}

fn not_tested(past_rad: f64, tripped: Option<&str>) -> SafetyReason {
    SafetyReason::NotTested { short_rad: -past_rad, trip: tripped.map(str::to_owned) }
}
