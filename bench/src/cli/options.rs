//! Options that several verbs have.

use procedures::diagnostic::Diagnostic;

use super::output;
use crate::exit;
use crate::files::profile;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder, sort};
use crate::files::unit::load_unit;
use crate::model::rig::{Rig, Tier};
use crate::plan::rehearsal::rehearse;
use crate::plan::{self, CampaignPlan, Wanted};
use crate::site::unit::Unit;

/// What becomes of procedures that the rig cannot run.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Leave out procedures that need a device the rig does not have; the outcome is PARTIAL
    #[arg(long)]
    pub(super) skip_missing: bool,
}

/// What a run, a check or a plan is made against.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct On {
    /// Rig: a shipped name or a path
    #[arg(long, default_value = "sim")]
    pub(super) rig: String,
    /// Simulated unit: a shipped name or a path
    #[arg(long, default_value = "nominal")]
    pub(super) unit: String,
    /// Rehearse a rig on simulated devices in this process instead of its own wires: in virtual time, or paced in real time
    #[arg(long, value_name = "TIER", value_enum)]
    pub(super) tier: Option<Rehearsal>,
}

/// A tier on which any rig can be rehearsed.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rehearsal {
    /// In virtual time, a new world for each point
    Virtual,
    /// In real time, one session for the whole run
    Paced,
}

/// What a run, a check or a plan is about, and what it is made against.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct Asked {
    /// Campaigns or procedures: shipped names or paths; `quick` if none
    pub(super) names: Vec<String>,
    #[command(flatten)]
    pub(super) on: On,
    /// Requirements file to use instead of the campaign's
    #[arg(long, value_name = "F")]
    pub(super) requirements: Option<String>,
}

impl Asked {
    /// What a plan shall hold: of the procedures those that `select` keeps.
    pub(super) fn wanted(&self, select: &[String], fit: Fit) -> Wanted {
        Wanted {
            names: self.names.clone(),
            requirements: self.requirements.clone(),
            select: select.to_vec(),
            skip_missing: fit.skip_missing,
            ..Wanted::default()
        }
    }

    /// Plans and rehearses without a run; the exit code where that fails.
    pub(super) fn rehearsed(&self, select: &[String], fit: Fit) -> Result<(CampaignPlan, Rig), u8> {
        let (rig, unit) = self.on.load()?;
        let begins = |plan: CampaignPlan| rehearse(&plan, &rig, &unit).map(|()| plan);
        let plan = plan::plan(&self.wanted(select, fit), &rig).and_then(begins);
        Ok((plan.map_err(|error| output::plan_error(&error, exit::USAGE))?, rig))
    }
}

impl On {
    /// Reads the rig and unit files.
    pub(super) fn load(&self) -> Result<(Rig, Unit), u8> {
        let (rig, unit) = load(&self.rig, &self.unit)?;
        Ok(match self.tier {
            None => (rig, unit),
            Some(Rehearsal::Virtual) => (rig.rehearsed_on(Tier::Virtual, &profile::simulated()), unit),
            Some(Rehearsal::Paced) => (rig.rehearsed_on(Tier::Paced, &profile::simulated()), unit),
        })
    }
}

/// Reads a rig, by shipped name or path.
pub(super) fn load_rig(name: &str) -> Result<Rig, Vec<Diagnostic>> {
    shipped::find(Folder::Rigs, name, None)
        .and_then(|source| sort::expect(source, Folder::Rigs))
        .and_then(read_rig)
}

/// Reads a rig and a unit, by shipped names or paths.
pub(super) fn load(rig: &str, unit: &str) -> Result<(Rig, Unit), u8> {
    match (load_rig(rig), load_unit(unit)) {
        (Ok(rig), Ok(unit)) => Ok((rig, unit)),
        (rig, unit) => {
            let found: Vec<_> = rig.err().into_iter().chain(unit.err()).flatten().collect();
            Err(output::mistakes(&found))
        }
    }
}
