//! Which program this is, and on what it runs: what must be equal where bytes must be.

use std::sync::OnceLock;

use procedures::regression::Program;

use crate::record::ITSELF;
use crate::record::journal::sha256;

/// The program that runs, and the features of this processor on which its arithmetic depends.
///
/// # Errors
/// When its own file cannot be read.
pub fn this_program() -> std::io::Result<Program> {
    static KNOWN: OnceLock<String> = OnceLock::new();
    let digest = match KNOWN.get() {
        Some(known) => known.clone(),
        None => {
            let found = sha256(&std::fs::read(ITSELF)?);
            KNOWN.get_or_init(|| found).clone()
        }
    };
    Ok(Program { version: env!("CARGO_PKG_VERSION").to_owned(), sha256: digest, processor: processor() })
}

#[cfg(target_arch = "x86_64")]
fn processor() -> String {
    let features = [
        ("avx", std::arch::is_x86_feature_detected!("avx")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
    ];
    let present = features.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name);
    std::iter::once("x86_64").chain(present).collect::<Vec<&str>>().join(" ")
}

#[cfg(not(target_arch = "x86_64"))]
fn processor() -> String {
    std::env::consts::ARCH.to_owned()
}
