//! `bench check`: every mistake of every file, before anything is switched on.

use super::output;
use crate::exit;
use crate::files::shipped::{self, Folder};
use crate::files::unit::Unit;
use crate::model::rig::Rig;
use crate::plan::{CampaignPlan, PlanError, Wanted};
use crate::rehearsal::rehearse;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Campaigns or procedures: shipped names or paths; `quick` if none
    names: Vec<String>,
    #[command(flatten)]
    on: On,
    /// Another requirements file
    #[arg(long, value_name = "F")]
    requirements: Option<String>,
    #[command(flatten)]
    fit: Fit,
}

/// What becomes of procedures that the rig cannot run.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Leave out procedures that need a device that the rig lacks: the outcome is PARTIAL
    #[arg(long)]
    pub(super) skip_missing: bool,
}

/// What a check or plan is made against.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct On {
    /// Rig: a shipped name or a path
    #[arg(long, default_value = "sim")]
    pub(super) rig: String,
    /// Simulated unit: a shipped name or a path
    #[arg(long, default_value = "nominal")]
    pub(super) unit: String,
}

impl On {
    /// Reads the rig and unit files.
    pub(super) fn load(&self) -> Result<(Rig, Unit), u8> {
        let rig = shipped::find(Folder::Rigs, &self.rig, None).and_then(Rig::parse);
        let unit = Unit::load(&self.unit);
        match (rig, unit) {
            (Ok(rig), Ok(unit)) => Ok((rig, unit)),
            (rig, unit) => {
                let found: Vec<_> = rig.err().into_iter().chain(unit.err()).flatten().collect();
                Err(output::mistakes(&found))
            }
        }
    }
}

pub(super) fn run(args: &Args) -> u8 {
    let (rig, unit) = match args.on.load() {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    let wanted = Wanted {
        names: args.names.clone(),
        requirements: args.requirements.clone(),
        skip_missing: args.fit.skip_missing,
        ..Wanted::default()
    };
    let begins = |plan: CampaignPlan| rehearse(&plan, &rig, &unit).map(|()| plan);
    match crate::plan::plan(&wanted, &rig).and_then(begins) {
        Ok(plan) => {
            let points: usize = plan.procedures.iter().map(|p| p.cases.len()).sum();
            let uncovered = plan.requirements.all.iter().filter(|r| r.judges.is_empty()).count();
            let text = format!(
                "{}: {} procedures, {points} points, {:.0} s; {} requirements must be measured, {uncovered} of {} have no kind that measures them yet",
                plan.id,
                plan.procedures.len(),
                plan.procedures.iter().map(|p| p.planned_s()).sum::<f64>(),
                plan.must_measure.len(),
                plan.requirements.all.len(),
            );
            output::say(&text);
            plan.left_out.iter().for_each(|left| output::say(left));
            exit::PASS
        }
        Err(error) => print(&error, exit::USAGE),
    }
}

/// Prints a plan error; `refusal` is the exit code where only the rig says no.
pub(super) fn print(error: &PlanError, refusal: u8) -> u8 {
    match error {
        PlanError::Mistakes(found) => output::mistakes(found),
        PlanError::Refused(found) => {
            output::mistakes(found);
            refusal
        }
        PlanError::NothingSelected(message) => {
            output::error(message);
            exit::NOTHING_SELECTED
        }
    }
}
