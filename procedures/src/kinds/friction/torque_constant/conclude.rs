//! Over the three points: friction by the gauge over friction by the current.

use std::f64::consts::TAU;

use analysis::angle_map::{Grid, bin_means};
use analysis::estimate::Estimate;
use analysis::friction::{SlowChange, half_difference};
use analysis::uncertainty::{Component, combine};

use super::keys::Keys;
use super::point::{CHANNEL, Driven, Pulled, TOPIC};
use super::{CONSTANT, ERROR, ESTIMATOR, MEASURANDS, PULLED};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::measurement::{Conclusion, Condition, Evidence, Measurement, PointResult};
use crate::quantity::QuantityKind as Q;
use crate::reason::{FrictionReason, Reason};
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

/// Relative change of slow friction over that of the velocity, at the most (director.md §3: 0.03 azimuth, 0.09 elevation).
const RATE_SHARE: f64 = 0.1;

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut whole = Conclusion::collected(points);
    let Some(case) = cases.first() else { return whole };
    let Some(limits) = axes.get(&case.axis) else { return whole };
    match compared(keys, limits, points) {
        Ok(found) => found.report(keys, &case.axis, limits, &mut whole),
        Err(reason) => {
            let own = MEASURANDS.iter().filter(|m| m.name != PULLED);
            let without =
                own.map(|m| Measurement::inconclusive(m.name, &case.axis, m.kind, ESTIMATOR, &reason));
            whole.measurements.extend(without);
        }
    }
    whole
}

/// Both frictions on the same angles.
struct Compared {
    /// Relative standard uncertainties in `u`, beside the values in N·m: by the gauge, by the current.
    pulled: Estimate,
    driven: Estimate,
    /// Rates of both, magnitudes.
    rates_rad_per_s: [f64; 2],
    angle_rad: Vec<f64>,
    /// Friction in each bin.
    maps_nm: [Vec<f64>; 2],
    spans_s: [[f64; 2]; 3],
}

/// Least and greatest angle of a record that goes one way.
fn ends_rad(angle_rad: &[f64]) -> Option<[f64; 2]> {
    match angle_rad {
        [first, .., last] => Some([first.min(*last), first.max(*last)]),
        _ => None,
    }
}

fn compared(keys: &Keys, limits: &AxisLimits, points: &[PointResult]) -> Result<Compared, Reason> {
    if let Some((point, reason)) = points.iter().find_map(|p| Some((p, p.inconclusive.as_ref()?))) {
        return Err(Reason::of_point(&point.point, reason));
    }
    let [up, down, driven] = points else { return Err(FrictionReason::NotAllRan.into()) };
    let up: &Pulled = up.reduced.get().ok_or(FrictionReason::NotAllRan)?;
    let down: &Pulled = down.reduced.get().ok_or(FrictionReason::NotAllRan)?;
    let driven: &Driven = driven.reduced.get().ok_or(FrictionReason::NotAllRan)?;
    let angles = [&up.angle_rad, &down.angle_rad, &driven.angle_rad];
    let period_rad = TAU / limits.cogging_orders_per_rev;
    let ranges: Option<Vec<[f64; 2]>> = angles.iter().map(|angle| ends_rad(angle)).collect();
    let ranges = ranges.ok_or(FrictionReason::NoAngles)?;
    let per_period =
        |angle: &[f64], range: &[f64; 2]| angle.len() as f64 * period_rad / (range[1] - range[0]);
    let fewest = angles
        .iter()
        .zip(&ranges)
        .map(|(angle, range)| per_period(angle, range))
        .fold(f64::INFINITY, f64::min);
    let grid = Grid::common(&ranges, period_rad, fewest).ok_or(FrictionReason::PointsShareNone)?;
    let map = |point: usize, torque_nm: &[f64]| {
        bin_means(angles[point], torque_nm, &grid)
            .ok_or_else(|| FrictionReason::NotCovering { point: points[point].point.clone() })
    };
    let bins = grid.bins_per_period_count;
    let friction = |growing: &[f64], falling: &[f64]| {
        half_difference(&[growing.to_vec()], &[falling.to_vec()], bins, SlowChange::PerhapsDrift)
            .filter(|found| found.value > 0.0)
            .ok_or(FrictionReason::NoFrictionSeen)
    };
    let gauge = [map(0, &up.torque_nm)?, map(1, &down.torque_nm)?];
    let motor = [map(2, &driven.growing_nm)?, map(2, &driven.falling_nm)?];
    let by_gauge = friction(&gauge[0], &gauge[1])?;
    let by_motor = friction(&motor[0], &motor[1])?;
    let zero = 0.5 * up.zero_u_nm.hypot(down.zero_u_nm);
    let relative = |found: Estimate, known: &[f64]| {
        let own = Component { u: found.u / found.value, dof: found.dof };
        let known: Vec<Component> = known.iter().map(|&u| Component::known(u)).collect();
        let spread = combine(&[vec![own], known].concat());
        Estimate { u: spread.u, dof: spread.dof, ..found }
    };
    let half = |[growing, falling]: [Vec<f64>; 2]| -> Vec<f64> {
        growing.iter().zip(&falling).map(|(up, down)| 0.5 * (up - down)).collect()
    };
    Ok(Compared {
        pulled: relative(by_gauge, &[keys.gauge_u_ratio, keys.arm_u_m / keys.arm_m, zero / by_gauge.value]),
        driven: relative(by_motor, &[driven.quantum_u_nm / by_motor.value]),
        rates_rad_per_s: [0.5 * (up.rate_rad_per_s + down.rate_rad_per_s), driven.rate_rad_per_s],
        angle_rad: grid.centres_rad(),
        maps_nm: [half(gauge), half(motor)],
        spans_s: [up.span_s, down.span_s, driven.span_s],
    })
}

impl Compared {
    fn report(&self, keys: &Keys, axis: &str, limits: &AxisLimits, whole: &mut Conclusion) {
        let Some(constant) = limits.torque_constant_nm_per_a else { return };
        let ratio = self.pulled.value / self.driven.value;
        let [pulled, driven] = self.rates_rad_per_s;
        let apart = RATE_SHARE * (pulled / driven - 1.0).abs();
        let part = |e: &Estimate| Component { u: e.u, dof: e.dof };
        let spread = combine(&[part(&self.pulled), part(&self.driven), Component::known(apart)]);
        let measurement = |name: &str, kind: Q, value: f64, u: f64, dof: f64| {
            let estimate = Estimate { value, u, dof, n: self.pulled.n };
            Measurement {
                conditions: vec![self.condition(keys)],
                flags: vec![self.ampere(keys), format!("at {}", Q::AngularVelocity.format(pulled))],
                evidence: self.evidence(axis),
                ..Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR)
            }
        };
        let gauge = self.pulled.value;
        let dof = spread.dof;
        whole.measurements.extend([
            measurement(PULLED, Q::Torque, gauge, gauge * self.pulled.u, self.pulled.dof),
            measurement(CONSTANT, Q::TorqueConstant, constant * ratio, constant * ratio * spread.u, dof),
            measurement(ERROR, Q::Ratio, ratio - 1.0, ratio * spread.u, dof),
        ]);
        whole.plots.push(self.picture(axis));
        if (ratio - 1.0).abs() > keys.allowed_ratio {
            let words = format!(
                "the measured torque constant of {axis} is {}, but the rig file has {}: plan, loops and \
                 interlocks of the run were off by {}",
                Q::TorqueConstant.format(constant * ratio),
                Q::TorqueConstant.format(constant),
                Q::Ratio.format(ratio - 1.0),
            );
            whole.remarks.push(format!(
                "SUSPICIOUS: {words}. Torques are based on the gauge, and no torque can pass its limit."
            ));
            let told =
                whole.measurements.iter_mut().filter(|m| [CONSTANT, ERROR].contains(&m.measurand.as_str()));
            told.for_each(|m| m.doubt = Some(words.clone()));
        }
    }

    fn ampere(&self, keys: &Keys) -> String {
        let words = if keys.ampere == "peak" { "peak" } else { "root mean square" };
        format!("current as the drive reports it: {words} of the phase current")
    }

    fn condition(&self, keys: &Keys) -> Condition {
        Condition {
            name: "velocity".to_owned(),
            requested: keys.velocity_rad_per_s,
            achieved: Some(self.rates_rad_per_s[0]),
            kind: Q::AngularVelocity,
        }
    }

    fn evidence(&self, axis: &str) -> Vec<Evidence> {
        let gauge = [format!("{TOPIC} {CHANNEL}"), format!("/{axis} position_rad")];
        let motor = [format!("/{axis} current_a"), format!("/{axis} position_rad")];
        let [up_s, down_s, driven_s] = self.spans_s;
        vec![
            Evidence::new(gauge.to_vec(), up_s),
            Evidence::new(gauge.to_vec(), down_s),
            Evidence::new(motor.to_vec(), driven_s),
        ]
    }

    /// Friction over angle, by the gauge and by the current.
    fn picture(&self, axis: &str) -> Plot {
        let angle: Vec<f64> = self.angle_rad.iter().map(|&rad| Q::Angle.to_display(rad)).collect();
        let series =
            |(label, map): (&str, &Vec<f64>)| Series::thinned(label, Style::Line, [&angle, map], MAX_POINTS);
        let plot = Plot::new(
            format!("torque-constant-{axis}"),
            "Friction by force gauge and by current",
            Scale::linear("angle", Q::Angle.display_unit()),
            Scale::linear("friction torque", Q::Torque.display_unit()),
        );
        let both = ["force gauge", "current times the rig's constant"].into_iter().zip(&self.maps_nm);
        Plot { series: both.map(series).collect(), ..plot }
    }
}
