//! `bench identify`: a unit file from what a stored run found.

use std::path::{Path, PathBuf};

use reports::record::Findings;

use super::{output, results};
use crate::exit;
use crate::files::rig::read_rig;
use crate::files::unit::load_unit;
use crate::identify::{self, Identified, Rehearsal, Setup, unit_file};
use crate::record::page::Page;
use crate::record::{durable, evidence};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder of a director, real or simulated
    run: PathBuf,
    /// Unit that gives what was not measured: a shipped name or a file
    #[arg(long, value_name = "UNIT", default_value = "nominal")]
    base: String,
    /// Unit file to write; its name becomes the id of the unit
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

pub(super) fn run(args: &Args) -> u8 {
    write(args).unwrap_or_else(|code| code)
}

fn write(args: &Args) -> Result<u8, u8> {
    let id = id(&args.out)?;
    let results = results::read_with_waivers(&args.run)?;
    let code = results::tell(&args.run, &evidence::check(&args.run));
    let page = Page::read(&args.run).map_err(|message| {
        output::error(&message);
        results::unusable(&args.run)
    })?;
    let rig = read_rig(page.rig.source()).map_err(|found| output::mistakes(&found))?;
    let setup = Setup::of(&rig).ok_or_else(|| {
        output::mistake(&format!(
            "{}: rig `{}` has no azimuth and elevation with torque constants; units are identified from runs of a director",
            args.run.display(),
            rig.id
        ))
    })?;
    let base = load_unit(&args.base).map_err(|found| output::mistakes(&found))?;
    let settings = base.director().ok_or_else(|| {
        output::mistake(&format!("--base {}: not a director; `bench list units` lists units", args.base))
    })?;
    let mut found = identify::identify(&results.findings, &setup, settings);
    Rehearsal { findings: &results.findings, run: &args.run, rig: &rig, base: &base, tell: &output::say }
        .identify(&mut found);
    if found.settings.is_empty() && found.curves.is_empty() {
        let run = args.run.display();
        return Err(output::mistake(&format!(
            "{run}: no finding says anything of a setting; run a campaign that measures the unit, e.g. `bench run quick`"
        )));
    }
    let base_from = base_from(&args.base);
    let title = format!("Twin of {}", results.findings.unit);
    let text = unit_file(&found, &id, &title, &base_from, &about(&results.findings, &page));
    durable::write(&args.out, text.as_bytes()).map_err(|error| {
        output::error(&format!("{}: {error}; {}", args.out.display(), durable::OUTPUT_HELP));
        exit::BENCH
    })?;
    tell(args, &found, settings);
    Ok(code)
}

/// The id of the unit; the file must be a new one.
fn id(out: &Path) -> Result<String, u8> {
    if out.exists() {
        return Err(output::mistake(&format!("--out {}: exists; choose a new file", out.display())));
    }
    let name = out.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix(".toml"));
    match name {
        Some(name) if !name.is_empty() => Ok(name.to_owned()),
        _ => Err(output::mistake(&format!(
            "--out {}: expected a file that ends in `.toml`, such as unit.toml: `bench run --unit` takes other names for shipped units",
            out.display()
        ))),
    }
}

/// How the file names its base: paths in a file are looked up beside it, so a path is made one from the root.
fn base_from(base: &str) -> String {
    let is_path = base.contains('/') || base.ends_with(".toml");
    let absolute = is_path.then(|| std::path::absolute(base).ok()).flatten();
    absolute.map_or_else(|| base.to_owned(), |path| path.display().to_string())
}

/// Which run the file is from.
fn about(findings: &Findings, page: &Page) -> Vec<String> {
    let serial =
        page.serial_number.as_ref().map_or_else(String::new, |number| format!(", serial number {number}"));
    vec![
        format!(
            "Identified by `bench identify` from a run of campaign {} on rig {}: unit {}{serial}, seed {}.",
            findings.campaign.id, page.rig_id, findings.unit, findings.seed
        ),
        "Each value has its expanded uncertainty U (95 %) and the findings that it rests on, by their share. \"In part\": only \
         determined together with other settings."
            .to_owned(),
    ]
}

/// What was found, and what was not.
fn tell(args: &Args, found: &Identified, base: &sim_devices::unit::UnitSettings) {
    let head = ["setting", "base", "identified", "U", "", "from"].map(str::to_owned).to_vec();
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(found.rows(base)).collect();
    output::say(&output::table(&rows));
    for line in &found.contradictions {
        output::say(&format!("contradiction: {line}"));
    }
    for line in &found.remarks {
        output::say(&format!("remark: {line}"));
    }
    output::say(&format!(
        "{} settings and {} curves from {}; {} as in {}, listed at the end of the file",
        found.settings.len(),
        found.curves.len(),
        args.run.display(),
        found.not_measured().len(),
        args.base
    ));
    output::say(&args.out.display().to_string());
}
