//! Sorts of files, and how the program is made to read each.

use bench::files::shipped::{self, Folder};
use rand_chacha::ChaCha8Rng;

use super::bed::{ANSWERS, Bed, CAMPAIGN, Named, PROCEDURE, SELF_CHECK, WAIVERS};
use super::log;
use super::text::{BYTES, TEXT, below, one};

/// Mutated files with the calls that read them.
pub(super) struct Case {
    /// What sort of file is mutated.
    pub sort: &'static str,
    /// In which way.
    pub how: &'static str,
    /// All files that the calls need.
    pub files: Vec<Named>,
    /// Arguments of the calls, one after the other.
    pub calls: Vec<Vec<String>>,
    /// Whether the first call is a check of what the second one runs: if it says yes, the run may not refuse.
    pub promises: bool,
}

/// A sort of file.
pub(super) struct Sort {
    /// Its name.
    pub name: &'static str,
    /// Makes a case.
    pub make: fn(&Bed, &mut ChaCha8Rng) -> Case,
}

/// All sorts.
pub(super) const SORTS: &[Sort] = &[
    Sort { name: "campaign", make: campaign },
    Sort { name: "procedure", make: procedure },
    Sort { name: "requirements", make: requirements },
    Sort { name: "rig", make: rig },
    Sort { name: "unit", make: unit },
    Sort { name: "build state", make: state },
    Sort { name: "controller parameters", make: parameters },
    Sort { name: "waivers", make: waivers },
    Sort { name: "answers", make: answers },
    Sort { name: "import map", make: map },
    Sort { name: "table", make: table },
    Sort { name: "run.json", make: |bed, random| kept(bed, random, "run.json") },
    Sort { name: "journal.jsonl", make: |bed, random| kept(bed, random, "journal.jsonl") },
    Sort { name: "results.json", make: |bed, random| kept(bed, random, "results.json") },
    Sort { name: "log", make: log },
    Sort { name: "log of a run", make: log_of_a_run },
];

/// Mutates a text once or twice.
fn mutated(original: Vec<u8>, random: &mut ChaCha8Rng) -> (Vec<u8>, &'static str) {
    let way = if below(random, 4) == 0 { one(random, BYTES) } else { one(random, TEXT) };
    let mut bytes = (way.apply)(original, random);
    if below(random, 4) == 0 {
        bytes = (one(random, TEXT).apply)(bytes, random);
    }
    (bytes, way.name)
}

fn call(text: &str) -> Vec<String> {
    text.split(' ').map(str::to_owned).collect()
}

fn calls(texts: &[&str]) -> Vec<Vec<String>> {
    texts.iter().map(|text| call(text)).collect()
}

fn file(name: &str, bytes: impl Into<Vec<u8>>) -> Named {
    (name.to_owned(), bytes.into())
}

/// Whether a case also runs what it checks.
fn runs(random: &mut ChaCha8Rng) -> bool {
    below(random, 6) == 0
}

const SHORT: &str = "quick/self-check-open";

fn campaign(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (bytes, how) = mutated(CAMPAIGN.into(), random);
    let state = Bed::shipped(Folder::States, "states/azimuth-table.toml");
    let state = if state.is_empty() { Bed::shipped(Folder::States, "azimuth-table.toml") } else { state };
    let files =
        vec![file("campaign.toml", bytes), file("procedure.toml", PROCEDURE), file("state.toml", state)];
    let verb = *one(random, &["check campaign.toml", "plan campaign.toml", "check campaign.toml"]);
    Case { sort: "campaign", how, files, calls: calls(&[verb]), promises: false }
}

fn procedure(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let is_one = |e: &&shipped::Embedded| e.path.contains('/');
    let all: Vec<_> = shipped::all(Folder::Procedures).filter(is_one).collect();
    let short = below(random, 4) == 0;
    let run = runs(random);
    let text = match (run, short) {
        (true, _) => SELF_CHECK,
        (_, true) => PROCEDURE,
        _ => one(random, &all).text,
    };
    let (bytes, how) = mutated(text.into(), random);
    let files = vec![file("procedure.toml", bytes)];
    let verbs: &[&str] = match (run, below(random, 4)) {
        (true, _) => &["check procedure.toml", "run procedure.toml --out out --non-interactive --yes"],
        (_, 0) => &["plan procedure.toml --points"],
        _ => &["check procedure.toml"],
    };
    Case { sort: "procedure", how, files, calls: calls(verbs), promises: run }
}

fn requirements(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (bytes, how) = mutated(Bed::shipped(Folder::Procedures, "requirements.toml"), random);
    let files = vec![file("requirements.toml", bytes)];
    let verb = "check quick/az-friction --requirements requirements.toml";
    Case { sort: "requirements", how, files, calls: calls(&[verb]), promises: false }
}

fn rig(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (bytes, how) = mutated(Bed::shipped(Folder::Rigs, "sim.toml"), random);
    let files = vec![file("rig.toml", bytes)];
    on(random, "rig", how, files, "--rig rig.toml")
}

fn unit(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let all: Vec<_> = shipped::all(Folder::Units).collect();
    let text = if below(random, 2) == 0 {
        one(random, &all).text.into()
    } else {
        Bed::shipped(Folder::Units, "nominal.toml")
    };
    let (bytes, how) = mutated(text, random);
    let files = vec![file("unit.toml", bytes)];
    on(random, "unit", how, files, "--unit unit.toml")
}

fn parameters(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (bytes, how) = mutated(Bed::shipped(Folder::Parameters, "director.toml"), random);
    let rig = String::from_utf8_lossy(&Bed::shipped(Folder::Rigs, "sim.toml")).into_owned();
    let rig = rig.replace("parameters = \"director\"", "parameters = \"gains.toml\"");
    let files = vec![file("gains.toml", bytes), file("rig.toml", rig)];
    on(random, "controller parameters", how, files, "--rig rig.toml")
}

/// A check with this option, and now and then a run.
fn on(
    random: &mut ChaCha8Rng,
    sort: &'static str,
    how: &'static str,
    files: Vec<Named>,
    option: &str,
) -> Case {
    let run = runs(random);
    let what = *one(random, &[SHORT, "quick/az-friction", "quick/az-step"]);
    let what = if run { SHORT } else { what };
    let mut all = vec![call(&format!("check {what} {option}"))];
    if run {
        all.push(call(&format!("run {what} {option} --out out --non-interactive --yes")));
    }
    Case { sort, how, files, calls: all, promises: run }
}

fn state(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let all: Vec<_> = shipped::all(Folder::States).collect();
    let (bytes, how) = mutated(one(random, &all).text.into(), random);
    let files =
        vec![file("campaign.toml", CAMPAIGN), file("procedure.toml", PROCEDURE), file("state.toml", bytes)];
    Case { sort: "build state", how, files, calls: calls(&["check campaign.toml"]), promises: false }
}

fn waivers(bed: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (bytes, how) = mutated(WAIVERS.into(), random);
    let mut files = run_folder(bed, &["run.json", "journal.jsonl", "results.json"]);
    files.push(file("waivers.toml", bytes));
    let verb = "report run --waivers waivers.toml --format html,md --out report";
    Case { sort: "waivers", how, files, calls: calls(&[verb]), promises: false }
}

fn answers(_: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (bytes, how) = mutated(ANSWERS.into(), random);
    let files = vec![file("answers.toml", bytes), file("procedure.toml", SELF_CHECK)];
    let verb = "run procedure.toml --answers answers.toml --out out --non-interactive";
    Case { sort: "answers", how, files, calls: calls(&[verb]), promises: false }
}

fn map(bed: &Bed, random: &mut ChaCha8Rng) -> Case {
    imported(bed, random, "import map", "import.toml")
}

fn table(bed: &Bed, random: &mut ChaCha8Rng) -> Case {
    if below(random, 6) > 0 {
        return imported(bed, random, "table", ".csv");
    }
    let time = *one(
        random,
        &["time = \"column\"\ntime-column = \"a\"", "time = \"rate\"\nrate = \"1 kHz\"", "time = \"none\""],
    );
    let map = format!(
        "schema = 1\nprocedure = \"response.toml\"\n{time}\n[[channel]]\nchannel = \"position_rad\"\ncolumn = \"b\"\n\
         unit = \"rad\"\n[[segment]]\nfile = \"t.csv\"\npoint = \"x\"\nbranch = \"record\"\n"
    );
    let response =
        bed.imports.iter().flatten().find(|(name, _)| name == "response.toml").map(|(_, b)| b.clone());
    let files = vec![
        file("import.toml", map),
        file("response.toml", response.unwrap_or_default()),
        file("t.csv", log::dense_table(random)),
    ];
    let calls = calls(&["import import.toml --out log", "rejudge LOG"]);
    Case { sort: "table", how: "many rows", files, calls, promises: false }
}

/// An import with one of its files mutated.
fn imported(bed: &Bed, random: &mut ChaCha8Rng, sort: &'static str, ending: &str) -> Case {
    let mut files = one(random, &bed.imports).clone();
    let fitting: Vec<usize> = (0..files.len()).filter(|&k| files[k].0.ends_with(ending)).collect();
    let at = *one(random, &fitting);
    let (bytes, how) = mutated(std::mem::take(&mut files[at].1), random);
    files[at].1 = bytes;
    Case { sort, how, files, calls: calls(&["import import.toml --out log", "rejudge LOG"]), promises: false }
}

/// Files of the folder of the short run, in a folder `run`.
fn run_folder(bed: &Bed, names: &[&str]) -> Vec<Named> {
    let wanted = |(name, _): &&Named| names.is_empty() || names.contains(&name.as_str());
    bed.run.iter().filter(wanted).map(|(name, bytes)| (format!("run/{name}"), bytes.clone())).collect()
}

/// A run folder with one of its texts mutated.
fn kept(bed: &Bed, random: &mut ChaCha8Rng, name: &'static str) -> Case {
    let mut files = run_folder(bed, &[]);
    let mut how = "";
    for (_, bytes) in files.iter_mut().filter(|(own, _)| own.ends_with(name)) {
        (*bytes, how) = mutated(std::mem::take(bytes), random);
    }
    let verb = match (name, below(random, 4)) {
        ("results.json", 0) | (_, 1) => "rejudge run",
        ("results.json", _) => "report run --format html,json,junit,csv,md --out report",
        ("journal.jsonl", 2) | (_, 3) => "inspect run --non-interactive",
        (_, _) => "rejudge run --out again",
    };
    Case { sort: name, how, files, calls: calls(&[verb]), promises: false }
}

fn log(bed: &Bed, random: &mut ChaCha8Rng) -> Case {
    let (_, original) = one(random, &bed.logs);
    let (bytes, how) = log::mutated(original, random);
    let verb = *one(random, &["rejudge L.mcap", "rejudge L.mcap --out again"]);
    Case { sort: "log", how, files: vec![file("L.mcap", bytes)], calls: calls(&[verb]), promises: false }
}

fn log_of_a_run(bed: &Bed, random: &mut ChaCha8Rng) -> Case {
    let mut files = run_folder(bed, &[]);
    let logs: Vec<usize> = (0..files.len()).filter(|&k| files[k].0.ends_with(".mcap")).collect();
    let at = *one(random, &logs);
    let (bytes, how) = log::mutated(&files[at].1, random);
    files[at].1 = bytes;
    let verb = *one(random, &["rejudge run", "rejudge run --out again", "inspect run --non-interactive"]);
    Case { sort: "log of a run", how, files, calls: calls(&[verb]), promises: false }
}
