//! `bench rejudge`: the same judge over the same files; says what differs.

use std::path::{Path, PathBuf};

use procedures::campaign::Claim;
use procedures::requirement::Requirements;
use rayon::prelude::*;
use reports::record::{EvidenceRecord, Findings, Results, TitlePage};

use self::differences::Compared;
use super::{folders, output, record, results, verdicts};
use crate::exit;
use crate::files::shipped::{self, Folder};
use crate::judge::{self, Fold, JudgedLog, Known, Tried, Trouble, fold};
use crate::record::durable;
use crate::record::evidence;
use crate::record::journal::{self, Entry};
use crate::record::page::{Basis, KeptFile, Page, PlannedLog};

mod differences;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder or a single log
    what: PathBuf,
    /// Requirements file to judge by instead of the recorded requirements
    #[arg(long, value_name = "F")]
    requirements: Option<String>,
    /// Folder for results and report; nothing is written without this option
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
    troubles: Vec<Trouble>,
    before: Option<Results>,
    /// How the run folder stands; `None` for a log alone.
    evidence: Option<EvidenceRecord>,
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
        Some(name) => shipped::find(Folder::Requirements, name, None).map_err(|m| output::mistakes(&m))?,
        None => kept.source(),
    };
    let parsed = Requirements::parse(&source).map_err(|m| output::mistakes(&m))?;
    Ok((parsed, source.text))
}

fn folder(args: &Args) -> Result<Rejudged, u8> {
    let page = Page::read(&args.what).map_err(|message| {
        output::error(&message);
        results::unusable(&args.what)
    })?;
    let (requirements, text) = requirements(args, &page.requirements)?;
    let gone = gone(&args.what);
    // Logs are judged at the same time, and told of in their order.
    let tried: Vec<Option<Tried>> = page
        .procedures
        .par_iter()
        .map(|planned| {
            let path = args.what.join(&planned.log);
            let is_there = std::fs::symlink_metadata(&path).is_ok();
            let known = Known::default();
            is_there
                .then(|| judge::try_log(judge::judge_log, &path, planned, &requirements, &known, page.seed))
        })
        .collect();
    let mut judged = Vec::new();
    let mut troubles = Vec::new();
    for (planned, tried) in page.procedures.iter().zip(tried) {
        let Some(tried) = tried else {
            let path = args.what.join(&planned.log);
            let note = "no log; the requirements that need it are inconclusive";
            output::note(&format!("{}: {note}", path.display()));
            judged.push(gone.contains(&planned.log).then(|| judge::missing(planned, page.seed)));
            continue;
        };
        troubles.extend(tried.trouble);
        judged.push(Some(tried.log));
    }
    let by = Fold { page: &page, requirements: &requirements, requirements_text: &text, folder: &args.what };
    let before = if args.what.join("results.json").exists() {
        results::read_with_waivers(&args.what).ok()
    } else {
        output::note(&format!("{}: no earlier results (the run did not finish)", args.what.display()));
        None
    };
    Ok(Rejudged {
        findings: fold(&by, &judged),
        must_measure: !page.must_measure.is_empty(),
        troubles,
        before,
        evidence: Some(evidence::check(&args.what)),
    })
}

/// Logs of which the journal says that they were gone before the run was over.
fn gone(folder: &Path) -> Vec<String> {
    let lines = journal::read(folder).map(|(lines, _)| lines).unwrap_or_default();
    let missing = lines.into_iter().filter_map(|line| match line.entry {
        Entry::Missing { file, .. } => Some(file),
        _ => None,
    });
    missing.collect()
}

fn judge_one(path: &Path, file: &str, requirements: &Requirements) -> Result<JudgedLog, u8> {
    judge::judge_log(path, file, requirements, &Known::default()).map_err(|error| {
        output::error(&error.to_string());
        match &error {
            judge::JudgeError::Log(procedures::log::LogError::Damaged { .. }) => exit::DAMAGED,
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
        (_, Ok((_, source))) => KeptFile::of(&source),
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
    // No other log has found anything: torques rest on the constants and inertias of the rig, with their uncertainties.
    let folder = path.parent().unwrap_or(Path::new(""));
    let by = Fold { page: &page, requirements: &requirements, requirements_text: &text, folder };
    let troubles = judged.damage.clone().map(Trouble::Damaged).into_iter().collect();
    let findings = fold(&by, &[Some(judged)]);
    Ok(Rejudged { findings, must_measure: false, troubles, before: None, evidence: None })
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
        left_out: Vec::new(),
        campaign_file: None,
        requirements,
        must_measure: Vec::new(),
        claim: Claim::Acceptance,
        rig: nothing(),
        rig_id: String::new(),
        unit: String::new(),
        unit_files: Vec::new(),
        seed: judged.seed,
        origin: judged.origin,
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
        grants: Vec::new(),
        polarity: Basis::default(),
        title_page: TitlePage::default(),
        operator: None,
        serial_number: None,
        command_line: String::new(),
        jobs: 1,
        wire_faults: Vec::new(),
        laws: Vec::new(),
        started_utc: String::new(),
    }
}

fn show(args: &Args, rejudged: Rejudged) -> u8 {
    let Rejudged { findings, must_measure, troubles, before, evidence } = rejudged;
    // A log that no requirement speaks of was still judged: its measurements are the result.
    let nothing_asked = !must_measure && findings.outcomes.iter().all(|o| o.judged == 0);
    let mut code = if nothing_asked { exit::PASS } else { verdicts::exit_code(findings.overall) };
    for trouble in &troubles {
        output::error(trouble.text());
        code = exit::worse(code, trouble.exit_code());
    }
    if let Some(found) = &evidence {
        code = exit::worse(code, results::tell(&args.what, found));
    }
    if let Some(folder) = &args.out
        && let Err(worse) = write(&args.what, folder, &findings, before.as_ref(), evidence)
    {
        return exit::worse(code, worse);
    }
    let compared = before.map(|before| Compared::new(&before.findings, &findings));
    if compared.as_ref().is_some_and(Compared::is_unexplained) {
        code = exit::worse(code, exit::INCONCLUSIVE);
    }
    if args.json {
        output::say(&reports::json::findings(&findings));
        if let Some(compared) = &compared {
            output::note(&compared.text);
        }
        return code;
    }
    output::say(&verdicts::text(&findings));
    if !nothing_asked {
        output::say(&format!("{}: {}", findings.campaign.id, verdicts::overall_word(&findings)));
    }
    if let Some(compared) = &compared {
        output::say(&compared.text);
    }
    code
}

fn write(
    what: &Path,
    folder: &Path,
    findings: &Findings,
    before: Option<&Results>,
    evidence: Option<EvidenceRecord>,
) -> Result<(), u8> {
    folders::make(folder)?;
    let results = Results { evidence, ..Results::new(findings.clone(), record::of_rejudged(what, before)) };
    let one = |f: &reports::Format| durable::write(&folder.join(f.file), &(f.render)(&results));
    reports::FORMATS.iter().try_for_each(one).map_err(|error| folders::unwritable(folder, &error))
}
