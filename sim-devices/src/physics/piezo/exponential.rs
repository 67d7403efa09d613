//! Matrix exponential: exact discretisation of small linear systems.

/// Terms of the Taylor series; with a norm below 1/2 the remainder is below 10⁻¹⁸.
const TERMS: u32 = 16;

/// `exp(A·t)` by scaling and squaring (Moler & Van Loan, *Nineteen dubious ways…*, SIAM Review 45 (2003) 3,
/// method 3). An input that is held or that moves linearly goes in as further states with known derivatives.
pub(crate) fn exponential<const N: usize>(a: &[[f64; N]; N], t: f64) -> [[f64; N]; N] {
    let norm = a.iter().map(|row| row.iter().map(|x| (x * t).abs()).sum::<f64>()).fold(0.0, f64::max);
    let mut halvings = 0;
    let mut scale = t;
    while norm * scale.abs() > 0.5 * t.abs() {
        scale *= 0.5;
        halvings += 1;
    }
    let mut result = identity();
    let mut term: [[f64; N]; N] = identity();
    for k in 1..=TERMS {
        term = product(&term, a, scale / f64::from(k));
        for (row, addend) in result.iter_mut().zip(&term) {
            row.iter_mut().zip(addend).for_each(|(x, y)| *x += y);
        }
    }
    for _ in 0..halvings {
        result = product(&result, &result, 1.0);
    }
    result
}

fn identity<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

fn product<const N: usize>(a: &[[f64; N]; N], b: &[[f64; N]; N], factor: f64) -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| factor * (0..N).map(|k| a[i][k] * b[k][j]).sum::<f64>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_stays_a_rotation_however_fast() {
        for turns in [0.01, 1.3, 250.0] {
            let rotation = exponential(&[[0.0, -turns], [turns, 0.0]], 1.0);
            assert!((rotation[0][0] - turns.cos()).abs() < 1e-12, "{turns}: {rotation:?}");
            assert!((rotation[1][0] - turns.sin()).abs() < 1e-12, "{turns}: {rotation:?}");
        }
    }

    #[test]
    fn a_ramp_through_a_first_order_lag_follows_the_textbook() {
        // x' = (u − x)/τ, u' = 1: x(t) = t − τ + τ·exp(−t/τ).
        let tau = 0.3;
        let t = 0.7;
        let map = exponential(&[[-1.0 / tau, 1.0 / tau, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]], t);
        assert!((map[0][2] - (t - tau + tau * (-t / tau).exp())).abs() < 1e-14);
    }
}
