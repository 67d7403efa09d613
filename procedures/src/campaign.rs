//! A campaign file: which procedures, in which order, and which requirements must get a verdict.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::condition;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::procedure::Subset;
use crate::requirement::Requirements;
use crate::table::{Field, SCHEMA_FIELD, Shape, TableReader, read_file};

mod check;
mod stage;
#[cfg(test)]
mod tests;

pub use check::check;
pub use stage::{FINAL, Stage};

/// One procedure of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// File as written.
    pub file: String,
    /// Points to keep; all if empty.
    pub points: Vec<Subset>,
    /// Index of its stage; `None` in a campaign without stages.
    pub stage: Option<usize>,
    /// Where it stands in the campaign file, for diagnostics.
    pub span: Range<usize>,
}

/// What a campaign claims for what it measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Claim {
    /// Requirements are verified over all that they claim; what was not covered is inconclusive.
    #[default]
    Acceptance,
    /// A first look: what was not covered has no verdict, a shortfall fails all the same. Nothing is accepted by it.
    Screening,
}

/// A campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// E.g. `quick`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Requirements file as written.
    pub requirements: String,
    /// Where that stands in the campaign file, for diagnostics.
    pub requirements_span: Range<usize>,
    /// Requirements without which it is incomplete.
    pub demanded: Demanded,
    /// What it claims.
    pub claim: Claim,
    /// Stages in order; empty in a campaign without any.
    pub stages: Vec<Stage>,
    /// Procedures in order: stage by stage, and within one as they stand in the file.
    pub procedures: Vec<Entry>,
    /// The file.
    pub source: SourceFile,
}

/// Which requirements must get a verdict; each with its place in the campaign file, for diagnostics.
#[derive(Clone, Debug, PartialEq)]
pub enum Demanded {
    /// Those that `must-measure` names.
    Listed(Vec<(String, Range<usize>)>),
    /// Every one that is not declared: `coverage = "full"`.
    All(Range<usize>),
}

/// Kinds differ from condition to condition, so values are read as texts.
const ENTRY: &[Field] = &[
    Field::required(
        "file",
        Shape::Text,
        "Procedure file, relative to the campaign; `shipped:quick/az-friction.toml` for one that comes \
         with the program.",
    ),
    Field::optional(
        "points",
        Shape::Map(&Shape::Texts),
        "Points to run, e.g. `{ velocity = [\"10 deg/s\"] }`.",
    ),
    Field::optional(
        "stage",
        Shape::Text,
        "Stage that it belongs to; required where the campaign has stages.",
    ),
];

/// Keys of a campaign file.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name, e.g. `quick`."),
    Field::required("title", Shape::Text, "Heading in the report."),
    Field::required(
        "requirements",
        Shape::Text,
        "Requirements file, relative to the campaign; `shipped:requirements.toml` for the one that comes \
         with the program.",
    ),
    Field::optional(
        "must-measure",
        Shape::Texts,
        "Requirements without which the campaign is incomplete; required unless `coverage` is `full`.",
    ),
    Field::default(
        "coverage",
        Shape::Choice(&["any", "full"]),
        "any",
        "`full`: every requirement must be measured, except those that are declared (`evidence`).",
    ),
    Field::default(
        "claim",
        Shape::Choice(&["acceptance", "screening"]),
        "acceptance",
        "`screening`: a first look; a requirement that was not measured over its whole claimed range gets \
         no verdict, and nothing is accepted.",
    ),
    Field::optional(
        "stage",
        Shape::Tables(stage::FIELDS),
        "Stages in order, `[[stage]]`; on simulated devices stages that do not need each other may run at \
         the same time.",
    ),
    Field::required(
        "procedure",
        Shape::Tables(ENTRY),
        "Procedures in order, `[[procedure]]`; those of an earlier stage come first.",
    ),
];

impl Campaign {
    /// Parses a campaign file (without opening the files it names).
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: SourceFile) -> Result<Self, Vec<Diagnostic>> {
        let unnamed = read_file(&source, FIELDS, |table| {
            table.schema();
            let id = table.text("id");
            let title = table.text("title");
            let requirements = table.text("requirements");
            let requirements_span = table.span("requirements");
            let demanded = demanded(table);
            let claim = match table.text("claim").as_deref() {
                Some("screening") => Claim::Screening,
                _ => Claim::Acceptance,
            };
            let stages = table.tables("stage", stage::read);
            // Stages that could not be read are no unknown ones.
            let unread = stages.is_none() && table.has("stage");
            let stages = stages.unwrap_or_default();
            let mut procedures = table.tables("procedure", entry);
            if procedures.as_ref().is_some_and(Vec::is_empty) && table.mistakes() == 0 {
                table.mistake("procedure", "the campaign has no procedure", None);
            }
            if let Some(entries) = procedures.as_mut().filter(|_| !unread) {
                stage::settle(table, &stages, entries);
                entries.sort_by_key(|(entry, _)| entry.stage);
            }
            let source = SourceFile::new("", "");
            Some(Self {
                id: id?,
                title: title?,
                requirements: requirements?,
                requirements_span,
                demanded: demanded?,
                claim,
                stages,
                procedures: procedures?.into_iter().map(|(entry, _)| entry).collect(),
                source,
            })
        })?;
        Ok(Self { source, ..unnamed })
    }

    /// Ids of the requirements that must get a verdict, of those that the campaign's requirements file holds.
    pub fn must_measure(&self, requirements: &Requirements) -> Vec<String> {
        match &self.demanded {
            Demanded::Listed(listed) => listed.iter().map(|(id, _)| id.clone()).collect(),
            Demanded::All(_) => {
                requirements.all.iter().filter(|r| !r.is_declared()).map(|r| r.id.clone()).collect()
            }
        }
    }

    /// Whether what this procedure measures is judged: in an earlier build state it is only reported.
    pub fn is_judged(&self, entry: &Entry) -> bool {
        entry.stage.and_then(|index| self.stages.get(index)).is_none_or(Stage::is_final)
    }

    /// Whether a procedure belongs to a stage that this one needs, directly or through others.
    pub fn is_needed(&self, stage: &Stage, entry: &Entry) -> bool {
        let Some(index) = entry.stage else { return false };
        let Some(of) = self.stages.get(index) else { return false };
        stage.needs.iter().any(|(id, _)| {
            let through = self.stages.iter().find(|s| s.id == *id);
            *id == of.id || through.is_some_and(|through| self.is_needed(through, entry))
        })
    }
}

fn demanded(table: &mut TableReader<'_>) -> Option<Demanded> {
    let listed = table.spanned_texts("must-measure");
    let is_full = table.text("coverage").is_some_and(|text| text == "full");
    match listed {
        Some(_) if is_full => {
            let message = "`coverage = \"full\"` demands every requirement, and `must-measure` only these";
            table.mistake("must-measure", message, Some("remove one of the two keys".to_owned()));
            None
        }
        Some(listed) => Some(Demanded::Listed(listed)),
        None if is_full => Some(Demanded::All(table.span("coverage"))),
        None if table.has("must-measure") => None,
        None => {
            let help = "name the requirements, `[]` for none, or write `coverage = \"full\"`";
            table.mistake("must-measure", "missing key `must-measure`", Some(help.to_owned()));
            None
        }
    }
}

fn entry(table: &mut TableReader<'_>) -> Option<(Entry, stage::Named)> {
    let file = table.text("file");
    let named = table.text("stage").map(|id| (id, table.span("stage")));
    let subset = |entry: crate::table::MapEntry, table: &mut TableReader<'_>| {
        let values = condition::read_values(table, &entry)?;
        Some(Subset { condition: entry.key, values })
    };
    let entries = table.lists("points").unwrap_or_default();
    let points = entries.into_iter().filter_map(|entry| subset(entry, table)).collect();
    Some((Entry { file: file?, points, stage: None, span: table.span("file") }, named))
}
