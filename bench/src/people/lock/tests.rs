use super::*;
use crate::record::journal::{Entry, Journal};

const RIG: &[&str] = &["director bus 0"];

fn named(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// A run folder with a journal that was never closed.
fn begun(folder: &Path, name: &str) -> (PathBuf, Journal) {
    let run = folder.join(name);
    std::fs::create_dir(&run).expect("writable");
    let mut journal = Journal::create(&run).expect("fresh");
    let opened = Entry::Opened { campaign: "c".into(), rig: "r".into(), unit: "u".into(), seed: 1 };
    journal.write(opened).expect("writable");
    (run, journal)
}

#[test]
fn a_resource_belongs_to_one_run_and_the_next_is_told_whose() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let first = take(folder.path(), &named(RIG), Path::new("runs/1")).expect("free");
    let told = take(folder.path(), &named(RIG), Path::new("runs/2")).expect_err("held").to_string();
    let pid = std::process::id();
    assert!(told.starts_with("director bus 0 is in use by run runs/1 (process "), "{told}");
    assert!(told.contains(&pid.to_string()), "{told}");
    take(folder.path(), &named(&["another rig"]), Path::new("runs/2")).expect("another resource is free");
    first.release();
    take(folder.path(), &named(RIG), Path::new("runs/2")).expect("free again");
}

#[test]
fn one_resource_that_is_held_leaves_all_others_free() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let _held = take(folder.path(), &named(&["b"]), Path::new("runs/1")).expect("free");
    take(folder.path(), &named(&["a", "b"]), Path::new("runs/2")).expect_err("b is held");
    take(folder.path(), &named(&["a"]), Path::new("runs/3")).expect("a was let go");
}

#[test]
fn a_run_that_dies_while_armed_must_be_inspected_first() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (run, mut journal) = begun(folder.path(), "lost");
    let held = take(folder.path(), &named(RIG), &run).expect("free");
    held.arm().expect("writable");
    drop(held); // the process dies: the lock goes, the mark stays
    let refused = take(folder.path(), &named(RIG), Path::new("runs/2")).expect_err("lost");
    assert!(refused.to_string().contains(&format!("`bench inspect {}`", run.display())), "{refused}");
    take_to_inspect(folder.path(), &named(RIG), Path::new("runs/2")).expect_err("not the run that was lost");
    take_to_inspect(folder.path(), &named(RIG), &run).expect("this one may look");
    let looked = |released| Entry::Inspected {
        by: "me".into(),
        found: "nothing".into(),
        angles_deg: Vec::new(),
        agrees: false,
        released,
    };
    journal.write(looked(false)).expect("writable");
    take(folder.path(), &named(RIG), Path::new("runs/2")).expect_err("looked at, but not released");
    journal.write(looked(true)).expect("writable");
    take(folder.path(), &named(RIG), Path::new("runs/2")).expect("released");
}

#[test]
fn a_mark_of_a_run_whose_journal_is_closed_is_left_over_and_does_no_harm() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (run, journal) = begun(folder.path(), "ended");
    let held = take(folder.path(), &named(RIG), &run).expect("free");
    held.arm().expect("writable");
    drop(held);
    journal.close(0).expect("writable");
    take(folder.path(), &named(RIG), Path::new("runs/2")).expect("it ended well");
}

#[test]
fn a_mark_that_cannot_be_read_stands_for_a_lost_run() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (run, _journal) = begun(folder.path(), "lost");
    let held = take(folder.path(), &named(RIG), &run).expect("free");
    held.arm().expect("writable");
    drop(held);
    let mark = folder.path().join("bench-director_bus_0.armed");
    for damage in ["", "{\"run\":"] {
        std::fs::write(&mark, damage).expect("writable");
        take(folder.path(), &named(RIG), Path::new("runs/2")).expect_err(damage);
    }
    std::fs::remove_dir_all(&run).expect("removable");
    take(folder.path(), &named(RIG), Path::new("runs/2")).expect_err("nor does a folder that is gone help");
}
