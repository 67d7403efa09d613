//! The gyros at rest: deviations, the five noises, bias, and the picture of a deviation with its fit.

use analysis::allan::{
    self, Bounded, Deviation, NoiseFit, NoiseTerm, Spacing, Statistic, bounded, drift, fit, quantum_of,
};
use analysis::estimate::Estimate;
use analysis::peaks::peak_ratio;
use analysis::uncertainty::rectangular_u;

use super::keys::{Keys, STILL};
use super::{BIAS, INSTABILITY, PEAK, RATE_WALK, WALK, step};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::inertial::{GYROS, Samples, body_rates, earth_rates};
use crate::log::Window;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{InertialReason, Reason, readable};
use crate::trace::{Mark, Note, Plot, Scale, Series, Style};

const ESTIMATOR: &str = "allan-gls/4";
const PEAK_ESTIMATOR: &str = "peak-over-noise/1";
/// A quantum above this part of the noise of a sample is flagged.
const COARSE_RATIO: f64 = 0.1;
/// A change of temperature above this is flagged.
const WARMING_K: f64 = 1.0;
/// Averages over less hold what no noise of the gyro is: motion of the structure against the encoders, from 10 Hz on (STR-MODE-1),
/// and filters of the unit.
const SHORTEST_S: f64 = 0.1;
/// What that makes of a random walk where shorter averages are fitted, too: 4 % of units drawn off the nominal one, half-width of
/// a rectangular distribution.
const STRUCTURE_U_RATIO: f64 = 0.023;
/// Half of a 95 % interval over its standard uncertainty.
const HALF_95: f64 = 1.96;

/// What is found of a gyro.
pub(super) struct Found {
    pub(super) points: Vec<Bounded>,
    pub(super) fit: NoiseFit,
    /// What motion of structure and axes adds to the relative uncertainty of the random walk.
    structure_u_ratio: f64,
    flags: Vec<String>,
    n: usize,
}

/// The five noises, and what they rest on.
struct Fitted {
    fit: NoiseFit,
    structure_u_ratio: f64,
    /// Shortest average that was fitted.
    shortest_s: f64,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult::of(case);
    let samples = match samples(case, window, axes) {
        Ok(samples) => samples,
        Err(reason) => {
            for gyro in GYROS {
                result.measurements.extend(without(keys, gyro, &reason));
                let peak = Measurement::inconclusive(PEAK, gyro, Q::Ratio, PEAK_ESTIMATOR, &reason);
                result.measurements.extend([peak, step::without(gyro, reason.clone())]);
            }
            result.inconclusive = Some(reason);
            return result;
        }
    };
    for (index, gyro) in GYROS.into_iter().enumerate() {
        match gyro_noise(&samples, index) {
            Ok(found) => {
                result.measurements.extend(noises(gyro, &found));
                result.plots.push(picture(gyro, &found));
                result.measurements.extend(bias(keys, &samples, index));
            }
            Err(reason) => result.measurements.extend(without(keys, gyro, &reason)),
        }
    }
    let tick_s = axes.limits(&case.axis).map_or(0.0, AxisLimits::tick_s);
    result.measurements.extend((0..GYROS.len()).map(|index| peak(&samples, index)));
    result.measurements.extend((0..GYROS.len()).map(|index| step::measured(&samples, index, tick_s)));
    for m in &mut result.measurements {
        m.point = Some(case.point.clone());
        if m.value.is_some() {
            m.evidence = samples.evidence();
        }
    }
    result.excluded.clone_from(&samples.excluded);
    result
}

fn samples(case: &Case, window: &Window, axes: &Axes) -> Result<Samples, Reason> {
    let span = window.segment(case, STILL)?;
    let samples = Samples::read(window, axes, span.start_s, span.end_s)?;
    let lasts_s = span.end_s - span.start_s;
    if samples.len() as f64 * samples.period_s < 0.5 * lasts_s {
        return Err(InertialReason::Interrupted {
            longest_s: samples.len() as f64 * samples.period_s,
            lasts_s,
        }
        .into());
    }
    Ok(samples)
}

/// The largest single departure from the rate at rest, in standard deviations of the noise: spikes, which no deviation over
/// time shows.
fn peak(samples: &Samples, index: usize) -> Measurement {
    let gyro = GYROS[index];
    match peak_ratio(&samples.rate_rad_per_s[index]) {
        Some(estimate) => Measurement::new(PEAK, gyro, Q::Ratio, Some(estimate), PEAK_ESTIMATOR),
        None => {
            let reason = InertialReason::NoNoise { gyro };
            Measurement::inconclusive(PEAK, gyro, Q::Ratio, PEAK_ESTIMATOR, reason)
        }
    }
}

/// Rate of a gyro less what the encoders say that the axes turned.
fn at_rest(samples: &Samples, index: usize) -> Vec<f64> {
    let [az, el] = samples.axis_rates();
    let elevation = samples.elevation_rad();
    let moved = az.iter().zip(&el).zip(&elevation).map(|((az, el), at)| body_rates(*az, *el, *at)[index]);
    samples.rate_rad_per_s[index][1..].iter().zip(moved).map(|(rate, moved)| rate - moved).collect()
}

fn gyro_noise(samples: &Samples, index: usize) -> Result<Found, Reason> {
    // A gyro that is stuck would hide behind the motion that is taken off.
    allan::Series::from_rate(&samples.rate_rad_per_s[index], samples.period_s)?;
    let rate = at_rest(samples, index);
    let series = allan::Series::from_rate(&rate, samples.period_s)?;
    let factors = series.factors(Spacing::Octave, Statistic::Oadev);
    let points = bounded(&series, Statistic::Oadev, &factors)?;
    let Fitted { fit, structure_u_ratio, shortest_s } = fitted(&points, series.rates(), samples.period_s)?;
    let mut flags = flags(samples, index, &rate, &fit);
    if shortest_s > SHORTEST_S {
        flags.push(format!(
            "averages of less than {shortest_s:.1} s hold motion that the encoders do not show, and are left out"
        ));
    }
    Ok(Found { points, fit, structure_u_ratio, flags, n: series.rates() })
}

/// The noises by averages that structure and filters do not reach, where the record is long enough for that; else by all averages,
/// with what those may add to the random walk.
///
/// Where the noises do not describe those averages, the shortest of them are left out until they do: an axis that its loop moves within
/// the play of an encoder turns with the noise of the gyro, and nothing shows how far. What the next longer start makes of the walk
/// counts in its uncertainty.
fn fitted(points: &[Bounded], rates: usize, period_s: f64) -> Result<Fitted, Reason> {
    let all: Vec<Deviation> = points.iter().map(|p| p.at).collect();
    let from = |shortest_s: f64| {
        let some: Vec<Deviation> = all.iter().copied().filter(|at| at.tau_s >= shortest_s).collect();
        fit(&some, rates, period_s).ok()
    };
    let is_sharp = |walk: NoiseTerm| walk.is_determined && walk.u <= STRUCTURE_U_RATIO * walk.value;
    let misfit = match from(SHORTEST_S) {
        Some(fit) if fit.goodness.is_misfit() => fit.goodness,
        Some(fit) if is_sharp(fit.random_walk()) => {
            return Ok(Fitted { fit, structure_u_ratio: 0.0, shortest_s: SHORTEST_S });
        }
        _ => {
            let fit = fit(&all, rates, period_s)?;
            return Ok(Fitted { fit, structure_u_ratio: STRUCTURE_U_RATIO, shortest_s: period_s });
        }
    };
    let mut shortest_s = 2.0 * SHORTEST_S;
    while let Some(fit) = from(shortest_s) {
        let walk = fit.random_walk();
        if walk.is_determined && !fit.goodness.is_misfit() {
            let next =
                from(2.0 * shortest_s).map(|next| next.random_walk()).filter(|next| next.is_determined);
            let apart = next.map_or(0.0, |next| (next.value / walk.value - 1.0).abs());
            return Ok(Fitted { fit, structure_u_ratio: rectangular_u(apart), shortest_s });
        }
        shortest_s *= 2.0;
    }
    Err(InertialReason::NoNoises { misfit_ratio: misfit.ratio().unwrap_or(f64::INFINITY) }.into())
}

fn flags(samples: &Samples, index: usize, rate: &[f64], fit: &NoiseFit) -> Vec<String> {
    let mut flags = samples.flags.clone();
    let noise = fit.deviation(samples.period_s);
    if let Some(quantum) = quantum_of(&samples.rate_rad_per_s[index]).filter(|q| *q > COARSE_RATIO * noise) {
        flags.push(format!("quantised: steps of {:.2} of the noise of a sample", quantum / noise));
    }
    if let Some(drift) = drift(rate, samples.period_s).filter(analysis::allan::Drift::is_significant) {
        flags.push(format!("drift of {:.3} deg/h in an hour", deg_per_h(drift.slope_per_s * 3600.0)));
    }
    let [first, last] = samples.temperature_degc;
    if (last - first).abs() > WARMING_K {
        flags.push(format!("temperature went from {first:.1} to {last:.1} degC"));
    }
    flags.extend(
        fit.goodness.flag().map(|flag| format!("the five noise processes do not describe it: {flag}")),
    );
    flags
}

fn noises(gyro: &str, found: &Found) -> Vec<Measurement> {
    let widened = found.fit.goodness.widening();
    let terms = [
        (WALK, Q::AngleRandomWalk, found.fit.random_walk()),
        (INSTABILITY, Q::AngularVelocity, found.fit.bias_instability()),
        (RATE_WALK, Q::RateRandomWalk, found.fit.rate_walk()),
    ];
    let one = |(name, kind, term): (&str, Q, NoiseTerm)| {
        let shown = |value: f64| readable(kind, value);
        let structure_u = if name == WALK { found.structure_u_ratio * term.value } else { 0.0 };
        let away = term.interval.map(|end| (widened * (end - term.value)).hypot(HALF_95 * structure_u));
        let [low, high] = [(term.value - away[0]).max(0.0), term.value + away[1]];
        let interval = format!("95 % from {} to {}", shown(low), shown(high));
        let flags = [vec![interval], found.flags.clone()].concat();
        if let Err(hopeless) = found.fit.goodness.check() {
            let reason = InertialReason::NoNoises { misfit_ratio: hopeless.ratio };
            return Measurement { flags, ..Measurement::inconclusive(name, gyro, kind, ESTIMATOR, reason) };
        }
        if !term.is_determined {
            let reason = InertialReason::NotToldApart { kind, most: high };
            return Measurement { flags, ..Measurement::inconclusive(name, gyro, kind, ESTIMATOR, reason) };
        }
        let u = (widened * term.u).hypot(structure_u);
        let estimate = Estimate { value: term.value, u, dof: term.dof, n: found.n };
        Measurement { flags, ..Measurement::new(name, gyro, kind, Some(estimate), ESTIMATOR) }
    };
    terms.into_iter().map(one).collect()
}

fn deg_per_h(rad_per_s: f64) -> f64 {
    rad_per_s.to_degrees() * 3600.0
}

/// Mean rate less the Earth's; its uncertainty is the noise of an average as long as the record.
fn bias(keys: &Keys, samples: &Samples, index: usize) -> Option<Measurement> {
    let latitude_rad = keys.latitude_rad?;
    let rate = at_rest(samples, index);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let azimuth = mean(&samples.angle_rad[0]);
    let elevation = mean(&samples.angle_rad[1]);
    let earth = earth_rates(latitude_rad, keys.heading_rad, azimuth, elevation)[index];
    let series = allan::Series::from_rate(&rate, samples.period_s).ok()?;
    let longest = Statistic::Oadev.largest_factor(series.rates()) / 4;
    let point = bounded(&series, Statistic::Oadev, &[longest.max(1)]).ok()?.pop()?;
    let estimate = Estimate {
        value: mean(&rate) - earth,
        u: point.at.deviation,
        dof: point.dof.unwrap_or(1.0),
        n: series.rates(),
    };
    let flags = vec![
        format!("{:.3} deg/h", deg_per_h(estimate.value)),
        format!("Earth's rate of {:.3} deg/h subtracted", deg_per_h(earth)),
    ];
    Some(Measurement {
        flags,
        ..Measurement::new(BIAS, GYROS[index], Q::AngularVelocity, Some(estimate), ESTIMATOR)
    })
}

fn without(keys: &Keys, gyro: &str, reason: &Reason) -> Vec<Measurement> {
    let all = [(WALK, Q::AngleRandomWalk), (INSTABILITY, Q::AngularVelocity), (RATE_WALK, Q::RateRandomWalk)];
    let bias = keys.latitude_rad.map(|_| (BIAS, Q::AngularVelocity));
    let one = |(name, kind)| Measurement::inconclusive(name, gyro, kind, ESTIMATOR, reason);
    all.into_iter().chain(bias).map(one).collect()
}

/// Points of the fitted curve.
const CURVE: usize = 200;

fn picture(gyro: &str, found: &Found) -> Plot {
    let tau: Vec<f64> = found.points.iter().map(|p| p.at.tau_s).collect();
    let deviation: Vec<f64> = found.points.iter().map(|p| deg_per_h(p.at.deviation)).collect();
    let bounded: Vec<(f64, [f64; 2])> =
        found.points.iter().filter_map(|p| Some((p.at.tau_s, p.interval?.map(deg_per_h)))).collect();
    let band = Series::new(
        "95 % interval",
        Style::Band,
        bounded.iter().map(|(tau, _)| *tau).collect(),
        bounded.iter().map(|(_, [low, high])| 0.5 * (low + high)).collect(),
    )
    .with_u(bounded.iter().map(|(_, [low, high])| 0.5 * (high - low)).collect());
    let first = tau.first().copied().unwrap_or(1.0);
    let last = tau.last().copied().unwrap_or(1.0);
    let at: Vec<f64> =
        (0..CURVE).map(|k| first * (last / first).powf(k as f64 / (CURVE - 1) as f64)).collect();
    let model: Vec<f64> = at.iter().map(|&tau| deg_per_h(found.fit.deviation(tau))).collect();
    let mut series = vec![
        band,
        Series::new("five noise processes", Style::Fit, at, model),
        Series::new("overlapping Allan deviation", Style::Markers, tau, deviation),
    ];
    let walk = found.fit.random_walk();
    let mut notes = Vec::new();
    let mut marks = Vec::new();
    if walk.is_determined && first < last {
        let of_walk = |tau: f64| deg_per_h(walk.value) / tau.sqrt();
        let line = Series::new(
            "angle random walk alone",
            Style::Line,
            vec![first, last],
            vec![of_walk(first), of_walk(last)],
        );
        series.push(line);
        // One second is where the coefficient is read.
        if (first..=last).contains(&1.0) {
            marks.push(Mark { label: "1 s".to_owned(), x: 1.0 });
            let label = format!("N = {} °/√h", rounded(Q::AngleRandomWalk.to_display(walk.value)));
            notes.push(Note { label, at: [1.0, of_walk(1.0)] });
        }
    }
    Plot {
        series,
        notes,
        marks,
        ..Plot::new(
            format!("allan-{gyro}"),
            format!("Allan deviation of gyro {gyro} at standstill"),
            Scale::logarithmic("averaging time", "s"),
            Scale::logarithmic("deviation", "deg/h"),
        )
    }
}

/// Three digits: what an interval of some per cent lets one say.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
