//! Dwell law: breakaway torque over the logarithm of the time at rest.

use super::least_squares::LinearFit;

/// Repeats at one requested dwell in one direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Repeats {
    /// +1 or −1.
    pub direction_ratio: f64,
    /// Time at rest before each breakaway, s.
    pub rest_s: Vec<f64>,
    /// Breakaway torque of each, N·m.
    pub torque_nm: Vec<f64>,
}

/// T = T0 + slope·ln(1 + t/τ_d), fitted to repeats at several dwell times.
#[derive(Clone, Debug, PartialEq)]
pub struct DwellLaw {
    /// T0, N·m.
    pub start_nm: f64,
    /// Slope per unit of the logarithm, N·m.
    pub slope_nm: f64,
    /// Standard uncertainty of the slope from the scatter between repeats (pure error), N·m.
    pub slope_u_nm: f64,
    /// Degrees of freedom of that scatter.
    pub dof: f64,
    /// Largest distance of a dwell's mean from the line, N·m.
    pub misfit_nm: f64,
    /// Standard deviation between repeats at one dwell, N·m.
    pub repeatability_nm: f64,
    /// τ_d, s.
    pub tau_s: f64,
}

impl DwellLaw {
    /// Fits the law by least squares to groups of repeats, each at one requested dwell in one direction. Where both
    /// directions are there, half their difference is a coefficient of its own: it is no scatter.
    ///
    /// The uncertainty comes from the repeats, not from the distance of the means to the line: a contact need not
    /// follow a logarithm, and then the slope is still that of the best line; `misfit_nm` says how far it is off.
    /// `None` without repeats, or where the times do not spread over three groups of one direction.
    pub fn new(groups: &[Repeats], tau_s: f64) -> Option<Self> {
        let forward = groups.iter().filter(|g| g.direction_ratio > 0.0).count();
        if forward.max(groups.len() - forward) < 3 {
            return None;
        }
        let both = forward > 0 && forward < groups.len();
        let abscissa = |t: &f64| (t / tau_s).ln_1p();
        let x: Vec<f64> = groups.iter().flat_map(|g| g.rest_s.iter().map(abscissa)).collect();
        let y: Vec<f64> = groups.iter().flat_map(|g| g.torque_nm.iter().copied()).collect();
        let mut columns = vec![vec![1.0; x.len()], x];
        if both {
            columns.push(groups.iter().flat_map(|g| g.rest_s.iter().map(|_| g.direction_ratio)).collect());
        }
        let fit = LinearFit::new(&columns, &y, None).ok()?;
        let spread: f64 = groups.iter().map(|g| squares_about_mean(&g.torque_nm)).sum();
        let dof = groups.iter().map(|g| g.torque_nm.len().saturating_sub(1)).sum::<usize>();
        if dof == 0 {
            return None;
        }
        let variance = spread / dof as f64;
        let misfit_nm = groups
            .iter()
            .map(|g| {
                let at = g.rest_s.iter().map(abscissa).sum::<f64>() / g.rest_s.len() as f64;
                (mean(&g.torque_nm) - fit.at(&[1.0, at, g.direction_ratio][..columns.len()])).abs()
            })
            .fold(0.0, f64::max);
        Some(Self {
            start_nm: fit.coefficients[0],
            slope_nm: fit.coefficients[1],
            slope_u_nm: (fit.unscaled_covariance[(1, 1)] * variance).sqrt(),
            dof: dof as f64,
            misfit_nm,
            repeatability_nm: variance.sqrt(),
            tau_s,
        })
    }

    /// The law at a time at rest, N·m.
    pub fn at(&self, t_s: f64) -> f64 {
        self.start_nm + self.slope_nm * (t_s / self.tau_s).ln_1p()
    }
}

/// Arithmetic mean; NaN of nothing.
pub fn mean(v: &[f64]) -> f64 {
    v.iter().sum::<f64>() / v.len() as f64
}

/// Σ (v − mean)².
pub fn squares_about_mean(v: &[f64]) -> f64 {
    let centre = mean(v);
    v.iter().map(|v| (v - centre).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The law at five dwells in both directions, two repeats each, `offset` off it, and a lopsided contact.
    fn groups(offset: f64) -> Vec<Repeats> {
        let mut groups = Vec::new();
        for direction_ratio in [1.0, -1.0] {
            for t in [1.0_f64, 3.0, 10.0, 30.0, 100.0] {
                let law = 210.0 + 4.2 * t.ln_1p() + 3.0 * direction_ratio;
                groups.push(Repeats {
                    direction_ratio,
                    rest_s: vec![t; 2],
                    torque_nm: vec![law - offset, law + offset],
                });
            }
        }
        groups
    }

    #[test]
    fn the_law_of_director_section_8_comes_back_with_its_slope() {
        let law = DwellLaw::new(&groups(0.5), 1.0).expect("five dwells, two repeats");
        assert!((law.slope_nm - 4.2).abs() < 1e-9 && (law.start_nm - 210.0).abs() < 1e-9, "{law:?}");
        assert!((law.repeatability_nm - 0.5_f64.sqrt()).abs() < 1e-9, "{law:?}");
        assert!(law.misfit_nm < 1e-9 && law.slope_u_nm > 0.1, "{law:?}");
    }

    #[test]
    fn without_repeats_or_with_two_dwells_there_is_no_law() {
        let mut single = groups(0.0);
        for group in &mut single {
            group.rest_s.truncate(1);
            group.torque_nm.truncate(1);
        }
        assert_eq!(DwellLaw::new(&single, 1.0), None);
        assert_eq!(DwellLaw::new(&groups(1.0)[..2], 1.0), None);
    }
}
