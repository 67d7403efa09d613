//! Requirements: what is judged, against which limit, by which rule.

use crate::condition::Meets;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::quantity::Limit;
use crate::table::{Field, SCHEMA_FIELD, Shape};

mod band;
mod cover;
mod read;
#[cfg(test)]
mod tests;

pub use band::{Band, Mask};
pub(crate) use cover::ANGLE;
pub use cover::Cover;

/// Decision rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Simple acceptance, shared risk.
    Simple,
    /// Guard band w = 1.65 u (ISO 14253-1 default, 95 %).
    GuardedNinetyFive,
    /// Guard band w = U = k·u with k = t(0.97725, ν) (ILAC-G8:09/2019).
    GuardedU,
}

/// How several measurements become one verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Take {
    /// The worst verdict counts, and among equals the smallest margin.
    Worst,
}

/// Only measurements whose condition meets this are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Where {
    /// Name of a condition, e.g. `velocity`.
    pub condition: String,
    /// What it must meet.
    pub meets: Meets,
}

/// One measurand that a requirement judges, and against what.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Name of the measurand; a requirement judges each at most once.
    pub measurand: String,
    /// The limit of everything that no band and no mask covers; `None`: that is only reported.
    pub limit: Option<Limit>,
    /// Limits that hold under conditions only; no two of them can be met at once.
    pub bands: Vec<Band>,
    /// A limit along a condition.
    pub mask: Option<Mask>,
    /// A goal beside the limit, reported only.
    pub goal: Option<Limit>,
    /// Decision rule.
    pub rule: Rule,
}

/// One requirement.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// E.g. `FRC-AZ`.
    pub id: String,
    /// What it demands, one sentence.
    pub text: String,
    /// Section of the study, e.g. `2.1.1, 3.1.1.1`.
    pub source: String,
    /// `test`, `analysis`, `inspection` or `demonstration`.
    pub method: String,
    /// Measurands that it judges, each with its limit and rule; empty while no kind measures it.
    pub judges: Vec<Judged>,
    /// All limits as written, for printing; empty for report-only.
    pub limit_text: String,
    /// Goals as written, for printing.
    pub goal_text: Option<String>,
    /// Axis that it belongs to; every axis if `None`.
    pub axis: Option<String>,
    /// Filters; a measurement without the condition passes the filter.
    pub conditions: Vec<Where>,
    /// Axes on each of which it must have been measured; empty: those on which it was.
    pub axes: Vec<String>,
    /// Stretches of conditions, or of angles of the axis, that the measurements must cover, on each axis.
    pub covers: Vec<Cover>,
    /// Where the evidence lies, for one that is shown by analysis or inspection instead of a measurement.
    pub evidence: Option<String>,
    /// How several become one.
    pub take: Take,
    /// Decision rule, unless a measurand has its own.
    pub rule: Rule,
}

/// All requirements of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirements {
    /// In file order.
    pub all: Vec<Requirement>,
}

impl Rule {
    /// Name in requirement files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Simple => "simple",
            Self::GuardedNinetyFive => "guarded-1.65u",
            Self::GuardedU => "guarded-u",
        }
    }
}

impl Requirement {
    /// What it says about this measurand, if it judges it.
    pub fn judged(&self, measurand: &str) -> Option<&Judged> {
        self.judges.iter().find(|j| j.measurand == measurand)
    }

    /// Whether it is shown by analysis or inspection, with a place for the evidence.
    pub fn is_declared(&self) -> bool {
        self.judges.is_empty() && self.evidence.is_some()
    }

    /// Whether anything that it judges has a limit: without one it never gets a verdict.
    pub fn is_limited(&self) -> bool {
        self.judges.iter().any(|j| j.limit.is_some() || !j.bands.is_empty() || j.mask.is_some())
    }

    /// Names of the measurands that it judges.
    pub fn measurands(&self) -> impl Iterator<Item = &str> + Clone {
        self.judges.iter().map(|j| j.measurand.as_str())
    }
}

const RULES: Shape = Shape::Choice(&["simple", "guarded-1.65u", "guarded-u"]);

const ALLOWANCE: &str =
    "How near to the limit still counts as meeting it, in the measurand's quantity; state it in `text`.";

/// Keys of a limit under conditions.
const BAND: &[Field] = &[
    Field::required(
        "where",
        Shape::Map(&Shape::Texts),
        "Where the limit applies, e.g. `{ elevation = \"-10 deg .. 20 deg\" }`.",
    ),
    Field::required("limit", Shape::Text, "Limit there."),
];

/// Keys of a limit along a condition.
const MASK: &[Field] = &[
    Field::required("over", Shape::Text, "Condition that the limit depends on, e.g. `frequency`."),
    Field::required("at", Shape::Texts, "Corner points of the mask, ascending, e.g. `[\"1 Hz\", \"3 Hz\"]`."),
    Field::required(
        "limit",
        Shape::Texts,
        "Limit at each corner point; linear over the logarithm of the condition between them.",
    ),
];

/// Keys of one measurand with a limit of its own, `[[requirement.judge]]`.
const JUDGE: &[Field] = &[
    Field::required("measurand", Shape::Text, "Name of the measurand."),
    Field::optional("limit", Shape::Text, "Limit in the measurand's quantity; report-only without one."),
    Field::optional("allowance", Shape::Text, ALLOWANCE),
    Field::optional("goal", Shape::Text, "Goal in addition to the limit; reported only."),
    Field::optional("rule", RULES, "Decision rule of this measurand instead of the requirement's."),
    Field::optional("bands", Shape::Tables(BAND), "Limits that apply only under given conditions."),
    Field::optional("mask", Shape::Table(MASK), "Limit along a condition: a curve mask."),
];

/// Keys of one requirement.
const REQUIREMENT: &[Field] = &[
    Field::required("id", Shape::Text, "Unique name, e.g. `FRC-AZ`."),
    Field::required("text", Shape::Text, "What is required, in one sentence."),
    Field::required("source", Shape::Text, "Source of the requirement, e.g. a section number."),
    Field::required(
        "method",
        Shape::Choice(&["test", "analysis", "inspection", "demonstration"]),
        "Verification method.",
    ),
    Field::optional(
        "measurand",
        Shape::Texts,
        "Measurands that it judges; absent while no kind measures it.",
    ),
    Field::optional("axis", Shape::Text, "Axis that it applies to; default: every axis."),
    Field::optional(
        "where",
        Shape::Map(&Shape::Texts),
        "Only measurements under these conditions: a limit, a range, or a list of values.",
    ),
    Field::optional("axes", Shape::Texts, "Axes on which it must be measured."),
    Field::optional(
        "covers",
        Shape::Tables(cover::FIELDS),
        "Ranges of conditions, or of angles of the axis, that the measurements must cover on each axis; otherwise there is no verdict.",
    ),
    Field::default(
        "take",
        Shape::Choice(&["worst"]),
        "worst",
        "How several measurements are combined into one verdict.",
    ),
    Field::optional("limit", Shape::Text, "Limit, in the quantity of the measurand."),
    Field::optional("allowance", Shape::Text, ALLOWANCE),
    Field::optional("limit-text", Shape::Text, "Limits in words, while no kind measures it."),
    Field::optional("goal", Shape::Text, "Goal in addition to the limit; reported only."),
    Field::default("rule", RULES, "guarded-u", "Decision rule."),
    Field::optional("judge", Shape::Tables(JUDGE), "Measurands with their own limits."),
    Field::optional(
        "evidence",
        Shape::Text,
        "Where the evidence is found (document, section), for a requirement shown by analysis or inspection.",
    ),
];

/// Keys of a requirements file.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("requirement", Shape::Tables(REQUIREMENT), "Every requirement, `[[requirement]]`."),
];

impl Requirements {
    /// Parses a requirements file.
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: &SourceFile) -> Result<Self, Vec<Diagnostic>> {
        let known: Vec<_> = crate::kinds::KINDS.iter().flat_map(|kind| kind.measurands).copied().collect();
        read::requirements(source, &known)
    }

    /// The requirement of this id.
    pub fn get(&self, id: &str) -> Option<&Requirement> {
        self.all.iter().find(|r| r.id == id)
    }
}
