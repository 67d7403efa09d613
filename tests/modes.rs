//! Modes of the simulated structure through the whole bench: a sound one agrees with its calculation, a soft one does not.

use std::path::Path;

use crate::bench::{Said, folder, run_in, verdict, write};

/// The quick procedure of the shipped files, with half of its time.
fn measured(folder: &Path, unit: &str) -> Said {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../procedures/quick/el-modes.toml");
    let text = std::fs::read_to_string(shipped).expect("a shipped file");
    assert!(text.contains("duration = \"55 s\""), "{text}");
    let file = write(folder, "el-modes.toml", &text.replace("duration = \"55 s\"", "duration = \"30 s\""));
    let file = file.to_str().expect("a path of ours");
    run_in(folder, &["run", file, "--unit", unit, "--out", "run", "--non-interactive"])
}

#[test]
fn the_nominal_structure_agrees_with_its_calculation() {
    let folder = folder();
    let said = measured(folder.path(), "nominal");
    for id in ["STR-MODE-2", "STR-MODE-3"] {
        assert_eq!(verdict(&folder.path().join("run"), id), "pass", "{id}\n{}\n{}", said.out, said.err);
    }
}

#[test]
fn a_soft_joint_fails_the_mode_that_it_lowers() {
    let folder = folder();
    let said = measured(folder.path(), "mode-low");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "STR-MODE-2"), "fail", "{}", said.out);
    assert_eq!(verdict(&run, "STR-MODE-3"), "pass", "{}", said.out);
}
