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
}

#[test]
fn an_open_shunt_lets_the_dc_link_rise_and_nothing_else_fails() {
    let folder = folder();
    let (said, verdicts) = measured(folder.path(), "shunt-open");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert_eq!(verdicts, ["pass", "pass", "pass", "pass", "fail"], "{}", said.out);
}

/// They trip the interlock after a cycle: what was hotter than allowed until then fails, the rest was not measured.
#[test]
fn blocked_heat_sinks_fail_although_the_interlock_ends_the_point() {
    let folder = folder();
    let (said, verdicts) = measured(folder.path(), "heat-sink-blocked");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    assert_eq!(
        verdicts,
        ["inconclusive", "inconclusive", "inconclusive", "fail", "inconclusive"],
        "{}",
        said.out
    );
}
