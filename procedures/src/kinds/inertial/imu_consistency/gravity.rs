//! Elevation by gravity, beside that of its encoder: accelerometers while the axes rest before each stroke.

use std::f64::consts::FRAC_1_SQRT_2;

use analysis::estimate::Estimate;
use analysis::goodness::Goodness;
use analysis::least_squares::LinearFit;

use super::keys::SETTLE;
use super::{BIAS, GRAVITY, ZERO};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::inertial::TOPIC;
use crate::log::{Rows, Window};
use crate::measurement::{Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{InertialReason, Reason};

const ESTIMATOR: &str = "elevation-by-gravity/2";
/// Accelerometers, in the order of their channels.
const CHANNELS: [&str; 3] = ["acceleration_x_m_per_s2", "acceleration_y_m_per_s2", "acceleration_z_m_per_s2"];
/// Standard gravity (ISO 80000-3), and what it is elsewhere on land: 9.780 to 9.834 m/s², rectangular.
const STANDARD_M_PER_S2: f64 = 9.806_65;
const GRAVITY_U_RATIO: f64 = 0.002_8 / 1.732;
/// Scale errors of two accelerometers differ by this much: 500 ppm each (ours), rectangular.
const SCALES_U_RATIO: f64 = 500e-6 / 1.732 * std::f64::consts::SQRT_2;
/// Biases wander from rest to rest, minutes apart: three times a bias instability of 50 µg (ours).
const WANDER_M_PER_S2: f64 = 1.5e-3;
/// The axes still settle in the first part of a rest.
const SETTLED_S: f64 = 1.0;
/// Fewest elevations, and how far apart the outer ones must be, for zero, gravity and two biases.
const LEAST_ELEVATIONS: usize = 3;
const LEAST_SPREAD_RAD: f64 = 0.5;
/// Elevations that are nearer to each other than this are one.
const SAME_RAD: f64 = 0.05;

/// Mean specific force during one rest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rest {
    elevation_rad: f64,
    /// Up from the line of sight and along it, m/s², with the standard uncertainty of both.
    up_m_per_s2: f64,
    ahead_m_per_s2: f64,
    u_m_per_s2: f64,
    span_s: [f64; 2],
}

/// The rest before the stroke of a point.
pub(super) fn rest(case: &Case, window: &Window, axes: &Axes) -> Result<Rest, Reason> {
    let span = window.segment(case, SETTLE)?;
    let span_s = [span.start_s + SETTLED_S, span.end_s];
    let inner = &axes.gimbal()?.inner.name;
    let imu = window.topic(TOPIC)?;
    let forces = CHANNELS.map(|name| Ok::<_, Reason>(moments(imu, name, span_s)?));
    let [x, y, z] = forces;
    let [x, y, z] = [x?, y?, z?];
    let elevation = moments(window.topic_with_rows(&format!("/{inner}"))?, "position_rad", span_s)?;
    if x.n < 2 {
        return Err(InertialReason::TooFewSamples { samples: x.n, least: 2 }.into());
    }
    Ok(Rest {
        elevation_rad: elevation.mean,
        up_m_per_s2: FRAC_1_SQRT_2 * (x.mean + y.mean),
        ahead_m_per_s2: z.mean,
        u_m_per_s2: ((x.variance + y.variance + z.variance) / 3.0 / x.n as f64).sqrt().hypot(WANDER_M_PER_S2),
        span_s,
    })
}

/// Mean and variance of a channel.
struct Moments {
    mean: f64,
    variance: f64,
    n: usize,
}

fn moments(rows: &Rows, channel: &str, span_s: [f64; 2]) -> Result<Moments, crate::missing::Missing> {
    let values = &rows.channel(channel)?[rows.range(span_s[0], span_s[1])];
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Ok(Moments { mean, variance: square / n.saturating_sub(1).max(1) as f64, n })
}

/// What the rests of all points say together.
pub(super) fn conclude(points: &[PointResult], axes: &Axes) -> Vec<Measurement> {
    let inner = axes.gimbal().map_or(String::new(), |gimbal| gimbal.inner.name.clone());
    let rests: Vec<&Rest> = points.iter().filter_map(|point| point.reduced.get::<Rest>()).collect();
    let rows: [(&str, &str, Q); 4] = [
        (ZERO, &inner, Q::Angle),
        (GRAVITY, &inner, Q::Ratio),
        (BIAS, "up", Q::Acceleration),
        (BIAS, "ahead", Q::Acceleration),
    ];
    let evidence = evidence(&rests, &inner);
    let found = fit(&rests);
    let measurement = |(k, (name, axis, kind)): (usize, (&str, &str, Q))| {
        let measurement = match &found {
            Ok((found, flag)) => Measurement {
                flags: flag.iter().cloned().collect(),
                ..Measurement::new(name, axis, kind, Some(found[k]), ESTIMATOR)
            },
            Err(reason) => Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason),
        };
        Measurement { evidence: evidence.clone(), ..measurement }
    };
    rows.into_iter().enumerate().map(measurement).collect()
}

fn evidence(rests: &[&Rest], inner: &str) -> Vec<Evidence> {
    let channels = CHANNELS.iter().map(|name| format!("{TOPIC} {name}"));
    let channels: Vec<String> = channels.chain([format!("/{inner} position_rad")]).collect();
    rests.iter().map(|rest| Evidence::new(channels.clone(), rest.span_s)).collect()
}

/// Zero of elevation, gravity over its standard value less 1, biases up and ahead; and what is to be said where the rests
/// scatter more than their noise and the wander of the biases.
///
/// An encoder that shows `z` more than gravity feels g·cos(el − z) up from the line of sight and g·sin(el − z) along it; to first
/// order in z that is linear in g, g·z and two biases. How much the scales of the accelerometers differ is a fifth unknown, zero
/// within what is known of it.
fn fit(rests: &[&Rest]) -> Result<([Estimate; 4], Option<String>), Reason> {
    let mut elevations: Vec<f64> = rests.iter().map(|rest| rest.elevation_rad).collect();
    elevations.sort_by(f64::total_cmp);
    elevations.dedup_by(|later, earlier| *later - *earlier < SAME_RAD);
    let spread_rad = elevations.last().zip(elevations.first()).map_or(0.0, |(last, first)| last - first);
    if elevations.len() < LEAST_ELEVATIONS || spread_rad < LEAST_SPREAD_RAD {
        return Err(InertialReason::FewElevations {
            elevations: elevations.len(),
            least: LEAST_ELEVATIONS,
            spread_rad,
            least_rad: LEAST_SPREAD_RAD,
        }
        .into());
    }
    let mut columns: [Vec<f64>; 5] = Default::default();
    let mut forces = Vec::new();
    let mut weights = Vec::new();
    let mut observe = |row: [f64; 5], force: f64, u: f64| {
        for (column, value) in columns.iter_mut().zip(row) {
            column.push(value);
        }
        forces.push(force);
        weights.push(1.0 / u.powi(2).max(f64::MIN_POSITIVE));
    };
    let half_m_per_s2 = 0.5 * STANDARD_M_PER_S2;
    for rest in rests {
        let (sin, cos) = rest.elevation_rad.sin_cos();
        observe([cos, sin, 1.0, 0.0, half_m_per_s2 * cos], rest.up_m_per_s2, rest.u_m_per_s2);
        observe([sin, -cos, 0.0, 1.0, -half_m_per_s2 * sin], rest.ahead_m_per_s2, rest.u_m_per_s2);
    }
    observe([0.0, 0.0, 0.0, 0.0, 1.0], 0.0, SCALES_U_RATIO);
    let fit = LinearFit::new(&columns, &forces, Some(&weights)).map_err(InertialReason::Gravity)?;
    let goodness = Goodness::of_known(fit.residual_variance, fit.dof);
    goodness.check()?;
    let u = |k: usize| (fit.unscaled_covariance[(k, k)] * goodness.variance_factor()).sqrt();
    let estimate = |value: f64, u: f64| Estimate { value, u, dof: goodness.dof(), n: rests.len() };
    let g = fit.coefficients[0];
    let found = [
        estimate(fit.coefficients[1] / g, u(1) / g.abs()),
        estimate(g / STANDARD_M_PER_S2 - 1.0, (u(0) / STANDARD_M_PER_S2).hypot(GRAVITY_U_RATIO)),
        estimate(fit.coefficients[2], u(2)),
        estimate(fit.coefficients[3], u(3)),
    ];
    Ok((found, goodness.flag()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rests(elevations_deg: &[f64], zero_rad: f64) -> Vec<Rest> {
        let rest = |deg: &f64| {
            let elevation_rad = deg.to_radians();
            let (sin, cos) = (elevation_rad - zero_rad).sin_cos();
            Rest {
                elevation_rad,
                up_m_per_s2: 9.81 * cos + 5e-3,
                ahead_m_per_s2: 9.81 * sin - 4e-3,
                u_m_per_s2: 6e-4,
                span_s: [1.0, 5.0],
            }
        };
        elevations_deg.iter().map(rest).collect()
    }

    #[test]
    fn the_zero_of_the_encoder_is_told_from_biases_and_gravity() {
        let rests = rests(&[0.0, 40.0, 80.0], 1.5e-3);
        let ([zero, gravity, up, ahead], flag) =
            fit(&rests.iter().collect::<Vec<_>>()).expect("three elevations");
        assert_eq!(flag, None);
        assert!((zero.value - 1.5e-3).abs() < 5e-6, "{zero:?}");
        assert!((100e-6..160e-6).contains(&zero.u), "{zero:?}");
        assert!((gravity.value - (9.81 / 9.806_65 - 1.0)).abs() < 5e-6 && gravity.u > 1.5e-3, "{gravity:?}");
        assert!((up.value - 5e-3).abs() < 3e-5 && (ahead.value + 4e-3).abs() < 3e-5, "{up:?} {ahead:?}");
    }

    #[test]
    fn elevations_that_do_not_tell_them_apart_are_refused() {
        let refused = |deg: &[f64]| {
            let rests = rests(deg, 0.0);
            fit(&rests.iter().collect::<Vec<_>>()).expect_err("refused").to_string()
        };
        let two = "rests at 2 elevations over 40 deg, but zero, gravity and biases need 3 over 28.6479 deg";
        assert_eq!(refused(&[0.0, 40.0, 40.01]), two);
        assert!(refused(&[30.0, 40.0, 50.0]).starts_with("rests at 3 elevations over 20 deg"));
    }
}
