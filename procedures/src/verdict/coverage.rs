//! Coverage factor and tail probability from Student's t.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Probability below +k of a standard normal at k = 2 (report.md §3): U covers 95.45 % two-sided.
const COVERAGE: f64 = 0.97725;

/// Coverage factor k = t(0.97725, ν): 2.00 at ν = ∞ (`None`), 2.32 at 9, 2.87 at 4. Fewer than one degree of freedom
/// count as one (no verdict is given there anyhow).
pub fn coverage_factor(dof: Option<f64>) -> f64 {
    match student(dof) {
        Some(student) => student.inverse_cdf(COVERAGE),
        None => normal().inverse_cdf(COVERAGE),
    }
}

/// P(T > z) with ν degrees of freedom.
pub(super) fn upper_tail(z: f64, dof: Option<f64>) -> f64 {
    /// Far beyond every tail that a double holds; the distributions do not take infinities or their squares.
    const FAR: f64 = 1e100;
    if z.is_nan() || z.abs() > FAR {
        return f64::from(u8::from(z < 0.0));
    }
    match student(dof) {
        Some(student) => student.sf(z),
        None => normal().sf(z),
    }
}

/// `None` stands for infinitely many degrees of freedom.
fn student(dof: Option<f64>) -> Option<StudentsT> {
    /// From here on t and normal agree to 1e-6 in k, and the incomplete beta function loses digits.
    const NORMAL_FROM: f64 = 1e6;
    let dof =
        dof.map(|dof| if dof.is_nan() { 1.0 } else { dof.max(1.0) }).filter(|dof| *dof < NORMAL_FROM)?;
    StudentsT::new(0.0, 1.0, dof).ok()
}

fn normal() -> Normal {
    Normal::standard()
}
