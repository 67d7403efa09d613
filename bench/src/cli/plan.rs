//! `bench plan`: what a run would do, in order.

use procedures::case::Case;

use super::check::{self, On};
use super::output;
use crate::exit;
use crate::plan::{CampaignPlan, PlannedProcedure, Wanted};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Campaigns or procedures: shipped names or paths; `quick` if none
    names: Vec<String>,
    #[command(flatten)]
    on: On,
    /// Another requirements file
    #[arg(long, value_name = "F")]
    requirements: Option<String>,
    /// Keep only these requirements, procedures, axes or kinds
    #[arg(long, value_name = "ID", num_args = 1..)]
    select: Vec<String>,
    /// One row per point
    #[arg(long)]
    points: bool,
}

pub(super) fn run(args: &Args) -> u8 {
    let (rig, _) = match args.on.load() {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    let wanted = Wanted {
        names: args.names.clone(),
        requirements: args.requirements.clone(),
        select: args.select.clone(),
        ..Wanted::default()
    };
    match crate::plan::plan(&wanted, &rig) {
        Ok(plan) => {
            output::say(&text(&plan, args.points));
            exit::PASS
        }
        Err(error) => check::print(&error, exit::USAGE),
    }
}

fn text(plan: &CampaignPlan, points: bool) -> String {
    let mut lines = vec![format!("{}: {}", plan.id, plan.title)];
    if plan.partial {
        lines.push("PARTIAL: not a whole campaign".to_owned());
    }
    let head = ["procedure", "point", "duration", "position", "rate", "acceleration", "torque"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for procedure in &plan.procedures {
        rows.push(summary(procedure));
        if points {
            rows.extend(procedure.cases.iter().map(|case| row("", &case.point, case)));
        }
    }
    lines.push(output::table(&rows));
    lines.push("each point: SAFE-OP, gates, OP, enable, segments, controlled stop, safe state".to_owned());
    lines.push(format!("must be measured: {}", plan.must_measure.join(" ")));
    lines.join("\n")
}

fn summary(planned: &PlannedProcedure) -> Vec<String> {
    let mut cells = cells(planned.cases.iter());
    let mut row = vec![planned.procedure.id.clone(), format!("{} points", planned.cases.len())];
    row.append(&mut cells);
    row
}

fn row(procedure: &str, point: &str, case: &Case) -> Vec<String> {
    let mut row = vec![procedure.to_owned(), point.to_owned()];
    row.append(&mut cells(std::iter::once(case)));
    row
}

fn cells<'a>(cases: impl Iterator<Item = &'a Case>) -> Vec<String> {
    let mut planned_s = 0.0;
    let mut whole = None;
    for case in cases {
        planned_s += case.planned_s();
        let envelope = case.envelope();
        match &mut whole {
            None => whole = Some(envelope),
            Some(whole) => whole.join(&envelope),
        }
    }
    let Some(e) = whole else { return Vec::new() };
    vec![
        format!("{planned_s:.0} s"),
        format!("{:.1} .. {:.1} deg", e.position_rad[0].to_degrees(), e.position_rad[1].to_degrees()),
        format!("{:.2} deg/s", e.velocity_rad_per_s.to_degrees()),
        format!("{:.1} deg/s^2", e.acceleration_rad_per_s2.to_degrees()),
        format!("{:.1} N*m", e.torque_nm),
    ]
}
