//! Pictures of the kind.

use super::cogging::markers;
use super::curve::Curve;
use super::gravity::Chosen;
use super::measurands::{AMPLITUDE, AMPLITUDE_CURRENT, FRICTION};
use super::numbers::{Cogging, Valid};
use super::point::Finding;
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

fn effort_label(kind: Q) -> &'static str {
    if kind == Q::Torque { "motor torque less inertia" } else { "motor current" }
}

/// Torque over angle, both branches.
pub(super) fn hysteresis_loop(case: &Case, kind: Q, finding: &Finding) -> Option<Plot> {
    let branch = |label: &str, [angle, value]: &[Vec<f64>; 2]| {
        Series::thinned(label, Style::Line, [&shown(Q::Angle, angle), &shown(kind, value)], MAX_POINTS)
    };
    let all: Vec<Series> = [("forward", &finding.forward), ("reverse", &finding.reverse)]
        .into_iter()
        .filter(|(_, curve)| !curve[0].is_empty())
        .map(|(label, curve)| branch(label, curve))
        .collect();
    if all.is_empty() {
        return None;
    }
    let title = format!("Hysteresis loop, {}", case.point);
    let (x, y) = (scale("angle", Q::Angle), scale(effort_label(kind), kind));
    Some(plot(format!("loop-{}", slug(&case.point)), title, x, y, all))
}

/// Friction over velocity with fit and band; excluded points stay visible as far as they reached a velocity.
pub(super) fn friction_curve(curve: &Curve, points: &[PointResult]) -> Option<Plot> {
    let velocities: Vec<f64> = curve.points.iter().map(|p| p.velocity_rad_per_s).collect();
    let (low, high) =
        (velocities.iter().copied().reduce(f64::min)?, velocities.iter().copied().reduce(f64::max)?);
    let log = high / low > 30.0;
    let grid: Vec<f64> = (0..CURVE_POINTS)
        .map(|k| f64::from(k) / f64::from(CURVE_POINTS - 1))
        .map(|s| if log { low * (high / low).powf(s) } else { low + (high - low) * s })
        .collect();
    let model = |v: f64| match (&curve.fit, &curve.line) {
        (Some(fit), _) => Some([fit.parameters.at_nm(v), fit.u_at_nm(v)]),
        (None, Some(line)) if v >= line.from_rad_per_s * (1.0 - 1e-9) => Some(line.at_nm(v)),
        _ => None,
    };
    let fitted: Vec<(f64, [f64; 2])> = grid.iter().filter_map(|&v| Some((v, model(v)?))).collect();
    let mut all = Vec::new();
    if !fitted.is_empty() {
        let x: Vec<f64> = fitted.iter().map(|(v, _)| Q::AngularVelocity.to_display(*v)).collect();
        let y: Vec<f64> = fitted.iter().map(|(_, [torque, _])| *torque).collect();
        let u = fitted.iter().map(|(_, [_, u])| COVERAGE * u).collect();
        all.push(Series { u, ..series("fit, k = 2", Style::Band, x.clone(), y.clone()) });
        let name = if curve.fit.is_some() { "Stribeck fit" } else { "T_C + σ2·ω" };
        all.push(series(name, Style::Fit, x, y));
    }
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

/// Friction values that did not stand (a condition of the procedure was broken), hollow.
fn excluded(points: &[PointResult]) -> Option<Series> {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for point in points.iter().filter(|p| Valid::of(p).is_none()) {
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
pub(super) fn half_sum(chosen: &Chosen<'_, '_>) -> Plot {
    let x = shown(Q::Angle, &chosen.half_sum.angle_rad);
    let fitted: Vec<f64> = chosen.half_sum.angle_rad.iter().map(|&a| chosen.fit.at_nm(a)).collect();
    let measured = [&x[..], &chosen.half_sum.torque_nm];
    let all = vec![
        Series::thinned("half-sum, mean of a cogging period", Style::Markers, measured, MAX_POINTS),
        Series::thinned("-A_u cos θ + K_s (θ - θ_0)", Style::Fit, [&x, &fitted], MAX_POINTS),
    ];
    let title = format!("Unbalance and spring, {}", chosen.point.name);
    plot("half-sum".into(), title, scale("angle", Q::Angle), scale("half-sum", Q::Torque), all)
}

/// Cogging spectrum in orders per revolution.
pub(super) fn spectrum(point: &Valid<'_>, cogging: &Cogging) -> Plot {
    let lines = [&cogging.line_order[..], &cogging.line_amplitude];
    let [order, amplitude, u] = markers(&cogging.harmonics);
    let u = u.iter().map(|u| COVERAGE * u).collect();
    let all = vec![
        Series::thinned("mean of both directions", Style::Bars, lines, MAX_POINTS),
        Series { u, ..series("harmonics, k = 2", Style::Markers, order, amplitude) },
    ];
    let title = format!("Cogging spectrum, {}", point.name);
    let picture = plot(
        "cogging-spectrum".into(),
        title,
        scale("order", Q::SpatialOrder),
        scale("amplitude", point.kind),
        all,
    );
    let limits_of = if point.kind == Q::Torque { AMPLITUDE } else { AMPLITUDE_CURRENT };
    Plot { limits_of: Some(limits_of.to_owned()), ..picture }
}
