//! `run.json`: the title page of a run folder, written before anything moves.

use std::path::Path;

use controllers::parameter::{AXIS_PARAMETERS, PARAMETERS, VELOCITY_LAW};
use procedures::campaign::Claim;
use procedures::diagnostic::SourceFile;
use reports::record::{DeviceRecord, FileHash, Grant, InstrumentRecord, LawRecord, Origin, TitlePage};
use serde::{Deserialize, Serialize};

use crate::record::bounded;
use crate::record::durable;
use crate::record::journal::sha256;

/// File name in the run folder.
pub(crate) const FILE: &str = "run.json";

/// A text that the run was made from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptFile {
    /// Name as it was found.
    pub name: String,
    /// Text of the file, verbatim.
    pub text: String,
}

impl KeptFile {
    /// A file as it was read.
    pub fn of(source: &SourceFile) -> Self {
        Self { name: source.name.clone(), text: source.text.clone() }
    }

    /// The file, to be read again.
    pub fn source(&self) -> SourceFile {
        SourceFile { name: self.name.clone(), text: self.text.clone() }
    }
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

/// What a proof of polarity is about; it is worth nothing once any of it has changed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Basis {
    /// Each device with what it says of itself, firmware included.
    pub identities: Vec<String>,
    /// Digest of the unit files: how a simulated unit is put together; of nothing for a real one.
    pub unit_sha256: String,
    /// Digest of the rig file.
    pub rig_sha256: String,
    /// Digest of all parameters of the controllers, and of their external laws.
    pub parameters_sha256: String,
}

impl Basis {
    /// What a proof of today would be about.
    pub fn new(
        devices: &[DeviceRecord],
        unit: &[String],
        rig: &str,
        gains: &controllers::DirectorGains,
        external: &[LawRecord],
    ) -> Self {
        let line = |key: &str, value_si: f64| format!("{key}={:016x}", value_si.to_bits());
        let shared = PARAMETERS.iter().map(|p| line(p.key, (p.get)(gains)));
        let of_axes =
            gains.axes.iter().flat_map(|own| AXIS_PARAMETERS.iter().map(|p| line(p.key, (p.get)(own))));
        let laws = gains.axes.iter().map(|own| format!("{VELOCITY_LAW}={}", own.velocity_law.name()));
        let external = external.iter().map(|law| format!("{}.{VELOCITY_LAW}={}", law.axis, law.sha256));
        let parameters: Vec<String> = shared.chain(of_axes).chain(laws).chain(external).collect();
        Self {
            identities: devices.iter().map(|d| format!("{}: {}", d.name, d.identity)).collect(),
            unit_sha256: sha256(unit.join("\0").as_bytes()),
            rig_sha256: sha256(rig.as_bytes()),
            parameters_sha256: sha256(parameters.join("\n").as_bytes()),
        }
    }

    /// All of it as one digest.
    pub fn hash(&self) -> String {
        let Self { identities, unit_sha256, rig_sha256, parameters_sha256 } = self;
        sha256(
            format!("{}\n{unit_sha256}\n{rig_sha256}\n{parameters_sha256}", identities.join("\n")).as_bytes(),
        )
    }

    /// What differs from an earlier one, each as a few words.
    pub(super) fn changes_since(&self, earlier: &Self) -> Vec<String> {
        let mut all = Vec::new();
        for (what, before, now) in [
            ("the unit file", &earlier.unit_sha256, &self.unit_sha256),
            ("the rig file", &earlier.rig_sha256, &self.rig_sha256),
            ("the parameters of the controllers", &earlier.parameters_sha256, &self.parameters_sha256),
        ] {
            if before != now {
                all.push(what.to_owned());
            }
        }
        let gone = earlier.identities.iter().filter(|id| !self.identities.contains(id));
        all.extend(gone.map(|id| format!("a device (it was {id})")));
        if self.identities.len() != earlier.identities.len() {
            all.push(format!(
                "the number of devices, from {} to {}",
                earlier.identities.len(),
                self.identities.len()
            ));
        }
        all
    }
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
    /// What the campaign claims.
    #[serde(default)]
    pub claim: Claim,
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
    /// What the ticking thread asked of the operating system; empty where time is virtual.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grants: Vec<Grant>,
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
    /// Faults that were planted on the wire, as they were asked for: nothing on it counts as real.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wire_faults: Vec<String>,
    /// External velocity laws; empty where all laws are built in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laws: Vec<LawRecord>,
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
        let size_bytes = text.len() as u64;
        let sha256 = sha256(text.as_bytes());
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
}
