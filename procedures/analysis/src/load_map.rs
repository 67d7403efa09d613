//! What the axis carries beside friction near a pose: cogging, unbalance and spring over angle.

use std::f64::consts::TAU;

use super::least_squares::LinearFit;

/// Harmonics of the cogging order in the model.
const HARMONICS: usize = 3;
/// Polynomial coefficients (constant, slope, curvature): a cosine and a line over a few degrees need no more.
const POLYNOMIAL: usize = 3;
/// Columns of the angle part.
const COLUMNS: usize = POLYNOMIAL + 2 * HARMONICS;

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
        let misfit_nm = misfit(position_rad, &direction, &fit, low, reach_rad);
        Some(Self { centre_rad, reach_rad, order_per_rev, fit, misfit_nm })
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
        self.fit.u_at(&row).hypot(self.misfit_nm)
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

/// Excess of the binned half-sum residual over what white noise of the same spread leaves in a bin.
fn misfit(position_rad: &[f64], direction: &[f64], fit: &LinearFit, low_rad: f64, reach_rad: f64) -> f64 {
    const BINS: usize = 40;
    let mut sums = [[0.0; 2]; BINS];
    let mut counts = [[0.0; 2]; BINS];
    for ((p, d), r) in position_rad.iter().zip(direction).zip(&fit.residuals) {
        let bin = (((p - low_rad) / (2.0 * reach_rad) * BINS as f64) as usize).min(BINS - 1);
        let side = usize::from(*d < 0.0);
        sums[bin][side] += r;
        counts[bin][side] += 1.0;
    }
    let mut excess = 0.0;
    let mut used = 0.0;
    for (sum, count) in sums.iter().zip(&counts).filter(|(_, c)| c[0] > 0.0 && c[1] > 0.0) {
        let half_sum = (sum[0] / count[0] + sum[1] / count[1]) / 2.0;
        let noise = fit.residual_variance * (1.0 / count[0] + 1.0 / count[1]) / 4.0;
        excess += half_sum * half_sum - noise;
        used += 1.0;
    }
    if used > 0.0 { (excess / used).max(0.0).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn one_direction_or_less_than_a_period_gives_no_map() {
        let [position, velocity, effort] = stroke(0.116, load);
        let half = position.len() / 2;
        assert!(LoadMap::new(&position[..half], &velocity[..half], &effort[..half], 108.0).is_none());
        let [position, velocity, effort] = stroke(0.01, load);
        assert!(LoadMap::new(&position, &velocity, &effort, 108.0).is_none());
    }
}
