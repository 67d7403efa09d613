//! The logs of a run folder: which there are, and whether what is attached to them is what the title page says.

use std::path::Path;

use procedures::log::LogReader;

use super::{Check, RESULTS};
use crate::record::log::{self, SESSION, SUFFIX};
use crate::record::page::{Page, PlannedLog};

/// Names of everything in a folder that is called like a log.
pub(super) fn all(folder: &Path) -> Vec<String> {
    let inside = std::fs::read_dir(folder).ok().into_iter().flatten().flatten();
    let names = inside.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| name.ends_with(SUFFIX)).collect()
}

/// Holds every log against the title page: procedure, seed, requirements, rig, unit and build state. A log that cannot
/// be read is no matter of this check: its digest tells whether it is the one that the run left.
pub(super) fn agree(check: &mut Check<'_>, page: &Page) {
    for planned in &page.procedures {
        if planned.log != format!("{}{SUFFIX}", planned.id) || planned.log.contains(['/', '\0']) {
            let id = &planned.id;
            let log = &planned.log;
            check.altered.push(format!("title page: the log of {id} cannot be called `{log}`"));
        } else if check.sha256(&planned.log).is_some()
            && let Ok(reader) = LogReader::open(&check.folder.join(&planned.log))
        {
            let differing = differing(&reader, page, planned);
            if !differing.is_empty() {
                let log = &planned.log;
                let what = differing.join(", ");
                check
                    .altered
                    .push(format!("{log} belongs to another run than the title page (differing: {what})"));
            }
        }
    }
    for name in all(check.folder).iter().filter(|name| page.procedures.iter().all(|p| p.log != **name)) {
        match name.strip_suffix(SUFFIX).filter(|stem| is_session(stem) && check.sha256(name).is_some()) {
            None => check.altered.push(format!("{name} does not belong to any procedure of this run")),
            Some(stem) => agree_session(check, page, stem, name),
        }
    }
}

/// Whether a log is called as those of the time between points are.
fn is_session(stem: &str) -> bool {
    let count = stem.strip_prefix(SESSION).and_then(|rest| rest.strip_prefix('-'));
    stem == SESSION || count.is_some_and(|count| count.parse::<u32>().is_ok())
}

fn agree_session(check: &mut Check<'_>, page: &Page, stem: &str, name: &str) {
    let Ok(reader) = LogReader::open(&check.folder.join(name)) else { return };
    let rig = reader.attachments().iter().find(|a| a.name == log::RIG).map(|a| a.text.as_str());
    let plan = reader.plan();
    let own_rig = Some(page.rig.text.as_str());
    let same =
        [("procedure", plan.procedure == stem), ("seed", plan.seed == page.seed), ("rig", rig == own_rig)];
    let differing: Vec<&str> = same.into_iter().filter(|(_, same)| !same).map(|(what, _)| what).collect();
    if !differing.is_empty() {
        let what = differing.join(", ");
        check.altered.push(format!("{name} belongs to another run than the title page (differing: {what})"));
    }
}

fn differing(reader: &LogReader, page: &Page, planned: &PlannedLog) -> Vec<&'static str> {
    let attached = |name: &str| reader.attachments().iter().find(|a| a.name == name).map(|a| a.text.as_str());
    let stage = planned.stage.as_ref().and_then(|id| page.stages.iter().find(|stage| stage.id == *id));
    let state = stage.filter(|_| planned.state.is_some()).and_then(|stage| stage.state.as_ref());
    let state = state.map(|file| file.text.as_str());
    // A build state lies over the unit.
    let layers: Vec<&str> =
        state.into_iter().chain(page.unit_files.iter().map(|f| f.text.as_str())).collect();
    let layer = |k: usize| attached(&log::unit_layer(k));
    let plan = reader.plan();
    let same = [
        ("procedure", plan.procedure == planned.id),
        ("seed", plan.seed == page.seed),
        ("requirements", attached(log::REQUIREMENTS) == Some(&page.requirements.text)),
        ("rig", attached(log::RIG) == Some(&page.rig.text)),
        ("build state", attached(log::STATE) == state),
        ("unit", (0..=layers.len()).all(|k| layer(k) == layers.get(k).copied())),
    ];
    same.into_iter().filter(|(_, same)| !same).map(|(what, _)| what).collect()
}

/// Results hold the digests of the logs that they were judged from: those of earlier versions among the findings, later ones in their
/// record.
pub(super) fn agree_with_results(check: &mut Check<'_>) {
    let text = std::fs::read_to_string(check.folder.join(RESULTS)).unwrap_or_default();
    let Ok(results) = reports::json::parse(&text) else { return };
    for procedure in &results.findings.procedures {
        let Some(log) = &procedure.log else { continue };
        let on_record = results.record.files.iter().find(|file| file.file == *log).map(|file| &file.sha256);
        let Some(judged) = procedure.log_sha256.as_ref().or(on_record) else { continue };
        match check.sha256(log) {
            Some(found) if found == judged => {}
            Some(_) => {
                check.altered.push(format!("{log} differs from the log that {RESULTS} was judged from"))
            }
            None => check.altered.push(format!("{log} is missing, although {RESULTS} was judged from it")),
        }
    }
}
