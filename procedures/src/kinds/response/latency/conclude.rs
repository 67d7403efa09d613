//! Measurements of a point, and what takes more than one: differences between levels and rates, the way back.

use analysis::estimate::Estimate;
use analysis::lag::{KnownLag, LagError, Order, Settings, transport_at_known_corner};
use analysis::uncertainty::rectangular_u;

use super::fit::{Described, Loop, MOST_DELAY_S, SlowResponse, WayOut};
use super::plan::{Keys, Stage};
use super::{BACK, BY_ONSET, HOLD, JITTER, LAG, LEVELS, RATES, ROUND_TRIP, SLOW, Value};
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Conclusion, Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};

const ESTIMATOR: &str = "latency/1";
/// Noise of the current alone shows less than a fifth of this.
const LEAST_JITTER_S: f64 = 25e-6;

/// A point without numbers, and why.
pub(super) fn without(case: &Case, stage: Stage, reason: &Reason) -> PointResult {
    let all: Vec<_> = stage.measurands().iter().map(|name| (*name, Q::Time)).collect();
    PointResult::without(case, &all, ESTIMATOR, reason.clone()).under(&conditions(case, None))
}

/// A time of a point, at the level that its record holds, V peak to peak.
pub(super) fn measurement(
    name: &str,
    case: &Case,
    level_v: Option<f64>,
    estimate: Estimate,
    flags: Vec<String>,
) -> Measurement {
    Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, level_v),
        flags,
        ..Measurement::new(name, &case.axis, Q::Time, Some(estimate), ESTIMATOR)
    }
}

/// The level is all that is asked of a point.
fn conditions(case: &Case, level_v: Option<f64>) -> Vec<Condition> {
    Condition::reached(case, |_| level_v)
}

/// Where a number comes from.
pub(super) fn evidence(window: &Window, topic: &str, channels: &[&str]) -> Vec<Evidence> {
    let times = window.rows(topic).map(|rows| rows.time_s.as_slice());
    let Some((&[t0_s, ..], &[.., t1_s])) = times.map(|t| (t, t)) else { return Vec::new() };
    let channels = channels.iter().map(|channel| format!("{topic} {channel}")).collect();
    vec![Evidence::new(channels, [t0_s, t1_s])]
}

/// Microseconds, for people.
pub(super) fn us(s: f64) -> f64 {
    1e6 * s
}

type Found = Result<(Estimate, Vec<String>), Reason>;

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Conclusion {
    let axis = cases.first().map_or("", |case| case.axis.as_str());
    let mut conclusion = Conclusion::collected(points);
    let jitter = Jitter::find(&conclusion.measurements);
    let blamed = jitter.as_ref().filter(|jitter| jitter.value_s > LEAST_JITTER_S);
    if let Some(jitter) = blamed {
        jitter.blame(&mut conclusion, points);
    }
    if let Some(jitter) = &jitter {
        jitter.count(&mut conclusion, points);
    }
    let loops: Vec<&Loop> = points
        .iter()
        .filter_map(|point| point.reduced.get())
        .filter(|found: &&Loop| blamed.is_none() || found.described != Described::ByNeither)
        .collect();
    let smear_s = jitter.as_ref().map_or(0.0, |jitter| jitter.most_of(&loops));
    let transports: Vec<Value> = loops.iter().map(|found| found.transport_s).collect();
    let corners: Vec<Value> = loops.iter().map(|found| found.corner_hz).collect();
    let mut add = |name: &str, found: Found, half_width_s: f64| {
        let mut measurement = named(name, axis, found);
        if measurement.value.is_some() {
            measurement.add_known(rectangular_u(half_width_s));
        }
        conclusion.measurements.push(measurement);
    };
    if keys.has(Stage::Fit) && keys.levels_v.len() > 1 {
        // Fits of the same order have the same error by jitter, which the difference does not contain.
        let is_alike = loops.windows(2).all(|two| two[0].described == two[1].described);
        add(LEVELS, levels(&transports), if is_alike { 0.0 } else { smear_s });
    }
    if keys.has(Stage::Slow) {
        let slow = slow(points, &transports, &corners);
        let slow = slow.as_ref().map_err(Clone::clone);
        // The lag of the fit counts in full here, and an error of the lag by jitter is as large as one of a delay.
        let most_s =
            jitter.as_ref().map_or(0.0, |jitter| smear_s.max(SECOND_ORDER_SMEAR_RATIO * jitter.most_s));
        add(SLOW, slow.clone().map(slow_itself), most_s);
        add(RATES, slow.map(rates), most_s);
    }
    if keys.has(Stage::Probe) {
        add(BACK, back(points, &transports), smear_s);
    }
    if let Some(transport_s) = mean(&transports) {
        let remark = remark(transport_s.value, &conclusion.measurements);
        conclusion.remarks.push(remark);
    }
    conclusion
}

/// The error of a first-order fit by jitter, in σ²/τ, for a delay with standard deviation σ and a current loop with lag τ: a longer lag
/// and a shorter delay. Drawn units with up to 50 us of jitter need 2.7. Half-width of a rectangular distribution (ours).
const SMEAR_RATIO: f64 = 3.0;

/// The largest error of the delay of a first-order fit, in σ: 0.9 where delays are evenly distributed, 1.33 where they take two values
/// one period apart (computed responses, see [`SECOND_ORDER_SMEAR_RATIO`]). Half-width of a rectangular distribution (ours).
const FIRST_ORDER_SMEAR_RATIO: f64 = 1.5;

/// The error of the delay of a second-order fit, in σ: the second pole takes up the jitter, and its lag is missing in the delay.
/// Computed responses of first-order loops of 700 Hz to 1300 Hz, sampled at 4 kHz behind evenly distributed delays over 50 us to 850 us,
/// are fitted with delays up to 1.59 σ too short and 0.20 σ too long. Half-width of a rectangular distribution (ours).
const SECOND_ORDER_SMEAR_RATIO: f64 = 1.6;

/// What steps say of the delay from command to command.
struct Jitter {
    /// Standard deviation of the delay, s.
    value_s: f64,
    /// The largest standard deviation that the steps do not exclude, s.
    most_s: f64,
    /// Delay by onset, s.
    onset_s: Option<f64>,
}

impl Jitter {
    fn find(measurements: &[Measurement]) -> Option<Self> {
        let find = |name: &str| measurements.iter().find(|m| m.measurand == name);
        let jitter = find(JITTER)?;
        let value_s = jitter.value?;
        let onset_s = find(BY_ONSET).and_then(|m| m.value);
        Some(Self { value_s, most_s: value_s + jitter.u, onset_s })
    }

    /// Half-width of the error that jitter may leave in the delay of a fit, s. A delay that takes a few values far apart, as where a
    /// command now and then misses its exchange, may leave up to 3.6 σ in a second-order fit: what such a fit differs from the
    /// onset of steps counts, too.
    fn half_width_s(&self, found: &Loop) -> f64 {
        let most_s = self.most_s;
        match found.described {
            Described::SecondOrder => {
                let apart_s = self.onset_s.map_or(0.0, |onset_s| (found.transport_s.value - onset_s).abs());
                apart_s.max(SECOND_ORDER_SMEAR_RATIO * most_s)
            }
            Described::FirstOrder | Described::ByNeither => {
                let by_lag_s = SMEAR_RATIO * most_s * most_s / found.lag_s;
                by_lag_s.min(FIRST_ORDER_SMEAR_RATIO * most_s)
            }
        }
    }

    /// The largest half-width among these fits, s.
    fn most_of(&self, loops: &[&Loop]) -> f64 {
        loops.iter().map(|found| self.half_width_s(found)).fold(0.0, f64::max)
    }

    /// Takes the verdicts from what jitter spoils. A fit without a corner, or one that neither order describes, says nothing about
    /// the loop. The round trip of a second-order fit stands, but its lag is not that of the current loop.
    fn blame(&self, conclusion: &mut Conclusion, points: &[PointResult]) {
        let reason = ResponseReason::DelayJitters { jitter_s: self.value_s }.to_string();
        for point in points {
            let described = point.reduced.get::<Loop>().map(|found| found.described);
            let has_no_corner =
                matches!(point.inconclusive, Some(Reason::Lag(LagError::NotDetermined { .. })));
            let spoiled: &[&str] = match described {
                _ if has_no_corner => &[ROUND_TRIP, LAG, HOLD],
                Some(Described::ByNeither) => &[ROUND_TRIP, LAG, HOLD],
                Some(Described::SecondOrder) => &[LAG],
                Some(Described::FirstOrder) | None => &[],
            };
            for m in of_point(conclusion, point).filter(|m| spoiled.contains(&m.measurand.as_str())) {
                m.inconclusive = Some(reason.clone());
            }
        }
    }

    /// Adds what jitter leaves in a fit to the uncertainty of its round trip.
    fn count(&self, conclusion: &mut Conclusion, points: &[PointResult]) {
        for point in points {
            let Some(found) = point.reduced.get::<Loop>() else { continue };
            let u_s = rectangular_u(self.half_width_s(found));
            let round_trips =
                of_point(conclusion, point).filter(|m| m.measurand == ROUND_TRIP && m.value.is_some());
            round_trips.for_each(|m| m.add_known(u_s));
        }
    }
}

fn of_point<'a>(
    conclusion: &'a mut Conclusion,
    point: &'a PointResult,
) -> impl Iterator<Item = &'a mut Measurement> {
    conclusion.measurements.iter_mut().filter(|m| m.point.as_deref() == Some(&point.point))
}

fn named(name: &str, axis: &str, found: Found) -> Measurement {
    match found {
        Ok((estimate, flags)) => {
            Measurement { flags, ..Measurement::new(name, axis, Q::Time, Some(estimate), ESTIMATOR) }
        }
        Err(reason) => Measurement::inconclusive(name, axis, Q::Time, ESTIMATOR, reason),
    }
}

/// Mean with the larger of what the uncertainties and what the scatter say of it.
fn mean(values: &[Value]) -> Option<Value> {
    let n = values.len() as f64;
    if values.is_empty() {
        return None;
    }
    let mean = values.iter().map(|v| v.value).sum::<f64>() / n;
    let within = values.iter().map(|v| v.u * v.u).sum::<f64>().sqrt() / n;
    let between = values.iter().map(|v| (v.value - mean).powi(2)).sum::<f64>() / (n * (n - 1.0).max(1.0));
    Some(Value { value: mean, u: within.max(between.sqrt()) })
}

fn estimate(value: f64, u: f64, n: usize) -> Estimate {
    Estimate { value, u, dof: f64::INFINITY, n }
}

fn levels(transports: &[Value]) -> Found {
    if transports.len() < 2 {
        return Err(ResponseReason::FewLevels { levels: transports.len() }.into());
    }
    let by = |a: &&Value, b: &&Value| a.value.total_cmp(&b.value);
    let low = transports.iter().min_by(by);
    let high = transports.iter().max_by(by);
    let (Some(low), Some(high)) = (low, high) else { return Err(ResponseReason::NoRoundTrip.into()) };
    let difference = high.value - low.value;
    let u = high.u.hypot(low.u);
    let agree = if difference <= 2.0 * u { "within" } else { "beyond" };
    let flag = format!("{agree} its expanded uncertainty of {:.2} us", us(2.0 * u));
    Ok((estimate(difference, u, transports.len()), vec![flag]))
}

/// The round trip with slow commands, beside that at the loop rate.
struct Slow {
    found: KnownLag,
    period_s: f64,
    corner_hz: f64,
    /// Round trip at the loop rate.
    fast: Value,
    lines: usize,
}

fn slow(points: &[PointResult], transports: &[Value], corners: &[Value]) -> Result<Slow, Reason> {
    let fast = mean(transports).ok_or(ResponseReason::NoCorner)?;
    let corner = mean(corners).ok_or(ResponseReason::NoCorner)?;
    let response: Option<&SlowResponse> = points.iter().find_map(|point| point.reduced.get());
    let SlowResponse { lines, period_s } = response.ok_or(ResponseReason::NoSlowResponse)?;
    let settings = Settings { period_s: *period_s, order: Order::First, most_delay_s: MOST_DELAY_S };
    let found = transport_at_known_corner(lines, &settings, [corner.value, corner.u])?;
    Ok(Slow { found, period_s: *period_s, corner_hz: corner.value, fast, lines: lines.len() })
}

fn slow_itself(slow: &Slow) -> (Estimate, Vec<String>) {
    let told = [
        format!("commands every {:.0} us, hold {:.0} us apart", us(slow.period_s), us(0.5 * slow.period_s)),
        format!("corner {:.0} Hz from the loop rate", slow.corner_hz),
    ];
    let flags = told.into_iter().chain(slow.found.goodness.flag()).collect();
    (estimate(slow.found.transport_s, slow.found.transport_u_s, slow.lines), flags)
}

fn rates(slow: &Slow) -> (Estimate, Vec<String>) {
    let Value { value: fast_s, u: fast_u_s } = slow.fast;
    let told = [
        format!("{:.1} us with commands every {:.0} us", us(slow.found.transport_s), us(slow.period_s)),
        format!(
            "hold {:.0} us apart; corner {:.0} Hz from the loop rate",
            us(0.5 * slow.period_s),
            slow.corner_hz
        ),
    ];
    let flags = told.into_iter().chain(slow.found.goodness.flag()).collect();
    let u_s = slow.found.transport_u_s.hypot(fast_u_s);
    (estimate(slow.found.transport_s - fast_s, u_s, slow.lines), flags)
}

fn back(points: &[PointResult], transports: &[Value]) -> Found {
    let round_s = mean(transports).ok_or(ResponseReason::RoundTripNotFound)?;
    let out: Vec<&WayOut> = points.iter().filter_map(|point| point.reduced.get()).collect();
    let first = out.first().ok_or(ResponseReason::NoWayOut)?;
    let out_s = first.delay_s;
    let flags =
        vec![format!("round trip {:.1} us less {:.1} us outward delay", us(round_s.value), us(out_s.value))];
    let difference_s = round_s.value - out_s.value;
    Ok((estimate(difference_s, round_s.u.hypot(out_s.u), out.len() + transports.len()), flags))
}

/// The round trip with lag and hold, as far as the lag has a verdict.
fn remark(round_s: f64, measurements: &[Measurement]) -> String {
    let find = |name: &str| measurements.iter().find(|m| m.measurand == name && m.inconclusive.is_none());
    let value_s = |name: &str| find(name).and_then(|m| m.value);
    let (Some(lag_s), Some(hold_s)) = (value_s(LAG), value_s(HOLD)) else {
        return format!("Round trip {:.1} us of transport.", us(round_s));
    };
    format!(
        "Round trip {:.1} us of transport; {:.1} us with the lag of the current loop ({:.1} us), {:.1} us with the \
         hold of the command ({:.1} us) too.",
        us(round_s),
        us(round_s + lag_s),
        us(lag_s),
        us(round_s + lag_s + hold_s),
        us(hold_s)
    )
}
