//! Who, when, where and how long: the part of a result that depends on the host, the clock and the people.

use serde::{Deserialize, Serialize};

/// Facts of the title page. What is `None` is printed as a dash, and the report is marked DRAFT while a field that
/// a final report needs is missing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TitlePage {
    /// Number of the report.
    pub report_id: Option<String>,
    /// Revision of the report.
    pub revision: Option<String>,
    /// Report that this one replaces, and why.
    pub supersedes: Option<String>,
    /// When it was issued, UTC, ISO 8601.
    pub issued_utc: Option<String>,
    /// Marking, e.g. `company confidential`.
    pub classification: Option<String>,
    /// Who orders.
    pub customer: Option<String>,
    /// Who delivers.
    pub supplier: Option<String>,
    /// Contract or order number.
    pub contract: Option<String>,
    /// Where the test took place.
    pub location: Option<String>,
    /// Part number of the unit under test.
    pub part_number: Option<String>,
    /// Build revision of the unit under test.
    pub unit_revision: Option<String>,
}

/// A device of the bench or the unit, as it identified itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceRecord {
    /// Name in the rig file, e.g. `az-drive`.
    pub name: String,
    /// What it says of itself: maker, model, serial number, firmware.
    pub identity: String,
    /// Whether it may be real: people near it are protected, whatever is proven.
    #[serde(alias = "real")]
    pub may_be_real: bool,
    /// Whether it is proven to be real: evidence speaks of metal only then.
    #[serde(default)]
    pub proven_real: bool,
    /// The grounds for both.
    pub grounds: String,
}

/// An external velocity law of an axis.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LawRecord {
    /// Name of the axis in the rig file.
    pub axis: String,
    /// Name of the law, as its library says.
    pub name: String,
    /// Version of the law, as its library says.
    pub version: String,
    /// The library, as it was named.
    pub file: String,
    /// SHA-256 of the library, hexadecimal.
    pub sha256: String,
    /// Where it was stepped: `in process` or `process of its own`.
    pub hosting: String,
}

/// An instrument of the bench, and what its calibration was worth on the day of the run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InstrumentRecord {
    /// Name in the rig file, e.g. `autocollimator`.
    pub name: String,
    /// What it measures for the bench, e.g. `reference`.
    pub role: String,
    /// Who made it, and which it is.
    pub maker: Option<String>,
    /// Model.
    pub model: Option<String>,
    /// Serial number.
    pub serial_number: Option<String>,
    /// Number of its certificate.
    pub certificate: Option<String>,
    /// Day of its calibration, ISO 8601.
    pub calibrated: Option<String>,
    /// Day until which that holds, ISO 8601.
    pub due: Option<String>,
    /// Uncertainty of the instrument, as the certificate says.
    pub uncertainty: Option<String>,
    /// E.g. `calibrated until 2027-03-01`, `simulated`.
    pub status: String,
}

/// A question to the operator, and what was said.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PromptRecord {
    /// Procedure or stage that asked.
    pub asked_by: String,
    /// Id of the question.
    pub id: String,
    /// `safety` or `info`.
    pub class: String,
    /// The question.
    pub text: String,
    /// The answer.
    pub answer: String,
    /// Who answered.
    pub by: String,
    /// How the answer came to be, e.g. `terminal`.
    pub how: String,
    /// When, UTC, ISO 8601.
    pub utc: String,
}

/// A demand that the customer lets pass for this unit. It never changes a verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WaiverRecord {
    /// Id of the requirement.
    pub requirement: String,
    /// Number of the waiver.
    pub number: String,
    /// Who approved it.
    pub approver: String,
    /// Last day on which it holds, ISO 8601.
    pub expiry: String,
    /// Why, and under which conditions.
    pub reason: String,
}

impl WaiverRecord {
    /// Whether it no longer holds on the day of this UTC time, ISO 8601.
    pub fn has_expired_by(&self, utc: &str) -> bool {
        utc.get(..10).is_some_and(|day| day > self.expiry.as_str())
    }
}

/// One attempt at a procedure; all are kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Id of the procedure.
    pub procedure: String,
    /// Counts from 1.
    pub attempt: u32,
    /// Log inside the run folder.
    pub file: String,
    /// How it ended.
    pub status: super::Status,
    /// Why it was made or how it ended, e.g. a trip with its numbers.
    pub reason: Option<String>,
    /// Duration on the rig as planned, s: the longest that it may take.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planned_s: Option<f64>,
    /// Duration on the rig as it was, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ran_s: Option<f64>,
}

/// A pause of the run that nobody planned.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interruption {
    /// When, UTC, ISO 8601.
    pub utc: String,
    /// What happened.
    pub reason: String,
}

/// One file of the run folder: a line of the raw-data index.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileHash {
    /// Path inside the run folder.
    pub file: String,
    /// Length in bytes.
    pub size_bytes: u64,
    /// Digest, lower-case hexadecimal.
    pub sha256: String,
}

/// Who, when, where and how long.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Name of the run folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// Facts of the title page.
    pub title_page: TitlePage,
    /// Who ran it.
    pub operator: Option<String>,
    /// Serial number of the unit under test.
    pub serial_number: Option<String>,
    /// Bench at which it ran.
    pub station: Option<String>,
    /// Rig file, e.g. `sim`.
    pub rig: Option<String>,
    /// Start, UTC, ISO 8601.
    pub started_utc: Option<String>,
    /// End, UTC, ISO 8601.
    pub ended_utc: Option<String>,
    /// Duration by the wall clock, s.
    pub wall_s: f64,
    /// Time that passed on the rig, s.
    pub simulated_s: f64,
    /// Processor time of the whole process, s.
    pub cpu_s: f64,
    /// Simulated seconds a second of processor time.
    pub speed_factor: Option<f64>,
    /// Points that ran at the same time.
    pub jobs: usize,
    /// How the program was called.
    pub command_line: String,
    /// Version of the program.
    pub software_version: String,
    /// Commit that it was built from, with `-dirty` where the tree was changed.
    pub git_commit: Option<String>,
    /// Target, processor features and anything else that moves the last bits of a number.
    pub numeric_profile: Option<String>,
    /// Devices with their identity.
    pub devices: Vec<DeviceRecord>,
    /// External velocity laws; empty where all laws were built in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laws: Vec<LawRecord>,
    /// Instruments with their calibration.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instruments: Vec<InstrumentRecord>,
    /// Attempts, all of them.
    pub attempts: Vec<Attempt>,
    /// Questions to the operator with their answers, in the order in which they were asked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prompts: Vec<PromptRecord>,
    /// Waivers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waivers: Vec<WaiverRecord>,
    /// What the ticking thread asked of the operating system; empty where time was virtual.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grants: Vec<super::Grant>,
    /// How late ticks came, for each point and for the time between points; empty where time was virtual.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lateness: Vec<super::LatenessRecord>,
    /// Pauses that nobody planned.
    pub interruptions: Vec<Interruption>,
    /// Raw-data index.
    pub files: Vec<FileHash>,
}

impl RunRecord {
    /// The waivers of a requirement.
    pub fn waivers_of<'a>(&'a self, requirement: &'a str) -> impl Iterator<Item = &'a WaiverRecord> {
        self.waivers.iter().filter(move |w| w.requirement == requirement)
    }

    /// Whether a waiver no longer holds on the day of the report: of its issue, else of the end of the run.
    pub fn has_expired(&self, waiver: &WaiverRecord) -> bool {
        let days = [&self.title_page.issued_utc, &self.ended_utc, &self.started_utc];
        days.into_iter().flatten().next().is_some_and(|utc| waiver.has_expired_by(utc))
    }

    /// The last attempt at a procedure.
    pub fn attempt_at(&self, procedure: &str) -> Option<&Attempt> {
        self.attempts.iter().rev().find(|a| a.procedure == procedure)
    }

    /// Names of the fields without which no final report is issued and that are missing here.
    pub fn missing_for_final(&self) -> Vec<&'static str> {
        let page = &self.title_page;
        [
            ("report number", page.report_id.is_none()),
            ("revision", page.revision.is_none()),
            ("date of issue", page.issued_utc.is_none()),
            ("part number", page.part_number.is_none()),
            ("serial number", self.serial_number.is_none()),
            ("unit revision", page.unit_revision.is_none()),
            ("station", self.station.is_none()),
            ("operator", self.operator.is_none()),
            ("start", self.started_utc.is_none()),
            ("end", self.ended_utc.is_none()),
        ]
        .into_iter()
        .filter_map(|(name, missing)| missing.then_some(name))
        .collect()
    }
}
