//! Presliding: the bristle follows the displacement, whatever the time it takes.

use super::nonlinear::NonlinearFit;

/// Share of the largest effort up to which the exponential is fitted: above, the speed grows and the fall of
/// friction with speed and with the renewal of the contact (director.md §8) bends the curve.
const FITTED_SHARE_RATIO: f64 = 0.8;
/// Blocks over which the effort is averaged before its largest value and that share of it are looked for: extremes
/// of noise would shorten the stretch.
const SMOOTHED: usize = 15;
/// Fewest blocks on the curve.
const FEWEST: usize = 20;

/// Bristle deflection along a path `x` (any sequence of positions), exact for any step:
/// dz/dx = 1 − z·sgn(dx)/z_ss, so z = ±z_ss + (z − ±z_ss)·e^(−|Δx|/z_ss) over each step.
///
/// `z0` is the deflection at the first position; the result is as long as `x`.
pub fn bristle(x: &[f64], z_ss: f64, z0: f64) -> Vec<f64> {
    let mut z = z0;
    let mut last = x.first().copied().unwrap_or(0.0);
    x.iter()
        .map(|&now| {
            let step = now - last;
            let target = z_ss.copysign(step);
            z = target + (z - target) * (-step.abs() / z_ss).exp();
            last = now;
            z
        })
        .collect()
}

/// What the start of a torque ramp says of the contact.
#[derive(Clone, Debug, PartialEq)]
pub struct RampFit {
    /// Bristle stiffness σ0, N·m/rad.
    pub sigma0: f64,
    /// Standard uncertainty of σ0 from the noise alone.
    pub sigma0_u: f64,
    /// Torque T_∞ that the exponential tends to, N·m.
    pub plateau_nm: f64,
    /// Standard uncertainty of T_∞ from the noise alone.
    pub plateau_u_nm: f64,
    /// Bristle torque σ0·z at the start of the ramp, N·m.
    pub start_nm: f64,
    /// Damping σ1 + σ2 that goes with it, N·m·s/rad; badly determined, for slow ramps not at all.
    pub damping: f64,
    /// Standard deviation of the residual of one block, N·m.
    pub noise_nm: f64,
    /// Degrees of freedom of the fit.
    pub dof: usize,
}

impl RampFit {
    /// Fits T(x) = T_∞ − (T_∞ − F0)·e^(−σ0·x/T_∞) with the rate term c·ż, ż from the measured course:
    /// F̂ = σ0·z + c·ż (LuGre with slow speed: σ1·ż + σ2·ω ≈ (σ1 + σ2)·ż, since ż ≈ ω until the contact slides).
    ///
    /// `time_s`, `x` (displacement in the direction of the ramp, rad, from its start) and `effort_nm` (in that
    /// direction, load taken off) are block means; rows before the ramp, at rest, pin down F0. `None` if there are
    /// too few rows below 80 % of the largest effort or the fit does not converge to positive σ0 and T_∞.
    pub fn new(time_s: &[f64], x: &[f64], effort_nm: &[f64]) -> Option<Self> {
        let smooth = running_mean(effort_nm, SMOOTHED);
        let top = smooth.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let until = smooth.iter().position(|&f| f >= FITTED_SHARE_RATIO * top)?;
        if until < FEWEST || top <= 0.0 {
            return None;
        }
        let time = &time_s[..until];
        let x = &x[..until];
        let effort = &effort_nm[..until];
        let start = [top / first_e_fold(x, &smooth[..until], top)?, top, effort[0], 0.0];
        let step = (time[until - 1] - time[0]) / (until - 1) as f64;
        let scale = [start[0], top, top, start[0]];
        let residuals = |p: &[f64]| model(x, step, p).iter().zip(effort).map(|(m, f)| f - m).collect();
        let fit = NonlinearFit::new(residuals, &start, &scale)?;
        let [sigma0, plateau_nm, start_nm, damping] = fit.parameters[..] else { return None };
        let sound = sigma0 > 0.0 && plateau_nm > 0.0 && plateau_nm < 10.0 * top;
        sound.then(|| Self {
            sigma0,
            sigma0_u: fit.u(0),
            plateau_nm,
            plateau_u_nm: fit.u(1),
            start_nm,
            damping,
            noise_nm: fit.residual_variance.sqrt(),
            dof: fit.dof,
        })
    }

    /// Displacement z_ss = T_∞/σ0 over which the bristle bends, rad.
    pub fn z_ss_rad(&self) -> f64 {
        self.plateau_nm / self.sigma0
    }
}

/// Means over `width` (odd) neighbours, fewer at the ends.
fn running_mean(values: &[f64], width: usize) -> Vec<f64> {
    let half = width / 2;
    (0..values.len())
        .map(|i| {
            let around = &values[i.saturating_sub(half)..(i + half + 1).min(values.len())];
            around.iter().sum::<f64>() / around.len() as f64
        })
        .collect()
}

/// Displacement at which the effort first passes 63 % of the top: a start value for z_ss.
fn first_e_fold(x: &[f64], effort_nm: &[f64], top_nm: f64) -> Option<f64> {
    let at = effort_nm.iter().position(|&f| f >= 0.63 * top_nm)?;
    let z_ss = x[at] - x[0];
    (z_ss > 0.0).then_some(z_ss)
}

/// σ0·z + c·ż for parameters [σ0, T_∞, F0, c].
fn model(x: &[f64], step_s: f64, p: &[f64]) -> Vec<f64> {
    let [sigma0, plateau, start, damping] = [p[0], p[1], p[2], p[3]];
    if !(sigma0 > 0.0 && plateau > 0.0) {
        return vec![f64::NAN; x.len()];
    }
    let z = bristle(x, plateau / sigma0, start / sigma0);
    let last = z.len() - 1;
    (0..z.len())
        .map(|i| {
            let a = i.saturating_sub(1);
            let b = (i + 1).min(last);
            sigma0 * z[i] + damping * (z[b] - z[a]) / ((b - a) as f64 * step_s)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_bristle_never_leaves_its_range_and_ignores_how_finely_the_path_is_cut(
            turns in proptest::collection::vec(-3.0..3.0f64, 1..8), z_ss in 0.1..2.0f64,
        ) {
            let mut path = vec![0.0];
            path.extend(&turns);
            let fine: Vec<f64> = path.windows(2)
                .flat_map(|w| (0..50).map(move |k| w[0] + (w[1] - w[0]) * f64::from(k) / 50.0))
                .chain(path.last().copied())
                .collect();
            let coarse = bristle(&path, z_ss, 0.0);
            let finer = bristle(&fine, z_ss, 0.0);
            prop_assert!(coarse.iter().all(|z| z.abs() <= z_ss * (1.0 + 1e-12)));
            prop_assert!((coarse[path.len() - 1] - finer[fine.len() - 1]).abs() < 1e-9);
        }
    }

    #[test]
    fn a_quasi_static_exponential_gives_its_stiffness_back() {
        let time: Vec<f64> = (0..800).map(|k| f64::from(k) * 5e-3).collect();
        let z_ss: f64 = 210.0 / 90_000.0;
        // Displacement under a linear ramp of 60 N·m/s: x = −z_ss·ln(1 − T/T_S), at rest for the first 0.2 s.
        let torque: Vec<f64> = time.iter().map(|t| (60.0 * (t - 0.2)).clamp(0.0, 209.0)).collect();
        let x: Vec<f64> = torque.iter().map(|t| -z_ss * (1.0 - t / 210.0).ln()).collect();
        let fit = RampFit::new(&time, &x, &torque).expect("converges");
        assert!((fit.sigma0 / 90_000.0 - 1.0).abs() < 1e-6, "{fit:?}");
        assert!((fit.plateau_nm / 210.0 - 1.0).abs() < 1e-6, "{fit:?}");
        assert!(fit.damping.abs() < 1.0, "{fit:?}");
    }

    #[test]
    fn an_axis_that_never_gives_way_has_no_fit() {
        let time: Vec<f64> = (0..200).map(|k| f64::from(k) * 5e-3).collect();
        assert_eq!(RampFit::new(&time, &vec![0.0; 200], &time), None);
    }
}
