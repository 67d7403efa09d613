//! Breakaway torque: the largest effort from the onset of displacement until the axis slides.

use super::least_squares::LinearFit;

/// A stretch of displacement over which the maximum is taken, in units of z_ss = T_S/σ0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where the maximum is looked for.
    pub judged: [f64; 2],
    /// What the smoothing polynomial rests on.
    pub fitted: [f64; 2],
}

/// A ramp from rest, from the onset of displacement on. Under a slow ramp the torque at z_ss is only 0.63 T_S, at
/// 3 z_ss 0.95 T_S. Under a fast one the bristles' damping adds to it, and the maximum lies as early as 1.6 z_ss.
/// Beyond 8 z_ss the axis slides (director.md §8).
pub const FROM_ONSET: Stretch = Stretch { judged: [0.5, 8.0], fitted: [0.3, 9.0] };
/// An axis that slides off when it is let go: before 3 z_ss its bristles are not bent yet and hold it less.
pub const SLIDING: Stretch = Stretch { judged: [3.0, 8.0], fitted: [2.5, 9.0] };
/// Degree of the polynomial: e^(−x/z_ss), the slowest part of the approach, is followed to 10⁻⁴ of T_S.
const DEGREE: usize = 10;
/// Displacement, in the same units, up to which rest is counted: the contact has given way.
const GIVEN_WAY: f64 = 3.0;
/// Fewest blocks from there to the end of the stretch.
const FEWEST: usize = 16;
/// Points at which the polynomial is asked for its maximum.
const GRID: usize = 1000;

/// Why there is no breakaway torque.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoBreakaway {
    /// The ramp ended before the stretch was passed.
    #[error("displacement reached {reached_ratio:.1} z_ss, {needed_ratio:.0} z_ss needed")]
    TooShort {
        /// Largest displacement over z_ss.
        reached_ratio: f64,
        /// What is needed.
        needed_ratio: f64,
    },
    /// The stretch went by within too few samples.
    #[error("only {blocks} blocks between 3 and 8 z_ss: the ramp is too fast for the log rate")]
    TooFast {
        /// Blocks found.
        blocks: usize,
    },
}

/// A breakaway torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// Largest smoothed effort over the stretch, N·m.
    pub torque_nm: f64,
    /// Standard uncertainty of `torque_nm` from noise (residuals of the polynomial), N·m.
    pub u_nm: f64,
    /// Degrees of freedom of that.
    pub dof: usize,
    /// Displacement where it lies, rad.
    pub at_rad: f64,
    /// Change of the torque for a relative change of z_ss: ∂T/∂ln z_ss, N·m.
    pub per_ln_z_ss_nm: f64,
    /// Index of the first block past 3 z_ss, where the contact has given way: the dwell is counted to it.
    pub given_way: usize,
}

/// The breakaway torque of one ramp: max F̂ over a stretch of displacement (estimators.md §1.5).
///
/// `x` is the displacement in the ramp's direction from its start (rad), `effort_nm` the effort in that direction
/// with the load taken off. White noise would lift the maximum of raw samples by several standard deviations, so
/// F̂ is first smoothed over displacement by one least-squares polynomial of degree 10 (no phase, no
/// shift), whose maximum is taken; its u is that of the polynomial where the maximum lies.
///
/// # Errors
/// See [`NoBreakaway`].
pub fn peak(x: &[f64], effort_nm: &[f64], z_ss_rad: f64, stretch: Stretch) -> Result<Peak, NoBreakaway> {
    let too_fast = |blocks| NoBreakaway::TooFast { blocks };
    let reached_ratio = x.iter().copied().fold(0.0, f64::max) / z_ss_rad;
    if reached_ratio < stretch.judged[1] {
        return Err(NoBreakaway::TooShort { reached_ratio, needed_ratio: stretch.judged[1] });
    }
    let first = |ratio: f64| x.iter().position(|&x| x >= ratio * z_ss_rad).unwrap_or(x.len());
    // The first pass counts: from the last time below the lower end on, up to the first time past the upper end.
    let [from, to] = stretch.fitted.map(first);
    let given_way = first(GIVEN_WAY);
    let inside = first(stretch.judged[1]).saturating_sub(given_way);
    if inside < FEWEST || given_way < from {
        return Err(too_fast(inside));
    }
    let scale = Span { low: stretch.fitted[0] * z_ss_rad, high: x[to - 1] };
    let columns: Vec<Vec<f64>> =
        (0..=DEGREE).map(|k| x[from..to].iter().map(|&x| scale.chebyshev(x)[k]).collect()).collect();
    let fit = LinearFit::new(&columns, &effort_nm[from..to], None).map_err(|_| too_fast(inside))?;
    let largest = |z_ss: f64| maximum(&fit, &scale, stretch.judged.map(|s| (s * z_ss).min(scale.high)));
    let (at_rad, torque_nm) = largest(z_ss_rad);
    let per_ln_z_ss_nm = (largest(1.01 * z_ss_rad).1 - largest(0.99 * z_ss_rad).1) / 0.02;
    let u_nm = fit.u_at(&scale.chebyshev(at_rad));
    Ok(Peak { torque_nm, u_nm, dof: fit.dof, at_rad, per_ln_z_ss_nm, given_way })
}

/// A stretch of displacement mapped onto −1…1.
struct Span {
    low: f64,
    high: f64,
}

impl Span {
    /// Chebyshev polynomials of degree 0…10 there.
    fn chebyshev(&self, x: f64) -> [f64; DEGREE + 1] {
        let u = (2.0 * x - self.low - self.high) / (self.high - self.low);
        let mut t = [1.0; DEGREE + 1];
        t[1] = u;
        for k in 2..=DEGREE {
            t[k] = 2.0 * u * t[k - 1] - t[k - 2];
        }
        t
    }
}

/// Place and value of the largest value of the fit between two displacements; the first of equals.
fn maximum(fit: &LinearFit, scale: &Span, [low, high]: [f64; 2]) -> (f64, f64) {
    let mut best = (low, f64::NEG_INFINITY);
    for k in 0..=GRID {
        let x = low + (high - low) * k as f64 / GRID as f64;
        let value = fit.at(&scale.chebyshev(x));
        if value > best.1 {
            best = (x, value);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(top: f64) -> (Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.025).collect();
        let f = x.iter().map(|x| top * (1.0 - (-x).exp()) * (1.0 - 0.002 * x)).collect();
        (x, f)
    }

    #[test]
    fn the_smoothed_maximum_of_a_clean_curve_is_its_maximum() {
        let (x, f) = curve(210.0);
        let truth =
            x.iter().zip(&f).filter(|(x, _)| (0.5..=8.0).contains(*x)).map(|(_, f)| *f).fold(0.0, f64::max);
        let peak = peak(&x, &f, 1.0, FROM_ONSET).expect("whole stretch there");
        assert!((peak.torque_nm - truth).abs() < 2e-4 * truth, "{peak:?} against {truth}");
        assert!((x[peak.given_way] - 3.0).abs() < 0.03);
    }

    #[test]
    fn a_ramp_that_stops_early_or_rushes_through_is_refused() {
        let (x, f) = curve(210.0);
        let short = peak(&x, &f, 2.0, FROM_ONSET).expect_err("ends at 5 z_ss").to_string();
        assert_eq!(short, "displacement reached 5.0 z_ss, 8 z_ss needed");
        let every = |v: &[f64]| -> Vec<f64> { v.iter().step_by(20).copied().collect() };
        assert!(matches!(peak(&every(&x), &every(&f), 1.0, FROM_ONSET), Err(NoBreakaway::TooFast { .. })));
    }

    #[test]
    fn a_curve_that_falls_at_the_stretch_begin_says_how_much_z_ss_matters() {
        let (x, _) = curve(1.0);
        let f: Vec<f64> = x.iter().map(|x| 40.0 - 1.3 * x).collect();
        let peak = peak(&x, &f, 1.0, FROM_ONSET).expect("whole stretch there");
        assert!((peak.torque_nm - 39.35).abs() < 1e-6);
        assert!((peak.per_ln_z_ss_nm + 0.65).abs() < 1e-3, "{peak:?}");
    }

    /// At 3 A/s the damping of elevation's bristles puts the maximum near 1.6 z_ss (director.md §8): from 3 z_ss on
    /// it would read 7 % low.
    #[test]
    fn a_maximum_that_lies_early_is_found_there() {
        let x: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.025).collect();
        let f: Vec<f64> = x.iter().map(|x| 36.0 * (1.0 - (-2.0 * x).exp()) + 10.0 * x * (-x).exp()).collect();
        let truth = f.iter().copied().fold(0.0, f64::max);
        let peak = peak(&x, &f, 1.0, FROM_ONSET).expect("whole stretch there");
        assert!((1.2..2.5).contains(&peak.at_rad), "{peak:?}");
        assert!((peak.torque_nm - truth).abs() < 2e-4 * truth, "{peak:?} against {truth}");
    }
}
