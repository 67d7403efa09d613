//! `bench check`: every mistake of every file, before anything is switched on; also of a family of units.

use procedures::diagnostic::SourceFile;
use reports::printable::counted;

use super::options::{Asked, Fit};
use super::output;
use crate::exit;
use crate::files::family::read_family;
use crate::files::shipped::sort::Sort;
use crate::files::shipped::{self, Folder, SHIPPED};
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
    if let [name] = args.asked.names.as_slice()
        && let Some(family) = family(name)
    {
        return match read_family(family) {
            Ok(family) => {
                output::say(&family.summary());
                exit::PASS
            }
            Err(mistakes) => output::mistakes(&mistakes),
        };
    }
    let (plan, rig) = match args.asked.rehearsed(&[], args.fit) {
        Ok(found) => found,
        Err(code) => return code,
    };
    let points: usize = plan.procedures.iter().map(|p| p.cases.len()).sum();
    let uncovered = plan.requirements.all.iter().filter(|r| r.judges.is_empty()).count();
    let mut text = format!(
        "{}: {}, {}, {:.0} s; {} must be measured",
        plan.id,
        counted(plan.procedures.len(), "procedure"),
        counted(points, "point"),
        plan.procedures.iter().map(|p| p.planned_s()).sum::<f64>(),
        counted(plan.must_measure.len(), "requirement"),
    );
    if uncovered > 0 {
        text +=
            &format!(", {uncovered} of {} cannot be: no kind measures them yet", plan.requirements.all.len());
    }
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

/// The family file of this name, if it means one.
fn family(name: &str) -> Option<SourceFile> {
    let source = shipped::find(Folder::Families, name, None).ok()?;
    (Sort::of(&source) == Some(Sort::Family)).then_some(source)
}

/// The files that a run would use besides the procedures of its campaign, and how many of those are shipped ones.
fn files(plan: &CampaignPlan, rig: &Rig) -> String {
    let shipped = plan.procedures.iter().filter(|p| p.procedure.source.name.starts_with(SHIPPED)).count();
    let campaign = plan.source.as_ref().map_or("none", |source| source.name.as_str());
    format!(
        "files: campaign {campaign}, requirements {}, rig {}; shipped procedures: {shipped} of {} (`bench plan` names \
         the files)",
        plan.requirements_source.name,
        rig.source.name,
        plan.procedures.len()
    )
}
