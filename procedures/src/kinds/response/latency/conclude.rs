//! Measurements of a point, and what takes more than one: differences between levels and rates, the way back.

use analysis::estimate::Estimate;
use analysis::lag::{KnownLag, LagError, Order, Settings, transport_at_known_corner};
use analysis::uncertainty::rectangular_u;

use super::fit::{Loop, MOST_DELAY_S, SlowResponse, WayOut};
use super::plan::{Keys, Stage};
use super::{BACK, HOLD, JITTER, LAG, LEVELS, RATES, ROUND_TRIP, SLOW, Value};
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
    blame_jitter(&mut conclusion, points);
    let smear_u_s = count_jitter(&mut conclusion, points);
    let loops: Vec<&Loop> = points.iter().filter_map(|point| point.reduced.get()).collect();
    let transports: Vec<Value> = loops.iter().map(|found| found.transport_s).collect();
    let corners: Vec<Value> = loops.iter().map(|found| found.corner_hz).collect();
    let mut add = |name: &str, found: Found, smear_u_s: f64| {
        let mut measurement = named(name, axis, found);
        if measurement.value.is_some() {
            measurement.add_known(smear_u_s);
        }
        conclusion.measurements.push(measurement);
    };
    // What jitter leaves in the fit is the same at every level.
    if keys.has(Stage::Fit) && keys.levels_v.len() > 1 {
        add(LEVELS, levels(&transports), 0.0);
    }
    if keys.has(Stage::Slow) {
        let slow = slow(points, &transports, &corners);
        let slow = slow.as_ref().map_err(Clone::clone);
        add(SLOW, slow.clone().map(slow_itself), smear_u_s);
        add(RATES, slow.map(rates), smear_u_s);
    }
    if keys.has(Stage::Probe) {
        add(BACK, back(points, &transports), smear_u_s);
    }
    conclusion.remarks.extend(mean(&transports).map(|transport_s| remark(transport_s.value, points)));
    conclusion
}

/// Jitter smears the response. Where steps show that the delay jitters, a fit without a corner, or one that neither order
/// describes, is that of no loop; the lag of second order is not that of the current loop.
fn blame_jitter(conclusion: &mut Conclusion, points: &[PointResult]) {
    let jitter = conclusion.measurements.iter().find(|m| m.measurand == JITTER);
    let Some(jitter_s) = jitter.and_then(|m| m.value).filter(|value| *value > LEAST_JITTER_S) else { return };
    let reason = ResponseReason::DelayJitters { jitter_s }.to_string();
    for point in points {
        let lost: &[&str] = match (&point.inconclusive, point.reduced.get::<Loop>().map(|found| found.order))
        {
            (Some(Reason::Lag(LagError::NotDetermined { .. })), _) | (_, Some(None)) => {
                &[ROUND_TRIP, LAG, HOLD]
            }
            (_, Some(Some(Order::Second))) => &[LAG],
            _ => &[],
        };
        let all = conclusion.measurements.iter_mut().filter(|m| m.point.as_deref() == Some(&point.point));
        all.filter(|m| lost.contains(&m.measurand.as_str()))
            .for_each(|m| m.inconclusive = Some(reason.clone()));
    }
}

/// By how many σ²/τ a fit of first order may be off, if the delay has the standard deviation σ and the current loop the lag τ: the
/// smear goes into lag and delay, with opposite signs. Drawn units with up to 50 us of jitter need 2.7. It is never more than σ:
/// exact responses need 0.85 σ (those of [`SECOND_ORDER_SMEAR_RATIO`]). Half-width of a rectangular distribution (ours).
const SMEAR_RATIO: f64 = 3.0;

/// By how many σ the delay of a fit of second order may be off: its second pole takes up the smear, and the delay of that pole is
/// missing. Responses of loops of 700 Hz to 1300 Hz, sampled at 4 kHz behind evenly distributed delays of 50 us to 850 us width, are
/// 1.59 σ short to 0.20 σ long, whatever their lag. Half-width of a rectangular distribution (ours).
const SECOND_ORDER_SMEAR_RATIO: f64 = 1.6;

/// Adds to the round trips by fit what jitter leaves in them, as far as steps cannot exclude it. Returns the largest such
/// standard uncertainty, s.
fn count_jitter(conclusion: &mut Conclusion, points: &[PointResult]) -> f64 {
    let jitter = conclusion.measurements.iter().find(|m| m.measurand == JITTER && m.value.is_some());
    let Some(most_s) = jitter.and_then(|m| Some(m.value? + m.u)) else { return 0.0 };
    let mut largest_u_s: f64 = 0.0;
    for point in points {
        let Some(found) = point.reduced.get::<Loop>() else { continue };
        let half_width_s = match found.order {
            Some(Order::Second) => SECOND_ORDER_SMEAR_RATIO * most_s,
            _ => most_s.min(SMEAR_RATIO * most_s * most_s / found.lag_s),
        };
        let u_s = rectangular_u(half_width_s);
        largest_u_s = largest_u_s.max(u_s);
        let mine = conclusion.measurements.iter_mut().filter(|m| m.point.as_deref() == Some(&point.point));
        mine.filter(|m| m.measurand == ROUND_TRIP && m.value.is_some()).for_each(|m| m.add_known(u_s));
    }
    largest_u_s
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

fn remark(round_s: f64, points: &[PointResult]) -> String {
    let lag = points.iter().flat_map(|p| &p.measurements).find(|m| m.measurand == LAG);
    let hold = points.iter().flat_map(|p| &p.measurements).find(|m| m.measurand == HOLD);
    let [lag_s, hold_s] = [lag, hold].map(|m| m.and_then(|m| m.value).unwrap_or_default());
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
