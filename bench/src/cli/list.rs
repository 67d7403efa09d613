//! `bench list`: what is shipped.

use procedures::diagnostic::SourceFile;
use procedures::kinds::KINDS;
use procedures::requirement::Requirements;

use super::output;
use crate::exit;
use crate::files::shipped::{self, Folder};
use crate::plan::is_campaign;
use crate::rig::devices::DRIVERS;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// What to list; everything if not given
    what: Option<What>,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Campaigns,
    Procedures,
    Requirements,
    Kinds,
    Measurands,
    Rigs,
    Drivers,
    Profiles,
    Readers,
    Units,
    Families,
    States,
    Criteria,
    Topics,
}

type Rows = fn() -> Vec<Vec<String>>;

const LISTS: &[(What, &str, Rows)] = &[
    (What::Campaigns, "campaigns", || procedures(true)),
    (What::Procedures, "procedures", || procedures(false)),
    (What::Requirements, "requirements", requirements),
    (What::Kinds, "kinds", kinds),
    (What::Measurands, "measurands", measurands),
    (What::Rigs, "rigs", || titled(Folder::Rigs)),
    (What::Drivers, "drivers", drivers),
    (What::Profiles, "drive profiles", || titled(Folder::Profiles)),
    (What::Readers, "reader profiles", || titled(Folder::Readers)),
    (What::Units, "units", || titled(Folder::Units)),
    (What::Families, "families of units", || titled(Folder::Families)),
    (What::States, "build states", || titled(Folder::States)),
    (What::Criteria, "criteria of `bench regress`", criteria),
    (What::Topics, "topics of `bench explain`", super::explain::topics::rows),
];

pub(super) fn run(args: &Args) -> u8 {
    for (what, heading, rows) in LISTS {
        match args.what {
            Some(wanted) if wanted == *what => output::say(&output::table(&rows())),
            Some(_) => {}
            None => output::say(&format!("{heading}\n{}\n", indent(&output::table(&rows())))),
        }
    }
    exit::PASS
}

fn indent(text: &str) -> String {
    text.lines().map(|l| format!("  {l}")).collect::<Vec<_>>().join("\n")
}

/// A shipped file's heading: the text of its `title` line.
fn title(source: &SourceFile) -> String {
    let line = source.text.lines().find_map(|l| l.strip_prefix("title = "));
    line.map_or(String::new(), |t| t.trim().trim_matches('"').to_owned())
}

fn procedures(campaigns: bool) -> Vec<Vec<String>> {
    shipped::all(Folder::Procedures)
        .filter(|e| !e.is_requirements() && is_campaign(&e.source()) == campaigns)
        .map(|e| vec![e.path.trim_end_matches(".toml").to_owned(), title(&e.source())])
        .collect()
}

fn titled(folder: Folder) -> Vec<Vec<String>> {
    shipped::all(folder).map(|e| vec![e.stem().to_owned(), title(&e.source())]).collect()
}

/// Criteria files have no heading: what they ask of is told.
fn criteria() -> Vec<Vec<String>> {
    let asked = |file: &shipped::Embedded| {
        let lines = file.text.lines().filter_map(|line| line.strip_prefix("requirement = "));
        lines.map(|id| id.trim_matches('"')).collect::<Vec<_>>().join(", ")
    };
    shipped::all(Folder::Criteria).map(|file| vec![file.stem().to_owned(), asked(file)]).collect()
}

fn requirements() -> Vec<Vec<String>> {
    let files = shipped::all(Folder::Procedures).filter(|e| e.is_requirements());
    let all = files.filter_map(|e| Requirements::parse(&e.source()).ok()).flat_map(|r| r.all);
    let mark = |measured: bool| if measured { "measured" } else { "no kind measures it yet" };
    all.map(|r| vec![r.id, mark(!r.judges.is_empty()).to_owned(), r.text]).collect()
}

fn kinds() -> Vec<Vec<String>> {
    let first = |doc: &str| {
        doc.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#')).unwrap_or("").to_owned()
    };
    KINDS.iter().map(|k| vec![k.name.to_owned(), first(k.doc)]).collect()
}

fn drivers() -> Vec<Vec<String>> {
    DRIVERS.iter().map(|driver| vec![driver.name.to_owned(), driver.doc.to_owned()]).collect()
}

fn measurands() -> Vec<Vec<String>> {
    let rows = |k: &procedures::kinds::Kind| {
        let name = k.name;
        k.measurands
            .iter()
            .map(move |m| {
                vec![m.name.to_owned(), name.to_owned(), m.kind.display_unit().to_owned(), m.doc.to_owned()]
            })
            .collect::<Vec<_>>()
    };
    KINDS.iter().flat_map(rows).collect()
}
