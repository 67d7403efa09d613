//! Lines that another process of the bench holds: who wants one is refused, and told who has it.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

use crate::bench::{folder, run_in, write};

const RIG: &str = include_str!("../bench/rigs/wired.toml");

/// The locks of a resource in all folders in which the program may keep them, held by this process.
fn held(resource: &str, holder: &str) -> Vec<(PathBuf, File)> {
    let folders = [PathBuf::from("/run/lock"), PathBuf::from("/var/lock"), std::env::temp_dir()];
    let held = folders.into_iter().filter_map(|folder| {
        let path = folder.join(format!("bench-{resource}.lock"));
        // Two of the folders may be one.
        let mut file = File::create_new(&path).ok()?;
        file.try_lock().expect("nobody else knows the file");
        file.write_all(holder.as_bytes()).expect("a writable folder");
        Some((path, file))
    });
    held.collect()
}

#[test]
fn an_instrument_that_another_process_has_is_refused_with_the_holder_and_taken_over_when_that_is_dead() {
    let folder = folder();
    // Nobody listens at this port of this computer, and no interface has this name: nothing is opened.
    let port = 20_000 + std::process::id() % 10_000;
    let scope = format!(
        "\n[[device]]\nname = \"scope\"\ndriver = \"infiniivision\"\nports = {{ line = \"tcp:localhost:{port}\" }}\n"
    );
    let interface = format!("lk{port}");
    write(
        folder.path(),
        "rig.toml",
        &(RIG.replace("ethercat:ecm/", &format!("ethercat:{interface}/")) + &scope),
    );
    let holder = r#"{"verb":"sim","run":"","pid":1234,"utc":"2026-01-01T00:00:00Z"}"#;
    // The first address of the name is that of either version.
    let resources = [format!("instrument_127_0_0_1_{port}"), format!("instrument____1__{port}")];
    let locks: Vec<(PathBuf, File)> = resources.iter().flat_map(|resource| held(resource, holder)).collect();
    assert!(!locks.is_empty(), "no folder for lock files is writable");
    let run = ["run", "shipped:wired/az-friction.toml", "--rig", "./rig.toml", "--yes", "--non-interactive"];
    for arguments in [&["devices", "--rig", "./rig.toml"][..], &[&run[..], &["--out", "refused"]].concat()] {
        let said = run_in(folder.path(), arguments);
        assert_eq!(said.code, 6, "{}{}", said.out, said.err);
        let expected = "is in use by `bench sim` (process 1234, since 2026-01-01T00:00:00Z); wait until it ends or stop it";
        assert!(said.err.contains(expected) && said.err.contains("instrument "), "{}", said.err);
    }
    let paths: Vec<PathBuf> = locks.iter().map(|(path, _)| path.clone()).collect();
    drop(locks);
    // The files are still there, as those of a process that died. What is missing now is the interface.
    let said = run_in(folder.path(), &["devices", "--rig", "./rig.toml"]);
    assert_eq!(said.code, 4, "{}{}", said.out, said.err);
    assert!(said.err.contains("no such network interface"), "{}", said.err);
    let own = PathBuf::from(format!("/run/lock/bench-interface_{interface}.lock"));
    for path in paths.iter().chain([&own]) {
        let _ = std::fs::remove_file(path);
    }
}
