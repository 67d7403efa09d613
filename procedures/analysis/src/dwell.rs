//! Dwell law: breakaway torque over the logarithm of the time at rest.

use super::goodness::Goodness;
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
    /// Standard uncertainty of the slope from the scatter between repeats (pure error), widened by `goodness`, N·m.
    pub slope_u_nm: f64,
    /// Degrees of freedom of that uncertainty.
    pub dof: f64,
    /// How well the law describes the means of the groups, by the scatter between repeats.
    pub goodness: Goodness,
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
    /// Means that lie further from the line than their repeats explain widen the uncertainty: a contact need not follow a logarithm.
    /// `misfit_nm` says how far it is off, and `goodness` whether it is a law at all.
    /// `None` without repeats, or where the times do not spread over three groups of one direction.
    pub fn new(groups: &[Repeats], tau_s: f64) -> Option<Self> {
        let groups: Vec<&Repeats> = groups.iter().filter(|g| !g.torque_nm.is_empty()).collect();
        let forward = groups.iter().filter(|g| g.direction_ratio > 0.0).count();
        if forward.max(groups.len() - forward) < 3 {
            return None;
        }
        let both = forward > 0 && forward < groups.len();
        let abscissa = |t: &f64| (t / tau_s).ln_1p();
        let x: Vec<f64> = groups.iter().flat_map(|g| g.rest_s.iter().map(abscissa)).collect();
        let y: Vec<f64> = groups.iter().flat_map(|g| g.torque_nm.iter().copied()).collect();
        let spread = squares_about_mean(&x);
        let mut columns = vec![vec![1.0; x.len()], x];
        if both {
            columns.push(groups.iter().flat_map(|g| g.rest_s.iter().map(|_| g.direction_ratio)).collect());
        }
        let fit = LinearFit::new(&columns, &y, None).ok()?;
        let off_nm: Vec<f64> = groups
            .iter()
            .map(|g| {
                let at = mean(&g.rest_s.iter().map(abscissa).collect::<Vec<_>>());
                mean(&g.torque_nm) - fit.at(&[1.0, at, g.direction_ratio][..columns.len()])
            })
            .collect();
        let left = groups.iter().zip(&off_nm).map(|(g, off)| g.torque_nm.len() as f64 * off * off).sum();
        let growth = fit.coefficients[1].powi(2) * spread;
        let found = Scatter::of(&groups)?;
        let goodness = found.goodness(left, groups.len().saturating_sub(columns.len()), growth)?;
        Some(Self {
            start_nm: fit.coefficients[0],
            slope_nm: fit.coefficients[1],
            slope_u_nm: (fit.unscaled_covariance[(1, 1)] * found.weight()).sqrt() * goodness.widening(),
            dof: goodness.dof(),
            goodness,
            misfit_nm: off_nm.iter().fold(0.0, |most, off| most.max(off.abs())),
            repeatability_nm: found.variance.sqrt(),
            tau_s,
        })
    }

    /// The law at a time at rest, N·m.
    pub fn at(&self, t_s: f64) -> f64 {
        self.start_nm + self.slope_nm * (t_s / self.tau_s).ln_1p()
    }
}

/// Scatter between repeats at one dwell.
struct Scatter {
    variance: f64,
    dof: usize,
}

impl Scatter {
    /// `None` without repeats.
    fn of(groups: &[&Repeats]) -> Option<Self> {
        let squares: f64 = groups.iter().map(|g| squares_about_mean(&g.torque_nm)).sum();
        let dof = groups.iter().map(|g| g.torque_nm.len() - 1).sum();
        (dof > 0).then(|| Self { variance: squares / dof as f64, dof })
    }

    /// Variance in whose units residuals are counted; 1 where all repeats are equal.
    fn weight(&self) -> f64 {
        if self.variance > 0.0 { self.variance } else { 1.0 }
    }

    /// What `left`, the squares that the law leaves of the means, says of it beside `growth`, those of the growth with the dwell.
    fn goodness(&self, left: f64, dof: usize, growth: f64) -> Option<Goodness> {
        let reduced = (dof > 0).then(|| left / dof as f64 / self.weight())?;
        if self.variance <= 0.0 {
            return Some(Goodness::by_scatter(reduced, dof));
        }
        let stated = Goodness::of_known(reduced, dof).stated_with(self.dof as f64);
        Some(stated.with_share((left / growth).sqrt()))
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
    use crate::synthetic_noise::gaussian;

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
    fn a_contact_that_follows_the_law_is_not_flagged_and_keeps_the_u_of_its_repeats() {
        let mut ratios = Vec::new();
        for seed in 0..200 {
            let mut normal = gaussian(seed);
            let mut scattered = groups(0.0);
            let torques = scattered.iter_mut().flat_map(|g| g.torque_nm.iter_mut());
            torques.for_each(|torque| *torque += 0.5 * normal());
            let law = DwellLaw::new(&scattered, 1.0).expect("five dwells, two repeats");
            assert!(law.goodness.check().is_ok(), "{law:?}");
            ratios.push(law.goodness.ratio().expect("the repeats state it"));
        }
        // That of F with 7 and 10 degrees of freedom.
        let mean = mean(&ratios);
        assert!((mean - 10.0 / 8.0).abs() < 0.15, "{mean}");
        let law = DwellLaw::new(&groups(0.5), 1.0).expect("five dwells, two repeats");
        assert_eq!((law.goodness.flag(), law.dof), (None, 10.0));
    }

    #[test]
    fn a_contact_that_follows_another_law_has_a_wider_u_that_says_so_or_none() {
        // A power of the time at rest bends upwards over its logarithm.
        let bent = |bend_nm: f64| {
            let mut groups = groups(0.5);
            for group in &mut groups {
                let off_nm = bend_nm * group.rest_s[0].sqrt();
                group.torque_nm.iter_mut().for_each(|torque| *torque += off_nm);
            }
            DwellLaw::new(&groups, 1.0).expect("five dwells, two repeats")
        };
        let [straight, bent, another] = [0.0, 2.0, 10.0].map(bent);
        assert!(bent.goodness.flag().is_some_and(|flag| flag.contains("u widened")), "{bent:?}");
        assert!(bent.slope_u_nm > 1.5 * straight.slope_u_nm && bent.dof == 7.0, "{bent:?} {straight:?}");
        assert!(bent.goodness.check().is_ok() && another.goodness.check().is_err(), "{bent:?} {another:?}");
    }

    #[test]
    fn repeats_that_are_all_equal_leave_the_distance_to_the_line_as_scatter() {
        let mut bent = groups(0.0);
        bent[0].torque_nm.iter_mut().for_each(|torque| *torque += 1.0);
        let law = DwellLaw::new(&bent, 1.0).expect("five dwells, two repeats");
        assert!(law.goodness.ratio().is_none() && law.goodness.flag().is_some(), "{law:?}");
        assert!(law.slope_u_nm > 0.01, "{law:?}");
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
