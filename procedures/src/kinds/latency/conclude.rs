//! What takes more than one point: differences between levels and rates, the way back.

use analysis::estimate::Estimate;
use analysis::lag::{KnownLag, Order, Settings, transport_at_known_corner};

use super::fit::{CORNER, MOST_DELAY_S, TRANSPORT, slow_lines};
use super::keys::{Keys, Stage};
use super::probe::WAY_OUT;
use super::result::{ESTIMATOR, us};
use super::{BACK, LEVELS, RATES, SLOW};
use crate::case::Case;
use crate::measurement::{Conclusion, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

/// A value with its standard uncertainty.
type Value = [f64; 2];
type Found = Result<(Estimate, Vec<String>), String>;

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult]) -> Conclusion {
    let axis = cases.first().map_or("", |case| case.axis.as_str());
    let mut measurements: Vec<Measurement> = points.iter().flat_map(|p| p.measurements.clone()).collect();
    let transports = values(points, TRANSPORT);
    let mut add = |name: &str, found: Found| measurements.push(named(name, axis, found));
    if keys.has(Stage::Fit) && keys.levels_v.len() > 1 {
        add(LEVELS, levels(&transports));
    }
    if keys.has(Stage::Slow) {
        let slow = slow(points, &transports);
        let slow = slow.as_ref().map_err(Clone::clone);
        add(SLOW, slow.clone().map(slow_itself));
        add(RATES, slow.map(rates));
    }
    if keys.has(Stage::Probe) {
        add(BACK, back(points, &transports));
    }
    let remarks = mean(&transports).map(|[value, _]| remark(value, points)).into_iter().collect();
    let plots = points.iter().flat_map(|p| p.plots.clone()).collect();
    Conclusion { measurements, plots, remarks, ..Conclusion::default() }
}

fn named(name: &str, axis: &str, found: Found) -> Measurement {
    match found {
        Ok((estimate, flags)) => {
            Measurement { flags, ..Measurement::new(name, axis, Q::Time, Some(estimate), ESTIMATOR) }
        }
        Err(reason) => Measurement::inconclusive(name, axis, Q::Time, ESTIMATOR, reason),
    }
}

fn values(points: &[PointResult], name: &str) -> Vec<Value> {
    let pair = |p: &PointResult| p.numbers.get(name).and_then(|v| Some([*v.first()?, *v.get(1)?]));
    points.iter().filter_map(pair).collect()
}

/// Mean with the larger of what the uncertainties and what the scatter say of it.
fn mean(values: &[Value]) -> Option<Value> {
    let n = values.len() as f64;
    if values.is_empty() {
        return None;
    }
    let mean = values.iter().map(|v| v[0]).sum::<f64>() / n;
    let within = values.iter().map(|v| v[1] * v[1]).sum::<f64>().sqrt() / n;
    let between = values.iter().map(|v| (v[0] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0).max(1.0));
    Some([mean, within.max(between.sqrt())])
}

fn estimate(value: f64, u: f64, n: usize) -> Estimate {
    Estimate { value, u, dof: f64::INFINITY, n }
}

fn levels(transports: &[Value]) -> Found {
    if transports.len() < 2 {
        return Err(format!(
            "the round trip was found at {} levels, at least 2 are needed",
            transports.len()
        ));
    }
    let by = |a: &&Value, b: &&Value| a[0].total_cmp(&b[0]);
    let (low, high) = (transports.iter().min_by(by), transports.iter().max_by(by));
    let (Some(low), Some(high)) = (low, high) else { return Err("no round trip".to_owned()) };
    let (difference, u) = (high[0] - low[0], high[1].hypot(low[1]));
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

fn slow(points: &[PointResult], transports: &[Value]) -> Result<Slow, String> {
    let missing = "the corner of the current loop was not found at the loop rate";
    let fast = mean(transports).ok_or(missing)?;
    let corner = mean(&values(points, CORNER)).ok_or(missing)?;
    let (lines, period_s) =
        points.iter().find_map(slow_lines).ok_or("no response to slow commands was found")?;
    let settings = Settings { period_s, order: Order::First, most_delay_s: MOST_DELAY_S };
    let found = transport_at_known_corner(&lines, &settings, corner).map_err(|e| e.to_string())?;
    Ok(Slow { found, period_s, corner_hz: corner[0], fast, lines: lines.len() })
}

fn slow_itself(slow: &Slow) -> (Estimate, Vec<String>) {
    let flags = vec![
        format!("commands every {:.0} us, hold {:.0} us apart", us(slow.period_s), us(0.5 * slow.period_s)),
        format!(
            "corner {:.0} Hz from the loop rate; chi2/dof {:.1}",
            slow.corner_hz, slow.found.misfit_ratio
        ),
    ];
    (estimate(slow.found.transport_s, slow.found.transport_u_s, slow.lines), flags)
}

fn rates(slow: &Slow) -> (Estimate, Vec<String>) {
    let [fast_s, fast_u_s] = slow.fast;
    let flags = vec![
        format!("{:.1} us with commands every {:.0} us", us(slow.found.transport_s), us(slow.period_s)),
        format!(
            "hold {:.0} us apart; corner {:.0} Hz from the loop rate",
            us(0.5 * slow.period_s),
            slow.corner_hz
        ),
        format!("chi2/dof {:.1}", slow.found.misfit_ratio),
    ];
    let u_s = slow.found.transport_u_s.hypot(fast_u_s);
    (estimate(slow.found.transport_s - fast_s, u_s, slow.lines), flags)
}

fn back(points: &[PointResult], transports: &[Value]) -> Found {
    let [round_s, round_u_s] = mean(transports).ok_or("the round trip was not found")?;
    let out = values(points, WAY_OUT);
    let [out_s, out_u_s] = *out.first().ok_or("the way out was not found: no record of a current probe")?;
    let flags = vec![format!("round trip {:.1} us less {:.1} us on the way out", us(round_s), us(out_s))];
    Ok((estimate(round_s - out_s, round_u_s.hypot(out_u_s), out.len() + transports.len()), flags))
}

fn remark(round_s: f64, points: &[PointResult]) -> String {
    let lag = points.iter().flat_map(|p| &p.measurements).find(|m| m.measurand == super::LAG);
    let hold = points.iter().flat_map(|p| &p.measurements).find(|m| m.measurand == super::HOLD);
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
