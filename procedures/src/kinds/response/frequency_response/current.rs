//! The current loop: torque that was sent to torque that the drive shows.

use analysis::estimate::Estimate;
use analysis::lag::{LagFit, Order, Settings, current_loop};

use super::pictures;
use super::point::Point;
use crate::kinds::response::excited::Channel;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAME: &str = "current-bandwidth";
const ESTIMATOR: &str = "current-loop-lag/1";
/// Below this loop rate a bandwidth around 1 kHz lies beyond what the samples can show (director.md, CUR-BW).
const LEAST_LOOP_RATE_HZ: f64 = 4000.0;
/// No current loop answers later than this.
const MOST_DELAY_S: f64 = 0.02;

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    let axis = &point.case.axis;
    let measurement = match fit(point, result) {
        Ok((fit, lines)) => measurement(axis, &fit, lines),
        Err(reason) => Measurement::inconclusive(NAME, axis, Q::Frequency, ESTIMATOR, reason),
    };
    result.measurements.push(point.measurement(measurement));
}

/// The fitted loop, and how many lines it rests on. Friction has no part in it, so presliding does not matter.
fn fit(point: &Point<'_>, result: &mut PointResult) -> Result<(LagFit, usize), String> {
    let rate_hz = point.limits.loop_rate_hz;
    if rate_hz < LEAST_LOOP_RATE_HZ {
        return Err(format!(
            "loop rate {rate_hz} Hz: a bandwidth around 1 kHz needs samples at {LEAST_LOOP_RATE_HZ} Hz"
        ));
    }
    let judged = point.response_while_holding(Channel::Torque, Channel::Shown)?;
    let title = format!("Current loop with hold and transport, {}", point.case.point);
    result.plots.extend(pictures::bode(&format!("current-{}", point.slug()), &title, "1", &judged));
    let with = |order| {
        let settings = Settings { period_s: 1.0 / rate_hz, order, most_delay_s: MOST_DELAY_S };
        current_loop(&judged.lines, &settings).map_err(|e| e.to_string())
    };
    let first = with(Order::First)?;
    let fit = if first.misfit { with(Order::Second)? } else { first };
    if fit.misfit {
        return Err(format!(
            "no lag of first or second order describes the loop: chi2/dof {:.1} and {:.1}, expected about 1",
            first.misfit_ratio, fit.misfit_ratio
        ));
    }
    Ok((fit, judged.lines.len()))
}

fn measurement(axis: &str, fit: &LagFit, n: usize) -> Measurement {
    let estimate = Estimate { value: fit.corner_hz, u: fit.corner_u_hz, dof: f64::INFINITY, n };
    let us = |s: f64| 1e6 * s;
    Measurement {
        flags: vec![
            format!("hold {:.0} us and transport {:.1} us removed", us(fit.hold_s), us(fit.transport_s)),
            format!("gain {:.4}", fit.gain),
            match fit.damping {
                Some([zeta, _]) => format!("second order, damping ratio {zeta:.3}"),
                None => "first order".to_owned(),
            },
        ],
        ..Measurement::new(NAME, axis, Q::Frequency, Some(estimate), ESTIMATOR)
    }
}
