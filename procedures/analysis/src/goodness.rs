//! What the residuals of a fit say about its model: one rule for every fit.
//!
//! A fit knows the spread of what it was fitted to in one of two ways.
//!
//! *Stated*: every observation has a standard uncertainty, and χ² over its degrees of freedom is 1 on average where the model
//! describes the observations. Above 1 the model lacks something: it counts as scatter, so that standard uncertainties grow by
//! the root of χ²/dof. Below a probability of one in a thousand that is flagged; where the stated variance was itself estimated from
//! repeats, χ²/dof has the F distribution. Beyond [`HOPELESS_RATIO`], and beyond chance, the model does not
//! describe what was observed and there is no number, unless the residuals are a small share of it ([`HOPELESS_SHARE`]): where
//! noise is next to nothing any model misses it, and is good all the same.
//!
//! *By its own scatter*: no observation has an uncertainty. The residuals are all there is, the uncertainty follows from them,
//! nothing can tell whether the model is right, and a flag says so.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::frf::Line;

/// χ² over its degrees of freedom beyond which a model does not describe what was observed: residuals of 4.5 times the stated
/// uncertainties.
pub const HOPELESS_RATIO: f64 = 20.0;
/// Residuals over what was observed, rms, up to which a model describes it, however small the noise is.
pub const HOPELESS_SHARE: f64 = 0.1;
/// What is said of a value whose fit tells its uncertainty by residuals alone, whatever else the uncertainty contains.
pub const BY_SCATTER: &str = "u of the fit by its scatter alone";
/// Probability of so large a χ² below which chance does not explain it.
const LEAST_PROBABILITY: f64 = 1e-3;
/// Fewest degrees of freedom of the variance of an observation that are reckoned with: below, its mean has no end.
const LEAST_DOF: f64 = 2.5;

/// How well a model describes what it was fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goodness {
    /// χ² by the stated uncertainties over its degrees of freedom, 1 on average; `None`: none was stated.
    ratio: Option<f64>,
    /// Degrees of freedom of the residuals.
    dof: f64,
    /// Factor on the covariance that the weights give.
    variance_factor: f64,
    /// Degrees of freedom of the uncertainty where the stated ones stand.
    stated_dof: f64,
    /// Residuals over what was observed, rms; 1 where it is not known.
    share: f64,
}

/// A model that does not describe what was observed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the model does not describe the record: chi2/dof {ratio:.0}, at most {HOPELESS_RATIO:.0} is accepted \
     where the residual exceeds a tenth of the signal; another effect acts, or the record is not of the \
     assumed kind"
)]
pub struct Hopeless {
    /// χ² over its degrees of freedom.
    pub ratio: f64,
}

impl Goodness {
    /// Observations with known uncertainties: `reduced` is χ²/dof by them.
    pub fn of_known(reduced: f64, dof: usize) -> Self {
        Self::of_estimated(reduced, dof, f64::INFINITY)
    }

    /// Observations whose variances were estimated with `each_dof` degrees of freedom each.
    ///
    /// χ² by such variances is d/(d − 1) times as large on average for complex d and scatters more; weights from them leave
    /// d/(d − 2) of the variance that they claim.
    pub fn of_estimated(reduced: f64, dof: usize, each_dof: f64) -> Self {
        let d = each_dof.max(LEAST_DOF);
        let mean = if d.is_finite() { d / (d - 1.0) } else { 1.0 };
        let widening = if d.is_finite() { d / (d - 2.0) } else { 1.0 };
        let ratio = reduced / mean;
        Self {
            ratio: Some(ratio),
            dof: dof as f64 / widening,
            variance_factor: ratio.max(1.0) * widening,
            stated_dof: f64::INFINITY,
            share: 1.0,
        }
    }

    /// Lines of a response: exact ones (variance 0) have only their residuals.
    pub fn of_lines(lines: &[Line], reduced: f64, dof: usize) -> Self {
        if lines.iter().all(|l| l.variance <= 0.0) {
            return Self::by_scatter(reduced, dof);
        }
        let each = lines.len() as f64 / lines.iter().map(|l| 1.0 / l.dof.max(1e-3)).sum::<f64>();
        let variance: f64 = lines.iter().map(|l| l.variance).sum();
        let power: f64 = lines.iter().map(|l| l.value.norm_sqr()).sum();
        Self::of_estimated(reduced, dof, each).with_share((reduced * variance / power).sqrt())
    }

    /// Observations without uncertainties: `reduced` is the mean square of their residuals in the units of the weights.
    pub fn by_scatter(reduced: f64, dof: usize) -> Self {
        let dof = dof as f64;
        Self { ratio: None, dof, variance_factor: reduced, stated_dof: f64::INFINITY, share: 1.0 }
    }

    /// The same where the stated uncertainties were estimated with so many degrees of freedom together.
    #[must_use]
    pub fn stated_with(self, stated_dof: f64) -> Self {
        Self { stated_dof, ..self }
    }

    /// The same with the residuals over what was observed, rms.
    #[must_use]
    pub fn with_share(self, share: f64) -> Self {
        Self { share, ..self }
    }

    /// Factor on the covariance that the weights give.
    pub fn variance_factor(&self) -> f64 {
        self.variance_factor
    }

    /// Factor on the standard uncertainties that the weights give.
    pub fn widening(&self) -> f64 {
        self.variance_factor.sqrt()
    }

    /// Degrees of freedom of the uncertainties: those of the residuals where they rule, else those of what was stated.
    pub fn dof(&self) -> f64 {
        match self.ratio {
            Some(ratio) if ratio <= 1.0 => self.stated_dof,
            _ => self.dof,
        }
    }

    /// χ² by the stated uncertainties over its degrees of freedom; `None` where none was stated.
    pub fn ratio(&self) -> Option<f64> {
        self.ratio
    }

    /// Whether the residuals are larger than chance makes them.
    pub fn is_misfit(&self) -> bool {
        self.ratio.is_some_and(|ratio| {
            let probability = if self.stated_dof.is_finite() {
                FisherSnedecor::new(self.dof, self.stated_dof).map(|law| law.sf(ratio)).ok()
            } else {
                ChiSquared::new(self.dof).map(|law| law.sf(ratio * self.dof)).ok()
            };
            probability.is_none_or(|p| p < LEAST_PROBABILITY)
        })
    }

    /// # Errors
    /// [`Hopeless`] where the model does not describe what was observed.
    pub fn check(&self) -> Result<(), Hopeless> {
        match self.ratio {
            Some(ratio) if ratio.is_nan() => Err(Hopeless { ratio }),
            Some(ratio) if ratio > HOPELESS_RATIO && self.share > HOPELESS_SHARE && self.is_misfit() => {
                Err(Hopeless { ratio })
            }
            _ => Ok(()),
        }
    }

    /// What the report says of it; nothing where the observations are described within their uncertainty.
    pub fn flag(&self) -> Option<String> {
        match self.ratio {
            None => Some(BY_SCATTER.to_owned()),
            Some(ratio) if self.is_misfit() => {
                let times = ratio.sqrt();
                Some(format!("residuals {times:.1} times their uncertainty, chi2/dof {ratio:.1}: u widened"))
            }
            Some(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::C64;
    use crate::synthetic_noise::gaussian;

    /// 4000 seeds of a right model whose variance is known from six repeats: four flags are expected, twelve or more have a
    /// probability of 0.1 %. Taken for exact, such variances flag 221.
    #[test]
    fn a_variance_from_few_repeats_flags_no_more_right_models_than_a_known_one() {
        let mut noise = gaussian(1);
        let mut mean_square =
            |count: u32| (0..count).map(|_| noise().powi(2)).sum::<f64>() / f64::from(count);
        let count = (0..4000)
            .map(|_| mean_square(5) / mean_square(6))
            .filter(|&reduced| Goodness::of_known(reduced, 5).stated_with(6.0).is_misfit())
            .count();
        assert!((1..12).contains(&count), "{count} of 4000");
        // With two repeats chance explains residuals of five times their scatter; with fifty nothing does.
        assert!(Goodness::of_known(25.0, 5).stated_with(2.0).check().is_ok());
        assert!(Goodness::of_known(25.0, 5).stated_with(50.0).check().is_err());
    }

    #[test]
    fn scatter_within_what_is_stated_leaves_it_and_beyond_widens_and_says_so() {
        let within = Goodness::of_known(0.7, 20).stated_with(50.0);
        assert_eq!((within.variance_factor(), within.dof(), within.flag()), (1.0, 50.0, None));
        // By chance χ²/20 exceeds 2.27 once in a thousand.
        let by_chance = Goodness::of_known(2.2, 20);
        assert!(!by_chance.is_misfit() && (by_chance.widening() - 2.2_f64.sqrt()).abs() < 1e-12);
        let beyond = Goodness::of_known(2.3, 20);
        assert!(beyond.is_misfit() && beyond.dof() == 20.0 && beyond.check().is_ok());
        // The same for F with 20 and 50 degrees of freedom: between 2.83 (60) and 3.15 (40) by the tables.
        let is_beyond = |ratio: f64| Goodness::of_known(ratio, 20).stated_with(50.0).is_misfit();
        assert!(!is_beyond(2.83) && is_beyond(3.15));
        assert!(beyond.flag().is_some_and(|flag| flag.contains("chi2/dof 2.3")));
    }

    #[test]
    fn a_model_that_does_not_describe_what_was_observed_gives_no_number() {
        let found = Goodness::of_known(1825.0, 25).check().expect_err("nothing of it");
        assert!(found.to_string().contains("chi2/dof 1825"));
        assert!(Goodness::of_known(f64::NAN, 25).check().is_err());
        let small = Goodness::of_known(1825.0, 25).with_share(0.02);
        assert!(small.check().is_ok() && small.is_misfit(), "2 % off a record without noise is described");
        assert!(Goodness::by_scatter(1825.0, 25).check().is_ok(), "of scatter alone nobody can say that");
    }

    #[test]
    fn variances_from_few_repeats_widen_and_are_no_misfit_for_being_estimates() {
        // Six periods: five complex degrees of freedom, χ²/dof is 5/4 on average.
        let line = |k: u32| Line { variance: 1.0, dof: 5.0, ..Line::exact(f64::from(k), C64::new(1.0, 0.0)) };
        let lines: Vec<Line> = (1..30).map(line).collect();
        let usual = Goodness::of_lines(&lines, 1.25, 54);
        assert!((usual.variance_factor() - 5.0 / 3.0).abs() < 1e-12 && !usual.is_misfit());
        let exact: Vec<Line> = lines.iter().map(|l| Line { variance: 0.0, ..*l }).collect();
        let own = Goodness::of_lines(&exact, 4e-8, 54);
        assert!(own.ratio().is_none() && (own.widening() - 2e-4).abs() < 1e-15 && own.flag().is_some());
    }
}
