//! The gate of every closed loop: signs and scales were proven on this very rig (safety.md: polarity).
//!
//! Procedures of the kind [`KIND`] run first and alone. What they prove stands in the journal together with what it
//! was proven of, so that a later run may rely on it as long as nothing of that has changed.

use std::path::Path;

use procedures::measurement::Proof;
use reports::record::{DeviceRecord, EvidenceState, Status};
use serde::{Deserialize, Serialize};

use crate::evidence;
use crate::journal::{self, Entry, sha256};
use crate::page::{Page, PlannedLog};

#[cfg(test)]
mod tests;

/// Name of the kind of procedure that opens the gate, and of the gate.
pub const KIND: &str = "polarity";

/// What a proof is about; it is worth nothing once any of it has changed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Basis {
    /// Each device with what it says of itself, firmware included.
    pub identities: Vec<String>,
    /// Digest of the unit files: how a simulated unit is put together; of nothing for a real one.
    pub unit_sha256: String,
    /// Digest of the rig file.
    pub rig_sha256: String,
    /// Digest of all parameters of the controllers.
    pub parameters_sha256: String,
}

impl Basis {
    /// What a proof of today would be about.
    pub fn new(
        devices: &[DeviceRecord],
        unit: &[String],
        rig: &str,
        gains: &controllers::DirectorGains,
    ) -> Self {
        let parameters: Vec<String> = controllers::parameter::PARAMETERS
            .iter()
            .map(|p| format!("{}={:016x}", p.key, (p.get)(gains).to_bits()))
            .collect();
        Self {
            identities: devices.iter().map(|d| format!("{}: {}", d.name, d.identity)).collect(),
            unit_sha256: sha256(unit.join("\0").as_bytes()),
            rig_sha256: sha256(rig.as_bytes()),
            parameters_sha256: sha256(parameters.join("\n").as_bytes()),
        }
    }

    /// All of it as one digest.
    pub fn hash(&self) -> String {
        let Self { identities, unit_sha256, rig_sha256, parameters_sha256 } = self;
        sha256(
            format!("{}\n{unit_sha256}\n{rig_sha256}\n{parameters_sha256}", identities.join("\n")).as_bytes(),
        )
    }

    /// What differs from an earlier one, each as a few words.
    fn changes_since(&self, earlier: &Self) -> Vec<String> {
        let mut all = Vec::new();
        for (what, before, now) in [
            ("the unit file", &earlier.unit_sha256, &self.unit_sha256),
            ("the rig file", &earlier.rig_sha256, &self.rig_sha256),
            ("the parameters of the controllers", &earlier.parameters_sha256, &self.parameters_sha256),
        ] {
            if before != now {
                all.push(what.to_owned());
            }
        }
        let gone = earlier.identities.iter().filter(|id| !self.identities.contains(id));
        all.extend(gone.map(|id| format!("a device (it was {id})")));
        if self.identities.len() != earlier.identities.len() {
            all.push(format!(
                "the number of devices, from {} to {}",
                earlier.identities.len(),
                self.identities.len()
            ));
        }
        all
    }
}

/// Whether loops may be closed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Gate {
    /// Proven, or nothing asks for it.
    Open,
    /// Not, and why: `polarity: …`.
    Closed(String),
}

impl Gate {
    /// Why it is closed.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Open => None,
            Self::Closed(reason) => Some(reason),
        }
    }
}

/// What the polarity procedures came to that ran in one build state, the final one if `None`. `outcome` gives status and
/// proof of the procedure of an index, or nothing where it left no log.
pub fn gate_in(
    state: Option<&str>,
    planned: &[PlannedLog],
    outcome: impl Fn(usize) -> Option<(Status, Option<Proof>)>,
) -> Gate {
    let counts = |p: &PlannedLog| p.kind == KIND && p.state.as_deref() == state;
    let checks = planned.iter().enumerate().filter(|(_, p)| counts(p));
    let mut reasons = checks.filter_map(|(index, p)| {
        let Some((status, proof)) = outcome(index) else {
            return Some(format!("not proven: {} left no log that can be judged", p.id));
        };
        match proof.filter(|proof| proof.gate == KIND) {
            Some(Proof { faults, .. }) if !faults.is_empty() => faults.into_iter().next(),
            Some(_) if status == Status::Completed => None,
            _ => Some(format!("not proven: {} {}", p.id, status.word())),
        }
    });
    reasons.next().map_or(Gate::Open, |reason| Gate::Closed(format!("{KIND}: {reason}")))
}

/// Whether the proof of an earlier run holds for what is here now.
///
/// # Errors
/// Why not: what that run lacks, or what has changed since.
pub fn accept(run: &Path, now: &Basis) -> Result<(), String> {
    let shown = run.display();
    let page = Page::read(run)?;
    let (lines, _) = journal::read(run)?;
    let evidence = evidence::check(run);
    if evidence.state == EvidenceState::Altered {
        return Err(format!(
            "--polarity {shown}: that run is not believed: evidence {}",
            evidence.sentence()
        ));
    }
    let proven = lines.iter().rev().find_map(|line| match &line.entry {
        Entry::Polarity { hash, proven, fault, .. } => Some((hash, *proven, fault)),
        _ => None,
    });
    let Some((hash, proven, fault)) = proven else {
        return Err(format!("--polarity {shown}: that run did not check polarity; leave the option out"));
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
        "--polarity {shown}: its proof no longer holds, because this has changed: {changes}; leave the option out, \
         and polarity is checked first"
    ))
}
