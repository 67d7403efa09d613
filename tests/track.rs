//! Tracking of simulated units, from the procedure file to the verdict: the target of a sound one stays in sight and the
//! mirror dwells on it; one that jumps out of the field, or a tracker that drops frames, fails TRK-LOSS.

use std::path::Path;

use crate::bench::{Said, folder, run_in, verdict, write};

const RAIL: &str = include_str!("../procedures/fat/track-rail.toml");
const DRONE: &str = include_str!("../procedures/fat/track-drone.toml");

/// A shipped file with both loops only and a record of 20 s, on the nominal unit with other settings.
fn tracked(folder: &Path, shipped: &str, settings: &str) -> (Said, [String; 4]) {
    let mut text = shipped.replace("[\"coarse\", \"both\"]", "[\"both\"]");
    assert_ne!(text, shipped, "the shipped file has both points");
    for duration in ["\"62 s\"", "\"125 s\""] {
        text = text.replace(duration, "\"20 s\"");
    }
    assert!(text.contains("duration = \"20 s\""), "the shipped file has its length there");
    let unit = format!("schema = 1\nid = \"mine\"\ntitle = \"Mine\"\nbase = \"nominal\"\n\n{settings}\n");
    write(folder, "track.toml", &text);
    write(folder, "unit.toml", &unit);
    let arguments = ["run", "track.toml", "--unit", "unit.toml", "--out", "run", "--non-interactive"];
    let said = run_in(folder, &arguments);
    let of = |id| verdict(&folder.join("run"), id);
    (said, ["TRK-RMS-C", "TRK-RMS-F", "TRK-LOSS", "ENG-DWELL"].map(of))
}

/// The cart sets off within half a second: that opens a window, before the record.
#[test]
fn the_nominal_unit_keeps_its_target_through_a_jump_and_dwells_on_it() {
    let folder = folder();
    let (said, verdicts) = tracked(folder.path(), RAIL, "[target]\nrail-reversal = \"0.5 s\"");
    assert_eq!(verdicts, ["pass", "none", "pass", "pass"], "{}\n{}", said.out, said.err);
    // One elevation does not verify what is claimed of 15 deg to 45 deg.
    assert_eq!(said.code, 3, "{}\n{}", said.out, said.err);
}

/// 8 m/s from one tenth of a second to the next are 94 mrad/s: the target leaves the field of 1 deg within 0.15 s.
#[test]
fn a_target_that_jumps_out_of_the_field_fails_although_the_interlock_ends_the_point() {
    let folder = folder();
    let soon = "[target]\ndrone-hover = \"1 s\"\ndrone-descent = \"1.5 m\"\ndrone-run-speed = \"8 m/s\"";
    let (said, verdicts) = tracked(folder.path(), DRONE, soon);
    assert_eq!(verdicts, ["inconclusive", "none", "fail", "inconclusive"], "{}\n{}", said.out, said.err);
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let results = std::fs::read_to_string(folder.path().join("run/results.json")).expect("results");
    assert!(results.contains("ended by interlock `tracker lost`"), "{}", said.out);
}

/// Of frames that come in four cases of five, three in a row are soon missing.
#[test]
fn a_tracker_that_drops_frames_loses_its_target() {
    let folder = folder();
    let (said, verdicts) = tracked(folder.path(), RAIL, "[trackers]\ncoarse-dropped = \"20 %\"");
    assert_eq!(verdicts[2], "fail", "{}\n{}", said.out, said.err);
}

/// The mirror swings, no camera behind it sees the target.
#[test]
fn a_mirror_loop_without_its_notch_never_dwells() {
    let folder = folder();
    let notch = "[mirror]\nnotch = \"0\"\naz-damping = \"0.08\"\nel-damping = \"0.08\"";
    let (said, verdicts) = tracked(folder.path(), RAIL, notch);
    assert_eq!(verdicts[3], "fail", "{}\n{}", said.out, said.err);
}
