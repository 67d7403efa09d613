//! `run.json`: the title page of a run folder, written before anything moves.

use std::path::Path;

use reports::record::{DeviceRecord, FileHash, InstrumentRecord, Origin, TitlePage};
use serde::{Deserialize, Serialize};

use crate::durable;
use crate::files::bounded;
use crate::files::unit::Unit;
use crate::journal::sha256;
use crate::model::rig::Rig;
use crate::plan::CampaignPlan;
use crate::polarity::Basis;

/// File name in the run folder.
pub const FILE: &str = "run.json";

/// A text that the run was made from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptFile {
    /// Name as it was found.
    pub name: String,
    /// Its text, verbatim.
    pub text: String,
}

/// A procedure of the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedLog {
    /// Id.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Name of its kind.
    pub kind: String,
    /// Axis that it moves.
    pub axis: String,
    /// Log in the run folder.
    pub log: String,
    /// Measurands that it yields.
    pub yields: Vec<String>,
    /// Whether any of its points closes a loop: it then needs polarity.
    #[serde(default)]
    pub closes_loops: bool,
    /// Id of its stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Build state of the unit; `None` for the final one, the only one that is judged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// Longest duration of all its points, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planned_s: Option<f64>,
}

/// A stage of the run: what must have come out before it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PageStage {
    /// Id.
    pub id: String,
    /// Heading.
    pub title: String,
    /// The file of its build state; `None` for the final one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<KeptFile>,
    /// Stages whose procedures must have completed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needs: Vec<String>,
    /// Requirements that these must have passed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needs_pass: Vec<String>,
}

/// The title page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Page {
    /// Version of this structure.
    pub schema: u32,
    /// Campaign id.
    pub campaign: String,
    /// Heading.
    pub title: String,
    /// Only a part of a campaign.
    pub partial: bool,
    /// Procedures that the rig lacks a device for, and what that costs, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Campaign file.
    pub campaign_file: Option<KeptFile>,
    /// Requirements file.
    pub requirements: KeptFile,
    /// Ids that must get a verdict.
    pub must_measure: Vec<String>,
    /// Rig file.
    pub rig: KeptFile,
    /// Name of the rig.
    pub rig_id: String,
    /// Name of the simulated unit, or what the real one is called.
    pub unit: String,
    /// Unit files, the unit's own first; empty for a real one.
    pub unit_files: Vec<KeptFile>,
    /// Seed.
    pub seed: u64,
    /// Derived from the devices, never read from a file.
    pub origin: Origin,
    /// Devices, with the grounds for real or simulated.
    pub devices: Vec<DeviceRecord>,
    /// What polarity is or was proven of.
    #[serde(default)]
    pub polarity: Basis,
    /// Stages in order; empty where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<PageStage>,
    /// Procedures in order.
    pub procedures: Vec<PlannedLog>,
    /// Instruments of the bench with what their calibration was worth on the day.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instruments: Vec<InstrumentRecord>,
    /// Facts for the report's title page.
    pub title_page: TitlePage,
    /// Who runs it.
    pub operator: Option<String>,
    /// Serial number of the unit under test.
    pub serial_number: Option<String>,
    /// How the program was called.
    pub command_line: String,
    /// Jobs at a time.
    pub jobs: usize,
    /// Start by the wall clock.
    pub started_utc: String,
}

impl Page {
    /// Writes it into a run folder; gives what there is now.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, folder: &Path) -> std::io::Result<FileHash> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        durable::write(&folder.join(FILE), text.as_bytes())?;
        let (size_bytes, sha256) = (text.len() as u64, sha256(text.as_bytes()));
        Ok(FileHash { file: FILE.to_owned(), size_bytes, sha256 })
    }

    /// Reads it from a run folder.
    ///
    /// # Errors
    /// As text, with the file's name: when it is missing or not one.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(FILE);
        let text = bounded::read_to_string(&path, bounded::MOST_RECORD_BYTES)
            .map_err(|e| format!("{}: cannot be read: {e}; is this a run folder?", path.display()))?;
        serde_json::from_str(&text).map_err(|e| format!("{}: not a title page: {e}", path.display()))
    }

    /// Files that a run is made from, by campaign, rig and unit.
    pub fn kept_files(
        plan: &CampaignPlan,
        rig: &Rig,
        unit: &Unit,
    ) -> (Option<KeptFile>, KeptFile, KeptFile, Vec<KeptFile>) {
        let keep =
            |s: &procedures::diagnostic::SourceFile| KeptFile { name: s.name.clone(), text: s.text.clone() };
        (
            plan.source.as_ref().map(keep),
            keep(&plan.requirements_source),
            keep(&rig.source),
            unit.sources.iter().map(keep).collect(),
        )
    }

    /// The procedures of a plan with the names of their logs.
    pub fn logs(plan: &CampaignPlan) -> Vec<PlannedLog> {
        plan.procedures
            .iter()
            .map(|p| PlannedLog {
                id: p.procedure.id.clone(),
                title: p.procedure.title.clone(),
                kind: p.procedure.kind.to_owned(),
                axis: p.procedure.axis.clone(),
                log: format!("{}.mcap", p.procedure.id),
                yields: p.procedure.experiment.yields().into_iter().map(str::to_owned).collect(),
                closes_loops: p.closes_loops(),
                stage: plan.stage_of(p).map(|s| s.stage.id.clone()),
                state: plan.state_of(p).map(|s| s.id.clone()),
                planned_s: Some(p.planned_s()),
            })
            .collect()
    }

    /// The stages of a plan.
    pub fn stages(plan: &CampaignPlan) -> Vec<PageStage> {
        let ids =
            |named: &[(String, std::ops::Range<usize>)]| named.iter().map(|(id, _)| id.clone()).collect();
        let keep =
            |s: &procedures::diagnostic::SourceFile| KeptFile { name: s.name.clone(), text: s.text.clone() };
        plan.stages
            .iter()
            .map(|s| PageStage {
                id: s.stage.id.clone(),
                title: s.stage.title.clone(),
                state: s.state.as_ref().map(|state| keep(&state.source)),
                needs: ids(&s.stage.needs),
                needs_pass: ids(&s.stage.needs_pass),
            })
            .collect()
    }
}
