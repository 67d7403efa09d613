//! `bench rejudge`: the same judge over the same files; says what differs.

use std::path::{Path, PathBuf};

use procedures::requirement::Requirements;
use reports::record::{Findings, Origin, Results, RunRecord, TitlePage};

use super::output;
use super::run::verdict_code;
use crate::exit;
use crate::files::shipped::{self, Folder};
use crate::journal::sha256;
use crate::judge::{self, Fold, JudgedLog, fold};
use crate::page::{KeptFile, Page, PlannedLog};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder or a single log
    what: PathBuf,
    /// Judge by another requirements file
    #[arg(long, value_name = "F")]
    requirements: Option<String>,
    /// Write results and report here; without it nothing is written
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the findings as JSON
    #[arg(long)]
    json: bool,
}

struct Rejudged {
    findings: Findings,
    /// Whether requirements were asked for by name.
    must_measure: bool,
    damaged: Vec<String>,
    before: Option<Results>,
}

pub(super) fn run(args: &Args) -> u8 {
    let rejudged = if args.what.is_dir() { folder(args) } else { single(args) };
    match rejudged {
        Ok(rejudged) => show(args, rejudged),
        Err(code) => code,
    }
}

fn requirements(args: &Args, kept: &KeptFile) -> Result<(Requirements, String), u8> {
    let source = match &args.requirements {
        Some(name) => shipped::find(Folder::Procedures, name, None).map_err(|m| output::mistakes(&m))?,
        None => procedures::diagnostic::SourceFile { name: kept.name.clone(), text: kept.text.clone() },
    };
    let parsed = Requirements::parse(&source).map_err(|m| output::mistakes(&m))?;
    Ok((parsed, source.text))
}

fn folder(args: &Args) -> Result<Rejudged, u8> {
    let page = Page::read(&args.what).map_err(|message| {
        output::error(&message);
        exit::USAGE
    })?;
    let (requirements, text) = requirements(args, &page.requirements)?;
    let (mut judged, mut damaged) = (Vec::new(), Vec::new());
    for planned in &page.procedures {
        let path = args.what.join(&planned.log);
        if !path.exists() {
            output::note(&format!("{}: no log; what it serves is inconclusive", path.display()));
            judged.push(None);
            continue;
        }
        let log = judge_one(&path, &planned.log, &requirements)?;
        damaged.extend(log.damage.clone());
        judged.push(Some(log));
    }
    let by = Fold { page: &page, requirements: &requirements, requirements_text: &text };
    let before = if args.what.join("results.json").exists() {
        super::report::read(&args.what).ok()
    } else {
        output::note(&format!(
            "{}: no earlier results (the run did not come to its end)",
            args.what.display()
        ));
        None
    };
    Ok(Rejudged {
        findings: fold(&by, &judged),
        must_measure: !page.must_measure.is_empty(),
        damaged,
        before,
    })
}

fn judge_one(path: &Path, file: &str, requirements: &Requirements) -> Result<JudgedLog, u8> {
    judge::judge_log(path, file, requirements).map_err(|error| {
        output::error(&error.to_string());
        match &error {
            judge::JudgeError::Log(procedures::log::LogError::Damaged { .. }) => exit::DAMAGED,
            judge::JudgeError::Log(procedures::log::LogError::Io { .. }) => exit::USAGE,
            _ => exit::USAGE,
        }
    })
}

/// A log alone: its attachments say everything.
fn single(args: &Args) -> Result<Rejudged, u8> {
    let path = &args.what;
    let file = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let attached = judge::attached_requirements(path);
    let kept = match (&args.requirements, attached) {
        (_, Ok((_, source))) => KeptFile { name: source.name, text: source.text },
        (Some(_), Err(_)) => KeptFile { name: String::new(), text: String::new() },
        (None, Err(error)) => {
            output::error(&error.to_string());
            let damaged = matches!(error, judge::JudgeError::Log(procedures::log::LogError::Damaged { .. }));
            return Err(if damaged { exit::DAMAGED } else { exit::USAGE });
        }
    };
    let (requirements, text) = requirements(args, &kept)?;
    let judged = judge_one(path, &file, &requirements)?;
    let page = page_of(&judged, &file, kept);
    let by = Fold { page: &page, requirements: &requirements, requirements_text: &text };
    let damaged = judged.damage.clone().into_iter().collect();
    Ok(Rejudged { findings: fold(&by, &[Some(judged)]), must_measure: false, damaged, before: None })
}

/// The title page that a single log stands for.
fn page_of(judged: &JudgedLog, file: &str, requirements: KeptFile) -> Page {
    let found = &judged.findings;
    let nothing = || KeptFile { name: String::new(), text: String::new() };
    Page {
        schema: 1,
        campaign: found.id.clone(),
        title: found.title.clone(),
        partial: true,
        campaign_file: None,
        requirements,
        must_measure: Vec::new(),
        rig: nothing(),
        rig_id: String::new(),
        unit: String::new(),
        unit_files: Vec::new(),
        seed: judged.seed,
        origin: if judged.mode == "imported" { Origin::Imported } else { Origin::Simulated },
        devices: Vec::new(),
        procedures: vec![PlannedLog {
            id: found.id.clone(),
            title: found.title.clone(),
            kind: found.kind.clone(),
            axis: found.axis.clone(),
            log: file.to_owned(),
            yields: judged.yields.clone(),
            closes_loops: false,
            stage: None,
            state: found.state.clone(),
            planned_s: None,
        }],
        stages: Vec::new(),
        instruments: Vec::new(),
        polarity: crate::polarity::Basis::default(),
        title_page: TitlePage::default(),
        operator: None,
        serial_number: None,
        command_line: String::new(),
        jobs: 1,
        started_utc: String::new(),
    }
}

fn show(args: &Args, rejudged: Rejudged) -> u8 {
    let Rejudged { findings, must_measure, damaged, before } = rejudged;
    // A log that no requirement speaks of was still judged: its measurements are the result.
    let nothing_asked = !must_measure && findings.outcomes.iter().all(|o| o.judged == 0);
    let mut code = if nothing_asked { exit::PASS } else { verdict_code(findings.overall) };
    for damage in &damaged {
        output::error(damage);
        code = exit::worse(code, exit::DAMAGED);
    }
    if let Some(folder) = &args.out
        && let Err(worse) = write(&args.what, folder, &findings, before.as_ref())
    {
        return worse;
    }
    if args.json {
        output::say(&reports::json::findings(&findings));
        return code;
    }
    output::say(&super::verdicts::text(&findings));
    if !nothing_asked {
        output::say(&format!("{}: {}", findings.campaign.id, super::run::overall_word(&findings)));
    }
    if let Some(before) = before {
        output::say(&differences(&before.findings, &findings));
    }
    code
}

/// The record of the run that was judged again: who and when of its title page, its files as they are now, how long its
/// procedures took and what was waived as its results say.
fn record(what: &Path, before: Option<&Results>) -> RunRecord {
    let before = before.map(|results| &results.record);
    let now = RunRecord {
        command_line: output::command_line(),
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        jobs: 1,
        attempts: before.map(|record| record.attempts.clone()).unwrap_or_default(),
        waivers: before.map(|record| record.waivers.clone()).unwrap_or_default(),
        ..RunRecord::default()
    };
    let Ok(page) = Page::read(what) else { return now };
    RunRecord {
        title_page: page.title_page,
        operator: page.operator,
        serial_number: page.serial_number,
        rig: Some(page.rig_id),
        started_utc: Some(page.started_utc),
        devices: page.devices,
        instruments: page.instruments,
        prompts: super::run::prompts(what),
        files: super::run::files(what),
        ..now
    }
}

fn write(what: &Path, folder: &Path, findings: &Findings, before: Option<&Results>) -> Result<(), u8> {
    let occupied = std::fs::read_dir(folder).is_ok_and(|mut inside| inside.next().is_some());
    if occupied {
        output::error(&format!("--out {}: the folder is not empty", folder.display()));
        return Err(exit::USAGE);
    }
    let record = record(what, before);
    let results = Results::new(findings.clone(), record);
    let written = std::fs::create_dir_all(folder).and_then(|()| {
        reports::FORMATS.iter().try_for_each(|f| std::fs::write(folder.join(f.file), (f.render)(&results)))
    });
    written.map_err(|error| {
        output::error(&format!("{}: {error}; {}", folder.display(), crate::campaign::OUTPUT_HELP));
        exit::BENCH
    })
}

/// What a person reads of a long line: where it begins to differ from another.
fn around(line: &str, other: &str) -> String {
    const BEFORE: usize = 40;
    const SHOWN: usize = 120;
    let same = line.chars().zip(other.chars()).take_while(|(a, b)| a == b).count();
    let from = if line.chars().count() <= SHOWN { 0 } else { same.saturating_sub(BEFORE) };
    let shown: String = line.chars().skip(from).take(SHOWN).collect();
    let cut = |cut: bool| if cut { "…" } else { "" };
    format!("{}{shown}{}", cut(from > 0), cut(line.chars().count() > from + SHOWN))
}

/// Whether the bytes are the same, or the first line that differs.
fn differences(before: &Findings, now: &Findings) -> String {
    let (before, now) = (reports::json::findings(before), reports::json::findings(now));
    if before == now {
        return format!("findings are the same, byte for byte (sha256 {})", sha256(now.as_bytes()));
    }
    let mut pairs = before.lines().zip(now.lines()).enumerate();
    match pairs.find(|(_, (a, b))| a != b) {
        Some((line, (a, b))) => {
            format!(
                "findings differ, first at line {}:\n  before: {}\n  now:    {}",
                line + 1,
                around(a.trim(), b.trim()),
                around(b.trim(), a.trim())
            )
        }
        None => "findings differ in length".to_owned(),
    }
}
