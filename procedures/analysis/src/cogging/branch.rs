//! One stroke as effort over angle, and least squares of harmonics on it.

use nalgebra::Complex;

use super::Settings;
use crate::least_squares::LinearFit;
use crate::uncertainty::{Component, correlation_factor};

/// Effort over angle in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Whether the angle fell during the stroke.
    pub reverse: bool,
    /// Angles, ascending or not.
    pub angle_rad: Vec<f64>,
    /// Effort (torque or current) at each angle.
    pub value: Vec<f64>,
    /// Weight of each value: the stretch of angle that it stands for.
    pub weight: Vec<f64>,
}

/// What lies under the harmonics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Background {
    /// Constant, cos θ and θ: unbalance and spring on part of a turn.
    PartTurn,
    /// Constant, cos θ and sin θ: unbalance on a full turn.
    FullTurn,
}

impl Background {
    pub(super) fn of(settings: &Settings) -> Self {
        if settings.full_turn { Self::FullTurn } else { Self::PartTurn }
    }
}

/// Columns of the background.
const BACKGROUND: usize = 3;

impl Branch {
    /// Complex amplitudes `a·e^{iφ}` of `a·cos(order·θ + φ)` at all orders together, background fitted too.
    pub(super) fn amplitudes(&self, background: Background, orders: &[f64]) -> Option<Vec<Complex<f64>>> {
        let fit = self.fit(background, orders)?;
        let b = |k: usize| fit.coefficients[k];
        Some(
            (0..orders.len())
                .map(|k| Complex::new(b(BACKGROUND + 2 * k), -b(BACKGROUND + 2 * k + 1)))
                .collect(),
        )
    }

    /// This stroke without background and the harmonics of these orders.
    pub(super) fn without_harmonics(&self, background: Background, orders: &[f64]) -> Option<Self> {
        let fit = self.fit(background, orders)?;
        Some(Self { value: fit.residuals, ..self.clone() })
    }

    /// Mean over a full turn with its uncertainty from what the harmonics of these orders leave (corrected for its
    /// correlation along the angle); `None` if the points do not suffice.
    pub fn mean_over_turn(&self, orders: &[f64]) -> Option<(f64, Component)> {
        let fit = self.fit(Background::FullTurn, orders)?;
        let factor = correlation_factor(&fit.residuals);
        let dof = (fit.dof as f64 / factor).max(1.0);
        Some((fit.coefficients[0], Component { u: fit.u(0) * factor.sqrt(), dof }))
    }

    fn fit(&self, background: Background, orders: &[f64]) -> Option<LinearFit> {
        let column = |f: &dyn Fn(f64) -> f64| self.angle_rad.iter().map(|&a| f(a)).collect::<Vec<f64>>();
        let mut columns = vec![column(&|_| 1.0), column(&f64::cos)];
        columns.push(match background {
            Background::PartTurn => column(&|a| a),
            Background::FullTurn => column(&f64::sin),
        });
        for &order in orders {
            columns.push(column(&|a| (order * a).cos()));
            columns.push(column(&|a| (order * a).sin()));
        }
        LinearFit::new(&columns, &self.value, Some(&self.weight)).ok()
    }

    /// Mean spacing of the angles.
    pub(super) fn spacing_rad(&self) -> f64 {
        let low = self.angle_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.angle_rad.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (high - low) / (self.angle_rad.len().max(2) - 1) as f64
    }
}
