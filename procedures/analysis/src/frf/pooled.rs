//! Variances of lines from few windows, pooled with those of their neighbours.

use super::{Frf, Line};

/// Fewest complex degrees of freedom with which the variance of a line is used alone. The reciprocal of a variance has a
/// finite mean square only above two.
const LEAST_VARIANCE_DOF: f64 = 3.0;
/// Degrees of freedom to be reached by pooling neighbouring lines, where a line has fewer than [`LEAST_VARIANCE_DOF`].
const POOLED_DOF: f64 = 32.0;
/// Most neighbours that are pooled on each side.
const MOST_REACH: usize = 32;

/// A variance with its complex degrees of freedom.
#[derive(Clone, Copy)]
pub(crate) struct Spread {
    pub(crate) variance: f64,
    pub(crate) dof: f64,
}

/// Variance of line `k`. With fewer than [`LEAST_VARIANCE_DOF`] it is the mean over the line and its neighbours, as many
/// on each side as make up [`POOLED_DOF`].
///
/// A variance of two or three windows that happens to be small would give its line all the weight, and χ² by such
/// variances has no finite scatter. Pooling is allowed because noise is smooth over a few lines.
pub(crate) fn spread(lines: &[Line], k: usize) -> Spread {
    let own = &lines[k];
    if own.dof >= LEAST_VARIANCE_DOF {
        return Spread { variance: own.variance, dof: own.dof };
    }
    let mut reach = 0;
    loop {
        let near = &lines[k.saturating_sub(reach)..(k + reach + 1).min(lines.len())];
        let dof: f64 = near.iter().map(|l| l.dof.clamp(0.0, POOLED_DOF)).sum();
        if dof >= POOLED_DOF || reach >= MOST_REACH || near.len() == lines.len() {
            let variance = near.iter().map(|l| l.variance).sum::<f64>() / near.len() as f64;
            return Spread { variance, dof: dof.max(LEAST_VARIANCE_DOF) };
        }
        reach += 1;
    }
}

/// The lines with the variances that [`spread`] gives them.
pub(crate) fn with_pooled_variances(lines: &[Line]) -> Frf {
    let pooled = |k: usize| {
        let Spread { variance, dof } = spread(lines, k);
        Line { variance, dof, ..lines[k] }
    };
    (0..lines.len()).map(pooled).collect()
}
