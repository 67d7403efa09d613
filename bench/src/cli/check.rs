//! `bench check`: every mistake of every file, before anything is switched on.

use super::options::{Asked, Fit};
use super::output;
use crate::exit;
use crate::files::shipped::SHIPPED;
use crate::model::rig::Rig;
use crate::plan::CampaignPlan;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    #[command(flatten)]
    asked: Asked,
    #[command(flatten)]
    fit: Fit,
}

pub(super) fn run(args: &Args) -> u8 {
    let (plan, rig) = match args.asked.rehearsed(&[], args.fit) {
        Ok(found) => found,
        Err(code) => return code,
    };
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
    output::say(&files(&plan, &rig));
    for planned in &plan.procedures {
        planned
            .cuts(&rig)
            .iter()
            .for_each(|cut| output::say(&format!("note: {}: {cut}", planned.procedure.id)));
    }
    plan.left_out.iter().for_each(|left| output::say(left));
    exit::PASS
}

/// The files that a run would use besides the procedures of its campaign, and how many of those are shipped ones.
fn files(plan: &CampaignPlan, rig: &Rig) -> String {
    let shipped = plan.procedures.iter().filter(|p| p.procedure.source.name.starts_with(SHIPPED)).count();
    let campaign = plan.source.as_ref().map_or("none", |source| source.name.as_str());
    format!(
        "files: campaign {campaign}, requirements {}, rig {}; {shipped} of {} procedures are shipped ones (`bench plan` names their files)",
        plan.requirements_source.name,
        rig.source.name,
        plan.procedures.len()
    )
}
