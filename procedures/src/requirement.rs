//! Requirements: what is judged, against which limit, by which rule.

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::quantity::Limit;

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
    pub limit: Limit,
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
    /// Measurands that it judges; empty while no kind measures it.
    pub measurands: Vec<String>,
    /// Axis that it belongs to; every axis if `None`.
    pub axis: Option<String>,
    /// Filters; a measurement without the condition passes the filter.
    pub conditions: Vec<Where>,
    /// How several become one.
    pub take: Take,
    /// The limit; `None` for report-only.
    pub limit: Option<Limit>,
    /// A goal beside the limit, reported only.
    pub goal: Option<Limit>,
    /// Decision rule.
    pub rule: Rule,
}

/// All requirements of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirements {
    /// In file order.
    pub all: Vec<Requirement>,
}

impl Requirements {
    /// Parses a requirements file.
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: &SourceFile) -> Result<Self, Vec<Diagnostic>> {
        let _ = source;
        todo!()
    }

    /// The requirement of this id.
    pub fn get(&self, id: &str) -> Option<&Requirement> {
        self.all.iter().find(|r| r.id == id)
    }
}
