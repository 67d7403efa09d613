//! Builds external laws as their authors would: the examples, and laws that go wrong in a way of their own.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use bench::cycle::laws::Law;
use external_law::Library;
use sha2::{Digest, Sha256};

/// Where the header and the examples are.
fn interface() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../controllers/abi")
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A shared library of this C text, which may include the example.
///
/// # Panics
/// Where there is no C compiler, or it refuses the text.
pub fn c(folder: &Path, name: &str, text: &str) -> PathBuf {
    c_linked(folder, name, text, &[])
}

/// The same, linked with these arguments in the folder.
///
/// # Panics
/// As [`c`].
pub fn c_linked(folder: &Path, name: &str, text: &str, link: &[&str]) -> PathBuf {
    let source = folder.join(format!("{name}_built.c"));
    let library = folder.join(format!("{name}.so"));
    std::fs::write(&source, text).expect("a writable folder");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let mut command = Command::new(compiler);
    command.args(["-std=gnu11", "-O2", "-Wall", "-Werror", "-ffp-contract=off", "-shared", "-fPIC"]);
    command.arg("-I").arg(interface()).arg("-I").arg(interface().join("examples"));
    run(command.arg("-o").arg(&library).arg(&source).args(link).current_dir(folder));
    library
}

/// The example in C.
///
/// # Panics
/// As [`c`].
pub fn c_example(folder: &Path) -> PathBuf {
    c(folder, "velocity_pi", "#include \"velocity_pi.c\"\n")
}

/// The example in Rust.
///
/// # Panics
/// Where there is no Rust compiler.
pub fn rust_example(folder: &Path) -> PathBuf {
    let library = folder.join("velocity_pi_rust.so");
    let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let mut command = Command::new(compiler);
    command.args(["--edition", "2024", "--crate-type", "cdylib", "-O"]);
    command.arg("-o").arg(&library).arg(interface().join("examples/velocity_pi.rs"));
    run(&mut command);
    library
}

/// The example in C, but for what `spoils` does after each step, with `in` and `out` at hand.
///
/// # Panics
/// As [`c`].
pub fn spoilt(folder: &Path, name: &str, spoils: &str) -> PathBuf {
    let text = format!(
        "#define bench_law_step pi_step\n#include \"velocity_pi.c\"\n#undef bench_law_step\n#include <unistd.h>\n\
         void bench_law_step(void *law, const bench_law_input *in, bench_law_output *out) {{\n\
         pi_step(law, in, out);\n{spoils}\n}}\n"
    );
    c(folder, name, &text)
}

/// SHA-256 of a file.
///
/// # Panics
/// For an unreadable file.
pub fn digest(file: &Path) -> String {
    let bytes = std::fs::read(file).expect("a library");
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A library that is loaded by its own digest.
///
/// # Panics
/// For a library that cannot be loaded.
pub fn loaded(file: &Path) -> Library {
    Library::load(file, &digest(file)).expect("a sound library")
}

/// The law of a library, stepped in this process.
///
/// # Panics
/// For a library that cannot be loaded.
pub fn in_process(file: &Path) -> Law {
    Law::in_process(file, &digest(file)).expect("a sound library")
}

/// The law of a library, stepped in a process of its own by the program `bench`.
///
/// # Panics
/// For a library that cannot be loaded.
pub fn hosted(file: &Path, program: &str, deadline: Option<Duration>) -> Law {
    Law::hosted(file, &digest(file), PathBuf::from(program), deadline).expect("a sound library")
}
