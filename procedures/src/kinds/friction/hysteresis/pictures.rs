//! Pictures: hysteresis loop of a point, friction over velocity, unbalance and spring, cogging.

use analysis::cogging::Amplitude;

use super::cogging::WithSpectrum;
use super::conclude::{FrictionCurve, SeparatingPoint};
use super::point::{EffortCurve, Finding, SlidingPoint};
use super::{AMPLITUDE, AMPLITUDE_CURRENT, FRICTION};
use crate::case::Case;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

/// Points of a fitted curve.
const CURVE_POINTS: u32 = 200;
/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;

fn scale(label: &str, kind: Q) -> Scale {
    Scale { label: label.to_owned(), unit: kind.display_unit().to_owned(), log: false }
}

fn shown(kind: Q, values: &[f64]) -> Vec<f64> {
    values.iter().map(|&v| kind.to_display(v)).collect()
}

fn series(label: &str, style: Style, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series::new(label, style, x, y)
}

fn plot(id: String, title: String, x: Scale, y: Scale, series: Vec<Series>) -> Plot {
    Plot { series, ..Plot::new(id, title, x, y) }
}

/// A name fit for an id: `velocity=10 deg/s` becomes `velocity-10-deg-s`.
fn slug(name: &str) -> String {
    let mut text = String::new();
    for c in name.chars() {
        if c.is_ascii_alphanumeric() || c == '.' {
            text.push(c.to_ascii_lowercase());
        } else if !text.ends_with('-') && !text.is_empty() {
            text.push('-');
        }
    }
    text.trim_end_matches('-').to_owned()
}

/// Torque over angle, both branches.
pub(super) fn hysteresis_loop(case: &Case, kind: Q, finding: &Finding) -> Option<Plot> {
    let branch = |label: &str, curve: &EffortCurve| {
        let angle = shown(Q::Angle, &curve.angle_rad);
        let effort = shown(kind, &curve.effort);
        (!angle.is_empty()).then(|| Series::thinned(label, Style::Line, [&angle, &effort], MAX_POINTS))
    };
    let mut all: Vec<Series> = Vec::new();
    all.extend(branch("forward", &finding.forward));
    all.extend(branch("reverse", &finding.reverse));
    if all.is_empty() {
        return None;
    }
    let title = format!("Hysteresis loop, {}", case.point);
    let effort_label = if kind == Q::Torque { "motor torque less inertia" } else { "motor current" };
    Some(plot(
        format!("loop-{}", slug(&case.point)),
        title,
        scale("angle", Q::Angle),
        scale(effort_label, kind),
        all,
    ))
}

/// Friction over velocity with fit and band; excluded points stay visible as far as they reached a velocity.
pub(super) fn friction_curve(curve: &FrictionCurve, points: &[PointResult]) -> Option<Plot> {
    let velocities: Vec<f64> = curve.points.iter().map(|p| p.velocity_rad_per_s).collect();
    let low = velocities.iter().copied().reduce(f64::min)?;
    let high = velocities.iter().copied().reduce(f64::max)?;
    let log = high / low > 30.0;
    let mut all = fitted_curve(curve, low, high, log);
    let y = curve.points.iter().map(|p| p.friction_nm).collect();
    let u = curve.points.iter().map(|p| COVERAGE * p.u_nm).collect();
    let markers = series("friction, k = 2", Style::Markers, shown(Q::AngularVelocity, &velocities), y);
    all.push(Series { u, ..markers });
    all.extend(excluded(points));
    let x = Scale { log, ..scale("velocity", Q::AngularVelocity) };
    let picture = plot(
        "friction-velocity".into(),
        "Friction over velocity".into(),
        x,
        scale("friction", Q::Torque),
        all,
    );
    Some(Plot { limits_of: Some(FRICTION.to_owned()), ..picture })
}

/// Band and line of what was fitted to friction, from the lowest to the highest velocity.
fn fitted_curve(curve: &FrictionCurve, low_rad_per_s: f64, high_rad_per_s: f64, log: bool) -> Vec<Series> {
    let mut x = Vec::new();
    let mut y = Vec::new();
    let mut u = Vec::new();
    for k in 0..CURVE_POINTS {
        let share = f64::from(k) / f64::from(CURVE_POINTS - 1);
        let velocity = if log {
            low_rad_per_s * (high_rad_per_s / low_rad_per_s).powf(share)
        } else {
            low_rad_per_s + (high_rad_per_s - low_rad_per_s) * share
        };
        let [torque_nm, torque_u_nm] = match (&curve.fitted, &curve.line) {
            (Ok(fit), _) => [fit.parameters.at_nm(velocity), fit.u_at_nm(velocity)],
            (Err(_), Some(line)) if velocity >= line.from_rad_per_s * (1.0 - 1e-9) => line.at_nm(velocity),
            _ => continue,
        };
        x.push(Q::AngularVelocity.to_display(velocity));
        y.push(torque_nm);
        u.push(COVERAGE * torque_u_nm);
    }
    if x.is_empty() {
        return Vec::new();
    }
    let name = if curve.fitted.is_ok() { "Stribeck fit" } else { "T_C + σ2·ω" };
    let band = Series { u, ..series("fit, k = 2", Style::Band, x.clone(), y.clone()) };
    vec![band, series(name, Style::Fit, x, y)]
}

/// Friction values that did not stand (a condition of the procedure was broken), hollow.
fn excluded(points: &[PointResult]) -> Option<Series> {
    let mut x = Vec::new();
    let mut y = Vec::new();
    for point in points.iter().filter(|p| p.reduced.get::<SlidingPoint>().is_none()) {
        for measurement in point.measurements.iter().filter(|m| m.measurand == FRICTION) {
            let velocity =
                measurement.conditions.iter().find(|c| c.name == "velocity").and_then(|c| c.achieved);
            if let (Some(value), Some(velocity)) = (measurement.value, velocity) {
                x.push(Q::AngularVelocity.to_display(velocity));
                y.push(Q::Torque.to_display(value));
            }
        }
    }
    (!x.is_empty()).then(|| series("excluded", Style::Excluded, x, y))
}

/// Half-sum of both directions with the fit of unbalance and spring.
pub(super) fn half_sum(best: &SeparatingPoint<'_>) -> Plot {
    let half_sum = &best.point.half_sum;
    let x = shown(Q::Angle, &half_sum.angle_rad);
    let fitted: Vec<f64> = half_sum.angle_rad.iter().map(|&angle| best.fit.at_nm(angle)).collect();
    let measured = [&x[..], &half_sum.torque_nm];
    let all = vec![
        Series::thinned("half-sum, mean of a cogging period", Style::Markers, measured, MAX_POINTS),
        Series::thinned("-A_u cos θ + K_s (θ - θ_0)", Style::Fit, [&x, &fitted], MAX_POINTS),
    ];
    let title = format!("Unbalance and spring, {}", best.point.name);
    plot("half-sum".into(), title, scale("angle", Q::Angle), scale("half-sum", Q::Torque), all)
}

/// Cogging spectrum in orders per revolution.
pub(super) fn spectrum(slowest: &WithSpectrum<'_>) -> Plot {
    let kind = slowest.point.kind;
    let spectrum = &slowest.cogging.spectrum;
    let lines = [&spectrum.order_per_rev[..], &spectrum.amplitude];
    let order = spectrum.harmonics.iter().map(|h| h.at_order_per_rev).collect();
    let cogging: Vec<Amplitude> = spectrum.harmonics.iter().map(|h| slowest.cogging_line(h)).collect();
    let amplitude = cogging.iter().map(|line| line.amplitude).collect();
    let u = cogging.iter().map(|line| COVERAGE * line.u).collect();
    let all = vec![
        Series::thinned("mean of both directions", Style::Bars, lines, MAX_POINTS),
        Series { u, ..series("harmonics, k = 2", Style::Markers, order, amplitude) },
    ];
    let title = format!("Cogging spectrum, {}", slowest.point.name);
    let picture = plot(
        "cogging-spectrum".into(),
        title,
        scale("order", Q::SpatialOrder),
        scale("amplitude", kind),
        all,
    );
    let limits_of = if kind == Q::Torque { AMPLITUDE } else { AMPLITUDE_CURRENT };
    Plot { limits_of: Some(limits_of.to_owned()), ..picture }
}
