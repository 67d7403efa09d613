//! Every defect, run as a customer would run it.

use validation::measured_flips::{Asked, HEAD, measured};

/// The table is that of `cargo run -p validation -- measured_flips`, which also takes whole campaigns.
#[test]
#[ignore = "takes minutes; `.ci/run` runs it after the others"]
fn each_defect_fails_what_it_must_and_turns_nothing_that_its_file_does_not_name() {
    let asked = Asked {
        whole: false,
        campaign: "quick".to_owned(),
        program: env!("CARGO_BIN_EXE_bench").into(),
        defects: Vec::new(),
    };
    let mut table = HEAD.to_owned();
    let mut broken = 0;
    let count = measured(&asked, |row| {
        table += &format!("\n{}", row.line());
        broken += row.broken.len();
    });
    assert!(count >= 65, "{count} defects are shipped");
    assert_eq!(broken, 0, "\n{table}");
}
