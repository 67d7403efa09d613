//! `bench check`: every mistake of every file, before anything is switched on.

use super::options::{Fit, On};
use super::output;
use crate::exit;
use crate::plan::rehearsal::rehearse;
use crate::plan::{CampaignPlan, Wanted};

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
        Err(error) => output::plan_error(&error, exit::USAGE),
    }
}
