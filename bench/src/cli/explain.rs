//! `bench explain`: kinds, drivers, drive profiles, requirements, units, controller parameters, safety parameters of a rig, exit codes.

use procedures::diagnostic::{Diagnostic, nearest};
use procedures::kinds::{self, KINDS};
use procedures::requirement::{Requirement, Requirements};

use examples::{Examples, keys};

use super::output;
use crate::exit::{self, EXIT_CODES};
use crate::files::family::read_family;
use crate::files::shipped::{self, Folder};
use crate::files::unit::{load_unit, read_state};
use crate::people::signals::{Does, Row, SIGNALS};
use crate::rig::devices;

mod examples;
mod rig;
mod settings;
pub(super) mod topics;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Any name that `bench list` shows; `rig` for safety parameters, `exit-code`, `signals`, or a topic: `units`,
    /// `verdicts`, `rules`, `selection`, `gates`, `stages`, `conditions`, `glossary`
    name: String,
}

pub(super) fn run(args: &Args) -> u8 {
    let name = args.name.as_str();
    let requirements = shipped_requirements();
    let found = exit_codes(name)
        .or_else(|| signals(name))
        .or_else(|| rig::page(name))
        .or_else(|| topics::page(name))
        .or_else(|| kind(name))
        .or_else(|| driver(name))
        .or_else(|| requirements.iter().find(|r| r.id == name).map(requirement))
        .or_else(|| measurand(name))
        .or_else(|| state(name))
        .or_else(|| family(name))
        // Before units: a name with `/` is taken for the path of one.
        .or_else(|| topics::file(name))
        .map(Ok)
        .or_else(|| unit_or_gains(name))
        .or_else(|| topics::rig_file(name).map(Ok))
        .or_else(|| topics::profile(name).map(Ok));
    match found {
        Some(Ok(text)) => {
            output::say(&text);
            exit::PASS
        }
        Some(Err(mistakes)) => output::mistakes(&mistakes),
        None => {
            let known = KINDS
                .iter()
                .map(|k| k.name)
                .chain(KINDS.iter().flat_map(|k| k.measurands.iter().map(|m| m.name)))
                .chain(devices::DRIVERS.iter().map(|d| d.name))
                .chain(requirements.iter().map(|r| r.id.as_str()))
                .chain(shipped::all(Folder::Units).map(|u| u.stem()))
                .chain(shipped::all(Folder::Families).map(|f| f.stem()))
                .chain(shipped::all(Folder::States).map(|s| s.stem()))
                .chain(shipped::all(Folder::Parameters).map(|p| p.stem()))
                .chain(shipped::all(Folder::Rigs).map(|r| r.stem()))
                .chain(shipped::all(Folder::Profiles).map(|p| p.stem()))
                .chain(shipped::all(Folder::Readers).map(|p| p.stem()))
                .chain(shipped::all(Folder::Procedures).map(|p| p.path.trim_end_matches(".toml")))
                .chain(["exit-code", "signals", "rig"]);
            let known: Vec<&str> = known.collect();
            let topics: Vec<&str> = topics::names().collect();
            let help = nearest(name, known.into_iter().chain(topics))
                .map_or(String::new(), |n| format!("; did you mean `{n}`?"));
            output::error(&format!("unknown name `{name}`{help} (`bench list` shows all names)"));
            exit::USAGE
        }
    }
}

fn shipped_requirements() -> Vec<Requirement> {
    let files = shipped::all(Folder::Procedures).filter(|e| e.is_requirements());
    files.filter_map(|e| Requirements::parse(&e.source()).ok()).flat_map(|r| r.all).collect()
}

fn exit_codes(name: &str) -> Option<String> {
    if name != "exit-code" && name != "exit-codes" {
        return None;
    }
    let mut lines = vec!["exit codes, highest priority first".to_owned()];
    lines.extend(EXIT_CODES.iter().map(|e| format!("{:>4}  {}", e.code, e.meaning)));
    lines.push(
        "If an axis hit its end stop or was not left at standstill, the exit code is 4, whatever the \
         verdict and whatever signal ended the run. The last lines of the run name that axis."
            .to_owned(),
    );
    Some(lines.join("\n"))
}

fn signals(name: &str) -> Option<String> {
    if name != "signals" && name != "signal" {
        return None;
    }
    let does = |does| match does {
        Does::Stops(code) => format!("controlled stop, exit {code}"),
        Does::StopsAtOnce(code) => format!("quick stop at once, exit {code}"),
        Does::HeldOff => "ignored, with a message that says why".to_owned(),
        Does::Nothing => "nothing".to_owned(),
    };
    let row = |row: &Row| vec![row.signal.as_str().to_owned(), does(row.does), row.why.to_owned()];
    let rows: Vec<_> = SIGNALS.iter().map(row).collect();
    Some(format!(
        "effect of signals on a run\n{}\nReal-time signals have no effect. SIGKILL, SIGSTOP and the \
         signals of a crash (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGSYS, SIGTRAP, SIGABRT) cannot be handled: \
         the drives' own watchdogs then stop the axes.",
        output::table(&rows)
    ))
}

fn kind(name: &str) -> Option<String> {
    let kind = kinds::kind(name)?;
    let mut lines =
        vec![format!("kind {}", kind.name), String::new(), kind.doc.trim().to_owned(), String::new()];
    lines.push("Keys".to_owned());
    let examples = Examples::of_kind(kind.name);
    lines.extend(kind.fields.iter().flat_map(|f| keys("", f, &examples)));
    lines.push("\nMeasurands".to_owned());
    lines.extend(
        kind.measurands.iter().map(|m| format!("  {} [{}]: {}", m.name, m.kind.display_unit(), m.doc)),
    );
    Some(lines.join("\n"))
}

/// A driver of devices: what it is, its ports, its keys.
fn driver(name: &str) -> Option<String> {
    let driver = devices::driver(name)?;
    let mut lines = vec![format!("driver {}: {}", driver.name, driver.doc)];
    lines.extend(driver.role.map(|role| format!("  role in procedures: {}", role.noun())));
    if let Some(role) = driver.certified_as {
        lines.push(format!(
            "  with real devices it needs an [[instrument]] of role `{role}` with its calibration"
        ));
    }
    lines.push("\nPorts".to_owned());
    lines.extend(driver.ports.iter().map(|port| format!("  {}: {}", port.key, port.doc)));
    lines.push("\nKeys".to_owned());
    let examples = Examples::of_driver(driver.name);
    lines.extend(driver.fields.iter().flat_map(|field| keys("", field, &examples)));
    Some(lines.join("\n"))
}

fn requirement(r: &Requirement) -> String {
    let mut lines =
        vec![format!("{}: {}", r.id, r.text), format!("  source: {}; verified by {}", r.source, r.method)];
    for judged in &r.judges {
        let all = judged.limit_texts().join("; ");
        let limit = if all.is_empty() { "report only" } else { &all };
        lines.push(format!("  judges {}: {limit}, rule {}", judged.measurand, judged.rule.name()));
    }
    lines.extend(r.conditions.iter().map(|w| format!("  only where {} {}", w.condition, w.meets.text())));
    if r.judges.is_empty() {
        lines.push(format!("  limit {}; no kind of experiment measures it yet", r.limit_text));
    }
    lines.join("\n")
}

fn measurand(name: &str) -> Option<String> {
    let (kind, m) = kinds::measurand(name)?;
    let judged = |r: &Requirement| r.judges.iter().any(|judge| judge.measurand == m.name);
    let judging: Vec<String> = shipped_requirements().into_iter().filter(judged).map(|r| r.id).collect();
    let judging = if judging.is_empty() { "no requirement".to_owned() } else { judging.join(", ") };
    Some(format!(
        "measurand {} [{}], from kind {}\n  {}\n  judged by {judging}",
        m.name,
        m.kind.display_unit(),
        kind.name,
        m.doc
    ))
}

/// A shipped build state: what it lays over a unit, as it stands in its file.
fn state(name: &str) -> Option<String> {
    let file = shipped::all(Folder::States).find(|file| file.stem() == name)?;
    let state = read_state(file.source()).ok()?;
    Some(format!("build state {}: {}\n\n{}", state.id, state.title, state.source.text.trim()))
}

/// A shipped family of units, as it stands in its file.
fn family(name: &str) -> Option<String> {
    let file = shipped::all(Folder::Families).find(|file| file.stem() == name)?;
    let family = read_family(file.source()).ok()?;
    Some(format!("family {}: {}\n\n{}", family.id, family.title, family.source.text.trim()))
}

/// A unit or a set of controller parameters; a file that was named as such but is wrong says what is wrong.
fn unit_or_gains(name: &str) -> Option<Result<String, Vec<Diagnostic>>> {
    if let Some(page) = settings::of_gains(name) {
        return Some(Ok(page));
    }
    let is_path = name.contains('/') || name.ends_with(".toml");
    match load_unit(name) {
        Ok(unit) => Some(Ok(settings::of_unit(&unit))),
        Err(mistakes) => is_path.then_some(Err(mistakes)),
    }
}
