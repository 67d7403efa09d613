//! Drives on a CAN bus through a procedure, rehearsed in process with frames that take their time.

use crate::bench::{folder, run_in};

#[test]
fn a_rig_on_can_runs_a_procedure_in_virtual_time() {
    let folder = folder();
    let arguments = [
        "run",
        "wired/az-friction",
        "--rig",
        "can",
        "--tier",
        "virtual",
        "--out",
        "run",
        "--non-interactive",
    ];
    let said = run_in(folder.path(), &arguments);
    let text = std::fs::read_to_string(folder.path().join("run/results.json"))
        .unwrap_or_else(|error| panic!("{error}: {}\n{}", said.out, said.err));
    let results: serde_json::Value = serde_json::from_str(&text).expect("results are JSON");
    let procedures = results["findings"]["procedures"].as_array().expect("procedures");
    assert!(procedures.len() >= 2, "polarity first: {procedures:?}");
    assert!(procedures.iter().all(|own| own["status"] == "completed"), "{}\n{}", said.out, said.err);
}

#[test]
fn devices_on_can_say_who_they_are() {
    let folder = folder();
    let said = run_in(folder.path(), &["devices", "--rig", "can", "--tier", "virtual"]);
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    assert!(said.out.contains("az-drive") && said.out.contains("el-drive"), "{}", said.out);
}
