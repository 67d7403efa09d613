//! Noise that responses share: two sensors of one axis both show what disturbs it.
//!
//! A fit that takes the residuals of its responses for independent says too much of the poles that they have in common, by up
//! to √2 for two. With the influence `ψ = B·(∂G/∂θ)ᵀ` of each weighted residual on θ and a correlation ρ between the residuals
//! of two responses at one frequency, the covariance grows by `Σ ψ_m·C·ψ_nᵀ + ψ_n·Cᵀ·ψ_mᵀ`, C the correlation of real and
//! imaginary parts (the "seemingly unrelated regressions" of Zellner, *J. Am. Stat. Assoc.* 57, 348, 1962, fitted with the
//! weights as they are).

use nalgebra::DMatrix;

use super::super::frf::C64;
use super::lines::{Data, Weighed};
use super::shape::Shape;
use super::solution::Follower;

/// A correlation that is smaller than so many of its own standard deviations, 1/√n, is taken for none.
const LEAST_DEVIATIONS: f64 = 3.0;

/// What is added to the covariance of θ, `of_theta`, both without the factor of the noise; zero where residuals do not correlate.
pub(super) fn covariance(
    data: &Data,
    shape: &Shape,
    theta: &[f64],
    followers: &[Follower],
    of_theta: &DMatrix<f64>,
) -> DMatrix<f64> {
    let n = shape.nonlinear_count();
    let mut sum = DMatrix::zeros(n, n);
    let left = |m: usize| residuals(&data.responses[m], shape, theta, &followers[m]);
    let slopes = |m: usize| slopes(&data.responses[m], shape, theta, &followers[m]);
    for second in 1..followers.len() {
        for first in 0..second {
            let lines = shared(&data.responses[first].s, &data.responses[second].s);
            if let Some(rho) = correlation(&left(first), &left(second), &lines) {
                add(&mut sum, [&slopes(first), &slopes(second)], &lines, rho);
            }
        }
    }
    of_theta * sum * of_theta
}

/// Weighted residuals of a response.
fn residuals(response: &Weighed, shape: &Shape, theta: &[f64], follower: &Follower) -> Vec<C64> {
    let lines = response.s.iter().zip(&response.value).zip(&response.root);
    lines.map(|((s, value), root)| (value - shape.at(theta, &follower.c, *s)) * *root).collect()
}

/// Slopes of the weighted residuals of a response over θ, the linear parameters following it: for each line a row of real and
/// one of imaginary parts.
fn slopes(response: &Weighed, shape: &Shape, theta: &[f64], follower: &Follower) -> Vec<DMatrix<f64>> {
    let [n, linear] = [shape.nonlinear_count(), shape.linear_count()];
    let mut own = vec![C64::default(); n];
    let mut columns = vec![C64::default(); linear];
    let mut at_line = |s: C64, root: f64| {
        shape.slopes(theta, &follower.c, s, &mut own);
        shape.columns(theta, s, &mut columns);
        let whole = |k: usize| {
            let followed: C64 = columns.iter().enumerate().map(|(l, c)| c * follower.follow[(l, k)]).sum();
            (own[k] - followed) * root
        };
        let row: Vec<C64> = (0..n).map(whole).collect();
        DMatrix::from_fn(2, n, |part, k| if part == 0 { row[k].re } else { row[k].im })
    };
    response.s.iter().zip(&response.root).map(|(s, root)| at_line(*s, *root)).collect()
}

/// Pairs of lines at one frequency, both ascending.
fn shared(first: &[C64], second: &[C64]) -> Vec<[usize; 2]> {
    let partner = |(i, s): (usize, &C64)| {
        let j = second.partition_point(|other| other.im < s.im * (1.0 - 1e-12));
        second.get(j).filter(|other| (other.im - s.im).abs() <= 1e-12 * s.im).map(|_| [i, j])
    };
    first.iter().enumerate().filter_map(partner).collect()
}

/// E(a·b̄) over the sizes of both; `None` where it is within what chance makes of none.
fn correlation(a: &[C64], b: &[C64], lines: &[[usize; 2]]) -> Option<C64> {
    let both: C64 = lines.iter().map(|[i, j]| a[*i] * b[*j].conj()).sum();
    let square = |value: fn(&[usize; 2]) -> usize, all: &[C64]| {
        lines.iter().map(|pair| all[value(pair)].norm_sqr()).sum::<f64>()
    };
    let rho = both / (square(|[i, _]| *i, a) * square(|[_, j]| *j, b)).sqrt();
    let least = LEAST_DEVIATIONS / (lines.len() as f64).sqrt();
    (rho.is_finite() && rho.norm() > least).then_some(rho)
}

/// Adds both cross terms of two responses.
fn add(sum: &mut DMatrix<f64>, [a, b]: [&[DMatrix<f64>]; 2], lines: &[[usize; 2]], rho: C64) {
    let parts = DMatrix::from_row_slice(2, 2, &[rho.re, -rho.im, rho.im, rho.re]);
    for [i, j] in lines {
        let cross = a[*i].transpose() * &parts * &b[*j];
        *sum += &cross + cross.transpose();
    }
}
