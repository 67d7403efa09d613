//! Requirements whose `where` no planned point meets: they would end without a verdict, long after the mistake was made.

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::measurement::Condition;
use procedures::requirement::{Requirement, Requirements, Where};

use super::PlannedProcedure;
use super::select::serves;

/// Every filter of the requirements that must be measured which nothing that is planned passes.
pub(super) fn met_nowhere(
    requirements: &Requirements,
    source: &SourceFile,
    must_measure: &[String],
    procedures: &[PlannedProcedure],
) -> Vec<Diagnostic> {
    let asked = requirements.all.iter().filter(|requirement| must_measure.contains(&requirement.id));
    let mut all = Vec::new();
    for requirement in asked {
        for (filter, measurand) in
            requirement.conditions.iter().flat_map(|f| requirement.measurands().map(move |m| (f, m)))
        {
            all.extend(mistake(requirement, filter, measurand, source, procedures));
        }
    }
    all
}

fn mistake(
    requirement: &Requirement,
    filter: &Where,
    measurand: &str,
    source: &SourceFile,
    procedures: &[PlannedProcedure],
) -> Option<Diagnostic> {
    let yields = |planned: &&PlannedProcedure| {
        serves(&planned.procedure, requirement) && planned.procedure.yields.contains(&measurand)
    };
    let mut asked: Vec<Condition> = Vec::new();
    for case in procedures.iter().filter(yields).flat_map(|planned| &planned.cases) {
        // What was not asked for under the condition passes the filter.
        let request = case.requested.iter().find(|request| request.name == filter.condition)?;
        let (name, kind, requested) = (request.name.clone(), request.kind, request.value);
        asked.push(Condition { name, requested, achieved: None, kind });
    }
    if asked.is_empty() || asked.iter().any(|condition| filter.meets.holds(condition)) {
        return None;
    }
    let mut values: Vec<String> = asked.iter().map(|c| c.kind.format(c.requested)).collect();
    values.dedup();
    let message = format!(
        "requirement `{}` counts `{measurand}` only from points with {} {}, but no such point is planned",
        requirement.id,
        filter.condition,
        filter.meets.text()
    );
    let help = format!("points are planned at {}; correct `where`, or add points", values.join(", "));
    Some(at_requirement(Diagnostic::new(message).help(help), source, &requirement.id))
}

/// The mistake at the id of a requirement in its file.
fn at_requirement(mistake: Diagnostic, source: &SourceFile, id: &str) -> Diagnostic {
    let quoted = format!("\"{id}\"");
    match source.text.find(&format!("id = {quoted}")) {
        Some(start) => mistake.at(source, start + 5..start + 5 + quoted.len()),
        None => mistake.in_file(source),
    }
}
