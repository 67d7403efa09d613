//! The open velocity loop and its margins.

use super::honest::{self, Judged};
use super::pictures;
use super::point::Point;
use crate::analysis::margins::{MarginError, Margins, NoCrossing, Settings, margins};
use crate::kinds::excited::Channel;
use crate::measurement::{Estimate, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAMES: &[&str] = &[
    "velocity-bandwidth",
    "velocity-gain-margin",
    "velocity-phase-margin",
    "velocity-delay-margin",
    "velocity-modulus-margin",
    "velocity-disk-margin",
];
const ESTIMATOR: &str = "velocity-margins/1";
/// PI controller and inertia.
const INTEGRATORS: u32 = 1;

/// A loop whose margins are read.
pub(super) struct Loop {
    /// Measurands, in the order of [`NAMES`]: as many of them as are wanted.
    pub(super) names: &'static [&'static str],
    pub(super) title: &'static str,
    /// Poles of the open loop at 0.
    pub(super) integrators_count: u32,
    pub(super) estimator: &'static str,
}

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    let of = Loop {
        names: NAMES,
        title: "Open velocity loop",
        integrators_count: INTEGRATORS,
        estimator: ESTIMATOR,
    };
    evaluate_loop(&of, point, point.response(Channel::Error, Channel::Rate), result);
}

pub(super) fn evaluate_loop(
    of: &Loop,
    point: &Point<'_>,
    judged: Result<Judged, String>,
    result: &mut PointResult,
) {
    let judged = match judged {
        Ok(judged) => judged,
        Err(reason) => return none(of, point, &reason, result),
    };
    keep(&judged, result);
    let (id, title) = (format!("loop-{}", point.slug()), format!("{}, {}", of.title, point.case.point));
    result.plots.extend(pictures::bode(&id, &title, "1", &judged));
    if let Some(corner_hz) = judged.presliding_below_hz {
        return none(of, point, &honest::presliding(&point.measured, corner_hz), result);
    }
    let settings = Settings { integrators_count: of.integrators_count, ..Settings::default() };
    match margins(&judged.lines, &settings) {
        Ok(found) => {
            let title = format!("Nyquist, {}", point.case.point);
            result.plots.push(pictures::nyquist(
                &format!("nyquist-{}", point.slug()),
                &title,
                &judged,
                &found,
            ));
            all(of, point, (&judged, &found), result);
        }
        Err(error) => none(of, point, &error.to_string(), result),
    }
}

/// The lines for pictures over all points.
fn keep(judged: &Judged, result: &mut PointResult) {
    for (name, lines) in [("loop", &judged.lines), ("loop-hollow", &judged.hollow)] {
        let mut put = |what: &str, of: &dyn Fn(&crate::analysis::frf::Line) -> f64| {
            result.numbers.insert(format!("{name}-{what}"), lines.iter().map(of).collect());
        };
        put("hz", &|l| l.frequency_hz);
        put("re", &|l| l.value.re);
        put("im", &|l| l.value.im);
        put("variance", &|l| l.variance);
        put("dof", &|l| l.dof);
        put("coherence", &|l| l.coherence.unwrap_or(1.0));
    }
}

fn none(of: &Loop, point: &Point<'_>, reason: &str, result: &mut PointResult) {
    let kinds = [Q::Frequency, Q::Decibel, Q::Angle, Q::Time, Q::Ratio, Q::Ratio];
    for (name, kind) in of.names.iter().zip(kinds) {
        let measurement = Measurement::inconclusive(name, &point.case.axis, kind, of.estimator, reason);
        result.measurements.push(point.measurement(measurement));
    }
}

fn all(of: &Loop, point: &Point<'_>, (judged, found): (&Judged, &Margins), result: &mut PointResult) {
    let n = judged.lines.len();
    let dof = judged.lines.iter().map(|l| 2.0 * l.dof).fold(f64::INFINITY, f64::min);
    let estimate = |value, u| Estimate { value, u, dof, n };
    let bandwidth = found.bandwidth().map(|c| estimate(c.frequency_hz, c.frequency_u_hz));
    let gain = found.gain_margin().map(|c| estimate(c.gain_margin_db, c.gain_margin_u_db));
    let phase = found.phase_margin().map(|c| estimate(c.phase_margin_rad, c.phase_margin_u_rad));
    let delay = found.delay_margin().map(|c| estimate(c.delay_margin_s, c.delay_margin_u_s));
    let modulus = Ok(estimate(found.modulus.value, found.modulus.u));
    let disk = Ok(estimate(found.disk.alpha.value, found.disk.alpha.u));
    let rows: [(Q, Result<Estimate, NoCrossing>); 6] = [
        (Q::Frequency, bandwidth),
        (Q::Decibel, gain),
        (Q::Angle, phase),
        (Q::Time, delay),
        (Q::Ratio, modulus),
        (Q::Ratio, disk),
    ];
    for (name, (kind, value)) in of.names.iter().zip(rows) {
        let axis = &point.case.axis;
        let mut measurement = match value {
            Ok(estimate) => Measurement::new(name, axis, kind, Some(estimate), of.estimator),
            Err(none) => {
                let reason = MarginError::from(none).to_string();
                Measurement::inconclusive(name, axis, kind, of.estimator, reason)
            }
        };
        measurement.excluded = judged.excluded.clone();
        measurement.flags = found.doubts.iter().map(|d| format!("not certified: {d}")).collect();
        measurement.flags.extend(bridged(judged, found));
        result.measurements.push(point.measurement(measurement));
    }
}

/// Crossings that were read across lines that do not count.
fn bridged(judged: &Judged, found: &Margins) -> Vec<String> {
    let crossings = found.gain_crossings.iter().map(|c| c.frequency_hz);
    let crossings = crossings.chain(found.phase_crossings.iter().map(|c| c.frequency_hz));
    let across = |hz: f64| {
        let above = judged.lines.partition_point(|l| l.frequency_hz < hz);
        let (low, high) = (judged.lines.get(above.wrapping_sub(1))?, judged.lines.get(above)?);
        let gap = low.frequency_hz..high.frequency_hz;
        judged.hollow.iter().find(|l| gap.contains(&l.frequency_hz)).map(|l| (hz, l.frequency_hz))
    };
    let text = |(hz, hollow): (f64, f64)| {
        format!(
            "not certified: crossing at {hz:.2} Hz is read across the line at {hollow:.2} Hz, which does not count"
        )
    };
    crossings.filter_map(across).map(text).collect()
}
