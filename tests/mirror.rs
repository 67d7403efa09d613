//! The steering mirror through `quick`'s own procedures: the nominal unit passes, each defect of the mirror fails what its
//! file says and nothing that it does not say.

use bench::files::unit::Unit;

use crate::bench::{folder, run_in, verdict};

const MIRROR: [&str; 4] = ["FSM-BW", "FSM-STR", "FSM-MODE", "FSM-CH"];

/// Verdicts of the mirror's requirements on a unit.
fn verdicts(unit: &str) -> Vec<(&'static str, String)> {
    let folder = folder();
    let procedures = ["quick/fsm-impedance", "quick/fsm-response"];
    let arguments =
        ["run", procedures[0], procedures[1], "--unit", unit, "--out", "run", "--non-interactive"];
    let said = run_in(folder.path(), &arguments);
    let run = folder.path().join("run");
    assert!(run.join("results.json").is_file(), "{}\n{}", said.out, said.err);
    MIRROR.into_iter().map(|id| (id, verdict(&run, id))).collect()
}

#[test]
fn nominal_mirror_passes_everything_that_is_asked_of_it() {
    assert_eq!(verdicts("nominal"), MIRROR.map(|id| (id, "pass".to_owned())));
}

#[test]
fn each_defect_of_the_mirror_fails_what_its_file_says_and_nothing_else() {
    for name in ["mirror-serial-slow", "mirror-stroke-short", "mirror-hysteresis", "mirror-notch-off"] {
        let unit = Unit::load(name).expect("a shipped defect");
        let found = verdicts(name);
        for (id, verdict) in &found {
            let must = unit.must_flip.iter().any(|claim| claim == id);
            let may = unit.may_flip.iter().any(|claim| claim == id);
            assert!(!must || verdict == "fail", "{name}: {id} must fail: {found:?}");
            assert!(must || may || verdict == "pass", "{name}: {id} turns unannounced: {found:?}");
        }
    }
}
