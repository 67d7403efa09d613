//! What a unit is expected to show, judged by the product's own rules: predictions of the model against the limits of
//! the requirements.

mod flips;
mod limits;
mod page;
#[cfg(test)]
mod tests;

use bench::files::parameters;
use bench::files::shipped::{self, Folder};
use controllers::DirectorGains;
use procedures::diagnostic::Diagnostic;
use procedures::measurement::{Estimate, Measurement};
use procedures::quantity::{Limit, QuantityKind};
use procedures::requirement::{Judged, Requirement, Requirements, Take};
use procedures::verdict::{self, Verdict};
use sim_devices::unit::UnitSettings;

use crate::prediction::{self, Expected};

pub use flips::{Flips, broken_claims, flips, turned};
pub use limits::{QUANTITIES, Quantity};
pub use page::{table, word};

/// Estimator of every predicted value.
const ESTIMATOR: &str = "model";

/// A prediction and what the product's rules make of it.
#[derive(Clone, Debug)]
pub struct Verified {
    /// The prediction.
    pub expected: Expected,
    /// Its kind of quantity.
    pub kind: QuantityKind,
    /// The limit that it is compared with; `None` for report-only.
    pub limit: Option<Limit>,
    /// Distance to the nearest bound, positive inside.
    pub margin: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
}

impl Verified {
    /// Margin over the guard band, the smaller the worse.
    fn reserve(&self) -> f64 {
        let margin = self.margin.unwrap_or(f64::INFINITY);
        margin / self.expected.uncertainty_si.max(1e-12)
    }
}

/// Requirements and gains as shipped.
#[derive(Clone, Debug)]
pub struct Judge {
    requirements: Requirements,
    gains: DirectorGains,
}

impl Judge {
    /// With the shipped requirements and the director's gains.
    ///
    /// # Errors
    /// All mistakes of these files.
    pub fn shipped() -> Result<Self, Vec<Diagnostic>> {
        let requirements = Requirements::parse(&shipped::find(Folder::Requirements, "requirements", None)?)?;
        let (_, gains) = parameters::named("director", None)?;
        Ok(Self { requirements, gains })
    }

    /// Every prediction for a unit, judged, in the order of the requirements. One that no model predicts has no row.
    pub fn verify(&self, unit: &UnitSettings) -> Vec<Verified> {
        let rows = prediction::predict(unit, &self.gains);
        let of_requirement = |r: &Requirement| {
            let mine = rows.iter().filter(|row| row.requirement == r.id);
            mine.map(|row| verified(row, r)).collect::<Vec<_>>()
        };
        self.requirements.all.iter().flat_map(of_requirement).collect()
    }
}

/// The worst row of each requirement, in their order: first by verdict, then by margin over uncertainty.
pub fn worst(rows: &[Verified]) -> Vec<&Verified> {
    let mut worst: Vec<&Verified> = Vec::new();
    for row in rows {
        match worst.last_mut() {
            Some(last) if last.expected.requirement == row.expected.requirement => {
                let is_worse = (row.verdict, -row.reserve()) > (last.verdict, -last.reserve());
                if is_worse {
                    *last = row;
                }
            }
            _ => worst.push(row),
        }
    }
    worst
}

/// What a unit trips before anything is measured.
pub fn trip(unit: &UnitSettings) -> Option<(&'static str, String)> {
    let polarity = prediction::polarity(unit).err().map(|why| ("polarity", why));
    polarity.or_else(|| prediction::bus(unit).err().map(|why| ("bus", why)))
}

fn verified(row: &Expected, requirement: &Requirement) -> Verified {
    let found = limits::known(row.requirement, row.quantity);
    let kind = found.map_or(QuantityKind::Count, |q| q.kind);
    let text = found.and_then(|q| q.limit).unwrap_or(&requirement.limit_text);
    let limit = kind.parse_limit(text).ok();
    let axis = row.axis.map_or("", |axis| ["az", "el"][axis]);
    // k = 2 is Student's factor for infinite degrees of freedom.
    let u = 0.5 * row.uncertainty_si;
    let estimate = Estimate { value: row.value_si, u, dof: f64::INFINITY, n: 1 };
    let measurement = Measurement::new(row.quantity, axis, kind, Some(estimate), ESTIMATOR);
    let judged = Judged {
        measurand: row.quantity.to_owned(),
        limit: limit.clone(),
        bands: Vec::new(),
        mask: None,
        goal: None,
        rule: requirement.rule,
    };
    let alone = Requirement {
        judges: vec![judged],
        conditions: Vec::new(),
        axes: Vec::new(),
        covers: Vec::new(),
        take: Take::Worst,
        ..requirement.clone()
    };
    let judgement = verdict::judge(&measurement, 0, &alone);
    Verified { expected: row.clone(), kind, limit, margin: judgement.margin, verdict: judgement.verdict }
}
