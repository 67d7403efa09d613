//! Settings from curves: least squares over all points, with slopes from rehearsals.

use std::cell::RefCell;
use std::collections::BTreeMap;

use procedures::identification::{Estimated, Observation, Posterior, Prior};

use crate::identify::Value;

/// Steps towards the solution; near it the curves are almost straight lines of the settings.
const STEPS: usize = 3;

/// A point of a measured curve.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) y: f64,
    /// Standard uncertainty.
    pub(super) u: f64,
    /// Whether its instrument has a scale of its own.
    pub(super) is_scaled: bool,
    /// Whether whole turns of 360 make no difference.
    pub(super) is_angle_deg: bool,
}

/// A setting that is sought.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unknown {
    pub(super) prior: Prior,
    /// Tells the slopes of the curves.
    pub(super) step: f64,
    /// Values to begin with, as distances from the base; none if it begins with the base.
    pub(super) scan: &'static [f64],
    /// Values that the simulation can have are multiples of this; 0 where it can have any.
    pub(super) grid: f64,
}

impl Unknown {
    /// The nearest value that the simulation can have.
    pub(super) fn rounded(&self, value: f64) -> f64 {
        let [least, most] = self.prior.range;
        if self.grid > 0.0 { ((value / self.grid).round() * self.grid).clamp(least, most) } else { value }
    }
}

/// Points by picture, curve and abscissa.
pub(super) type Curves = BTreeMap<String, Point>;

/// Settings from curves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fit {
    pub(super) values: Vec<Value>,
    /// Root of χ²/ν.
    pub(super) misfit_ratio: f64,
}

/// The settings whose curves are nearest to the measured ones: Gauss–Newton with the slopes between rehearsals. The noise of a rehearsal is
/// as large as that of the measurement, so variances are doubled; u is widened by what the curves leave (Birge ratio).
pub(super) fn fit(
    measured: &Curves,
    unknowns: &[Unknown],
    scale_u: f64,
    shown: &dyn Fn(&[f64]) -> Result<Curves, String>,
) -> Result<Fit, String> {
    let priors: Vec<Prior> = unknowns.iter().map(|unknown| unknown.prior).collect();
    // The scan and the steps come by the same values more than once, and a rehearsal takes seconds.
    let rehearsed = RefCell::new(BTreeMap::<Vec<u64>, Curves>::new());
    let shown = &|values: &[f64]| {
        let key: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
        if let Some(curves) = rehearsed.borrow().get(&key) {
            return Ok(curves.clone());
        }
        let curves = shown(values)?;
        rehearsed.borrow_mut().insert(key, curves.clone());
        Ok(curves)
    };
    let start = start(measured, unknowns, scale_u, shown)?;
    let at_start = shown(&start)?;
    let stepped = stepped(unknowns, &start, shown)?;
    let mut at = start;
    let mut shown_there = at_start.clone();
    for _ in 0..STEPS {
        let points = points(measured, &at_start, &stepped, &shown_there);
        let solved = solved(&points, &priors, &at, scale_u)?;
        at = unknowns.iter().zip(&solved.parameters).map(|(own, found)| own.rounded(found.value)).collect();
        shown_there = shown(&at)?;
    }
    let points = points(measured, &at_start, &stepped, &shown_there);
    let posterior = solved(&points, &priors, &at, scale_u)?;
    let dof = (points.len() - priors.len() - 1) as f64;
    let misfit_ratio = (posterior.residuals_u.iter().map(|r| r * r).sum::<f64>() / dof).sqrt();
    let value = |estimated: &Estimated| Value {
        value_si: estimated.value,
        u_si: estimated.spread.u * misfit_ratio.max(1.0),
        dof: Some(dof),
    };
    Ok(Fit { values: posterior.parameters[..priors.len()].iter().map(value).collect(), misfit_ratio })
}

/// Where the steps begin: the scanned values whose curves are nearest, the other settings being free.
fn start(
    measured: &Curves,
    unknowns: &[Unknown],
    scale_u: f64,
    shown: &dyn Fn(&[f64]) -> Result<Curves, String>,
) -> Result<Vec<f64>, String> {
    let mut start: Vec<f64> = unknowns.iter().map(|unknown| unknown.prior.value).collect();
    for (k, own) in unknowns.iter().enumerate().filter(|(_, own)| !own.scan.is_empty()) {
        let at_start = shown(&start)?;
        let stepped = stepped(unknowns, &start, shown)?;
        let mut nearest = f64::INFINITY;
        let from = start.clone();
        for offset in own.scan {
            let mut at = from.clone();
            at[k] = (from[k] + offset).clamp(own.prior.range[0], own.prior.range[1]);
            let is_fixed =
                |place: usize| Prior { is_fixed: place == k, value: at[place], ..unknowns[place].prior };
            let priors: Vec<Prior> = (0..unknowns.len()).map(is_fixed).collect();
            let points = points(measured, &at_start, &stepped, &shown(&at)?);
            let solved = solved(&points, &priors, &at, scale_u)?;
            let misfit = solved.residuals_u.iter().map(|r| r * r).sum::<f64>() / points.len() as f64;
            if misfit < nearest {
                (nearest, start) = (misfit, at);
            }
        }
    }
    Ok(start)
}

/// What is shown with each setting moved from these values.
fn stepped(
    unknowns: &[Unknown],
    from: &[f64],
    shown: &dyn Fn(&[f64]) -> Result<Curves, String>,
) -> Result<Vec<Moved>, String> {
    let moved = |(k, Unknown { prior, step, .. }): (usize, &Unknown)| {
        let step = prior.step_from(from[k], *step);
        let mut values = from.to_vec();
        values[k] += step;
        Ok(Moved { step, curves: shown(&values)? })
    };
    unknowns.iter().enumerate().map(moved).collect()
}

/// What a unit shows with one setting moved.
struct Moved {
    step: f64,
    curves: Curves,
}

/// A measured point with what is shown there, and by how much more for each unit of a setting.
struct Compared {
    measured: Point,
    shown: f64,
    slopes: Vec<f64>,
}

/// The points that all curves have.
fn points(measured: &Curves, base: &Curves, stepped: &[Moved], shown: &Curves) -> Vec<Compared> {
    let one = |(name, point): (&String, &Point)| {
        let from = base.get(name)?.y;
        let shown = shown.get(name)?.y;
        let between = |from: f64, to: f64| {
            let turns = if point.is_angle_deg { ((to - from) / 360.0).round() } else { 0.0 };
            to - from - 360.0 * turns
        };
        let slope = |moved: &Moved| Some(between(from, moved.curves.get(name)?.y) / moved.step);
        Some(Compared {
            measured: Point { y: shown + between(shown, point.y), ..point.clone() },
            shown,
            slopes: stepped.iter().map(slope).collect::<Option<_>>()?,
        })
    };
    measured.iter().filter_map(one).collect()
}

/// The settings by the points, linearised about `at`; the shift of scaled curves comes behind them.
fn solved(points: &[Compared], priors: &[Prior], at: &[f64], scale_u: f64) -> Result<Posterior, String> {
    let count = priors.len();
    if points.len() < 2 * (count + 1) {
        return Err(format!("rehearsals share only {} points with what was measured", points.len()));
    }
    let shift = Prior { value: 0.0, u: scale_u, range: [f64::NEG_INFINITY, f64::INFINITY], is_fixed: false };
    let all: Vec<Prior> = priors.iter().copied().chain([shift]).collect();
    let observation = |(series, point): (usize, &Compared)| Observation {
        value: point.measured.y,
        u: 2_f64.sqrt() * point.measured.u,
        dof: f64::INFINITY,
        series,
        parameters: (0..count + usize::from(point.measured.is_scaled)).collect(),
    };
    let observations: Vec<Observation> = points.iter().enumerate().map(observation).collect();
    let predicted = |index: usize, values: &[f64]| {
        let Compared { measured, shown, slopes } = &points[index];
        let moved: f64 = slopes.iter().zip(values).zip(at).map(|((slope, v), at)| slope * (v - at)).sum();
        shown + moved + if measured.is_scaled { values[count] } else { 0.0 }
    };
    Ok(Posterior::new(&all, &observations, &predicted))
}

#[cfg(test)]
mod tests {
    use super::super::MISFIT_MOST;
    use super::*;

    /// Curves of two settings, bent, with a sensor whose scale is off by `shift`.
    fn curves_of(values: &[f64], noise: f64, shift: f64) -> Curves {
        let y = |k: i32| {
            let x = 0.1 * f64::from(k);
            let bent = values[0] * x * (1.0 + 0.1 * values[0]) + (values[1] * x).cos();
            bent + noise * f64::from(2 * (k % 2) - 1) + if k > 40 { shift } else { 0.0 }
        };
        (1..80)
            .map(|k| (k.to_string(), Point { y: y(k), u: 0.001, is_scaled: k > 40, is_angle_deg: false }))
            .collect()
    }

    fn unknowns() -> [Unknown; 2] {
        [0.5, 1.0].map(|value| Unknown {
            prior: Prior { value, u: 0.3, range: [0.0, 2.0], is_fixed: false },
            step: 0.05,
            grid: 0.0,
            scan: &[],
        })
    }

    fn fitted(noise: f64) -> Fit {
        let measured = curves_of(&[0.62, 1.04], noise, 0.02);
        fit(&measured, &unknowns(), 0.1, &|values| Ok(curves_of(values, -noise, 0.0))).expect("a fit")
    }

    #[test]
    fn two_settings_are_found_from_curves_that_bend_with_them_whatever_the_scale_of_one_sensor_is() {
        let fit = fitted(0.0005);
        for (value, truth) in fit.values.iter().zip([0.62, 1.04]) {
            assert!((value.value_si - truth).abs() < 2.0 * value.u_si && value.u_si < 1e-3, "{fit:?}");
        }
        assert!(fit.misfit_ratio < 2.0, "{fit:?}");
    }

    #[test]
    fn curves_of_something_else_widen_the_uncertainty() {
        let [good, bad] = [0.0005, 0.05].map(fitted);
        assert!(bad.misfit_ratio > MISFIT_MOST, "{bad:?}");
        assert!(bad.values[0].u_si > 5.0 * good.values[0].u_si, "{good:?} {bad:?}");
    }

    #[test]
    fn a_narrow_line_is_found_from_afar() {
        let line = |hz: f64| -> Curves {
            // As wide as a line at 140 Hz with a damping ratio of 0.02.
            let y = |k: i32| 1.0 / (1.0 + ((f64::from(k) - hz) / 2.8).powi(2));
            (100..180)
                .map(|k| (k.to_string(), Point { y: y(k), u: 0.001, is_scaled: false, is_angle_deg: false }))
                .collect()
        };
        let prior = Prior { value: 140.0, u: 28.0, range: [1.0, 1e3], is_fixed: false };
        let own = Unknown { prior, step: 0.5, grid: 0.0, scan: &[-8.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0] };
        let found =
            |own: Unknown| fit(&line(135.3), &[own], 1.0, &|values| Ok(line(values[0]))).expect("a fit");
        let scanned = found(own);
        assert!((scanned.values[0].value_si - 135.3).abs() < 0.05, "{scanned:?}");
        let straight = found(Unknown { scan: &[], ..own });
        assert!((straight.values[0].value_si - 135.3).abs() > 0.5, "{straight:?}");
    }

    #[test]
    fn no_values_are_rehearsed_twice() {
        let rehearsed = RefCell::new(Vec::new());
        let scanned = unknowns().map(|own| Unknown { scan: &[-0.1, 0.0, 0.1], ..own });
        let shown = |values: &[f64]| {
            rehearsed.borrow_mut().push(values.to_vec());
            Ok(curves_of(values, 0.0, 0.0))
        };
        fit(&curves_of(&[0.62, 1.04], 0.0005, 0.02), &scanned, 0.1, &shown).expect("a fit");
        let all = rehearsed.into_inner();
        let again = all.iter().enumerate().filter(|(k, values)| all[..*k].contains(values)).count();
        assert_eq!(again, 0, "{all:?}");
    }

    #[test]
    fn curves_with_other_points_tell_nothing() {
        let measured = curves_of(&[0.62, 1.04], 0.0, 0.0);
        let found = fit(&measured, &unknowns(), 0.1, &|_| Ok(Curves::new()));
        assert!(found.expect_err("no common points").starts_with("rehearsals share only 0 points"));
    }

    #[test]
    fn a_delay_in_steps_is_found_between_them_from_phases_that_turn_round() {
        let phases = |delay_s: f64| -> Curves {
            let y = |hz: f64| (500.0 - 360.0 * hz * delay_s).rem_euclid(360.0) - 180.0;
            let point = |hz: f64| Point { y: y(hz), u: 0.5, is_scaled: false, is_angle_deg: true };
            (1..70).map(|hz| (hz.to_string(), point(f64::from(hz)))).collect()
        };
        let delay = Unknown {
            prior: Prior { value: 1.5e-3, u: 0.5e-3, range: [0.0, 0.1], is_fixed: false },
            step: 250e-6,
            grid: 50e-6,
            scan: &[],
        };
        let rounded = |values: &[f64]| Ok(phases((values[0] / 50e-6).round() * 50e-6));
        let found = fit(&phases(1.87e-3), &[delay], 1.0, &rounded).expect("a fit");
        assert!((found.values[0].value_si - 1.87e-3).abs() < 1e-6, "{found:?}");
        assert!(found.misfit_ratio < 1.0, "{found:?}");
    }
}
