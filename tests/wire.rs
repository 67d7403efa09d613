//! Captures and faults of the wire, as far as no interface is needed.

use crate::bench::{folder, run_in, write};

#[test]
fn captures_and_faults_need_a_rig_with_an_interface() {
    let folder = folder();
    for option in [["--tap", "wire.pcapng"], ["--wire-fault", "back:drop@0.1"]] {
        for rig in ["sim", "paced"] {
            let said = run_in(folder.path(), &[&["run", "quick", "--rig", rig], &option[..]].concat());
            assert_eq!(said.code, 2, "{option:?}: {}", said.err);
            let expected = format!("{} {}: expected a rig of tier wired or hardware", option[0], option[1]);
            assert!(said.err.contains(&expected), "{}", said.err);
            assert!(said.err.contains("leave out the option or choose another --rig"), "{}", said.err);
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 0, "nothing was made");
}

#[test]
fn captures_overwrite_nothing_and_have_a_format_each() {
    let folder = folder();
    write(folder.path(), "old.pcapng", "");
    for (files, expected) in [
        (&["wire.pcap"][..], "--tap wire.pcap: expected a name that ends with `.pcapng` or `.mcap`"),
        (&["old.pcapng"], "--tap old.pcapng: the file exists"),
        (&["a.mcap", "b.mcap"], "--tap b.mcap: expected one file of each format"),
        (&["runs/x.mcap"], "--tap runs/x.mcap: a tap is no evidence and cannot lie in the run folder"),
    ] {
        let taps: Vec<&str> = files.iter().flat_map(|file| ["--tap", file]).collect();
        let asked = ["run", "wired", "--rig", "wired", "--yes", "--out", "runs"];
        let said = run_in(folder.path(), &[&asked, &taps[..]].concat());
        assert_eq!(said.code, 2, "{files:?}: {}", said.err);
        assert!(said.err.contains(expected), "{files:?}: {}", said.err);
    }
}

#[test]
fn a_fault_that_cannot_be_read_is_told_what_was_expected() {
    let folder = folder();
    let said = run_in(folder.path(), &["run", "quick", "--wire-fault", "back:drop=0.001"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("expected WAY:KIND@WHEN, e.g. `back:drop@0.001`"), "{}", said.err);
    let help = run_in(folder.path(), &["run", "--help"]).out;
    for word in ["--tap <FILE>", "--wire-fault <FAULT>", "WAY is `out`", "`delay=300us`", "`1000x3`"] {
        assert!(help.contains(word), "{word}: {help}");
    }
}

#[cfg(target_os = "linux")]
#[test]
#[allow(clippy::print_stderr)]
fn faults_are_refused_before_the_first_frame_where_the_interface_is_hardware() {
    let is_hardware =
        |name: &String| std::path::Path::new("/sys/class/net").join(name).join("device").exists();
    let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let Some(hardware) = names.filter(|name| name.len() < 16).find(is_hardware) else {
        eprintln!("skipped: this computer has no network card");
        return;
    };
    let folder = folder();
    let rig =
        include_str!("../bench/rigs/wired.toml").replace("ethercat:ecm/", &format!("ethercat:{hardware}/"));
    write(folder.path(), "rig.toml", &rig);
    let said = run_in(
        folder.path(),
        &["run", "wired", "--rig", "rig.toml", "--yes", "--wire-fault", "back:drop@0.1"],
    );
    assert_eq!(said.code, 6, "{}", said.err);
    assert!(said.err.contains(&format!("interface {hardware} has a physical device")), "{}", said.err);
}
