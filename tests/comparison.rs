//! `bench compare`: what differs between two runs, and nothing else.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::bench::{Said, folder, run_in, write};

/// Runs that several tests compare: `nominal`, `other-seed` and `as-measured`.
pub(crate) fn runs() -> &'static Path {
    static RUNS: OnceLock<PathBuf> = OnceLock::new();
    RUNS.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("comparison");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).expect("the folder of an earlier test");
        }
        std::fs::create_dir_all(&folder).expect("a folder for tests");
        for (name, unit, seed) in
            [("nominal", "nominal", "1"), ("other-seed", "nominal", "2"), ("as-measured", "as-measured", "1")]
        {
            let select = ["--select", "EL-FRICTION", "--select", "AZ-LATENCY"];
            let of_run = ["run", "quick", "--unit", unit, "--seed", seed, "--out", name, "--non-interactive"];
            let said = run_in(&folder, &[&of_run[..], &select].concat());
            assert!(matches!(said.code, 0 | 1 | 3), "{}\n{}", said.out, said.err);
        }
        folder
    })
}

fn compare(arguments: &[&str]) -> Said {
    run_in(runs(), &[&["compare"], arguments].concat())
}

fn json(said: &Said) -> serde_json::Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {}", said.out))
}

/// Measurands and axes of the values that are called so.
fn called(compared: &serde_json::Value, call: &str) -> BTreeSet<String> {
    let values = compared["findings"]["values"].as_array().expect("a list of values");
    let name = |pair: &serde_json::Value| {
        let quantity = &pair["quantity"];
        format!(
            "{} {}",
            quantity["measurand"].as_str().unwrap_or("?"),
            quantity["axis"].as_str().unwrap_or("?")
        )
    };
    values.iter().filter(|pair| pair["call"] == call).map(name).collect()
}

#[test]
fn a_run_is_identical_to_itself() {
    let said = compare(&["nominal", "nominal"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.lines().last().is_some_and(|line| line.starts_with("identical: ")), "{}", said.out);
    let compared = json(&compare(&["nominal", "nominal", "--json"]));
    assert_eq!((&compared["identical"], &compared["differs"]), (&true.into(), &false.into()));
    assert!(called(&compared, "same").is_empty() && called(&compared, "identical").len() > 20);
}

#[test]
fn another_seed_of_the_same_unit_gives_no_difference_beyond_uncertainty() {
    let said = compare(&["nominal", "other-seed"]);
    assert_eq!(said.code, 0, "{}", said.out);
    assert!(said.out.contains("no difference beyond uncertainty"), "{}", said.out);
    let seeds: Vec<&str> = said.out.lines().filter(|line| line.ends_with("differs")).collect();
    assert_eq!(seeds.len(), 1, "only the seeds of the title pages differ: {}", said.out);
    assert!(seeds[0].starts_with("seed "), "{}", seeds[0]);
}

#[test]
fn the_unit_as_measured_differs_from_nominal_in_what_its_file_says() {
    let said = compare(&["nominal", "as-measured", "--json"]);
    assert_eq!(said.code, 1, "{}", said.err);
    let differ = called(&json(&said), "differs");
    // Spring of elevation, delays of azimuth; the rigid gains over elevation make both axes accelerate differently.
    for expected in ["spring-stiffness el", "spring-torque el", "transport-round-trip az"] {
        assert!(differ.contains(expected), "{expected} is not among {differ:?}");
    }
    // The largest friction of any cogging period is told from what is left of the load.
    let follows =
        ["spring-", "transport-", "small-motion-inertia ", "torque-scale-ratio ", "friction-unevenness el"];
    let strange: Vec<&String> =
        differ.iter().filter(|name| !follows.iter().any(|part| name.starts_with(part))).collect();
    assert!(strange.is_empty(), "no setting of the file explains {strange:?}");
    let text = compare(&["nominal", "as-measured"]).out;
    for fact in ["unit ", "unit files "] {
        let line =
            text.lines().find(|line| line.starts_with(fact)).unwrap_or_else(|| panic!("{fact}: {text}"));
        assert!(line.ends_with("differs"), "{line}");
    }
}

#[test]
fn a_tolerance_leaves_small_differences_alone() {
    let tolerant = json(&compare(&["nominal", "as-measured", "--tolerance", "0.9", "--json"]));
    assert_eq!(tolerant["tolerance"], 0.9);
    assert!(called(&tolerant, "differs").is_empty());
    assert_eq!(compare(&["nominal", "as-measured", "--tolerance", "2"]).code, 2);
}

#[test]
fn the_comparison_is_written_as_markdown_and_as_data_and_never_over_something() {
    let folder = folder();
    let out = folder.path().join("difference");
    let path = out.to_str().expect("a plain path");
    assert_eq!(compare(&["nominal", "as-measured", "--out", path]).code, 1);
    let markdown = std::fs::read_to_string(out.join("comparison.md")).expect("Markdown");
    assert!(markdown.contains("| EL-FRICTION | spring-stiffness | el |"), "{markdown}");
    assert!(markdown.contains("## Values that are the same"), "{markdown}");
    let data = std::fs::read_to_string(out.join("comparison.json")).expect("data");
    let data: serde_json::Value = serde_json::from_str(&data).expect("JSON");
    assert_eq!(data["schema"], "comparison/1");
    assert_eq!(compare(&["nominal", "as-measured", "--out", path]).code, 2, "the folder is not empty");
}

#[test]
fn what_cannot_be_compared_is_told() {
    let folder = folder();
    let compare_here = |b: &str| {
        let nominal = runs().join("nominal");
        run_in(folder.path(), &["compare", nominal.to_str().expect("a plain path"), b])
    };
    let gone = compare_here("gone");
    assert_eq!(gone.code, 2);
    assert!(gone.err.contains("gone"), "{}", gone.err);
    let results = std::fs::read_to_string(runs().join("nominal/results.json")).expect("results");
    write(folder.path(), "later/results.json", &results.replace("fat-result/1", "fat-result/9"));
    let later = compare_here("later");
    assert_eq!(later.code, 2);
    assert!(later.err.contains("schema `fat-result/9`, expected `fat-result/1`"), "{}", later.err);
    let others =
        ["EL-FRICTION", "AZ-LATENCY", "POLARITY"].iter().fold(results, |text, id| text.replace(id, "OTHER"));
    write(folder.path(), "other/results.json", &others);
    let other = compare_here("other");
    assert_eq!(other.code, 2, "{}", other.out);
    assert!(other.err.contains("nothing to compare"), "{}", other.err);
}

#[test]
fn a_run_is_compared_with_published_values() {
    let folder = folder();
    let table = "schema = 1\nid = \"study\"\ntitle = \"The study\"\nsource = \"study, table 3.5\"\n\
        [[value]]\nmeasurand = \"spring-stiffness\"\naxis = \"el\"\nvalue = \"54 N*m/rad\"\nu = \"0.3 N*m/rad\"\n\
        [[value]]\nmeasurand = \"viscous-coefficient\"\naxis = \"el\"\nvalue = \"68.4 N*m*s/rad\"\n\
        u = \"0.03 N*m*s/rad\"\n";
    let path = write(folder.path(), "study.toml", table);
    let table = path.to_str().expect("a plain path");
    let nominal = compare(&["nominal", table, "--json"]);
    assert_eq!(nominal.code, 1, "{}", nominal.err);
    assert_eq!(called(&json(&nominal), "differs"), BTreeSet::from(["spring-stiffness el".to_owned()]));
    let as_measured = compare(&["as-measured", table]);
    assert_eq!(as_measured.code, 0, "{}", as_measured.out);
    write(folder.path(), "wrong.toml", "schema = 1\nid = \"x\"\ntitle = \"x\"\nsource = \"x\"\n");
    let wrong = folder.path().join("wrong.toml");
    assert_eq!(compare(&["nominal", wrong.to_str().expect("a plain path")]).code, 2, "no value");
}

#[test]
fn the_published_values_in_the_documents_are_read_and_the_run_that_measured_none_of_them_is_told_so() {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/published/velocity-loops.toml");
    let said = compare(&["nominal", table.to_str().expect("a plain path")]);
    assert_eq!(said.code, 2, "{}", said.out);
    assert!(said.err.contains("nothing to compare"), "{}", said.err);
}
