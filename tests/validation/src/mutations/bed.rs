//! What is mutated: shipped files, the fixtures of the tests, and the folder of a short run.

use std::path::{Path, PathBuf};
use std::process::Command;

use bench::files::shipped::{self, Folder};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::sorts::{Case, SORTS};

/// A procedure that is over in seconds and leaves a short log.
pub(super) const PROCEDURE: &str = r#"schema = 1
id = "FRICTION"
title = "Friction, short"
kind = "hysteresis"
axis = "az"
log-rate = "50 Hz"
[sweep]
velocity = ["20 deg/s", "60 deg/s"]
span = "-40 deg .. 40 deg"
cycles = 1
[gate]
heat-sink = "< 60 degC"
[valid-if]
velocity = "within 5 % of requested"
dropped-cycles = "< 0.1 %, longest < 5 ms"
[[prompt]]
id = "free"
class = "info"
text = "Is the area free?"
"#;

/// A procedure that closes no loop: its run has no other log and a small folder.
pub(super) const SELF_CHECK: &str = r#"schema = 1
id = "SELF-CHECK"
title = "Self-check, short"
kind = "self-check"
axis = "az"
log-rate = "50 Hz"
duration = "3 s"
azimuth = "0 deg"
elevation = "40 deg"
[gate]
heat-sink = "< 60 degC"
[[prompt]]
id = "free"
class = "info"
text = "Is the area free?"
"#;

/// A campaign of the first.
pub(super) const CAMPAIGN: &str = r#"schema = 1
id = "short"
title = "A short campaign"
requirements = "requirements.toml"
must-measure = ["FRC-AZ"]
[[stage]]
id = "table"
title = "Azimuth as a torque table"
state = "state.toml"
inertia = { az = "640 kg*m^2" }
[[procedure]]
file = "shipped:fat/polarity-table.toml"
stage = "table"
[[stage]]
id = "whole"
title = "The whole unit"
needs = ["table"]
[[procedure]]
file = "procedure.toml"
stage = "whole"
points = { velocity = ["20 deg/s"] }
"#;

/// Answers to its prompts.
pub(super) const ANSWERS: &str = "schema = 1\n[answers]\nfree = \"yes\"\n";

/// Waivers of its requirement.
pub(super) const WAIVERS: &str = "schema = 1\n[[waiver]]\nrequirement = \"FRC-AZ\"\nnumber = \"W-17\"\napprover = \"B. Customer\"\nexpiry = \"2026-12-31\"\nreason = \"retainer is exchanged\"\n";

/// A file by its name.
pub(super) type Named = (String, Vec<u8>);

/// Everything that is mutated.
pub struct Bed {
    /// The program under test.
    pub program: PathBuf,
    /// Where the trials have their folders.
    pub folder: PathBuf,
    /// Files of the folder of a short run.
    pub run: Vec<Named>,
    /// Logs: of that run, and of imported tables.
    pub logs: Vec<Named>,
    /// Import maps, each with the files beside it.
    pub imports: Vec<Vec<Named>>,
}

impl Bed {
    /// Runs and imports what is then mutated; `whole` with a log of friction, which takes a minute on the rig.
    ///
    /// # Errors
    /// When the program does not do it.
    pub fn make(program: &Path, folder: &Path, whole: bool) -> Result<Self, String> {
        let make = folder.join("bed");
        let file = |name: &str, text: &str| (name.to_owned(), text.as_bytes().to_vec());
        let files =
            [file("friction.toml", PROCEDURE), file("self.toml", SELF_CHECK), file("answers.toml", ANSWERS)];
        write(&make, &files)?;
        let runs = [("self.toml", "run"), ("friction.toml", "friction")];
        for (name, out) in runs.into_iter().take(1 + usize::from(whole)) {
            let run = ["run", name, "--answers", "answers.toml", "--out", out, "--non-interactive"];
            said(program, &make, &run)?;
        }
        let run = read(&make.join("run"))?;
        let mut logs: Vec<Named> = run.iter().filter(|(name, _)| name.ends_with(".mcap")).cloned().collect();
        if whole {
            let files = read(&make.join("friction"))?;
            logs.extend(files.into_iter().filter(|(name, _)| name == "FRICTION.mcap"));
        }
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data");
        let mut imports = Vec::new();
        for name in ["odrive_cogging", "impact_frf", "motorbench"] {
            let files = read(&data.join(name))?;
            write(&make.join(name), &files)?;
            said(program, &make.join(name), &["import", "import.toml", "--out", "log"])?;
            logs.extend(read(&make.join(name).join("log"))?);
            imports.push(files);
        }
        Ok(Self { program: program.to_owned(), folder: folder.to_owned(), run, logs, imports })
    }

    /// The mutated files of a seed and the calls that read them.
    pub(super) fn case(&self, seed: u64) -> Case {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let sort = &SORTS[(seed % SORTS.len() as u64) as usize];
        (sort.make)(self, &mut random)
    }

    /// Writes the files of a seed, with the calls.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn keep(&self, seed: u64, folder: &Path) -> Result<(), String> {
        let case = self.case(seed);
        write(folder, &case.files)?;
        let calls: Vec<String> = case.calls.iter().map(|call| call.join(" ")).collect();
        write(folder, &[("calls.txt".to_owned(), calls.join("\n").into_bytes())])
    }

    /// A shipped file of a folder, as text.
    pub(super) fn shipped(folder: Folder, path: &str) -> Vec<u8> {
        shipped::all(folder).find(|e| e.path == path).map_or_else(Vec::new, |e| e.text.into())
    }
}

/// Writes files below a folder.
///
/// # Errors
/// When they cannot be written.
pub(super) fn write(folder: &Path, files: &[Named]) -> Result<(), String> {
    for (name, bytes) in files {
        let path = folder.join(name);
        let parent = path.parent().unwrap_or(folder);
        let written = std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, bytes));
        written.map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// The files of a folder.
fn read(folder: &Path) -> Result<Vec<Named>, String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_file() {
            all.push((name, std::fs::read(entry.path()).map_err(failed)?));
        }
    }
    all.sort();
    Ok(all)
}

fn said(program: &Path, folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.map_err(|e| format!("{}: {e}", program.display()))?;
    match output.status.code() {
        Some(0 | 1 | 3) => Ok(()),
        _ => Err(format!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr))),
    }
}
