//! Transport by fit: the response of the current as a sampled loop, so that lag and hold come out apart.

use analysis::estimate::Estimate;
use analysis::frf::{Frf, Line, unwrapped_rad};
use analysis::lag::{LagFit, Order, Settings, current_loop, sampled_response};

use super::Value;
use super::response::{LIMITED, Response, response};
use super::result::{evidence, measurement, us};
use super::{HOLD, LAG, ROUND_TRIP};
use crate::axis::AxisLimits;
use crate::case::Case;
use crate::log::Window;
use crate::measurement::{Exclusion, Measurement, PointResult, Reduced};
use crate::trace::{Plot, Scale, Series, Style};

/// No command answers later than this.
pub(super) const MOST_DELAY_S: f64 = 0.02;
/// Below this loop rate a corner around 1 kHz cannot be told from a delay.
const LEAST_LOOP_RATE_HZ: f64 = 4000.0;

/// What a point at the loop rate says of the loop.
pub(super) struct Loop {
    pub(super) transport_s: Value,
    pub(super) corner_hz: Value,
}

/// The response to commands at a part of the loop rate.
pub(super) struct SlowResponse {
    pub(super) lines: Frf,
    /// Period of the commands.
    pub(super) period_s: f64,
}

/// A point at the loop rate.
pub(super) fn fit(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, String> {
    let rate_hz = limits.loop_rate_hz;
    if rate_hz < LEAST_LOOP_RATE_HZ {
        return Err(format!(
            "loop rate {rate_hz} Hz: lag and transport come apart from {LEAST_LOOP_RATE_HZ} Hz on"
        ));
    }
    let found = response(case, window, limits, 1)?;
    let (fit, flags, u_s) = loop_of(&found.lines, 1.0 / rate_hz)?;
    let n = found.lines.len();
    let estimate = |value, u| Estimate { value, u, dof: f64::INFINITY, n };
    let lag_u_s = fit.lag_s * fit.corner_u_hz / fit.corner_hz;
    let evidence =
        evidence(window, &format!("/{}", case.axis), &["excitation", "torque_command_nm", "current_a"]);
    let with = |name: &str, estimate: Estimate, flags: Vec<String>| Measurement {
        evidence: evidence.clone(),
        ..measurement(name, case, found.level_v, estimate, flags)
    };
    Ok(PointResult {
        point: case.point.clone(),
        measurements: vec![
            with(ROUND_TRIP, estimate(fit.transport_s, u_s), [totals(&fit, &found), flags].concat()),
            with(LAG, estimate(fit.lag_s, lag_u_s), vec![corner(&fit)]),
            with(HOLD, estimate(fit.hold_s, 0.0), vec!["half a period, exact".to_owned()]),
        ],
        plots: vec![picture(case, &found.lines, &fit, 1.0 / rate_hz)],
        reduced: Reduced::to(Loop {
            transport_s: Value { value: fit.transport_s, u: u_s },
            corner_hz: Value { value: fit.corner_hz, u: fit.corner_u_hz },
        }),
        excluded: excluded(&found),
        ..PointResult::default()
    })
}

/// The loop, remarks about it, and the standard uncertainty of its transport. A loop that is none of first order is taken
/// as one of second order; where that does not fit either, what the two say of the transport differs by its uncertainty.
fn loop_of(lines: &[Line], period_s: f64) -> Result<(LagFit, Vec<String>, f64), String> {
    let settings = Settings { period_s, order: Order::First, most_delay_s: MOST_DELAY_S };
    let first = current_loop(lines, &settings).map_err(|e| e.to_string())?;
    if !first.misfit {
        return Ok((first, Vec::new(), first.transport_u_s));
    }
    let second = current_loop(lines, &Settings { order: Order::Second, ..settings });
    match second {
        Ok(second) if !second.misfit => {
            Ok((second, vec!["current loop of second order".to_owned()], second.transport_u_s))
        }
        other => {
            let apart_s = other.map_or(first.lag_s, |second| (second.transport_s - first.transport_s).abs());
            let flag = format!(
                "a lag of first order does not describe the loop: chi2/dof {:.1}, expected about 1",
                first.misfit_ratio
            );
            Ok((first, vec![flag], first.transport_u_s.hypot(apart_s)))
        }
    }
}

fn totals(fit: &LagFit, found: &Response) -> Vec<String> {
    let lagged_s = fit.transport_s + fit.lag_s;
    vec![
        format!("with lag {:.1} us, with lag and hold {:.1} us", us(lagged_s), us(lagged_s + fit.hold_s)),
        format!("correlation with the corner {:.2}", fit.correlation),
        format!("{} lines, {} windows", found.lines.len(), found.windows),
    ]
}

fn corner(fit: &LagFit) -> String {
    format!("corner {:.1} Hz, gain {:.4}", fit.corner_hz, fit.gain)
}

fn excluded(found: &Response) -> Vec<Exclusion> {
    let exclusion = |count: usize, of: &str, reason: &str| Exclusion {
        count,
        of: of.to_owned(),
        reason: reason.to_owned(),
    };
    let all = [
        exclusion(found.noisy, "lines", "signal to noise below 20 dB"),
        exclusion(found.limited, "windows", LIMITED),
    ];
    all.into_iter().filter(|e| e.count > 0).collect()
}

/// Phase over frequency, measured and fitted.
fn picture(case: &Case, lines: &[Line], fit: &LagFit, period_s: f64) -> Plot {
    let hz: Vec<f64> = lines.iter().map(|l| l.frequency_hz).collect();
    let damping = fit.damping.map(|[zeta, _]| zeta);
    let model = |l: &Line| {
        let value = sampled_response(l.frequency_hz, period_s, fit.corner_hz, damping, fit.transport_s);
        Line::exact(l.frequency_hz, value)
    };
    let degrees = |lines: &[Line]| unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect::<Vec<_>>();
    let modelled: Vec<Line> = lines.iter().map(model).collect();
    let slug = case.point.replace([',', '=', ' '], "-");
    Plot {
        series: vec![
            Series::new("measured", Style::Markers, hz.clone(), degrees(lines)),
            Series::new("lag, hold and transport", Style::Fit, hz, degrees(&modelled)),
        ],
        ..Plot::new(
            format!("phase-{slug}"),
            format!("Current over torque command: phase, {}", case.point),
            Scale::logarithmic("frequency", "Hz"),
            Scale::linear("phase", "deg"),
        )
    }
}

/// A point with commands at a part of the loop rate: its lines, for when the corner is known.
pub(super) fn slow(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, String> {
    let every = case.excitations.first().map_or(1, |e| e.every_ticks.max(1));
    let found = response(case, window, limits, every as usize)?;
    let excluded = excluded(&found);
    let period_s = f64::from(every) / limits.loop_rate_hz;
    Ok(PointResult {
        reduced: Reduced::to(SlowResponse { lines: found.lines, period_s }),
        excluded,
        ..PointResult::of(case)
    })
}
