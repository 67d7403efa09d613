//! One spin, and its rates by gyros and encoder with their difference.

use std::f64::consts::FRAC_1_SQRT_2;

use analysis::estimate::Estimate;
use analysis::goodness::BY_SCATTER;
use analysis::turning::Turning;

use super::coupling;
use super::keys::SPIN;
use super::{DELAY, MAPPING, SCALE};
use crate::axis::Axes;
use crate::case::Case;
use crate::kinds::inertial::Samples;
use crate::log::Window;
use crate::measurement::{Condition, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::Reason;
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

const ESTIMATOR: &str = "turning/2";
/// A mapping that is off by more is wrong, not misaligned: 1°.
const WRONG_RAD: f64 = std::f64::consts::PI / 180.0;

/// A spin: what the gyros and the encoder show, and what comes of it.
pub(super) struct Spin {
    pub(super) samples: Samples,
    /// Rate of the axis by the encoder, mean over each sample but the first.
    pub(super) rate_rad_per_s: Vec<f64>,
    /// Rates left, up and ahead of the line of sight over the same time, without what the other axis moves.
    pub(super) along: [Vec<f64>; 3],
    pub(super) found: Turning,
    pub(super) expected: [f64; 3],
    elevation_rad: f64,
    /// 0: the outer axis turns, 1: the inner one.
    pub(super) turning: usize,
}

pub(super) fn analyse(case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let kinds = [(SCALE, Q::Ratio), (MAPPING, Q::Angle), (DELAY, Q::Time)];
    let spin = match spin(case, window, axes) {
        Ok(spin) => spin,
        Err(reason) => {
            let coupling = coupling::without(case, &reason);
            let mut result = PointResult::without(case, &kinds, ESTIMATOR, reason);
            result.measurements.extend(coupling);
            return result;
        }
    };
    let values = [
        spin.found.scale_error(),
        spin.found.angle_from_rad(spin.expected),
        (spin.found.delay_s, spin.found.delay_u_s),
    ];
    let measurement = |((name, kind), (value, u)): ((&str, Q), (f64, f64))| {
        let estimate = Estimate { value, u, dof: spin.found.dof, n: spin.found.n };
        Measurement {
            point: Some(case.point.clone()),
            conditions: conditions(case, &spin),
            flags: [flags(name, value, &spin), spin.samples.flags.clone(), vec![BY_SCATTER.to_owned()]]
                .concat(),
            evidence: spin.samples.evidence(),
            ..Measurement::new(name, &case.axis, kind, Some(estimate), ESTIMATOR)
        }
    };
    let is_wrong = values[1].0 > WRONG_RAD;
    let turning = kinds.into_iter().zip(values).map(measurement);
    PointResult {
        measurements: turning.chain(coupling::measure(case, window, axes, &spin)).collect(),
        plots: picture(case, &spin),
        excluded: spin.samples.excluded.clone(),
        remarks: if is_wrong { vec![remark(case, &spin)] } else { Vec::new() },
        ..PointResult::of(case)
    }
}

/// What was asked for, with the elevation that was reached.
pub(super) fn conditions(case: &Case, spin: &Spin) -> Vec<Condition> {
    Condition::reached(case, |_| Some(spin.elevation_rad))
}

fn spin(case: &Case, window: &Window, axes: &Axes) -> Result<Spin, Reason> {
    let span = window.segment(case, SPIN)?;
    let samples = Samples::read(window, axes, span.start_s, span.end_s)?;
    let is_inner = axes.gimbal_index(&case.axis) == Some(1);
    let angle = usize::from(is_inner);
    let [az, el] = samples.axis_rates();
    let middle: Vec<f64> = samples.angle_rad[angle].windows(2).map(|a| 0.5 * (a[0] + a[1])).collect();
    let mut along = along(&samples);
    let other = if is_inner { &az } else { &el };
    take_off(&mut along, other, is_inner, &samples.elevation_rad());
    let rate_rad_per_s = if is_inner { el } else { az };
    let found = Turning::new([&along[0], &along[1], &along[2]], &rate_rad_per_s, &middle, samples.period_s)?;
    let elevation = samples.elevation_rad();
    let elevation_rad = elevation.iter().sum::<f64>() / elevation.len() as f64;
    let (sin, cos) = elevation_rad.sin_cos();
    // A positive rate about `left` turns the line of sight down.
    let expected = if is_inner { [-1.0, 0.0, 0.0] } else { [0.0, cos, sin] };
    Ok(Spin { samples, rate_rad_per_s, along, found, expected, elevation_rad, turning: angle })
}

/// Rates left, up and ahead of the line of sight over each sample but the first.
pub(super) fn along(samples: &Samples) -> [Vec<f64>; 3] {
    let [x, y, z] = &samples.rate_rad_per_s;
    // director.md §6: left = (x − y)/√2, up = (x + y)/√2.
    let mixed = |sign: f64| -> Vec<f64> {
        x[1..].iter().zip(&y[1..]).map(|(x, y)| FRAC_1_SQRT_2 * (x + sign * y)).collect()
    };
    [mixed(-1.0), mixed(1.0), z[1..].to_vec()]
}

/// Takes the motion of the axis that only holds off the rates of the gyros. Its velocity loop is closed on these gyros: if their
/// mapping is off, it moves at each turn of the other axis by some of what they show, and hides it.
fn take_off(
    along_rad_per_s: &mut [Vec<f64>; 3],
    other_rad_per_s: &[f64],
    is_outer: bool,
    elevation_rad: &[f64],
) {
    let [left, up, ahead] = along_rad_per_s;
    for (k, (rate_rad_per_s, elevation_rad)) in other_rad_per_s.iter().zip(elevation_rad).enumerate() {
        if is_outer {
            up[k] -= rate_rad_per_s * elevation_rad.cos();
            ahead[k] -= rate_rad_per_s * elevation_rad.sin();
        } else {
            // A positive rate about `left` turns the line of sight down.
            left[k] += rate_rad_per_s;
        }
    }
}

fn flags(name: &str, value: f64, spin: &Spin) -> Vec<String> {
    match name {
        SCALE => vec![format!("{:.1} ppm", 1e6 * value)],
        DELAY => {
            vec![format!("{:.1} us; both as logged, including the transport delay of each", 1e6 * value)]
        }
        _ if value > WRONG_RAD => vec!["mapping wrong".to_owned(), seen(&spin.found.along, &spin.expected)],
        _ => vec![seen(&spin.found.along, &spin.expected)],
    }
}

fn seen(found: &[f64], expected: &[f64]) -> String {
    let text = |v: &[f64]| v.iter().map(|x| format!("{x:.4}")).collect::<Vec<_>>().join(", ");
    format!("left, up, ahead of the line of sight: {} seen, {} expected", text(found), text(expected))
}

/// What the report says of a mapping that is wrong.
fn remark(case: &Case, spin: &Spin) -> String {
    let own: f64 = spin.found.along.iter().zip(&spin.expected).map(|(f, e)| f * e).sum();
    let what = if own < 0.0 {
        "the gyros show rotation opposite to the encoder"
    } else {
        "the gyros show rotation about another axis"
    };
    format!("{}: {what}; {}.", case.point, seen(&spin.found.along, &spin.expected))
}

fn picture(case: &Case, spin: &Spin) -> Vec<Plot> {
    let n = spin.rate_rad_per_s.len();
    let start_s = spin.samples.time_s[0];
    let time: Vec<f64> = spin.samples.time_s[1..].iter().map(|t| t - start_s).collect();
    let by_gyros = |k: usize| (0..3).map(|d| spin.along[d][k] * spin.expected[d]).sum::<f64>();
    let gyros: Vec<f64> = (0..n).map(|k| by_gyros(k).to_degrees()).collect();
    let encoder: Vec<f64> = spin.rate_rad_per_s.iter().map(|r| r.to_degrees()).collect();
    let difference: Vec<f64> = gyros.iter().zip(&encoder).map(|(g, e)| 1e3 * (g - e)).collect();
    let series = |label: &str, style: Style, y: &[f64]| Series::thinned(label, style, [&time, y], MAX_POINTS);
    let id = case.point.replace(|c: char| !c.is_ascii_alphanumeric(), "-");
    let abscissa = || Scale::linear("time", "s");
    let rates = Plot {
        series: vec![series("encoder", Style::Line, &encoder), series("gyros", Style::Fit, &gyros)],
        ..Plot::new(
            format!("rates-{id}"),
            format!("Rate of the axis by encoder and gyros, {}", case.point),
            abscissa(),
            Scale::linear("rate", "deg/s"),
        )
    };
    let panel = Plot {
        series: vec![series("gyros less encoder", Style::Line, &difference)],
        ..Plot::new(
            format!("rate-difference-{id}"),
            "Difference",
            abscissa(),
            Scale::linear("difference", "mdeg/s"),
        )
    };
    let panel = panel.panel_of(&rates);
    vec![rates, panel]
}
