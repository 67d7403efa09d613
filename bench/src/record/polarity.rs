//! The gate of every closed loop: signs and scales were proven on this very rig (safety.md: polarity).
//!
//! Procedures of the kind [`POLARITY`] run first and alone. What they prove stands in the journal together with what it
//! was proven of, so that a later run may rely on it as long as nothing of that has changed.

use std::path::Path;

use procedures::measurement::Proof;
use reports::record::{EvidenceState, Status};

use crate::model::signs::POLARITY;
use crate::record::evidence;
use crate::record::journal::{self, Entry};
use crate::record::page::{Basis, Page, PlannedLog};

#[cfg(test)]
mod tests;

/// Whether loops may be closed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Gate {
    /// Proven, or nothing asks for it.
    Open,
    /// Not, and why: `polarity: …`.
    Closed(String),
}

impl Gate {
    /// Why it is closed.
    pub(crate) fn reason(&self) -> Option<&str> {
        match self {
            Self::Open => None,
            Self::Closed(reason) => Some(reason),
        }
    }
}

/// What the polarity procedures came to that ran in one build state, the final one if `None`. `outcome` gives status and
/// proof of the procedure of an index, or nothing where it left no log.
pub(crate) fn gate_in(
    state: Option<&str>,
    planned: &[PlannedLog],
    outcome: impl Fn(usize) -> Option<(Status, Option<Proof>)>,
) -> Gate {
    let counts = |p: &PlannedLog| p.kind == POLARITY && p.state.as_deref() == state;
    let checks = planned.iter().enumerate().filter(|(_, p)| counts(p));
    let mut reasons = checks.filter_map(|(index, p)| {
        let Some((status, proof)) = outcome(index) else {
            return Some(format!("not proven: {} left no log that can be judged", p.id));
        };
        match proof.filter(|proof| proof.gate == POLARITY) {
            Some(Proof { faults, .. }) if !faults.is_empty() => faults.into_iter().next(),
            Some(_) if status == Status::Completed => None,
            _ => Some(format!("not proven: {} {}", p.id, status.word())),
        }
    });
    reasons.next().map_or(Gate::Open, |reason| Gate::Closed(format!("{POLARITY}: {reason}")))
}

/// Whether the proof of an earlier run holds for what is here now.
///
/// # Errors
/// Why not: what that run lacks, or what has changed since.
pub(crate) fn accept(run: &Path, now: &Basis) -> Result<(), String> {
    let shown = run.display();
    let page = Page::read(run)?;
    let (lines, _) = journal::read(run)?;
    let evidence = evidence::check(run);
    if evidence.state == EvidenceState::Altered {
        return Err(format!(
            "--polarity {shown}: that run is not accepted: evidence {}",
            evidence.sentence()
        ));
    }
    let proven = lines.iter().rev().find_map(|line| match &line.entry {
        Entry::Polarity { hash, proven, fault, .. } => Some((hash, *proven, fault)),
        _ => None,
    });
    let Some((hash, proven, fault)) = proven else {
        return Err(format!("--polarity {shown}: that run did not check polarity; leave out the option"));
    };
    if !proven {
        let fault = fault.as_deref().unwrap_or("no reason is given");
        return Err(format!("--polarity {shown}: that run did not prove it: {fault}"));
    }
    if *hash == now.hash() {
        return Ok(());
    }
    let changes = now.changes_since(&page.polarity);
    let changes = if changes.is_empty() { "its title page".to_owned() } else { changes.join(", ") };
    Err(format!(
        "--polarity {shown}: its proof is no longer valid, because this has changed: {changes}; leave out \
         the option to check polarity first"
    ))
}
