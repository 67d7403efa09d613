//! Which of the drawn settings the values of a measurand depend on.

use analysis::family_wise::holm;
use analysis::rank::spearman;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Draws, Judged, in_set, standard_error};

/// Probability that a measurand is said to depend on any setting, though it depends on none.
const LEVEL: f64 = 0.05;
/// Fewest units with a value from which correlations are told.
const LEAST_UNITS: usize = 10;

/// How the values of a measurand go with a setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Key of the setting.
    pub setting: String,
    /// Rank correlation (Spearman) of values and setting, -1 to 1.
    pub coefficient: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// Two-sided tail of the coefficient if there were no dependence, adjusted over all settings (Holm).
    pub p_family: f64,
}

/// The settings that values depend on beyond chance, the strongest first, and how many were looked at.
pub(super) fn of_values(judged: &[Judged<'_>], draws: Draws) -> (Vec<Sensitivity>, usize) {
    let with_value: Vec<Judged<'_>> = judged.iter().copied().filter(|one| one.value_si().is_some()).collect();
    let Some(first) = with_value.first().filter(|_| with_value.len() >= LEAST_UNITS) else {
        return (Vec::new(), 0);
    };
    let keys = first.unit.settings_si.iter().map(|(key, _)| key.as_str());
    let mut all: Vec<Sensitivity> = keys.filter_map(|key| sensitivity(&with_value, draws, key)).collect();
    let tails: Vec<f64> = all.iter().map(|one| one.p_family).collect();
    all.iter_mut().zip(holm(&tails)).for_each(|(one, adjusted)| one.p_family = adjusted);
    let tested = all.len();
    all.retain(|one| one.p_family <= LEVEL);
    all.sort_by(|a, b| b.coefficient.abs().total_cmp(&a.coefficient.abs()));
    (all, tested)
}

/// One setting, with its tail not yet adjusted; `None` where values or settings are all the same.
fn sensitivity(judged: &[Judged<'_>], draws: Draws, key: &str) -> Option<Sensitivity> {
    let (coefficient, u, dof) = match draws {
        Draws::Independent => {
            let coefficient = correlation(judged, key)?;
            let dof = judged.len() as f64 - 2.0;
            // A perfect correlation of finitely many units is uncertain all the same.
            let unexplained = (1.0 - coefficient * coefficient).max(1e-12);
            (coefficient, (unexplained / dof).sqrt(), dof)
        }
        Draws::Randomised { sets } => {
            let each: Vec<f64> = (0..sets).filter_map(|set| correlation(&in_set(judged, set), key)).collect();
            let mean = each.iter().sum::<f64>() / each.len() as f64;
            (mean, standard_error(&each)?.max(1e-9), each.len() as f64 - 1.0)
        }
    };
    let student = StudentsT::new(0.0, 1.0, dof).ok()?;
    let p_family = 2.0 * student.sf((coefficient / u).abs());
    Some(Sensitivity { setting: key.to_owned(), coefficient, u, p_family })
}

/// Rank correlation of the values with a setting.
fn correlation(judged: &[Judged<'_>], key: &str) -> Option<f64> {
    let setting =
        |one: &Judged<'_>| one.unit.settings_si.iter().find(|(name, _)| name == key).map(|(_, si)| *si);
    let settings: Option<Vec<f64>> = judged.iter().map(setting).collect();
    let values: Vec<f64> = judged.iter().filter_map(Judged::value_si).collect();
    spearman(&settings?, &values)
}
