//! Whether campaign, procedures and requirements fit together, before anything moves.

use std::ops::Range;

use super::{Campaign, Demanded};
use crate::diagnostic::Diagnostic;
use crate::procedure::Procedure;
use crate::requirement::{Requirement, Requirements};
use crate::table::{mistake_in, quoted, sort_by_place, suggestion};

/// Everything in a campaign that cannot come to a verdict; `procedures` are those of its entries, in the same order, `None` where
/// not all of them could be read and planned: then what they would have yielded is not judged.
///
/// Found are: two procedures of one id, a `must-measure` id that is unknown, named twice, measured by no kind yet,
/// or whose measurands no procedure of the campaign yields on the requirement's axis in the final build state (with
/// `coverage = "full"` any requirement that is not declared); a requirement that a stage waits for and nothing before it
/// measures.
pub fn check(
    campaign: &Campaign,
    procedures: Option<Vec<&Procedure>>,
    requirements: &Requirements,
) -> Vec<Diagnostic> {
    let yielded = procedures.as_deref();
    let mut mistakes = yielded.map_or_else(Vec::new, |procedures| same_ids(campaign, procedures));
    match &campaign.demanded {
        Demanded::Listed(listed) => mistakes.extend(listed_ones(campaign, listed, requirements, yielded)),
        Demanded::All(span) => {
            let asked = requirements.all.iter().filter(|r| !r.is_declared());
            mistakes.extend(asked.filter_map(|r| not_measured(campaign, r, span, yielded)));
        }
    }
    if let Some(procedures) = yielded {
        mistakes.extend(gates_on_nothing(campaign, procedures, requirements));
    }
    sort_by_place(&mut mistakes);
    mistakes
}

/// Mistakes in the ids that `must-measure` lists.
fn listed_ones(
    campaign: &Campaign,
    listed: &[(String, Range<usize>)],
    requirements: &Requirements,
    procedures: Option<&[&Procedure]>,
) -> Vec<Diagnostic> {
    let mut mistakes = Vec::new();
    for (index, (id, span)) in listed.iter().enumerate() {
        if listed[..index].iter().any(|(earlier, _)| earlier == id) {
            mistakes.push(at(campaign, span, format!("requirement `{id}` is listed twice"), None));
        } else if let Some(requirement) = requirements.get(id) {
            mistakes.extend(without_limit(campaign, requirement, span));
            mistakes.extend(not_measured(campaign, requirement, span, procedures));
        } else {
            mistakes.push(unknown(campaign, id, span, requirements));
        }
    }
    mistakes
}

/// Why a requirement cannot get a verdict from the final build state of this campaign, if so; procedures that could not
/// all be read are not blamed.
fn not_measured(
    campaign: &Campaign,
    requirement: &Requirement,
    span: &Range<usize>,
    procedures: Option<&[&Procedure]>,
) -> Option<Diagnostic> {
    if requirement.judges.is_empty() {
        let message = format!("no kind of experiment measures requirement `{}` yet", requirement.id);
        let help = "remove it from `must-measure`, or give it `evidence` from analysis or inspection";
        return Some(at(campaign, span, message, Some(help.to_owned())));
    }
    let procedures = procedures?;
    let judged = || campaign.procedures.iter().zip(procedures).filter(|(e, _)| campaign.is_judged(e));
    let nobody = |measurand: &&str| !judged().any(|(_, p)| yields(p, requirement, measurand));
    let missing: Vec<&str> = requirement.measurands().filter(nobody).collect();
    let help = || format!("add a procedure that measures {}", quoted(missing.iter().copied()));
    (!missing.is_empty()).then(|| at(campaign, span, nobody_yields(requirement, &missing), Some(help())))
}

/// A requirement that is only reported, where a verdict is asked for.
fn without_limit(campaign: &Campaign, requirement: &Requirement, span: &Range<usize>) -> Option<Diagnostic> {
    (!requirement.judges.is_empty() && !requirement.is_limited()).then(|| {
        let message = format!("requirement `{}` has no limit: it can never get a verdict", requirement.id);
        let help = "give it a `limit`, or remove it here".to_owned();
        at(campaign, span, message, Some(help))
    })
}

/// Requirements that a stage waits for and that nothing in the stages it needs measures: it would never begin.
fn gates_on_nothing(
    campaign: &Campaign,
    procedures: &[&Procedure],
    requirements: &Requirements,
) -> Vec<Diagnostic> {
    let mut mistakes = Vec::new();
    for (stage, (id, span)) in campaign.stages.iter().flat_map(|s| s.needs_pass.iter().map(move |n| (s, n))) {
        let Some(requirement) = requirements.get(id) else {
            mistakes.push(unknown(campaign, id, span, requirements));
            continue;
        };
        mistakes.extend(without_limit(campaign, requirement, span));
        let measures = |entry: &super::Entry, procedure: &Procedure| {
            campaign.is_judged(entry)
                && campaign.is_needed(stage, entry)
                && requirement.measurands().any(|m| yields(procedure, requirement, m))
        };
        if !campaign.procedures.iter().zip(procedures).any(|(entry, p)| measures(entry, p)) {
            let message = format!("no stage that `{}` needs measures requirement `{id}`", stage.id);
            let help = "name the stage that measures it in `needs`".to_owned();
            mistakes.push(at(campaign, span, message, Some(help)));
        }
    }
    mistakes
}

/// Whether a procedure yields this measurand on the requirement's axis.
fn yields(procedure: &Procedure, requirement: &Requirement, measurand: &str) -> bool {
    requirement.axis.as_ref().is_none_or(|axis| *axis == procedure.axis)
        && procedure.yields.contains(&measurand)
}

fn nobody_yields(requirement: &Requirement, missing: &[&str]) -> String {
    let axis = requirement.axis.as_ref().map_or_else(String::new, |axis| format!(" on axis `{axis}`"));
    let measurands = quoted(missing.iter().copied());
    format!(
        "no procedure of the campaign measures {measurands}{axis}, which requirement `{}` judges",
        requirement.id
    )
}

fn same_ids(campaign: &Campaign, procedures: &[&Procedure]) -> Vec<Diagnostic> {
    let mut mistakes = Vec::new();
    for (index, (procedure, entry)) in procedures.iter().zip(&campaign.procedures).enumerate() {
        let first = procedures[..index].iter().find(|other| other.id == procedure.id);
        if let Some(first) = first {
            let files = format!("`{}` and `{}`", first.source.name, procedure.source.name);
            let message = format!("two procedures have the id `{}`: {files}", procedure.id);
            let help = "logs are named after the id: rename one of the two".to_owned();
            mistakes.push(at(campaign, &entry.span, message, Some(help)));
        }
    }
    mistakes
}

/// An id that the requirements file does not hold, with the nearest one: the list of all would be long.
fn unknown(campaign: &Campaign, id: &str, span: &Range<usize>, requirements: &Requirements) -> Diagnostic {
    let near = crate::diagnostic::nearest(id, requirements.all.iter().map(|r| r.id.as_str()));
    let message = format!("unknown requirement `{id}` in `{}`", campaign.requirements);
    at(campaign, span, message, near.map(|near| suggestion(id, [near])))
}

fn at(campaign: &Campaign, span: &Range<usize>, message: String, help: Option<String>) -> Diagnostic {
    mistake_in(&campaign.source, span.clone(), message, help)
}
