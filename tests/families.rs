//! Families of units from the command line: what is drawn, what it runs as, what is said of mistakes.

use std::fs;

use crate::bench::{folder, run_in, write};

const FAMILY: &str = "schema = 1\nid = \"mine\"\ntitle = \"Mine\"\n\n[[setting]]\nkeys = [\"*.inertia\"]\nhalf-width = \"5 % of \
                      nominal\"\nreason = \"payload\"\n";

#[test]
fn drawn_unit_files_are_the_same_each_time_and_each_is_explained_as_a_unit() {
    let folder = folder();
    for out in ["a", "b"] {
        let drawn =
            run_in(folder.path(), &["draw", "production", "--units", "3", "--seed", "7", "--out", out]);
        assert_eq!(drawn.code, 0, "{}", drawn.err);
        assert!(drawn.out.contains("3 units of production with seed 7"), "{}", drawn.out);
    }
    for number in 1..=3 {
        let name = format!("production-7-{number}.toml");
        let [a, b] =
            ["a", "b"].map(|out| fs::read(folder.path().join(out).join(&name)).expect("a unit file"));
        assert_eq!(a, b);
        let explained = run_in(folder.path(), &["explain", &format!("a/{name}")]);
        assert_eq!(explained.code, 0, "{}", explained.err);
        assert!(
            explained.out.contains(&format!("Unit {number} of production with seed 7")),
            "{}",
            explained.out
        );
    }
    let again = run_in(folder.path(), &["draw", "production", "--units", "3", "--out", "a"]);
    assert_eq!(again.code, 2);
    assert!(again.err.contains("the folder is not empty"), "{}", again.err);
}

#[test]
fn a_unit_drawn_from_a_family_of_ones_own_passes_a_procedure() {
    let folder = folder();
    write(folder.path(), "mine.toml", FAMILY);
    let drawn = run_in(
        folder.path(),
        &["draw", "./mine.toml", "--units", "20", "--method", "latin-hypercube", "--out", "units"],
    );
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let unit = "units/mine-latin-hypercube-1-20-of-20.toml";
    let ran = run_in(
        folder.path(),
        &["run", "quick/self-check-open", "--unit", unit, "--out", "run", "--non-interactive"],
    );
    let page = fs::read_to_string(folder.path().join("run/run.json")).unwrap_or_default();
    assert!(page.contains("family-sha256"), "{} {}", ran.code, ran.err);
}

#[test]
fn mistakes_about_families_are_usage_errors_that_say_what_to_do() {
    let folder = folder();
    write(folder.path(), "mine.toml", &FAMILY.replace("5 %", "-5 %"));
    for (asked, said) in [
        (["draw", "./mine.toml", "--units", "2", "--out", "u"].as_slice(), "`half-width` must be above zero"),
        (&["draw", "prodution", "--units", "2", "--out", "u"], "did you mean `production`?"),
        (
            &["draw", "nominal", "--units", "2", "--out", "u"],
            "`nominal` is a unit: give it with `--unit nominal`",
        ),
        (&["run", "--unit", "./mine.toml", "--out", "u"], "draw units from it with `bench draw"),
        (
            &[
                "draw",
                "production",
                "--units",
                "30",
                "--method",
                "sobol",
                "--randomisations",
                "3",
                "--out",
                "u",
            ],
            "at least 10",
        ),
        (&["check", "./mine.toml"], "`half-width` must be above zero"),
    ] {
        let refused = run_in(folder.path(), asked);
        assert_eq!(refused.code, 2, "{asked:?}: {}", refused.err);
        assert!(refused.err.contains(said), "{asked:?}: {}", refused.err);
    }
    let good = run_in(folder.path(), &["list", "families"]);
    assert!(good.out.contains("production"), "{}", good.out);
    write(folder.path(), "mine.toml", FAMILY);
    let checked = run_in(folder.path(), &["check", "./mine.toml"]);
    assert_eq!(checked.code, 0, "{}", checked.err);
    assert!(checked.out.contains("family mine: 2 settings"), "{}", checked.out);
}

/// Runs of one procedure on three drawn units and on one that was not drawn: `1`, `2`, `3`, `nominal`.
fn runs() -> tempfile::TempDir {
    let folder = folder();
    let drawn = run_in(folder.path(), &["draw", "production", "--units", "3", "--out", "units"]);
    assert_eq!(drawn.code, 0, "{}", drawn.err);
    let units = ["1", "2", "3"].map(|number| (number, format!("units/production-1-{number}.toml")));
    for (name, unit) in units.into_iter().chain([("nominal", "nominal".to_owned())]) {
        let of_run = [
            "run",
            "quick",
            "--select",
            "FSM-IMPEDANCE",
            "--unit",
            &unit,
            "--out",
            name,
            "--non-interactive",
        ];
        let ran = run_in(folder.path(), &of_run);
        assert!(matches!(ran.code, 0 | 1 | 3), "{}\n{}", ran.out, ran.err);
    }
    folder
}

#[test]
fn runs_of_drawn_units_give_pass_probabilities_and_quantiles_and_others_are_refused() {
    let folder = runs();
    let asked = ["monte-carlo", "3", "1", "2", "--out", "population"];
    let said = run_in(folder.path(), &asked);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.starts_with("3 units of production (independent, seed 1) through quick"),
        "{}",
        said.out
    );
    let row =
        said.out.lines().find(|line| line.starts_with("FSM-MODE")).unwrap_or_else(|| panic!("{}", said.out));
    assert!(row.contains("100 % (29 % .. 100 %)") && row.ends_with(" %"), "{row}");
    let markdown =
        fs::read_to_string(folder.path().join("population").join("population.md")).expect("a report");
    assert!(markdown.contains("| FSM-MODE |"), "{markdown}");
    let data = run_in(folder.path(), &["monte-carlo", "1", "2", "3", "--json"]);
    let kept = fs::read_to_string(folder.path().join("population/population.json")).expect("a report");
    assert_eq!(data.out.trim_end(), kept.trim_end(), "the order of the folders does not matter");
    let missing = run_in(folder.path(), &["monte-carlo", "1", "3"]);
    assert!(missing.out.contains("without a run: 2"), "{}", missing.out);
    for (folders, expected) in [
        (["1", "2", "1"], "unit `production-1-1` is given twice"),
        (["1", "2", "nominal"], "unit `nominal` was not drawn from a family"),
        (["1", "2", "units"], "units/results.json: cannot be read"),
    ] {
        let refused = run_in(folder.path(), &[&["monte-carlo"][..], &folders].concat());
        assert_eq!(refused.code, 2, "{folders:?}: {}", refused.err);
        assert!(refused.err.contains(expected), "{folders:?}: {}", refused.err);
    }
}
