//! `bench regress` and `bench merge`: two controllers on the same units, from the command line to the files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use sim_devices::unit::UnitSettings;
use validation::prediction::{Expected, predict};
use validation::shipped;

use crate::bench::{Said, content, folder, run_in, write};

const GAINS: &str = include_str!("../controllers/params/director.toml");

/// A folder with a campaign of one loop, its criteria, three units, and controllers: `slow.toml` has 20 % less gain in elevation,
/// `wild.toml` swings up.
fn desk(folder: &Path) {
    let campaign = "schema = 1\nid = \"loop\"\ntitle = \"One loop\"\nmust-measure = [\"VEL-BW\"]\nclaim = \"screening\"\n\
        requirements = \"shipped:requirements.toml\"\n\
        [[procedure]]\nfile = \"shipped:regression/el-velocity-loop.toml\"\n";
    write(folder, "loop.toml", campaign);
    let criteria = "schema = 1\n[[criterion]]\nrequirement = \"VEL-BW\"\nmargin = \"0.1 Hz\"\n\
        [[criterion]]\nrequirement = \"VEL-PM\"\nmargin = \"1 deg\"\nblocking = false\n";
    write(folder, "regress.toml", criteria);
    for (name, inertia) in [("light", 0.97), ("medium", 1.0), ("heavy", 1.03)] {
        let unit = format!(
            "schema = 1\nid = \"{name}\"\ntitle = \"{name}\"\nbase = \"nominal\"\n[el]\ncoulomb-torque = \"{} N*m\"\n",
            40.0 * inertia
        );
        write(folder, &format!("{name}.toml"), &unit);
    }
    assert!(GAINS.contains("velocity-kp = \"18250 N*m*s/rad\""), "the gain that the tests change");
    write(folder, "slow.toml", &GAINS.replace("18250 N*m*s/rad", "14600 N*m*s/rad"));
    write(folder, "wild.toml", &GAINS.replace("18250 N*m*s/rad", "90000 N*m*s/rad"));
}

const UNITS: [&str; 4] = ["--unit", "./light.toml", "./medium.toml", "./heavy.toml"];

fn regress(folder: &Path, arguments: &[&str]) -> Said {
    run_in(folder, &[&["regress", "./loop.toml"], &UNITS[..], arguments].concat())
}

/// A folder in which `slow` was compared with the baseline, into `slow`.
fn compared() -> &'static Path {
    static DONE: OnceLock<PathBuf> = OnceLock::new();
    DONE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("regression");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).expect("the folder of an earlier test");
        }
        std::fs::create_dir_all(&folder).expect("a folder for tests");
        desk(&folder);
        let said = regress(&folder, &["--candidate", "./slow.toml", "--out", "slow", "--jobs", "2"]);
        assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
        folder
    })
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

const FILES: [&str; 6] =
    ["baseline.json", "candidate.json", "criteria.json", "junit.xml", "regression.json", "regression.md"];

/// Bandwidth of elevation's velocity loop at 0 degrees by the linear model, with this share of its proportional gain.
fn bandwidth_hz(share: f64) -> f64 {
    let mut gains = shipped::gains();
    gains.el.velocity_kp_nm_s_per_rad *= share;
    let rows = predict(&UnitSettings::default(), &gains);
    let is_own = |row: &&Expected| {
        row.requirement == "VEL-BW" && row.axis == Some(1) && row.condition == "elevation 0 deg"
    };
    rows.iter().find(is_own).expect("a row of the model").value_si
}

#[test]
fn less_gain_is_worse_by_what_it_takes_from_the_bandwidth_and_the_comparison_says_where() {
    let markdown = String::from_utf8(bytes(compared(), "slow/regression.md")).expect("text");
    assert!(
        markdown.starts_with("# Servo regression: worse: 1 of 1 blocking comparison blocked"),
        "{markdown}"
    );
    let row = markdown.lines().find(|line| line.starts_with("| WORSE |")).expect("a row that blocks");
    assert!(row.contains("VEL-BW") && row.contains("EL-VELOCITY-LOOP el"), "{row}");
    let data: serde_json::Value =
        serde_json::from_slice(&bytes(compared(), "slow/regression.json")).expect("JSON");
    let shift = data["decision"]["outcomes"][0]["shift"].as_f64().expect("a shift");
    let expected = bandwidth_hz(1.0) - bandwidth_hz(14_600.0 / 18_250.0);
    assert!(
        expected > 0.2 && (shift - expected).abs() < 0.02,
        "{shift} Hz, by the linear model {expected} Hz"
    );
    assert_eq!(
        std::fs::read_dir(compared().join("slow")).expect("a folder").count(),
        FILES.len(),
        "no log stays"
    );
}

#[test]
fn a_controller_beside_itself_is_identical_and_one_job_writes_the_bytes_of_two() {
    let folder = folder();
    desk(folder.path());
    let said = regress(folder.path(), &["--candidate", "director", "--out", "one", "--jobs", "1"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    assert!(said.out.contains("identical: 1 blocking comparison with the same values"), "{}", said.out);
    assert_eq!(bytes(folder.path(), "one/baseline.json"), bytes(compared(), "slow/baseline.json"));
}

#[test]
fn merged_shards_have_the_bytes_of_the_whole_and_a_lost_one_is_named_and_run_again_alone() {
    let folder = folder();
    desk(folder.path());
    let shard = |number: u32| {
        let [part, out] = [format!("{number}/2"), format!("part-{number}")];
        let arguments = ["--candidate", "./slow.toml", "--shard", &part, "--out", &out];
        let said = regress(folder.path(), &arguments);
        assert_eq!(said.code, 0, "{}", said.err);
    };
    shard(2);
    let lost = run_in(folder.path(), &["merge", "part-2", "--out", "whole"]);
    assert_eq!(lost.code, 2);
    assert!(
        lost.err.contains("shards 1 of 2 are missing") && lost.err.contains("--shard 1/2"),
        "{}",
        lost.err
    );
    shard(1);
    let merged = run_in(folder.path(), &["merge", "part-2", "part-1", "--out", "whole"]);
    assert_eq!(merged.code, 1, "{}\n{}", merged.out, merged.err);
    for file in FILES {
        let [own, whole] =
            [bytes(folder.path(), &format!("whole/{file}")), bytes(compared(), &format!("slow/{file}"))];
        assert!(own == whole, "{file} differs");
    }
    let twice = run_in(folder.path(), &["merge", "part-2", "part-2", "part-1", "--out", "again"]);
    assert!(twice.code == 2 && twice.err.contains("is in part-2, too"), "{}", twice.err);
}

#[test]
fn a_stored_baseline_is_compared_without_running_it_again() {
    let folder = folder();
    desk(folder.path());
    let stored = compared().join("slow/baseline.json");
    let stored = stored.to_str().expect("a plain path");
    let said = regress(folder.path(), &["--baseline", stored, "--candidate", "director", "--out", "again"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    assert!(said.err.contains("3 of 3 runs"), "only the candidate ran: {}", said.err);
    let other_seed =
        ["--baseline", stored, "--candidate", "director", "--out", "seed", "--seed", "5", "--bisect"];
    let other = regress(folder.path(), &other_seed);
    assert_eq!(other.code, 125, "{}", other.err);
    assert!(other.err.contains("seed: the baseline has 1, the candidate has 5"), "{}", other.err);
}

#[test]
fn a_candidate_that_trips_is_worse_and_its_units_are_named() {
    let folder = folder();
    desk(folder.path());
    let said = regress(folder.path(), &["--candidate", "./wild.toml", "--out", "wild", "--bisect"]);
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert!(said.out.contains("runs ended early with the candidate"), "{}", said.out);
    let junit = String::from_utf8(bytes(folder.path(), "wild/junit.xml")).expect("text");
    assert!(junit.contains("failures=\"3\""), "{junit}");
}

#[test]
fn what_cannot_be_compared_is_told_before_anything_runs() {
    let folder = folder();
    desk(folder.path());
    write(folder.path(), "no-margin.toml", "schema = 1\n[[criterion]]\nrequirement = \"VEL-BW\"\n");
    write(
        folder.path(),
        "unknown.toml",
        "schema = 1\n[[criterion]]\nrequirement = \"VEL-BV\"\nmargin = \"1 Hz\"\n",
    );
    write(
        folder.path(),
        "elsewhere.toml",
        "schema = 1\n[[criterion]]\nrequirement = \"TRK-BW\"\nmargin = \"0.1 Hz\"\n",
    );
    write(folder.path(), "later.json", "{ \"schema\": \"regression-arm/9\" }");
    let with = |more: &[&str]| {
        regress(folder.path(), &[&["--candidate", "director", "--out", "never"], more].concat())
    };
    for (arguments, expected) in [
        (&["--criteria", "./no-margin.toml"][..], "missing key `margin`"),
        (&["--criteria", "./unknown.toml"][..], "unknown requirement `VEL-BV`"),
        (&["--criteria", "./light.toml"][..], "contains a simulated unit"),
        (&["--baseline", "./later.json"][..], "schema `regression-arm/9`, expected `regression-arm/1`"),
        (&["--baseline", "./gone.json"][..], "gone.json: cannot be read"),
        (&["--shard", "3/2"][..], "expected K/N with K from 1 to N"),
        (&["--shard", "1/4"][..], "4 parts of 3 units; some would be empty"),
        (&["--criteria", "./elsewhere.toml"][..], "no procedure of campaign `loop` measures it"),
        (&["--sequential"][..], "--sequential looks at up to 40 units, and there are 3"),
    ] {
        let said = with(arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.err);
        assert!(said.err.contains(expected), "{arguments:?}: {}", said.err);
    }
    let twice = run_in(
        folder.path(),
        &["regress", "./loop.toml", "--unit", "nominal", "nominal", "--candidate", "director"],
    );
    assert!(
        twice.code == 2 && twice.err.contains("unit `nominal` is named twice, or equals another one"),
        "{}",
        twice.err
    );
    std::fs::remove_file(folder.path().join("regress.toml")).expect("a file");
    let without = with(&[]);
    assert!(
        without.code == 2 && without.err.contains("no criteria: `regress.toml` is not here"),
        "{}",
        without.err
    );
}

#[test]
fn proposed_criteria_are_read_and_call_the_controller_beside_itself_identical() {
    let folder = folder();
    desk(folder.path());
    let stored = compared().join("slow/baseline.json");
    let stored = stored.to_str().expect("a plain path");
    let said = regress(folder.path(), &["--baseline", stored, "--propose", "proposed.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = std::fs::read_to_string(folder.path().join("proposed.toml")).expect("criteria");
    assert!(text.contains("requirement = \"VEL-BW\"\nmargin = "), "{text}");
    assert_eq!(
        regress(folder.path(), &["--baseline", stored, "--propose", "proposed.toml"]).code,
        2,
        "it exists"
    );
}

#[test]
fn an_arm_that_drops_tracker_frames_leaves_every_other_stream_of_the_log_unchanged() {
    let folder = folder();
    write(
        folder.path(),
        "lossy.toml",
        "schema = 1\nid = \"lossy\"\ntitle = \"Lossy link\"\n[trackers]\ncoarse-dropped = \"60 %\"\nfine-dropped = \"60 %\"\n",
    );
    write(folder.path(), "still.toml", STILL);
    let arguments = [
        "regress",
        "./still.toml",
        "--criteria",
        "./track.toml",
        "--unit",
        "nominal",
        "as-measured",
        "--candidate",
        "director",
        "--candidate-state",
        "./lossy.toml",
        "--out",
        "out",
        "--keep",
    ];
    write(
        folder.path(),
        "track.toml",
        "schema = 1\n[[criterion]]\nrequirement = \"LAT-TRK\"\nmeasurand = \"tracker-latency\"\nmargin = \"50 %\"\n",
    );
    let said = run_in(folder.path(), &arguments);
    assert!(matches!(said.code, 0 | 3), "{}\n{}", said.out, said.err);
    let streams = |arm: &str| {
        let log = folder.path().join(format!("out/runs/unit-1-seed-1-{arm}/AZ-COARSE-LATENCY.mcap"));
        let mut streams: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
        for (topic, time, bytes) in content(&log).into_iter().filter(|(topic, ..)| topic.starts_with('/')) {
            streams.entry(topic).or_default().push((time, bytes));
        }
        streams
    };
    let [baseline, candidate] = ["baseline", "candidate"].map(streams);
    assert!(baseline.len() > 8 && baseline.keys().eq(candidate.keys()), "{:?}", baseline.keys());
    let differ: Vec<&String> =
        baseline.keys().filter(|topic| baseline[*topic] != candidate[*topic]).collect();
    assert_eq!(differ, ["/coarse", "/events", "/fine"], "only what tells of frames");
}

/// Trackers measured at rest: no loop is closed by what they see.
const STILL: &str = "schema = 1\nid = \"still\"\ntitle = \"Trackers at rest\"\nmust-measure = []\nclaim = \"screening\"\n\
    requirements = \"shipped:requirements.toml\"\n\
    [[procedure]]\nfile = \"shipped:quick/az-coarse-latency.toml\"\n";
