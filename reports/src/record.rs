//! What a run comes to, as data: findings that any machine reproduces, and the record of who, when and how long.
//!
//! Source of the division: the same seed and the same limits give byte-identical [`Findings`]; whatever depends on
//! the host, the clock or the operator stands in [`RunRecord`].

use procedures::measurement::{Condition, Exclusion, Measurement};
use procedures::trace::Plot;
use procedures::verdict::{Judgement, Outcome, Overall, Verdict};
use serde::{Deserialize, Serialize};

mod evidence;
mod finite;
mod realtime;
mod requirement;
mod run;
mod safety;

pub use evidence::{EvidenceRecord, EvidenceState};
pub use realtime::{Grant, LatenessRecord};
pub use requirement::{ComparatorCode, DecisionRule, JudgedFindings, LimitFindings, RequirementFindings};
pub use run::{
    Attempt, DeviceRecord, FileHash, InstrumentRecord, Interruption, LawRecord, PromptRecord, RunRecord,
    TitlePage, WaiverRecord,
};
pub use safety::{ComputedWorst, NotEnforcedFinding, SafetyFindings, StopFinding, TripFinding};

/// Name and version of the structure of `results.json`.
pub const SCHEMA: &str = "fat-result/1";

/// All that a report is made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// What was found; byte-identical for the same seed, limits and program.
    pub findings: Findings,
    /// Who, when, where and how long.
    pub record: RunRecord,
    /// What a check of the run folder found; `None` in what the run itself wrote, which was checked later.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<EvidenceRecord>,
}

impl Results {
    /// Findings and record under the current schema, with every number finite (see [`Findings::make_finite`]).
    pub fn new(mut findings: Findings, record: RunRecord) -> Self {
        findings.make_finite();
        Self { schema: SCHEMA.to_owned(), findings, record, evidence: None }
    }

    /// The record with what a check of the run folder found.
    pub fn with_evidence(self, evidence: EvidenceRecord) -> Self {
        Self { evidence: Some(evidence), ..self }
    }
}

/// Whether the devices were real.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// Every device was real.
    Real,
    /// At least one device was simulated or not provably real, at least one was real.
    Mixed,
    /// All devices were simulated.
    Simulated,
    /// A record that another tool made.
    Imported,
}

/// How far a procedure or point came. Never a verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the names are the field's words for them")]
pub enum Status {
    Completed,
    Aborted,
    Errored,
    Lost,
    Skipped,
    #[default]
    NotRun,
}

impl Status {
    /// The word as it is printed.
    pub fn word(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Aborted => "aborted",
            Self::Errored => "errored",
            Self::Lost => "lost",
            Self::Skipped => "skipped",
            Self::NotRun => "not run",
        }
    }
}

impl From<procedures::log::PointStatus> for Status {
    fn from(status: procedures::log::PointStatus) -> Self {
        use procedures::log::PointStatus;
        match status {
            PointStatus::Completed => Self::Completed,
            PointStatus::Aborted => Self::Aborted,
            PointStatus::Errored => Self::Errored,
            PointStatus::Lost => Self::Lost,
        }
    }
}

/// Which campaign was run, and from which texts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CampaignFindings {
    /// E.g. `quick`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Only a selection of the campaign was run; the report is headed PARTIAL.
    pub partial: bool,
    /// Procedures that the rig lacks a device for, and what that costs, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Digest of the campaign file, lower-case hexadecimal; `None` where there was no file.
    pub sha256: Option<String>,
    /// Digest of the requirements file, lower-case hexadecimal.
    pub requirements_sha256: Option<String>,
}

/// Everything that the same seed, limits and program reproduce byte for byte.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// The campaign.
    pub campaign: CampaignFindings,
    /// Name of the simulated unit, or how the real one is called.
    pub unit: String,
    /// Real or simulated.
    pub origin: Origin,
    /// Seed of the run.
    pub seed: u64,
    /// What it all comes to.
    pub overall: Overall,
    /// Requirements of the campaign, in the order of the requirements file.
    pub requirements: Vec<RequirementFindings>,
    /// Outcome of each requirement, in the same order.
    pub outcomes: Vec<Outcome>,
    /// Requirements of the file that this campaign does not measure.
    pub not_in_this_campaign: Vec<String>,
    /// Requirements of the file that no kind of experiment measures yet.
    pub no_kind_measures_it_yet: Vec<String>,
    /// Independent estimates of one quantity that are too far apart, a sentence each. Nothing passes with one of them: which
    /// estimate is wrong is not known, and nor is what else it touches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disagreements: Vec<String>,
    /// What the drives do not enforce in the mode that the bench uses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_enforced: Vec<NotEnforcedFinding>,
    /// Procedures in the order of the campaign.
    pub procedures: Vec<ProcedureFindings>,
}

impl Findings {
    /// The requirement of this id.
    pub fn requirement(&self, id: &str) -> Option<&RequirementFindings> {
        self.requirements.iter().find(|r| r.id == id)
    }

    /// The outcome of the requirement of this id.
    pub fn outcome(&self, id: &str) -> Option<&Outcome> {
        self.outcomes.iter().find(|o| o.requirement == id)
    }

    /// The procedure and measurement that decided an outcome, by the name of the procedure and the judgement.
    pub fn deciding<'a>(
        &'a self,
        decided_by: &'a (String, Judgement),
    ) -> Option<(&'a ProcedureFindings, &'a Measurement, &'a Judgement)> {
        let (id, judgement) = decided_by;
        let procedure = self.procedures.iter().find(|p| p.id == *id)?;
        Some((procedure, procedure.measurements.get(judgement.measurement)?, judgement))
    }

    /// The measurement that a judgement of this procedure speaks of.
    pub(crate) fn deciding_of(&self, procedure: &str, judgement: &Judgement) -> Option<&Measurement> {
        let procedure = self.procedures.iter().find(|p| p.id == procedure)?;
        procedure.measurements.get(judgement.measurement)
    }
}

/// What one procedure found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProcedureFindings {
    /// E.g. `AZ-FRICTION`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Name of its kind.
    pub kind: String,
    /// Axis that it moved.
    pub axis: String,
    /// Stage of the campaign that it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Build state of the unit before the final one: what was measured in it is reported, not judged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// The kind's documentation: what it finds, how it excites and computes, when it fails, source.
    pub method: String,
    /// How far it came.
    pub status: Status,
    /// The worst of its judgements.
    pub verdict: Verdict,
    /// Log inside the run folder; `None` if there is none.
    pub log: Option<String>,
    /// Digest of the log in results of earlier versions, lower-case hexadecimal; now it stands in the record alone
    /// ([`RunRecord::files`]): a log says when it was made.
    #[serde(default, skip_serializing)]
    pub log_sha256: Option<String>,
    /// Points in the order of the plan.
    pub points: Vec<PointRow>,
    /// All measurements.
    pub measurements: Vec<Measurement>,
    /// All judgements; they refer to `measurements` by index.
    pub judgements: Vec<Judgement>,
    /// Pictures over points, and of points.
    pub plots: Vec<Plot>,
    /// What the reader should know, e.g. what was not determined.
    pub remarks: Vec<String>,
    /// Trips, stops, and how the axes were left; `None` in results that were written before it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub safety: Option<SafetyFindings>,
}

impl ProcedureFindings {
    /// The judgements of the measurement of this index.
    pub fn judgements_of(&self, measurement: usize) -> impl Iterator<Item = &Judgement> {
        self.judgements.iter().filter(move |j| j.measurement == measurement)
    }
}

/// One point of a procedure: one row of its table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointRow {
    /// Name of the point, e.g. `velocity=10 deg/s`.
    pub point: String,
    /// How it ended.
    pub status: Status,
    /// The worst of the judgements of its measurements.
    pub verdict: Verdict,
    /// Conditions, asked for and reached.
    pub conditions: Vec<Condition>,
    /// Indices of its measurements in the procedure's list.
    pub measurements: Vec<usize>,
    /// What was left out.
    pub excluded: Vec<Exclusion>,
    /// Why it gives no numbers, or how it ended early.
    pub reason: Option<String>,
}

impl PointRow {
    /// The row of a point, its conditions and verdict collected from the measurements that name it.
    pub fn collect(
        point: &str,
        status: Status,
        excluded: Vec<Exclusion>,
        reason: Option<String>,
        measurements: &[Measurement],
        judgements: &[Judgement],
    ) -> Self {
        let own: Vec<usize> =
            (0..measurements.len()).filter(|&i| measurements[i].point.as_deref() == Some(point)).collect();
        let mut conditions: Vec<Condition> = Vec::new();
        for condition in own.iter().flat_map(|&i| &measurements[i].conditions) {
            if conditions.iter().all(|c| c.name != condition.name) {
                conditions.push(condition.clone());
            }
        }
        let verdict = judgements
            .iter()
            .filter(|j| own.contains(&j.measurement))
            .map(|j| j.verdict)
            .max()
            .unwrap_or(Verdict::None);
        Self { point: point.to_owned(), status, verdict, conditions, measurements: own, excluded, reason }
    }
}

#[cfg(test)]
mod tests;
