//! What a defect turns, against the nominal unit.

use procedures::verdict::Verdict;

use super::{Verified, trip, worst};
use crate::files::unit::Unit;

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

/// Holds what a unit must and may turn against what it does turn.
pub fn flips(unit: &Unit, rows: &[Verified], nominal: &[Verified]) -> Flips {
    let trip = trip(unit);
    let mut broken = Vec::new();
    let tripped = trip.as_ref().map(|(name, _)| *name);
    if tripped != unit.must_trip.as_deref() {
        broken.push(format!("trips {tripped:?}, must trip {:?}", unit.must_trip));
    }
    // A run that trips measures nothing.
    if trip.is_some() {
        return Flips { trip, turned: Vec::new(), broken };
    }
    let before = worst(nominal);
    let mut turned = Vec::new();
    for now in worst(rows) {
        let id = now.expected.requirement;
        let was = before.iter().find(|row| row.expected.requirement == id).map(|row| row.verdict);
        if was != Some(now.verdict) {
            turned.push((id, now.verdict));
        }
    }
    for id in &unit.must_flip {
        if !turned.iter().any(|(turned, verdict)| turned == id && *verdict == Verdict::Fail) {
            broken.push(format!("{id} must fail and does not"));
        }
    }
    let claimed = |id: &str| unit.must_flip.iter().chain(&unit.may_flip).any(|claim| claim == id);
    let stray = turned.iter().filter(|(id, _)| !claimed(id));
    broken.extend(
        stray.map(|(id, verdict)| format!("{id} turns to {} unannounced", super::page::word(*verdict))),
    );
    Flips { trip, turned, broken }
}
