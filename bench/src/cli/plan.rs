//! `bench plan`: what a run would do, in order, and what happens when it is interrupted at its worst instant.

use super::options::{Asked, Fit};
use super::output;
use crate::exit;
use crate::model::rig::Rig;
use crate::plan::{CampaignPlan, phases, preflight};

mod actions;
mod rows;
mod stages;
#[cfg(test)]
mod tests;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    #[command(flatten)]
    asked: Asked,
    /// Plan only these requirements, procedures, stages, axes or kinds
    #[arg(long, value_name = "ID", num_args = 1..)]
    select: Vec<String>,
    /// One row per point
    #[arg(long)]
    points: bool,
    #[command(flatten)]
    fit: Fit,
}

pub(super) fn run(args: &Args) -> u8 {
    match args.asked.rehearsed(&args.select, args.fit) {
        Ok((plan, rig)) => {
            output::say(&text(&plan, &rig, args.points));
            exit::PASS
        }
        Err(code) => code,
    }
}

/// The file of everything that a run would use.
fn files(plan: &CampaignPlan, rig: &Rig) -> Vec<Vec<String>> {
    let row = |what: &str, file: &str| vec![what.to_owned(), file.to_owned()];
    let campaign = plan.source.iter().map(|source| row("campaign", &source.name));
    let first =
        campaign.chain([row("requirements", &plan.requirements_source.name), row("rig", &rig.source.name)]);
    let procedures = plan.procedures.iter().map(|p| row(&p.procedure.id, &p.procedure.source.name));
    first.chain(procedures).collect()
}

fn text(plan: &CampaignPlan, rig: &Rig, points: bool) -> String {
    let found = preflight::envelopes(&plan.procedures, rig);
    let mut lines = vec![format!("{}: {}", plan.id, plan.title)];
    if plan.partial {
        lines.push("PARTIAL: not a whole campaign".to_owned());
    }
    lines.extend(plan.left_out.iter().cloned());
    lines.extend(stages::text(plan));
    lines.push(output::table(&rows::envelope(&found, points)));
    lines.push("\nworst cases (a stop, and a loss of torque, each at the worst instant)".to_owned());
    lines.push(output::table(&rows::worst(&found, rig, points)));
    let bounded = rows::bounded(&found);
    if !bounded.is_empty() {
        lines.push("\nsegments in torque mode (no planned position) and what bounds their motion".to_owned());
        lines.push(output::table(&bounded));
    }
    lines.push("\norder of actions".to_owned());
    lines.extend(actions::list(plan, rig));
    lines.push("\nnot enforced by the drives in torque mode (CST); monitored by the bench alone".to_owned());
    lines.push(output::table(&rows::not_enforced()));
    lines.push("\nresidual risks".to_owned());
    let risks = preflight::risks(&found, rig);
    lines.extend(risks.iter().map(|risk| format!("- {risk}")));
    if risks.is_empty() {
        lines.push(
            "- none found: no planned coast reaches an end stop, and no released axis swings".to_owned(),
        );
    }
    let one_phase = phases::one_phase(&plan.procedures, rig);
    if !one_phase.is_empty() {
        lines.push("\nsweeps that cover only one phase of the cogging".to_owned());
        lines.extend(one_phase.iter().map(|text| format!("- {text}")));
    }
    lines.extend(stages::instruments(rig));
    lines.push("\nfiles".to_owned());
    lines.push(output::table(&files(plan, rig)));
    let required = if plan.must_measure.is_empty() { "none".to_owned() } else { plan.must_measure.join(" ") };
    lines.push(format!("\nmust be measured: {required}"));
    lines.join("\n")
}
