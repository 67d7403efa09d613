//! What the axis carries beside friction near a pose: cogging, unbalance and spring over angle.

use std::f64::consts::TAU;

use super::goodness::Goodness;
use super::least_squares::LinearFit;

/// Harmonics of the cogging order in the model.
const HARMONICS: usize = 3;
/// Polynomial coefficients (constant, slope, curvature): a cosine and a line over a few degrees need no more.
const POLYNOMIAL: usize = 3;
/// Columns of the angle part.
const COLUMNS: usize = POLYNOMIAL + 2 * HARMONICS;
/// Columns of the friction part.
const FRICTION: usize = 2;
/// Bins over the stroke in which the directions are compared.
const BINS: usize = 40;

/// Half the sum of the torques of a slow stroke back and forth, as a smooth function of angle: the part of
/// F̂ = T_m − J·α that does not change sign with direction, in N·m.
///
/// Model: quadratic in angle, plus harmonics 1…3 of the cogging order, plus a friction term for each direction.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadMap {
    centre_rad: f64,
    reach_rad: f64,
    order_per_rev: f64,
    fit: LinearFit,
    /// How well the model describes what does not change sign with direction, by the scatter of what does.
    pub goodness: Goodness,
    /// Variance of a sample, by that scatter.
    variance: f64,
    /// Rms of what the model leaves of the half sum, binned over angle, beyond what noise alone leaves; N·m.
    pub misfit_nm: f64,
}

impl LoadMap {
    /// Fits the map to samples of a stroke: angle, velocity (its sign is the direction), effort.
    ///
    /// `order_per_rev` is the expected number of cogging periods in a turn. `None` if the samples do not cover both
    /// directions and at least one period, or cannot tell the columns apart.
    pub fn new(
        position_rad: &[f64],
        velocity_rad_per_s: &[f64],
        effort_nm: &[f64],
        order_per_rev: f64,
    ) -> Option<Self> {
        let low = position_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let high = position_rad.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let reach_rad = (high - low) / 2.0;
        if !(order_per_rev > 0.0 && 2.0 * reach_rad >= TAU / order_per_rev) {
            return None;
        }
        let centre_rad = (high + low) / 2.0;
        let direction: Vec<f64> = velocity_rad_per_s.iter().map(|v| v.signum()).collect();
        let rows: Vec<[f64; COLUMNS]> =
            position_rad.iter().map(|&p| row(p - centre_rad, reach_rad, order_per_rev, p)).collect();
        let mut columns: Vec<Vec<f64>> = (0..COLUMNS).map(|k| rows.iter().map(|r| r[k]).collect()).collect();
        columns.push(direction.clone());
        // Viscous part and slow change of friction along the stroke.
        columns.push(direction.iter().zip(&rows).map(|(d, r)| d * r[1]).collect());
        let fit = LinearFit::new(&columns, effort_nm, None).ok()?;
        let bins = bins(position_rad, &direction, &fit.residuals, low, reach_rad);
        let misfit_nm = misfit(&bins, fit.residual_variance);
        let power = effort_nm.iter().map(|torque| torque * torque).sum::<f64>() / effort_nm.len() as f64;
        let (goodness, variance) = goodness(&bins, &fit, power);
        Some(Self { centre_rad, reach_rad, order_per_rev, fit, goodness, variance, misfit_nm })
    }

    /// The load torque at an angle inside the stroke, N·m; outside, the polynomial is held at the stroke's end.
    pub fn at(&self, position_rad: f64) -> f64 {
        self.dot(&self.row(position_rad))
    }

    /// The cogging part alone, N·m; periodic, so it holds at every angle of the axis.
    pub fn cogging_at(&self, position_rad: f64) -> f64 {
        let mut row = self.row(position_rad);
        row[..POLYNOMIAL].fill(0.0);
        self.dot(&row)
    }

    /// Amplitude of the largest cogging harmonic, N·m.
    pub fn cogging_amplitude_nm(&self) -> f64 {
        let b = &self.fit.coefficients;
        (0..HARMONICS).map(|k| b[POLYNOMIAL + 2 * k].hypot(b[POLYNOMIAL + 2 * k + 1])).fold(0.0, f64::max)
    }

    /// Standard uncertainty of the map at an angle: noise of the fit and misfit, N·m.
    pub fn u_at(&self, position_rad: f64) -> f64 {
        let mut row = self.row(position_rad).to_vec();
        row.extend([0.0, 0.0]);
        let noise = self.fit.u_at(&row) * (self.variance / self.fit.residual_variance).sqrt();
        (noise * self.goodness.widening()).hypot(self.misfit_nm)
    }

    /// Lowest and highest angle that the stroke covered.
    pub fn span_rad(&self) -> [f64; 2] {
        [self.centre_rad - self.reach_rad, self.centre_rad + self.reach_rad]
    }

    fn row(&self, position_rad: f64) -> [f64; COLUMNS] {
        let off = (position_rad - self.centre_rad).clamp(-self.reach_rad, self.reach_rad);
        row(off, self.reach_rad, self.order_per_rev, position_rad)
    }

    fn dot(&self, row: &[f64; COLUMNS]) -> f64 {
        row.iter().zip(self.fit.coefficients.iter()).map(|(x, b)| x * b).sum()
    }
}

fn row(off_rad: f64, reach_rad: f64, order_per_rev: f64, position_rad: f64) -> [f64; COLUMNS] {
    let mut row = [0.0; COLUMNS];
    let u = off_rad / reach_rad;
    row[0] = 1.0;
    row[1] = u;
    row[2] = u * u;
    for k in 0..HARMONICS {
        let (sin, cos) = ((k + 1) as f64 * order_per_rev * position_rad).sin_cos();
        row[POLYNOMIAL + 2 * k] = cos;
        row[POLYNOMIAL + 2 * k + 1] = sin;
    }
    row
}

/// Residuals at one angle: means of both directions.
struct Bin {
    /// Half the sum of both.
    half_sum_nm: f64,
    /// Half their difference: friction that the model lacks, and noise as large as that of the half sum.
    half_difference_nm: f64,
    /// Variance of either over that of a sample.
    share: f64,
}

fn bins(
    position_rad: &[f64],
    direction: &[f64],
    residuals: &[f64],
    low_rad: f64,
    reach_rad: f64,
) -> Vec<Bin> {
    let mut sums = [[0.0; 2]; BINS];
    let mut counts = [[0.0; 2]; BINS];
    for ((p, d), r) in position_rad.iter().zip(direction).zip(residuals) {
        let bin = (((p - low_rad) / (2.0 * reach_rad) * BINS as f64) as usize).min(BINS - 1);
        let side = usize::from(*d < 0.0);
        sums[bin][side] += r;
        counts[bin][side] += 1.0;
    }
    let both = sums.iter().zip(&counts).filter(|(_, c)| c[0] > 0.0 && c[1] > 0.0);
    both.map(|(sum, count)| {
        let [there, back] = [sum[0] / count[0], sum[1] / count[1]];
        Bin {
            half_sum_nm: (there + back) / 2.0,
            half_difference_nm: (there - back) / 2.0,
            share: (1.0 / count[0] + 1.0 / count[1]) / 4.0,
        }
    })
    .collect()
}

/// Excess of the binned half-sum residual over what white noise of the same spread leaves in a bin.
fn misfit(bins: &[Bin], variance: f64) -> f64 {
    if bins.is_empty() {
        return 0.0;
    }
    let excess: f64 = bins.iter().map(|bin| bin.half_sum_nm.powi(2) - variance * bin.share).sum();
    (excess / bins.len() as f64).max(0.0).sqrt()
}

/// The half sums against the scatter that the half differences state, and the variance of a sample by these: noise that lasts
/// from sample to sample is in both. Where too few bins have both directions, and where nothing scatters, only the residuals are
/// left. `power_nm2` is the mean square of what was observed.
fn goodness(bins: &[Bin], fit: &LinearFit, power_nm2: f64) -> (Goodness, f64) {
    let mean_square = |of: fn(&Bin) -> f64, columns: usize| -> Option<(f64, usize)> {
        let dof = bins.len().checked_sub(columns).filter(|dof| *dof > 0)?;
        Some((bins.iter().map(|bin| of(bin).powi(2) / bin.share).sum::<f64>() / dof as f64, dof))
    };
    let left = mean_square(|bin| bin.half_sum_nm, COLUMNS);
    let scatter = mean_square(|bin| bin.half_difference_nm, FRICTION);
    match left.zip(scatter) {
        Some(((left, dof), (variance, scatter_dof))) if variance > 0.0 => {
            let rms =
                (bins.iter().map(|bin| bin.half_sum_nm.powi(2)).sum::<f64>() / bins.len() as f64).sqrt();
            let stated = Goodness::of_known(left / variance, dof).stated_with(scatter_dof as f64);
            (stated.with_share(rms / power_nm2.sqrt()), variance)
        }
        _ => (Goodness::by_scatter(1.0, fit.dof), fit.residual_variance),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_noise::gaussian;

    fn load(p: f64) -> f64 {
        5.0 * (108.0 * p + 0.4).sin() - 14.0 * p.cos() + 20.0 * (p - 0.7)
    }

    /// A stroke of ±`reach` about 60 deg and back, with friction of 36 N·m against the motion.
    fn stroke(reach: f64, load: impl Fn(f64) -> f64) -> [Vec<f64>; 3] {
        let count = 400;
        let centre = 60.0_f64.to_radians();
        let along = |k: i32| centre + reach * (2.0 * f64::from(k) / f64::from(count) - 1.0);
        let there = (0..=count).map(|k| (along(k), 0.0175));
        let back = (0..=count).rev().map(|k| (along(k), -0.0175));
        let all: Vec<(f64, f64)> = there.chain(back).collect();
        let effort = all.iter().map(|(p, v): &(f64, f64)| load(*p) + 36.0 * v.signum()).collect();
        let (position, velocity) = all.into_iter().unzip();
        [position, velocity, effort]
    }

    #[test]
    fn cogging_unbalance_and_spring_come_out_of_the_half_sum() {
        let [position, velocity, effort] = stroke(0.116, load);
        let map = LoadMap::new(&position, &velocity, &effort, 108.0).expect("four periods");
        for off in [-0.1, -0.03, 0.0, 0.05] {
            let angle = 60.0_f64.to_radians() + off;
            assert!((map.at(angle) - load(angle)).abs() < 0.01, "{}", map.at(angle) - load(angle));
        }
        assert!((map.cogging_amplitude_nm() - 5.0).abs() < 0.01);
        // Periodic, so it holds at another pose too.
        let elsewhere = 20.0_f64.to_radians();
        assert!((map.cogging_at(elsewhere) - 5.0 * (108.0 * elsewhere + 0.4).sin()).abs() < 0.02);
    }

    #[test]
    fn cogging_of_another_order_shows_as_misfit_and_in_u() {
        let [position, velocity, effort] = stroke(0.116, |p| 5.0 * (77.0 * p).sin());
        let map = LoadMap::new(&position, &velocity, &effort, 108.0).expect("four periods");
        assert!(map.misfit_nm > 1.0, "{}", map.misfit_nm);
        assert!(map.u_at(60.0_f64.to_radians()) >= map.misfit_nm);
    }

    /// The stroke with noise of 0.5 N·m in every sample.
    fn noisy(seed: u64, load: impl Fn(f64) -> f64) -> LoadMap {
        let [position, velocity, mut effort] = stroke(0.116, load);
        let mut normal = gaussian(seed);
        effort.iter_mut().for_each(|torque| *torque += 0.5 * normal());
        LoadMap::new(&position, &velocity, &effort, 108.0).expect("four periods")
    }

    #[test]
    fn a_load_of_the_model_leaves_no_more_than_what_changes_with_direction() {
        let maps: Vec<LoadMap> = (0..100).map(|seed| noisy(seed, load)).collect();
        let ratio = |map: &LoadMap| map.goodness.ratio().expect("stated by the half differences");
        let mean = maps.iter().map(ratio).sum::<f64>() / maps.len() as f64;
        // That of F with 31 and 38 degrees of freedom.
        assert!((mean - 38.0 / 36.0).abs() < 0.1, "{mean}");
        let flagged = maps.iter().filter(|map| map.goodness.flag().is_some()).count();
        // Chance exceeds what is flagged in 2.5 % of cases: the scatter that states the uncertainty is an estimate itself.
        assert!(flagged <= 8, "{flagged} of 100");
    }

    #[test]
    fn a_load_that_the_model_lacks_is_flagged_and_widens_u_and_one_that_outweighs_it_is_refused() {
        let at = 60.0_f64.to_radians();
        let [plain, ripple, other] =
            [0.0, 0.5, 15.0].map(|extra| noisy(1, move |p| load(p) + extra * (77.0 * p).sin()));
        assert!(ripple.goodness.flag().is_some_and(|flag| flag.contains("u widened")), "{ripple:?}");
        assert!(ripple.u_at(at).powi(2) - ripple.misfit_nm.powi(2) > 2.0 * plain.u_at(at).powi(2));
        assert!(ripple.goodness.check().is_ok() && plain.goodness.check().is_ok());
        assert!(other.goodness.check().is_err(), "{:?}", other.goodness);
    }

    #[test]
    fn one_direction_or_less_than_a_period_gives_no_map() {
        let [position, velocity, effort] = stroke(0.116, load);
        let half = position.len() / 2;
        assert!(LoadMap::new(&position[..half], &velocity[..half], &effort[..half], 108.0).is_none());
        let [position, velocity, effort] = stroke(0.01, load);
        assert!(LoadMap::new(&position, &velocity, &effort, 108.0).is_none());
    }
}
