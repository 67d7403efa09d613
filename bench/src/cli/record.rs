//! The record of a run: who, when, on what, how long. Nothing else puts one together.

use std::path::Path;

use reports::record::{Attempt, LatenessRecord, PromptRecord, Results, RunRecord};

use super::output;
use crate::campaign::RunResult;
use crate::clock::{Stopwatch, cpu_s, utc_now};
use crate::judge;
use crate::record::journal::{self, Entry};
use crate::record::log::{SESSION, SUFFIX};
use crate::record::page::Page;

/// Of a run that is over but for its results.
pub(super) fn of_run(result: &RunResult, folder: &Path, watch: &Stopwatch) -> RunRecord {
    let page = &result.page;
    let cpu_s = cpu_s().unwrap_or(0.0);
    RunRecord {
        ended_utc: Some(utc_now()),
        wall_s: watch.elapsed_s(),
        simulated_s: result.simulated_s,
        cpu_s,
        speed_factor: (cpu_s > 0.0).then(|| result.simulated_s / cpu_s),
        jobs: page.jobs,
        command_line: page.command_line.clone(),
        numeric_profile: Some(format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)),
        attempts: attempts(result),
        files: result.journal.kept().to_vec(),
        lateness: lateness(result, folder),
        ..by_page(page.clone(), folder)
    }
}

/// Of a run that was judged again: who and when of its title page; when it ended, how long it and its procedures took, its files
/// and what was waived as its results said. A log alone has no title page, and its record says no more than who judged.
pub(super) fn of_rejudged(what: &Path, before: Option<&Results>) -> RunRecord {
    let page = Page::read(what).ok();
    let before = before.filter(|_| page.is_some()).map(|results| results.record.clone()).unwrap_or_default();
    RunRecord {
        ended_utc: before.ended_utc,
        wall_s: before.wall_s,
        simulated_s: before.simulated_s,
        jobs: 1,
        command_line: output::command_line(),
        attempts: before.attempts,
        lateness: before.lateness,
        waivers: before.waivers,
        files: before.files,
        ..page.map_or_else(by_version, |page| by_page(page, what))
    }
}

/// What a title page and the journal beside it say.
fn by_page(page: Page, folder: &Path) -> RunRecord {
    RunRecord {
        run: name_of(folder),
        title_page: page.title_page,
        operator: page.operator,
        serial_number: page.serial_number,
        rig: Some(page.rig_id),
        started_utc: Some(page.started_utc),
        devices: page.devices,
        laws: page.laws,
        instruments: page.instruments,
        grants: page.grants,
        prompts: prompts(folder),
        ..by_version()
    }
}

/// Name of a run folder, also of `.`.
fn name_of(folder: &Path) -> Option<String> {
    let whole = std::path::absolute(folder).ok()?;
    let last = whole.components().next_back()?;
    Some(last.as_os_str().to_string_lossy().into_owned())
}

fn by_version() -> RunRecord {
    RunRecord { software_version: env!("CARGO_PKG_VERSION").to_owned(), ..RunRecord::default() }
}

/// How late the ticks of all points came, and of the sessions between them.
fn lateness(result: &RunResult, folder: &Path) -> Vec<LatenessRecord> {
    let judged = result.judged.iter().flatten().flat_map(|log| log.lateness.clone());
    let files = result.journal.kept().iter().map(|kept| kept.file.as_str());
    let sessions = files.filter(|file| file.starts_with(SESSION) && file.ends_with(SUFFIX));
    judged.chain(sessions.flat_map(|file| judge::lateness_of_log(&folder.join(file), file))).collect()
}

fn attempts(result: &RunResult) -> Vec<Attempt> {
    let runs = result.page.procedures.iter().zip(&result.runs);
    runs.map(|(planned, run)| Attempt {
        procedure: planned.id.clone(),
        attempt: 1,
        file: planned.log.clone(),
        status: run.status,
        reason: run.reason.clone(),
        planned_s: planned.planned_s,
        ran_s: (run.loop_s > 0.0).then_some(run.loop_s),
    })
    .collect()
}

/// Questions with their answers, as the journal holds them; none where it cannot be read.
fn prompts(folder: &Path) -> Vec<PromptRecord> {
    let lines = journal::read(folder).map(|(lines, _)| lines).unwrap_or_default();
    let answered = lines.into_iter().filter_map(|line| match line.entry {
        Entry::Answered { procedure, prompt, class, text, answer, by, how } => Some(PromptRecord {
            asked_by: procedure,
            id: prompt,
            class,
            text,
            answer,
            by,
            how,
            utc: line.utc,
        }),
        _ => None,
    });
    answered.collect()
}
