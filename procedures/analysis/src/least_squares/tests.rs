use proptest::prelude::*;

use super::*;

fn columns(a: f64, b: f64) -> Vec<Vec<f64>> {
    let angle: Vec<f64> = (0..=2000).map(|i| (a + (b - a) * f64::from(i) / 2000.0).to_radians()).collect();
    vec![vec![1.0; angle.len()], angle.iter().map(|t| t.cos()).collect(), angle]
}

#[test]
fn unbalance_and_spring_inflate_as_the_errata_say() {
    for (a, b, published) in [(-10.0, 90.0, 14.0), (-5.0, 85.0, 17.0), (0.0, 80.0, 22.0), (10.0, 70.0, 39.0)]
    {
        let x = columns(a, b);
        let y = vec![0.0; x[0].len()];
        let fit = LinearFit::new(&x, &y, None).expect("three independent columns");
        assert!((fit.worst_inflation() - published).abs() < 0.6, "{a}..{b}: {}", fit.worst_inflation());
    }
}

#[test]
fn straight_line_by_hand() {
    // y = 1 + 2x with residuals +1, -2, +1: b unchanged, s² = 6/1, Sxx = 2.
    let x = vec![vec![1.0; 3], vec![-1.0, 0.0, 1.0]];
    let fit = LinearFit::new(&x, &[0.0, -1.0, 4.0], None).expect("a line through three points");
    assert!((fit.coefficients[0] - 1.0).abs() < 1e-14 && (fit.coefficients[1] - 2.0).abs() < 1e-14);
    assert!((fit.u(1) - 3.0_f64.sqrt()).abs() < 1e-13);
    assert!((fit.u_at(&[1.0, 1.0]) - 5.0_f64.sqrt()).abs() < 1e-13);
    assert_eq!(fit.dof, 1);
}

#[test]
fn a_column_that_repeats_another_is_named() {
    let x = vec![vec![1.0; 4], vec![1.0, 2.0, 3.0, 4.0], vec![2.0, 4.0, 6.0, 8.0]];
    let none = LinearFit::new(&x, &[0.0; 4], None);
    assert_eq!(none, Err(FitError::Dependent { column: 2 }));
}

#[test]
fn wrong_shapes_and_numbers_are_errors() {
    let x = vec![vec![1.0; 3]];
    assert_eq!(LinearFit::new(&x, &[0.0; 4], None), Err(FitError::Length { expected: 4, found: 3 }));
    assert_eq!(LinearFit::new(&x[..], &[0.0, f64::NAN, 0.0], None), Err(FitError::NotFinite),);
    let short = vec![vec![1.0], vec![2.0]];
    assert_eq!(
        LinearFit::new(&short, &[0.0], None),
        Err(FitError::TooFew { observations: 1, coefficients: 2 })
    );
}

proptest! {
    /// An exact model comes back whatever its scales are.
    #[test]
    fn exact_models_are_recovered(a in -1e3..1e3_f64, b in -1e-3..1e-3_f64, s in 1e-4..1e4_f64) {
        let t: Vec<f64> = (0..50).map(|i| f64::from(i) * s).collect();
        let y: Vec<f64> = t.iter().map(|t| a + b * t).collect();
        let w: Vec<f64> = (0..50).map(|i| 1.0 + f64::from(i % 3)).collect();
        let fit = LinearFit::new(&[vec![1.0; 50], t], &y, Some(&w)).expect("two independent columns");
        let size = a.abs().max((b * s * 50.0).abs()).max(1e-12);
        prop_assert!((fit.coefficients[0] - a).abs() <= 1e-10 * size);
        prop_assert!((fit.coefficients[1] - b).abs() * s <= 1e-10 * size);
    }
}
