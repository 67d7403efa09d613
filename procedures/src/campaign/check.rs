//! Whether campaign, procedures and requirements fit together, before anything moves.

use std::ops::Range;

use super::Campaign;
use crate::diagnostic::Diagnostic;
use crate::procedure::Procedure;
use crate::requirement::{Requirement, Requirements};
use crate::table::{mistake_in, quoted, sort_by_place, suggestion};

/// Everything in a campaign that cannot come to a verdict; `procedures` are those of its entries, in the same order
/// (fewer if some could not be read: then what they would have yielded is not judged).
///
/// Found are: two procedures of one id, a `must-measure` id that is unknown, named twice, measured by no kind yet,
/// or whose measurands no procedure of the campaign yields on the requirement's axis in the final build state; a
/// requirement that a stage waits for and nothing before it measures.
pub fn check(campaign: &Campaign, procedures: &[Procedure], requirements: &Requirements) -> Vec<Diagnostic> {
    let mut mistakes = same_ids(campaign, procedures);
    let complete = procedures.len() == campaign.procedures.len();
    for (index, (id, span)) in campaign.must_measure.iter().zip(&campaign.must_measure_spans).enumerate() {
        let mistake = |message: String, help: Option<String>| at(campaign, span, message, help);
        if campaign.must_measure[..index].contains(id) {
            mistakes.push(mistake(format!("requirement `{id}` is named twice"), None));
            continue;
        }
        let Some(requirement) = requirements.get(id) else {
            let help = suggestion_of_few(id, requirements);
            mistakes
                .push(mistake(format!("unknown requirement `{id}` in `{}`", campaign.requirements), help));
            continue;
        };
        if requirement.judges.is_empty() {
            let message = format!("no kind of experiment measures requirement `{id}` yet");
            mistakes.push(mistake(message, Some("take it out of `must-measure`".to_owned())));
        } else if complete {
            let judged = || campaign.procedures.iter().zip(procedures).filter(|(e, _)| campaign.is_judged(e));
            let nobody = |measurand: &&str| !judged().any(|(_, p)| yields(p, requirement, measurand));
            let missing: Vec<&str> = requirement.measurands().filter(nobody).collect();
            if !missing.is_empty() {
                let help = format!("add a procedure that yields {}", quoted(missing.iter().copied()));
                mistakes.push(mistake(nobody_yields(requirement, &missing), Some(help)));
            }
        }
    }
    if complete {
        mistakes.extend(gates_on_nothing(campaign, procedures, requirements));
    }
    if campaign.covers_all {
        mistakes.extend(uncovered(campaign, requirements));
    }
    sort_by_place(&mut mistakes);
    mistakes
}

/// Requirements that are neither measured nor declared, where the campaign is to cover all.
fn uncovered(campaign: &Campaign, requirements: &Requirements) -> Option<Diagnostic> {
    let named = |id: &String| campaign.must_measure.contains(id);
    let open = requirements.all.iter().filter(|r| !named(&r.id) && !r.is_declared());
    let ids: Vec<&str> = open.map(|r| r.id.as_str()).collect();
    if ids.is_empty() {
        return None;
    }
    let span = campaign.must_measure_spans.first().cloned().unwrap_or(0..0);
    let message = format!(
        "the campaign is to cover all requirements, but {} are neither measured nor declared: {}",
        ids.len(),
        quoted(ids.iter().copied())
    );
    let help = "add a procedure and the id to `must-measure`, or `evidence` to a requirement that analysis or inspection shows";
    Some(at(campaign, &span, message, Some(help.to_owned())))
}

/// Requirements that a stage waits for and that nothing in the stages it needs measures: it would never begin.
fn gates_on_nothing(
    campaign: &Campaign,
    procedures: &[Procedure],
    requirements: &Requirements,
) -> Vec<Diagnostic> {
    let mut mistakes = Vec::new();
    for (stage, (id, span)) in campaign.stages.iter().flat_map(|s| s.needs_pass.iter().map(move |n| (s, n))) {
        let Some(requirement) = requirements.get(id) else {
            let help = suggestion_of_few(id, requirements);
            let message = format!("unknown requirement `{id}` in `{}`", campaign.requirements);
            mistakes.push(at(campaign, span, message, help));
            continue;
        };
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
        "no procedure of the campaign yields {measurands}{axis}, which requirement `{}` judges",
        requirement.id
    )
}

fn same_ids(campaign: &Campaign, procedures: &[Procedure]) -> Vec<Diagnostic> {
    let mut mistakes = Vec::new();
    for (index, (procedure, entry)) in procedures.iter().zip(&campaign.procedures).enumerate() {
        let first = procedures[..index].iter().find(|other| other.id == procedure.id);
        if let Some(first) = first {
            let files = format!("`{}` and `{}`", first.source.name, procedure.source.name);
            let message = format!("two procedures have the id `{}`: {files}", procedure.id);
            mistakes.push(at(campaign, &entry.span, message, Some("logs are named after the id".to_owned())));
        }
    }
    mistakes
}

/// The nearest id, or nothing: the list of all would be long.
fn suggestion_of_few(id: &str, requirements: &Requirements) -> Option<String> {
    let near = crate::diagnostic::nearest(id, requirements.all.iter().map(|r| r.id.as_str()))?;
    Some(suggestion(id, [near]))
}

fn at(campaign: &Campaign, span: &Range<usize>, message: String, help: Option<String>) -> Diagnostic {
    mistake_in(&campaign.source, span.clone(), message, help)
}
