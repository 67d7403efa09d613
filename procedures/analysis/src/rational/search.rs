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

/// Most steps taken after the search.
const LAST_STEPS: usize = 2;
/// Part of the gain that such a step must not leave; where it leaves more, rounding has been reached.
const LEFT: f64 = 0.25;

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
    let rounding = f64::EPSILON.powi(2) * data.size();
    let mut damping = FIRST_DAMPING;
    let mut growth = 2.0;
    let mut evaluations = 1;
    loop {
        let Some(model) = at.model(data, shape, theta.as_slice()) else { return ill(&theta) };
        if model.decrement <= (TOLERANCE * at.cost).max(rounding) {
            return found(&at, model, &theta);
        }
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
            if damping > MOST_DAMPING {
                break None;
            }
            damping *= growth;
            growth *= 2.0;
        };
        let Some((trial, there)) = next else { return found(&at, model, &theta) };
        (theta, at) = (trial, there);
    }
}

/// Plain Gauss–Newton from a minimum that [`search`] found, as long as what is left to gain shrinks: the cost is too
/// coarse for that (its rounding hides the last half of the digits), its gradient is not. So the end does not show the
/// way, and with it neither the unit of the response nor the last bit of a line. `None` where the normal equations lose
/// their footing.
pub(super) fn settled(data: &Data, shape: &Shape, theta: &[f64]) -> Option<(Vec<f64>, Eliminated)> {
    let mut theta = DVector::from_column_slice(theta);
    let mut at = Normal::new(data, shape, theta.as_slice())?;
    let mut model = at.model(data, shape, theta.as_slice())?;
    for _ in 0..LAST_STEPS {
        let Some((step, _)) = step(&model, 0.0) else { break };
        let trial = &theta + step;
        let Some(there) = Normal::new(data, shape, trial.as_slice()) else { break };
        let Some(next) = there.model(data, shape, trial.as_slice()) else { break };
        if next.decrement > LEFT * model.decrement {
            break;
        }
        (theta, at, model) = (trial, there, next);
    }
    Some((theta.as_slice().to_vec(), at.eliminated(model)))
}

fn found(at: &Normal, model: Model, theta: &DVector<f64>) -> End {
    End::Found(theta.as_slice().to_vec(), Box::new(at.eliminated(model)))
}
