//! Levenberg–Marquardt on [normal equations](super::normal) (Marquardt, *J. SIAM* 11, 431, 1963; damping after
//! Nielsen, IMM-REP-1999-05, Technical University of Denmark).

use nalgebra::{DMatrix, DVector};

use super::lines::Data;
use super::normal::{Model, Normal};
use super::projection::{PATIENCE, TOLERANCE};
use super::shape::Shape;
use super::solution::Eliminated;

/// First damping over the diagonal: starts are close as a rule.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping at which steps vanish in rounding.
const MOST_DAMPING: f64 = 1e12;

/// How a search ended.
pub(super) enum End {
    /// At a minimum.
    Found(Vec<f64>, Box<Eliminated>),
    /// Here the normal equations lose their footing.
    Ill(Vec<f64>),
    /// Nowhere.
    Lost,
}

/// Step of damped normal equations and by how much it should lower the cost.
fn step(model: &Model, damping: f64) -> Option<(DVector<f64>, f64)> {
    let mut damped: DMatrix<f64> = model.information.clone();
    let diagonal = model.information.diagonal() * damping;
    (0..diagonal.len()).for_each(|k| damped[(k, k)] += diagonal[k]);
    let step = damped.cholesky()?.solve(&model.gradient);
    let predicted = step.dot(&(diagonal.component_mul(&step) + &model.gradient));
    (predicted.is_finite() && step.iter().all(|v| v.is_finite())).then_some((step, predicted))
}

/// Minimises the cost from `start`.
pub(super) fn search(data: &Data, shape: &Shape, start: &[f64]) -> End {
    let mut theta = DVector::from_column_slice(start);
    let ill = |theta: &DVector<f64>| End::Ill(theta.as_slice().to_vec());
    let Some(mut at) = Normal::new(data, shape, start) else { return ill(&theta) };
    let rounding = f64::EPSILON.powi(2) * size(data);
    let (mut damping, mut growth) = (FIRST_DAMPING, 2.0);
    let mut evaluations = 1;
    loop {
        let Some(model) = at.model(data, shape, theta.as_slice()) else { return ill(&theta) };
        let flat = model.decrement <= (TOLERANCE * at.cost).max(rounding);
        // Raises the damping until the cost falls; where nothing is left to gain, rounding may keep it from that.
        let next = loop {
            if evaluations > PATIENCE * (start.len() + 1) {
                return End::Lost;
            }
            let Some((step, predicted)) = step(&model, damping) else { return ill(&theta) };
            let trial = &theta + step;
            evaluations += 1;
            let Some(there) = Normal::new(data, shape, trial.as_slice()) else { return ill(&theta) };
            let ratio = (at.cost - there.cost) / predicted.max(f64::MIN_POSITIVE);
            if ratio > 0.0 {
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
                break Some((trial, there));
            }
            if flat || damping > MOST_DAMPING {
                break None;
            }
            damping *= growth;
            growth *= 2.0;
        };
        let Some((trial, there)) = next else { return found(&at, model, &theta) };
        (theta, at) = (trial, there);
        if flat {
            let Some(model) = at.model(data, shape, theta.as_slice()) else { return ill(&theta) };
            return found(&at, model, &theta);
        }
    }
}

fn found(at: &Normal, model: Model, theta: &DVector<f64>) -> End {
    End::Found(theta.as_slice().to_vec(), Box::new(at.eliminated(model)))
}

/// Sum of weighted squares of the values.
fn size(data: &Data) -> f64 {
    let of = |r: &super::lines::Weighed| -> f64 {
        r.value.iter().zip(&r.root).map(|(v, root)| root * root * v.norm_sqr()).sum()
    };
    data.responses.iter().map(of).sum()
}
