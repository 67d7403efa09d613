//! The minimum of χ² over the five parameters: grid of starts, then Levenberg–Marquardt on bounded parameters.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, OMatrix, SVector, U5};

use super::{Bounds, Parameters, Point};
use crate::least_squares::LinearFit;

/// Stribeck velocities on the grid of starts.
const STARTS: u32 = 8;
/// Shapes on the grid of starts.
const SHAPES: [f64; 5] = [0.5, 0.85, 1.4, 2.2, 3.5];
/// Best starts that are refined.
const REFINED: usize = 4;

/// The best minimum from all starts and its χ².
pub(super) fn from_all_starts(points: &[Point], bounds: &Bounds) -> Option<(Parameters, f64)> {
    let mut starts: Vec<(f64, Parameters)> = Vec::new();
    let [low, high] = [bounds.slowest, bounds.stribeck[1] / 2.0];
    for i in 0..STARTS {
        let place = f64::from(i) / f64::from(STARTS - 1);
        let stribeck = low * (high / low).powf(place);
        starts.extend(SHAPES.iter().filter_map(|&shape| start(points, stribeck, shape)));
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<(Parameters, f64)> = None;
    for (_, start) in starts.into_iter().take(REFINED) {
        let problem = Problem { points, bounds: *bounds, free: free(&start, bounds) };
        let (solved, _) = LevenbergMarquardt::new().with_patience(60).minimize(problem);
        let parameters = solved.parameters();
        let chi2 = chi2(points, &parameters);
        if chi2.is_finite() && best.is_none_or(|(_, least)| chi2 < least) {
            best = Some((parameters, chi2));
        }
    }
    best
}

fn chi2(points: &[Point], parameters: &Parameters) -> f64 {
    points.iter().map(|p| ((p.friction_nm - parameters.at_nm(p.velocity_rad_per_s)) / p.u_nm).powi(2)).sum()
}

/// The three linear parameters by least squares at a given Stribeck velocity and shape, and their χ².
fn start(points: &[Point], stribeck: f64, shape: f64) -> Option<(f64, Parameters)> {
    let column =
        |f: &dyn Fn(f64) -> f64| points.iter().map(|p| f(p.velocity_rad_per_s)).collect::<Vec<f64>>();
    let columns = [column(&|_| 1.0), column(&|v| (-(v / stribeck).powf(shape)).exp()), column(&|v| v)];
    let friction: Vec<f64> = points.iter().map(|p| p.friction_nm).collect();
    let weight: Vec<f64> = points.iter().map(|p| 1.0 / (p.u_nm * p.u_nm)).collect();
    let fit = LinearFit::new(&columns, &friction, Some(&weight)).ok()?;
    let least = friction.iter().copied().fold(f64::INFINITY, f64::min) * 1e-3;
    let b = |k: usize| fit.coefficients[k].max(least);
    let fastest = points.iter().map(|p| p.velocity_rad_per_s).fold(0.0, f64::max);
    let parameters = Parameters {
        coulomb_nm: b(0),
        static_nm: b(0) + b(1),
        stribeck_rad_per_s: stribeck,
        viscous_nm_s_per_rad: fit.coefficients[2].max(least / fastest),
        shape_ratio: shape,
    };
    Some((chi2(points, &parameters), parameters))
}

/// Unbounded parameters: ln T_C, ln(T_S − T_C), logit of ln ω_s, ln σ2, logit of ln δ.
fn free(parameters: &Parameters, bounds: &Bounds) -> SVector<f64, 5> {
    let logit = |value: f64, [low, high]: [f64; 2]| {
        let place = ((value / low).ln() / (high / low).ln()).clamp(1e-6, 1.0 - 1e-6);
        (place / (1.0 - place)).ln()
    };
    SVector::from([
        parameters.coulomb_nm.ln(),
        (parameters.static_nm - parameters.coulomb_nm).ln(),
        logit(parameters.stribeck_rad_per_s, bounds.stribeck),
        parameters.viscous_nm_s_per_rad.ln(),
        logit(parameters.shape_ratio, bounds.shape),
    ])
}

/// A bounded parameter and its derivative by the free one.
fn bounded(free: f64, [low, high]: [f64; 2]) -> (f64, f64) {
    let place = 1.0 / (1.0 + (-free).exp());
    let value = low * (high / low).powf(place);
    (value, value * (high / low).ln() * place * (1.0 - place))
}

struct Problem<'a> {
    points: &'a [Point],
    bounds: Bounds,
    free: SVector<f64, 5>,
}

impl Problem<'_> {
    fn parameters(&self) -> Parameters {
        let x = &self.free;
        Parameters {
            coulomb_nm: x[0].exp(),
            static_nm: x[0].exp() + x[1].exp(),
            stribeck_rad_per_s: bounded(x[2], self.bounds.stribeck).0,
            viscous_nm_s_per_rad: x[3].exp(),
            shape_ratio: bounded(x[4], self.bounds.shape).0,
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, U5> for Problem<'_> {
    type ParameterStorage = Owned<f64, U5>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U5>;

    fn set_params(&mut self, x: &SVector<f64, 5>) {
        self.free = *x;
    }

    fn params(&self) -> SVector<f64, 5> {
        self.free
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let parameters = self.parameters();
        let residual = |p: &Point| (parameters.at_nm(p.velocity_rad_per_s) - p.friction_nm) / p.u_nm;
        let all = DVector::from_iterator(self.points.len(), self.points.iter().map(residual));
        all.iter().all(|r| r.is_finite()).then_some(all)
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U5>> {
        let parameters = self.parameters();
        let x = &self.free;
        // T_S = e^x0 + e^x1: x0 moves both torques, x1 the static one alone.
        let chain = [
            x[0].exp(),
            x[1].exp(),
            bounded(x[2], self.bounds.stribeck).1,
            x[3].exp(),
            bounded(x[4], self.bounds.shape).1,
        ];
        let mut rows = OMatrix::<f64, Dyn, U5>::zeros(self.points.len());
        for (i, p) in self.points.iter().enumerate() {
            let g = parameters.gradient(p.velocity_rad_per_s);
            let by_free = [g[0] + g[1], g[1], g[2], g[3], g[4]];
            for k in 0..5 {
                rows[(i, k)] = by_free[k] * chain[k] / p.u_nm;
            }
        }
        rows.iter().all(|v| v.is_finite()).then_some(rows)
    }
}
