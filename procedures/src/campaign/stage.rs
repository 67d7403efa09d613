//! Stages of a campaign: what belongs together, in which order, in which build state, and what must have come out before.

use std::ops::Range;

use super::Entry;
use crate::procedure::{PROMPT_FIELDS, Prompt, PromptClass, is_harmless, read_prompts};
use crate::quantity::QuantityKind;
use crate::table::{Field, Shape, TableReader, quoted, suggestion};

/// The build state in which requirements are verified: the unit as it is delivered.
pub const FINAL: &str = "final";

/// A stage of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// E.g. `range`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Build state that its prompts bring, e.g. `azimuth-table`; the final one if `None`.
    pub state: Option<String>,
    /// Inertia about axes in this build state, kg·m², by name of the axis, where it is not the rig's.
    pub inertia_kg_m2: Vec<(String, f64)>,
    /// Stages whose procedures must all have completed before any of this one begins, each with its place in the file.
    pub needs: Vec<(String, Range<usize>)>,
    /// Requirements that those stages must not have left without a pass, each with its place in the file.
    pub needs_pass: Vec<(String, Range<usize>)>,
    /// Questions before its first procedure.
    pub prompts: Vec<Prompt>,
    /// Where its id stands in the file.
    pub span: Range<usize>,
}

impl Stage {
    /// Whether its procedures run on the unit as it is delivered: only those are judged.
    pub fn is_final(&self) -> bool {
        self.state.as_deref().is_none_or(|state| state == FINAL)
    }
}

/// Keys of a `[[stage]]`.
pub(super) const FIELDS: &[Field] = &[
    Field::required("id", Shape::Text, "Name that procedures, `needs` and `--select` use, e.g. `range`."),
    Field::required("title", Shape::Text, "Heading."),
    Field::optional(
        "state",
        Shape::Text,
        "Build state that a safety prompt of the stage asks for, e.g. `azimuth-table`. Default: `final`, \
         the only one whose results are judged.",
    ),
    Field::optional(
        "inertia",
        Shape::Map(&Shape::Text),
        "Inertia about an axis in this build state, e.g. `{ az = \"640 kg*m^2\" }`; the gains of its loops \
         are scaled with it.",
    ),
    Field::optional(
        "needs",
        Shape::Texts,
        "Earlier stages; this stage is skipped unless all their procedures completed.",
    ),
    Field::optional(
        "needs-pass",
        Shape::Texts,
        "Requirements; this stage is skipped unless they pass with the measurements of the stages in `needs`.",
    ),
    Field::optional(
        "prompt",
        Shape::Tables(PROMPT_FIELDS),
        "Questions to the operator before its first procedure, `[[stage.prompt]]`.",
    ),
];

/// Reads one `[[stage]]`.
pub(super) fn read(table: &mut TableReader<'_>) -> Option<Stage> {
    let id = table.text("id");
    let title = table.text("title");
    let state = table.text("state");
    let inertia_kg_m2 = inertia(table);
    let needs = table.spanned_texts("needs").unwrap_or_default();
    let needs_pass = table.spanned_texts("needs-pass").unwrap_or_default();
    let prompts = read_prompts(table);
    if id.as_deref().is_some_and(|id| !is_harmless(id)) {
        table.mistake("id", "`id` of a stage: letters, digits, `-` and `_`, such as `range`", None);
    }
    if state.is_some() && !prompts.iter().any(|prompt| prompt.class == PromptClass::Safety) {
        let help = "add a `[[stage.prompt]]` of class `safety`: the operator must set up the build state \
                    and confirm it";
        table.mistake(
            "state",
            "a stage with a build state does not ask the operator for it",
            Some(help.to_owned()),
        );
    }
    if state.is_none() && !inertia_kg_m2.is_empty() {
        let help =
            "name the build state as `state`, or remove `inertia` to use that of the rig file".to_owned();
        table.mistake("inertia", "`inertia` is given for the final build state", Some(help));
    }
    if !needs_pass.is_empty() && needs.is_empty() {
        let help = "name the stages that measure the requirement in `needs`".to_owned();
        table.mistake("needs-pass", "`needs-pass` without `needs`", Some(help));
    }
    let span = table.span("id");
    Some(Stage { id: id?, title: title?, state, inertia_kg_m2, needs, needs_pass, prompts, span })
}

fn inertia(table: &mut TableReader<'_>) -> Vec<(String, f64)> {
    let mut all = Vec::new();
    for (axis, text, span) in table.map("inertia").unwrap_or_default() {
        match QuantityKind::Inertia.parse(&text) {
            Ok(value) if value > 0.0 => all.push((axis, value)),
            Ok(_) => table.mistake_at(span, format!("`{axis}`: the inertia must be positive"), None),
            Err(error) => table.mistake_at(span, format!("`{axis}`: {error}"), error.help()),
        }
    }
    all
}

/// Mistakes in how stages and procedures fit together; gives each entry the index of its stage.
pub(super) fn settle(table: &mut TableReader<'_>, stages: &[Stage], entries: &mut [(Entry, Named)]) {
    twice(table, stages);
    for (index, stage) in stages.iter().enumerate() {
        needs(table, &stages[..index], stage);
    }
    states(table, stages);
    for (entry, named) in entries.iter_mut() {
        entry.stage = place(table, stages, &entry.span, named);
    }
    for (index, stage) in stages.iter().enumerate() {
        if entries.iter().all(|(entry, _)| entry.stage != Some(index)) && table.mistakes() == 0 {
            let help = format!("give a `[[procedure]]` with `stage = \"{}\"`, or remove the stage", stage.id);
            table.mistake_at(
                stage.span.clone(),
                format!("no procedure belongs to stage `{}`", stage.id),
                Some(help),
            );
        }
    }
}

/// The stage that an entry names, with its place in the file.
pub(super) type Named = Option<(String, Range<usize>)>;

fn place(
    table: &mut TableReader<'_>,
    stages: &[Stage],
    entry: &Range<usize>,
    named: &Named,
) -> Option<usize> {
    let ids = || stages.iter().map(|stage| stage.id.as_str());
    match named {
        None if stages.is_empty() => None,
        None => {
            let help = format!("add `stage = \"…\"`; the stages are {}", quoted(ids()));
            table.mistake_at(
                entry.clone(),
                "the campaign has stages, but this procedure belongs to none",
                Some(help),
            );
            None
        }
        Some((id, span)) => {
            let found = stages.iter().position(|stage| stage.id == *id);
            if found.is_none() {
                let help = suggestion(id, ids().collect::<Vec<_>>());
                table.mistake_at(span.clone(), format!("unknown stage `{id}`"), Some(help));
            }
            found
        }
    }
}

fn twice(table: &mut TableReader<'_>, stages: &[Stage]) {
    for (index, stage) in stages.iter().enumerate() {
        if stages[..index].iter().any(|other| other.id == stage.id) {
            table.mistake_at(stage.span.clone(), format!("two stages have the id `{}`", stage.id), None);
        }
        for prompt in &stage.prompts {
            if stages[..index].iter().flat_map(|s| &s.prompts).any(|other| other.id == prompt.id) {
                let message = format!("two stages have a prompt with the id `{}`", prompt.id);
                let help = Some("answers are assigned by id: rename one".to_owned());
                table.mistake_at(stage.span.clone(), message, help);
            }
        }
    }
}

/// What a stage needs comes before it: so no two can wait for each other.
fn needs(table: &mut TableReader<'_>, before: &[Stage], stage: &Stage) {
    for (id, span) in &stage.needs {
        if before.iter().all(|other| other.id != *id) {
            let message = format!("stage `{}` needs `{id}`, which is not an earlier stage", stage.id);
            let help = suggestion(id, before.iter().map(|s| s.id.as_str()).collect::<Vec<_>>());
            table.mistake_at(span.clone(), message, Some(help));
        }
    }
}

/// Nobody brings the unit back by itself: after another build state a stage must say which one it has.
fn states(table: &mut TableReader<'_>, stages: &[Stage]) {
    let mut now: &str = FINAL;
    for stage in stages {
        match &stage.state {
            Some(state) => now = state,
            None if now == FINAL => {}
            None => {
                let message = format!(
                    "stage `{}` follows a stage with build state `{now}` but names no build state",
                    stage.id
                );
                let help = format!("add `state = \"{FINAL}\"` and a safety prompt that asks for it");
                table.mistake_at(stage.span.clone(), message, Some(help));
                now = FINAL;
            }
        }
    }
}

#[cfg(test)]
mod tests;
