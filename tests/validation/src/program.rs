//! Where a study finds the program that it runs.

use std::path::PathBuf;
use std::process::Command;

/// This checkout's program, built as the study is: it lies beside it.
pub fn built() -> PathBuf {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "-p", "bench", "--bin", "bench"]);
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    assert!(cargo.status().is_ok_and(|status| status.success()), "the program builds");
    let own = std::env::current_exe().expect("a program knows where it lies");
    own.parent().expect("below the target's folder").join("bench")
}
