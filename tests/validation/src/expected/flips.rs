//! What a defect turns, against the nominal unit, and what its file says of that.

use bench::site::unit::Unit;
use procedures::verdict::Verdict;

use super::{Verified, page, trip, worst};

/// What became of a unit's claims.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flips {
    /// What it trips before anything is measured, and why.
    pub trip: Option<(&'static str, String)>,
    /// Requirements whose verdict is another than the nominal unit's, with the new one.
    pub turned: Vec<(&'static str, Verdict)>,
    /// Claims that do not hold, in words.
    pub broken: Vec<String>,
}

/// Holds what a unit must and may turn against what it does turn, by the model.
pub fn flips(unit: &Unit, rows: &[Verified], nominal: &[Verified]) -> Flips {
    let trip = unit.director().and_then(trip);
    let mut broken = Vec::new();
    let tripped = trip.as_ref().map(|(name, _)| *name);
    if tripped != unit.must_trip.as_deref() {
        broken.push(format!("trips {tripped:?}, must trip {:?}", unit.must_trip));
    }
    // A run that trips measures nothing.
    if trip.is_some() {
        return Flips { trip, turned: Vec::new(), broken };
    }
    let turned = turned(&verdicts(nominal), &verdicts(rows));
    // Of what no model predicts, measured runs tell whether it turns.
    let is_predicted = |id: &String| nominal.iter().any(|row| row.expected.requirement == id);
    let must_flip = unit.must_flip.iter().filter(|id| is_predicted(id)).cloned().collect();
    broken.extend(broken_claims(&Unit { must_flip, ..unit.clone() }, &turned));
    Flips { trip, turned, broken }
}

fn verdicts(rows: &[Verified]) -> Vec<(&'static str, Verdict)> {
    worst(rows).into_iter().map(|row| (row.expected.requirement, row.verdict)).collect()
}

/// Requirements whose verdict is another than before, with the new one. Both lists hold a requirement once, `now` perhaps
/// not all of those of `before`.
pub fn turned<'a>(before: &[(&str, Verdict)], now: &[(&'a str, Verdict)]) -> Vec<(&'a str, Verdict)> {
    let was = |id: &str| before.iter().find(|(other, _)| *other == id).map(|(_, verdict)| *verdict);
    now.iter().filter(|(id, verdict)| was(id) != Some(*verdict)).copied().collect()
}

/// What the unit's file says and these turns do not show, in words: requirements that must fail and do not, and those that
/// turn and are not named.
pub fn broken_claims(unit: &Unit, turned: &[(&str, Verdict)]) -> Vec<String> {
    let failed = |id: &String| turned.iter().any(|(other, v)| other == id && *v == Verdict::Fail);
    let missing = unit.must_flip.iter().filter(|id| !failed(id));
    let missing = missing.map(|id| format!("{id} must fail and does not"));
    let claimed = |id: &str| unit.must_flip.iter().chain(&unit.may_flip).any(|claim| claim == id);
    let stray = turned.iter().filter(|(id, _)| !claimed(id));
    missing
        .chain(stray.map(|(id, verdict)| format!("{id} turns to {} unannounced", page::word(*verdict))))
        .collect()
}
