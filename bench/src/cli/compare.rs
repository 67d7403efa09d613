//! `bench compare`: what two stored runs, or a run and published values, say of the same quantities.

use std::path::{Path, PathBuf};

use procedures::comparison::PublishedTable;
use reports::comparison::{Fact, RunComparison};
use reports::record::{EvidenceRecord, Origin, Results};

use super::{folders, output, results};
use crate::exit;
use crate::files::shipped;
use crate::record::durable;
use crate::record::evidence;
use crate::record::journal::sha256;
use crate::record::page::{self, KeptFile, Page};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Run folder
    a: PathBuf,
    /// Another run folder, or a TOML file of published values
    b: PathBuf,
    /// Share of a value, or of the height of a curve, up to which a difference is of no interest, e.g. 0.02; with it, curves
    /// without uncertainty are judged, too
    #[arg(long, value_name = "F", value_parser = ratio)]
    tolerance: Option<f64>,
    /// Folder for `comparison.md` and `comparison.json`
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the comparison as JSON
    #[arg(long)]
    json: bool,
}

fn ratio(text: &str) -> Result<f64, String> {
    let parsed = text.parse::<f64>().ok().filter(|ratio| *ratio > 0.0 && *ratio < 1.0);
    parsed.ok_or_else(|| "expected a number between 0 and 1, e.g. 0.02 for 2 %".to_owned())
}

/// A run folder as it was read.
struct Stored {
    name: String,
    results: Results,
    /// `None` for results that were judged again into a folder of their own.
    page: Option<Page>,
    evidence: EvidenceRecord,
}

pub(super) fn run(args: &Args) -> u8 {
    compare(args).unwrap_or_else(|code| code)
}

fn compare(args: &Args) -> Result<u8, u8> {
    let a = Stored::read(&args.a)?;
    let mut code = results::tell(&args.a, &a.evidence);
    let compared = if args.b.is_dir() {
        let b = Stored::read(&args.b)?;
        code = exit::worse(code, results::tell(&args.b, &b.evidence));
        RunComparison::of_runs(
            [&a.name, &b.name],
            facts(&a, &b),
            [&a.results.findings, &b.results.findings],
            args.tolerance,
        )
    } else {
        let source = shipped::read(&args.b).map_err(|found| output::mistakes(&found))?;
        let table = PublishedTable::parse(&source).map_err(|found| output::mistakes(&found))?;
        RunComparison::with_published(&a.name, &a.results.findings, &table, args.tolerance)
    };
    if compared.is_empty() {
        output::error(&format!(
            "{} and {}: nothing to compare: no procedure, measurand, axis and conditions in common; compare runs of one campaign",
            args.a.display(),
            args.b.display()
        ));
        return Err(exit::USAGE);
    }
    if let Some(folder) = &args.out {
        write(folder, &compared)?;
    }
    if args.json {
        output::say(reports::comparison::json(&compared).trim_end());
    } else {
        output::say(&reports::comparison::text(&compared));
    }
    Ok(if compared.differs() { exit::worse(code, exit::FAIL) } else { code })
}

impl Stored {
    fn read(folder: &Path) -> Result<Self, u8> {
        let results = results::read_with_waivers(folder)?;
        let page = if folder.join(page::FILE).exists() {
            Some(Page::read(folder).map_err(|message| {
                output::error(&message);
                results::unusable(folder)
            })?)
        } else {
            None
        };
        Ok(Self { name: folder.display().to_string(), results, page, evidence: evidence::check(folder) })
    }

    /// What the title page says, in words; a dash where there is none.
    fn says(&self, what: impl Fn(&Page) -> String) -> String {
        self.page.as_ref().map_or_else(|| "—".to_owned(), what)
    }
}

/// What a person compares first: what was run, on what, by whom it was controlled.
fn facts(a: &Stored, b: &Stored) -> Vec<Fact> {
    let fact =
        |what: &str, said: &dyn Fn(&Stored) -> String| Fact { what: what.to_owned(), a: said(a), b: said(b) };
    let digest = |files: &[&KeptFile]| {
        let texts: Vec<&str> = files.iter().map(|file| file.text.as_str()).collect();
        short(&sha256(texts.join("\0").as_bytes()))
    };
    let campaign = |page: &Page| page.campaign_file.as_ref().map_or_else(String::new, |file| digest(&[file]));
    let unit = |page: &Page| digest(&page.unit_files.iter().collect::<Vec<_>>());
    let devices = |page: &Page| {
        let all: Vec<String> = page.devices.iter().map(|d| format!("{}: {}", d.name, d.identity)).collect();
        format!("{} ({})", all.len(), short(&sha256(all.join("\n").as_bytes())))
    };
    let laws = |page: &Page| {
        let all = page.laws.iter();
        let said =
            all.map(|law| format!("{}: {} {} ({})", law.axis, law.name, law.version, short(&law.sha256)));
        said.collect::<Vec<_>>().join(", ")
    };
    let none = |text: String| if text.is_empty() { "—".to_owned() } else { text };
    vec![
        fact("evidence", &|s| s.evidence.state.word().to_owned()),
        fact("origin", &|s| origin(s.results.findings.origin).to_owned()),
        fact("campaign", &|s| {
            let campaign = &s.results.findings.campaign;
            let part = if campaign.partial { " (PARTIAL)" } else { "" };
            format!("{}{part}", campaign.id)
        }),
        fact("campaign file", &|s| none(s.says(campaign))),
        fact("requirements", &|s| {
            none(s.results.findings.campaign.requirements_sha256.as_deref().map_or_else(String::new, short))
        }),
        fact("rig", &|s| s.says(|page| format!("{} ({})", page.rig_id, digest(&[&page.rig])))),
        fact("unit", &|s| none(s.results.findings.unit.clone())),
        fact("unit files", &|s| s.says(unit)),
        fact("serial number", &|s| none(s.results.record.serial_number.clone().unwrap_or_default())),
        fact("seed", &|s| s.results.findings.seed.to_string()),
        fact("controller parameters", &|s| none(s.says(|page| short(&page.polarity.parameters_sha256)))),
        fact("external laws", &|s| none(s.says(laws))),
        fact("devices", &|s| s.says(devices)),
        fact("faults planted on the wire", &|s| none(s.says(|page| page.wire_faults.join(", ")))),
    ]
}

/// As much of a digest as tells two of them apart.
fn short(digest: &str) -> String {
    digest.chars().take(12).collect()
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Real => "real",
        Origin::Mixed => "real and simulated",
        Origin::Simulated => "simulated",
        Origin::Imported => "imported",
    }
}

fn write(folder: &Path, compared: &RunComparison) -> Result<(), u8> {
    folders::make(folder)?;
    let markdown = reports::comparison::markdown(compared);
    let data = reports::comparison::json(compared);
    let write = |name: &str, text: &str| durable::write(&folder.join(name), text.as_bytes());
    write("comparison.md", &markdown)
        .and_then(|()| write("comparison.json", &data))
        .map_err(|error| folders::unwritable(folder, &error))
}
