//! Results of a run folder as verbs read them, with what its evidence is worth.

use std::io::ErrorKind;
use std::path::Path;

use reports::record::{EvidenceRecord, EvidenceState, Results, WaiverRecord};

use super::output;
use crate::exit;
use crate::record::bounded;
use crate::record::evidence;

/// Reads the results of a run folder.
fn read(run: &Path) -> Result<Results, u8> {
    let path = run.join("results.json");
    let text = bounded::read_to_string(&path, bounded::MOST_RECORD_BYTES).map_err(|e| {
        let help = if run.join(crate::record::page::FILE).exists() {
            format!("the run did not finish; judge its logs with `bench rejudge {} --out DIR`", run.display())
        } else {
            "is this a run folder?".to_owned()
        };
        output::error(&format!("{}: cannot be read: {e}; {help}", path.display()));
        exit::USAGE
    })?;
    reports::json::parse(&text).map_err(|e| {
        output::error(&format!("{}: not results of this program: {e}", path.display()));
        unusable(run)
    })
}

/// Exit code for a folder of which a file cannot be used: it was altered, or it is none of a run.
pub(super) fn unusable(run: &Path) -> u8 {
    match tell(run, &evidence::check(run)) {
        exit::DAMAGED => exit::DAMAGED,
        _ => exit::USAGE,
    }
}

/// Waivers of a run, kept beside its results: those are evidence and stay as the run wrote them.
pub(super) const WAIVERS: &str = "waivers.json";

/// The waivers that an earlier report kept in a run folder.
fn kept_waivers(run: &Path) -> Result<Option<Vec<WaiverRecord>>, u8> {
    let path = run.join(WAIVERS);
    let refused = |error: &dyn std::fmt::Display| {
        let help = "give the waivers again with --waivers F --format json";
        output::error(&format!("{}: {error}; {help}", path.display()));
        exit::USAGE
    };
    match std::fs::read_to_string(&path) {
        Ok(text) => serde_json::from_str(&text).map(Some).map_err(|error| refused(&error)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(refused(&error)),
    }
}

/// Results of a run folder with the waivers that were kept since.
pub(super) fn read_with_waivers(run: &Path) -> Result<Results, u8> {
    let mut results = read(run)?;
    if let Some(waivers) = kept_waivers(run)? {
        results.record.waivers = waivers;
    }
    Ok(results)
}

/// Tells how a run folder stands, and what that means for the exit code.
pub(super) fn tell(run: &Path, found: &EvidenceRecord) -> u8 {
    let line = format!("{}: evidence {}", run.display(), found.sentence());
    if found.state == EvidenceState::Altered {
        output::error(&line);
        return exit::DAMAGED;
    }
    output::note(&line);
    exit::PASS
}
