//! Envelope, soft limits and restricted zones of simulated units, from the procedure file to the verdict.

use std::path::Path;

use crate::bench::{Said, folder, run_in, verdict};

fn measured(folder: &Path, file: &str, unit: &str) -> Said {
    run_in(folder, &["run", file, "--unit", unit, "--out", "run", "--non-interactive"])
}

#[test]
fn the_nominal_unit_covers_its_envelope_and_keeps_every_limit() {
    for (file, range) in [("quick/az-range.toml", "MOT-RNG-AZ"), ("fat/el-range.toml", "MOT-RNG-EL")] {
        let folder = folder();
        let said = measured(folder.path(), file, "nominal");
        for id in [range, "MOT-SOFT", "MOT-MASK"] {
            assert_eq!(verdict(&folder.path().join("run"), id), "pass", "{id}\n{}\n{}", said.out, said.err);
        }
        assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    }
}

/// The bench's own limits hold all the same: only the drive's are travelled past, by as much as was planned.
#[test]
fn a_drive_that_ignores_its_soft_limits_fails_them_and_nothing_else() {
    let folder = folder();
    let said = measured(folder.path(), "quick/az-range.toml", "soft-limit-missing");
    assert_eq!(said.code, 1, "{}\n{}", said.out, said.err);
    let run = folder.path().join("run");
    assert_eq!(verdict(&run, "MOT-SOFT"), "fail", "{}", said.out);
    assert_eq!(verdict(&run, "MOT-RNG-AZ"), "pass", "{}", said.out);
    assert_eq!(verdict(&run, "MOT-MASK"), "pass", "{}", said.out);
}
