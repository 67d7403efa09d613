//! Tracking of simulated units, from the procedure file to the verdict: the target of a sound one stays in sight and the
//! mirror dwells on it; one that jumps out of the field, or a tracker that drops frames, fails TRK-LOSS.

use std::path::Path;

use crate::bench::{Said, folder, run_in, verdict, write};

/// The shipped points, one of them and shorter: the drone comes down sooner and flies along the rails while the record runs.
const PROCEDURE: &str = include_str!("../procedures/fat/track-drone.toml");
const UNIT: &str = "schema = 1\nid = \"brisk\"\ntitle = \"Nominal unit, brisk drone\"\nbase = \"nominal\"\n\n\
                    [target]\ndrone-hover = \"1 s\"\ndrone-descent = \"1.5 m\"\ndrone-run = \"40 m\"\n";

fn tracked(folder: &Path, more: &str) -> (Said, [String; 4]) {
    let both = PROCEDURE.replace("[\"coarse\", \"both\"]", "[\"both\"]");
    let shorter = both.replace("duration = \"125 s\"", "duration = \"20 s\"");
    assert!(both != PROCEDURE && shorter != both, "the shipped file has its loops and its length there");
    write(folder, "track.toml", &shorter);
    write(folder, "unit.toml", &format!("{UNIT}{more}"));
    let arguments = ["run", "track.toml", "--unit", "unit.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder, &arguments);
    let of = |id| verdict(&folder.join("run"), id);
    (said, ["TRK-RMS-C", "TRK-RMS-F", "TRK-LOSS", "ENG-DWELL"].map(of))
}

#[test]
fn the_nominal_unit_keeps_its_target_through_a_jump_and_dwells_on_it() {
    let folder = folder();
    let (said, verdicts) = tracked(folder.path(), "");
    assert_eq!(verdicts, ["pass", "none", "pass", "pass"], "{}\n{}", said.out, said.err);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
}

/// 8 m/s from one tenth of a second to the next are 94 mrad/s: the target leaves the field of 1 deg within 0.15 s.
#[test]
fn a_target_that_jumps_out_of_the_field_fails_although_the_interlock_ends_the_point() {
    let folder = folder();
    let (said, verdicts) = tracked(folder.path(), "drone-run-speed = \"8 m/s\"\n");
    assert_eq!(verdicts, ["inconclusive", "none", "fail", "inconclusive"], "{}\n{}", said.out, said.err);
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let results = std::fs::read_to_string(folder.path().join("run/results.json")).expect("results");
    assert!(results.contains("ended by interlock `tracker lost`"), "{}", said.out);
}

/// Of frames that come in four cases of five, three in a row are soon missing.
#[test]
fn a_tracker_that_drops_frames_loses_its_target() {
    let folder = folder();
    let (said, verdicts) = tracked(folder.path(), "\n[trackers]\ncoarse-dropped = \"20 %\"\n");
    assert_eq!(verdicts[2], "fail", "{}\n{}", said.out, said.err);
}
