//! `bench check`: every mistake of every file, before anything is switched on.

use super::options::{Asked, Fit};
use super::output;
use crate::exit;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    #[command(flatten)]
    asked: Asked,
    #[command(flatten)]
    fit: Fit,
}

pub(super) fn run(args: &Args) -> u8 {
    let plan = match args.asked.rehearsed(&[], args.fit) {
        Ok((plan, _)) => plan,
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
    plan.left_out.iter().for_each(|left| output::say(left));
    exit::PASS
}
