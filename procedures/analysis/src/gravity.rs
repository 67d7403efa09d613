//! Unbalance and spring from the half-sum of both directions, by least squares.

use std::ops::Range;

use crate::least_squares::{FitError, LinearFit};
use crate::uncertainty::correlation_factor;

/// Largest variance inflation at which unbalance and spring still count as told apart.
pub const MOST_INFLATION: f64 = 30.0;

/// Half-sum of both directions, one value a cogging period.
///
/// Columns are means over the same period as the torque, so the model holds exactly for periods of any length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HalfSum {
    /// Mean angle.
    pub angle_rad: Vec<f64>,
    /// Mean cosine of the angle.
    pub cosine_ratio: Vec<f64>,
    /// Half-sum of the torque of both directions.
    pub torque_nm: Vec<f64>,
}

impl HalfSum {
    /// Some of the periods.
    ///
    /// # Panics
    /// Where the periods are not all there.
    #[must_use]
    pub fn part(&self, periods: Range<usize>) -> Self {
        let cut = |column: &[f64]| column[periods.clone()].to_vec();
        Self {
            angle_rad: cut(&self.angle_rad),
            cosine_ratio: cut(&self.cosine_ratio),
            torque_nm: cut(&self.torque_nm),
        }
    }

    /// First and last angle of the periods, half a period beyond their mean angles; `None` of fewer than two periods.
    pub fn angles_rad(&self) -> Option<[f64; 2]> {
        let [first, .., last] = self.angle_rad[..] else { return None };
        let half = (last - first) / (self.angle_rad.len() - 1) as f64 / 2.0;
        Some([first - half, last + half])
    }

    /// So many periods about the middle, of at least so many.
    #[must_use]
    pub fn middle(&self, periods: usize) -> Self {
        let skip = (self.torque_nm.len() - periods) / 2;
        self.part(skip..skip + periods)
    }
}

/// Constant, unbalance and spring: `half-sum = c − A_u·cos θ + K_s·θ` with `c = −K_s·θ_0`.
///
/// From J·α = T_m − T_f + A_u·cos θ − K_s·(θ − θ_0) at constant speed, where half the sum of both directions has no
/// friction. θ_0 is identified by the constant alone, so a torque offset of the drive, or friction that differs
/// between the directions, counts as spring.
#[derive(Clone, Debug, PartialEq)]
pub struct Gravity {
    fit: LinearFit,
    /// Factor by which correlated residuals widen the covariance.
    factor: f64,
}

impl Gravity {
    /// Fits `[1, cos θ, θ]`.
    ///
    /// # Errors
    /// Too few periods (four at least), or a span on which the columns are one and the same.
    pub fn new(half_sum: &HalfSum) -> Result<Self, FitError> {
        let one = vec![1.0; half_sum.torque_nm.len()];
        let columns = [one, half_sum.cosine_ratio.clone(), half_sum.angle_rad.clone()];
        let fit = LinearFit::new(&columns, &half_sum.torque_nm, None)?;
        let factor = correlation_factor(&fit.residuals);
        Ok(Self { fit, factor })
    }

    /// Larger variance inflation of unbalance and spring.
    pub fn inflation_factor(&self) -> f64 {
        self.fit.worst_inflation()
    }

    /// Degrees of freedom, reduced by the correlation of the residuals.
    pub fn dof_count(&self) -> f64 {
        (self.fit.dof as f64 / self.factor).max(1.0)
    }

    /// Unbalance amplitude A_u, signed, and its standard uncertainty.
    pub fn unbalance_nm(&self) -> [f64; 2] {
        [-self.fit.coefficients[1], self.fit.u(1) * self.factor.sqrt()]
    }

    /// Spring stiffness K_s per rad and its standard uncertainty.
    pub fn stiffness_nm_per_rad(&self) -> [f64; 2] {
        [self.fit.coefficients[2], self.fit.u(2) * self.factor.sqrt()]
    }

    /// Spring torque K_s·(θ − θ_0) at an angle and its standard uncertainty.
    pub fn spring_nm(&self, angle_rad: f64) -> [f64; 2] {
        let row = [1.0, 0.0, angle_rad];
        [self.fit.at(&row), self.fit.u_at(&row) * self.factor.sqrt()]
    }

    /// Whole model at an angle.
    pub fn at_nm(&self, angle_rad: f64) -> f64 {
        self.fit.at(&[1.0, angle_rad.cos(), angle_rad])
    }

    /// The end of travel with the larger spring torque, of a spring that is at rest somewhere on the travel.
    ///
    /// The constant of the fit is that of the spring, and half of what friction differs by in both directions. A rest angle beyond
    /// the travel therefore counts as lying at its end, and what remains of the constant as friction.
    pub fn largest_spring(&self, travel_rad: [f64; 2]) -> LargestSpring {
        let ends = travel_rad.map(|angle| self.spring_nm(angle));
        let is_at_rest_between = ends[0][0] * ends[1][0] <= 0.0;
        if is_at_rest_between {
            // The spring is linear, so its largest torque lies at an end; the lower one of equals.
            let far = usize::from(ends[1][0].abs() > ends[0][0].abs());
            let [torque_nm, u_nm] = ends[far];
            return LargestSpring {
                at_rad: travel_rad[far],
                torque_nm: torque_nm.abs(),
                u_nm,
                beyond_nm: 0.0,
            };
        }
        let near = usize::from(ends[1][0].abs() < ends[0][0].abs());
        let span_rad = travel_rad[1] - travel_rad[0];
        let [stiffness, u] = self.stiffness_nm_per_rad();
        LargestSpring {
            at_rad: travel_rad[1 - near],
            torque_nm: stiffness.abs() * span_rad,
            u_nm: u * span_rad,
            beyond_nm: ends[near][0].abs(),
        }
    }
}

/// Spring torque at the end of the travel that is farther from its rest angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestSpring {
    /// That end.
    pub at_rad: f64,
    /// Magnitude.
    pub torque_nm: f64,
    /// Its standard uncertainty.
    pub u_nm: f64,
    /// Part of the constant of the fit that no spring explains whose rest angle lies on the travel; 0 where one does.
    pub beyond_nm: f64,
}

/// Unbalance from two opposite poses: half the **difference** of the half-sums at θ and θ + π, least squares on
/// `[1, cos θ]` (director study, erratum E13: the half sum would cancel it).
///
/// Returns A_u (signed), its standard uncertainty and degrees of freedom.
///
/// # Errors
/// As [`LinearFit::new`]; [`FitError::Length`] if the poses have different numbers of periods.
pub fn unbalance_of_poses(pose: &HalfSum, opposite: &HalfSum) -> Result<[f64; 3], FitError> {
    let expected = pose.torque_nm.len();
    let found = opposite.torque_nm.len();
    if expected != found {
        return Err(FitError::Length { expected, found });
    }
    let halves = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| (a - b) / 2.0).collect() };
    let difference = halves(&pose.torque_nm, &opposite.torque_nm);
    let cosine = halves(&pose.cosine_ratio, &opposite.cosine_ratio);
    let fit = LinearFit::new(&[vec![1.0; expected], cosine], &difference, None)?;
    let factor = correlation_factor(&fit.residuals);
    Ok([-fit.coefficients[1], fit.u(1) * factor.sqrt(), (fit.dof as f64 / factor).max(1.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half-sums over 2° periods, model plus a small deterministic residual.
    fn half_sum(from_deg: f64, to_deg: f64, unbalance: f64, stiffness: f64, rest_deg: f64) -> HalfSum {
        let count = ((to_deg - from_deg) / 2.0) as usize;
        let mut out = HalfSum::default();
        for k in 0..count {
            let angle = (from_deg + 2.0 * k as f64 + 1.0).to_radians();
            out.angle_rad.push(angle);
            out.cosine_ratio.push(angle.cos());
            let spring = stiffness * (angle - rest_deg.to_radians());
            out.torque_nm
                .push(spring - unbalance * angle.cos() + 0.01 * (k as f64 * 2.399_963 + from_deg).sin());
        }
        out
    }

    #[test]
    fn elevation_over_its_wide_span_gives_both() {
        let fit = Gravity::new(&half_sum(-8.0, 88.0, 14.0, 54.0, 40.0)).expect("48 periods");
        assert!(fit.inflation_factor() < MOST_INFLATION, "{}", fit.inflation_factor());
        assert!((fit.unbalance_nm()[0] - 14.0).abs() < 0.05);
        assert!((fit.stiffness_nm_per_rad()[0] - 54.0).abs() < 0.05);
        let spring = fit.largest_spring([-10_f64.to_radians(), 90_f64.to_radians()]);
        let off_nm = spring.torque_nm - 54.0 * 50_f64.to_radians();
        assert!(off_nm.abs() < 4.0 * spring.u_nm + 0.02, "{spring:?}");
        assert_eq!(spring.beyond_nm, 0.0);
    }

    #[test]
    fn a_constant_torque_without_stiffness_is_no_spring() {
        // As friction that is 5 N·m larger in one direction leaves it.
        let mut halves = half_sum(-60.0, 60.0, 0.0, 0.0, 0.0);
        halves.torque_nm.iter_mut().for_each(|torque| *torque += 5.0);
        let fit = Gravity::new(&halves).expect("60 periods");
        let spring = fit.largest_spring([-2.8, 2.8]);
        assert!(spring.torque_nm < 4.0 * spring.u_nm && spring.torque_nm < 0.2, "{spring:?}");
        assert!((spring.beyond_nm - 5.0).abs() < 0.2, "{spring:?}");
    }

    #[test]
    fn a_spring_is_wound_up_over_the_whole_travel_at_the_most() {
        // Rest angle at 80 deg by the constant; the travel ends at 60 deg.
        let fit = Gravity::new(&half_sum(-60.0, 60.0, 0.0, 10.0, 80.0)).expect("60 periods");
        let spring = fit.largest_spring([-60_f64.to_radians(), 60_f64.to_radians()]);
        assert!(
            (spring.torque_nm - 10.0 * 120_f64.to_radians()).abs() < 4.0 * spring.u_nm + 0.02,
            "{spring:?}"
        );
        assert!(
            (spring.beyond_nm - 10.0 * 20_f64.to_radians()).abs() < 0.2 && spring.at_rad < 0.0,
            "{spring:?}"
        );
    }

    #[test]
    fn a_narrow_span_inflates_beyond_the_limit() {
        let fit = Gravity::new(&half_sum(10.0, 70.0, 14.0, 54.0, 40.0)).expect("30 periods");
        assert!(fit.inflation_factor() > MOST_INFLATION);
    }

    #[test]
    fn opposite_poses_give_unbalance_and_their_half_sum_would_not() {
        let here = half_sum(-60.0, 60.0, 14.0, 54.0, 40.0);
        let there = half_sum(120.0, 240.0, 14.0, 54.0, 40.0);
        let [unbalance, u, dof] = unbalance_of_poses(&here, &there).expect("equal poses");
        assert!((unbalance - 14.0).abs() < 0.05 && u < 0.02 && dof > 10.0, "{unbalance} ± {u}");
        let sum: Vec<f64> = here.torque_nm.iter().zip(&there.torque_nm).map(|(a, b)| (a + b) / 2.0).collect();
        let columns = [vec![1.0; sum.len()], here.cosine_ratio, here.angle_rad];
        let cancelled = LinearFit::new(&columns, &sum, None).expect("three columns");
        assert!(cancelled.coefficients[1].abs() < 0.1);
    }
}
