//! The duty cycle of simulated units, from the procedure file to the verdict: a sound one passes, one whose shunt is open
//! or whose heat sinks are blocked does not.

use std::path::Path;

use crate::bench::{Said, folder, run_in, verdict};

const IDS: [&str; 5] = ["MOT-DUTY", "MOT-CUR-AZ", "MOT-CUR-EL", "THM-SINK", "PWR-BUS"];

fn measured(folder: &Path, unit: &str) -> (Said, Vec<String>) {
    let said =
        run_in(folder, &["run", "quick/both-duty.toml", "--unit", unit, "--out", "run", "--non-interactive"]);
    let verdicts = IDS.map(|id| verdict(&folder.join("run"), id)).to_vec();
    (said, verdicts)
}

#[test]
fn the_nominal_unit_bears_the_duty_cycle_of_both_axes_at_once() {
    let folder = folder();
    let (said, verdicts) = measured(folder.path(), "nominal");
    assert_eq!(verdicts, ["pass"; 5], "{}\n{}", said.out, said.err);
    // MOT-DUTY is about each axis alone, too; the others are about both at once.
    assert_eq!(said.code, 3, "{}", said.out);
    let alone = "MOT-DUTY: not measured: rms-current-az: moving-axes 1 .. 2, reached 2 only";
    assert!(said.out.contains(alone), "{}", said.out);
    for id in &IDS[1..] {
        assert!(!said.out.contains(&format!("{id}: not measured")), "{id}\n{}", said.out);
    }
}

#[test]
fn an_open_shunt_lets_the_dc_link_rise_and_nothing_else_fails() {
    let folder = folder();
    let (said, verdicts) = measured(folder.path(), "shunt-open");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert_eq!(verdicts, ["pass", "pass", "pass", "pass", "fail"], "{}", said.out);
}

#[test]
fn blocked_heat_sinks_fail_by_where_a_repeated_cycle_ends_and_nothing_else_does() {
    let folder = folder();
    let (said, verdicts) = measured(folder.path(), "heat-sink-blocked");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert_eq!(verdicts, ["pass", "pass", "pass", "fail", "pass"], "{}", said.out);
}

/// Without any heat sink the interlock ends the first cycle: what was hotter than allowed until then fails, the rest was not
/// measured.
#[test]
fn a_missing_heat_sink_fails_although_the_interlock_ends_the_point() {
    let folder = folder();
    let axis = "heat-sink-rise = \"200 degC\"\nheat-sink-power = \"25 W\"\nheat-sink-time = \"60 s\"\n";
    let unit = format!(
        "schema = 1\nid = \"bare\"\ntitle = \"No heat sink\"\nbase = \"nominal\"\n\n[az]\n{axis}\n[el]\n{axis}"
    );
    std::fs::write(folder.path().join("bare.toml"), unit).expect("a writable folder");
    let (said, verdicts) = measured(folder.path(), "bare.toml");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert_eq!(
        verdicts,
        ["inconclusive", "inconclusive", "inconclusive", "fail", "inconclusive"],
        "{}",
        said.out
    );
}
