//! Builds external laws as their authors would: the examples, and laws that go wrong in a way of their own.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use bench::cycle::laws::{Hosting, Law, Laws};
use external_law::Library;
use sha2::{Digest, Sha256};

/// Where the header and the examples are.
fn interface() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../controllers/abi")
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A shared library of this C text, which may include the example.
pub(crate) fn c(folder: &Path, name: &str, text: &str) -> PathBuf {
    let source = folder.join(format!("{name}_built.c"));
    let library = folder.join(format!("{name}.so"));
    std::fs::write(&source, text).expect("a writable folder");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let mut command = Command::new(compiler);
    command.args(["-std=gnu11", "-O2", "-Wall", "-Werror", "-ffp-contract=off", "-shared", "-fPIC"]);
    command.arg("-I").arg(interface()).arg("-I").arg(interface().join("examples"));
    run(command.arg("-o").arg(&library).arg(&source));
    library
}

/// The example in C.
pub(crate) fn c_example(folder: &Path) -> PathBuf {
    c(folder, "velocity_pi", "#include \"velocity_pi.c\"\n")
}

/// The example in Rust.
pub(crate) fn rust_example(folder: &Path) -> PathBuf {
    let library = folder.join("velocity_pi_rust.so");
    let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let mut command = Command::new(compiler);
    command.args(["--edition", "2024", "--crate-type", "cdylib", "-O"]);
    command.arg("-o").arg(&library).arg(interface().join("examples/velocity_pi.rs"));
    run(&mut command);
    library
}

/// The example in C, but for what `spoils` does after each step, with `in` and `out` at hand.
pub(crate) fn spoilt(folder: &Path, name: &str, spoils: &str) -> PathBuf {
    let text = format!(
        "#define bench_law_step pi_step\n#include \"velocity_pi.c\"\n#undef bench_law_step\n#include <unistd.h>\n\
         void bench_law_step(void *law, const bench_law_input *in, bench_law_output *out) {{\n\
         pi_step(law, in, out);\n{spoils}\n}}\n"
    );
    c(folder, name, &text)
}

/// SHA-256 of a file.
pub(crate) fn digest(file: &Path) -> String {
    let bytes = std::fs::read(file).expect("a library");
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A library that is loaded by its own digest.
pub(crate) fn loaded(file: &Path) -> Library {
    Library::load(file, &digest(file)).expect("a sound library")
}

/// Azimuth by the law of a library.
pub(crate) fn on_azimuth(file: &Path, hosting: Hosting) -> Laws {
    let mut laws = Laws::default();
    assert!(laws.insert("az", Law { library: Arc::new(loaded(file)), hosting }));
    laws
}
