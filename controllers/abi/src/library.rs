//! A shared library with a law: loaded once, checked before any of its functions makes a torque.
#![allow(unsafe_code, reason = "functions and descriptions of a library are C pointers")]

use std::ffi::{CStr, c_char, c_void};
use std::fmt::Write as _;
use std::io::{Read as _, Write as _};
use std::os::fd::AsRawFd as _;
use std::path::Path;
use std::ptr::NonNull;

use libloading::os::unix::{Library as Loaded, RTLD_LOCAL, RTLD_NOW};
use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, memfd_create};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::rows::{
    ABI_VERSION, LawInput, LawOutput, LawSetup, MOST_PARAMETERS, RawDescription, RawParameter,
};

/// Largest library that is read.
const MOST_BYTES: u64 = 256 << 20;
/// Shared libraries that a law may need: how their names begin.
const OF_THE_SYSTEM: &[&str] =
    &["libc.so.", "libm.so.", "libgcc_s.so.", "libpthread.so.", "libdl.so.", "librt.so.", "ld-linux"];
/// Longest name, version or unit.
const MOST_LETTERS: usize = 100;

/// Why a library cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct LibraryError {
    /// The library.
    pub file: String,
    /// What was expected, what was found, what to do.
    pub reason: String,
}

/// What a library says of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Name of the law.
    pub name: String,
    /// Version of the law.
    pub version: String,
    /// Parameters of the law, in the order of their values in [`Library::create`].
    pub parameters: Vec<Parameter>,
}

/// A parameter as a library describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// A key of an axis in the parameter file, or a name of the law's own.
    pub name: String,
    /// SI unit of its value.
    pub unit: String,
    /// Value where the parameter file has none of this name.
    pub default_si: Option<f64>,
}

type Describe = unsafe extern "C" fn() -> *const RawDescription;
type Create = unsafe extern "C" fn(*const LawSetup, *const f64) -> *mut c_void;
type Step = unsafe extern "C" fn(*mut c_void, *const LawInput, *mut LawOutput);
type Destroy = unsafe extern "C" fn(*mut c_void);

/// A loaded library. It stays loaded until the process ends.
#[derive(Clone, Debug)]
pub struct Library {
    file: String,
    sha256: String,
    description: Description,
    create: Create,
    step: Step,
    destroy: Destroy,
}

impl Library {
    /// Loads a library whose bytes have this SHA-256 (hexadecimal). Exactly the bytes that were checked are loaded,
    /// whatever becomes of the file.
    ///
    /// # Errors
    /// When the file cannot be read or loaded, has another digest, lacks a function, or was built for another version
    /// or layout of the interface.
    pub fn load(path: &Path, sha256: &str) -> Result<Self, LibraryError> {
        let file = path.display().to_string();
        Self::load_file(path, sha256).map_err(|reason| LibraryError { file, reason })
    }

    fn load_file(path: &Path, sha256: &str) -> Result<Self, String> {
        let bytes = read(path)?;
        let found = hex(&Sha256::digest(&bytes));
        if !found.eq_ignore_ascii_case(sha256) {
            return Err(format!(
                "expected SHA-256 {sha256}, found {found}; name the digest of the build that you mean \
                 (`sha256sum FILE`)"
            ));
        }
        stands_alone(&bytes)?;
        let loaded = open(&bytes)?;
        let describe: Describe = function(loaded, "bench_law_describe")?;
        let create: Create = function(loaded, "bench_law_create")?;
        let step: Step = function(loaded, "bench_law_step")?;
        let destroy: Destroy = function(loaded, "bench_law_destroy")?;
        // SAFETY: the function has this signature by the interface, and its library is never unloaded.
        let raw = NonNull::new(unsafe { describe() }.cast_mut()).ok_or("bench_law_describe returned NULL")?;
        let raw = checked(raw)?;
        let description = Description {
            name: text(raw.name, "name of the law")?,
            version: text(raw.version, "version of the law")?,
            parameters: parameters(&raw)?,
        };
        let file = path.display().to_string();
        Ok(Self { file, sha256: found, description, create, step, destroy })
    }

    /// The file as it was named.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// SHA-256 of the file, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// What it says of itself.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Makes an instance of the law.
    ///
    /// # Errors
    /// When there is not one value for each parameter, or the library makes no instance.
    pub fn create(&self, setup: &LawSetup, values_si: &[f64]) -> Result<Instance, LibraryError> {
        let failed = |reason: String| LibraryError { file: self.file.clone(), reason };
        let expected = self.description.parameters.len();
        if values_si.len() != expected {
            return Err(failed(format!("expected {expected} parameters, found {}", values_si.len())));
        }
        // SAFETY: both rows live through the call and have the layout and length that the library stated.
        let law = unsafe { (self.create)(setup, values_si.as_ptr()) };
        let law = NonNull::new(law).ok_or_else(|| {
            failed(format!(
                "bench_law_create returned NULL: the law refuses {setup:?} with parameters {values_si:?}"
            ))
        })?;
        Ok(Instance { law, step: self.step, destroy: self.destroy })
    }
}

/// The law of one axis, with its state.
#[derive(Debug)]
pub struct Instance {
    law: NonNull<c_void>,
    step: Step,
    destroy: Destroy,
}

// SAFETY: by the interface an instance may move to another thread; `&mut self` keeps it to one thread at a time.
unsafe impl Send for Instance {}

impl Instance {
    /// One step. What the law does not write stays NaN.
    pub fn step(&mut self, input: &LawInput) -> LawOutput {
        let mut output = LawOutput { torque_nm: f64::NAN, saturated: f64::NAN, fault: f64::NAN };
        // SAFETY: `law` is what `create` returned and is not destroyed yet; both rows live through the call.
        unsafe { (self.step)(self.law.as_ptr(), input, &raw mut output) };
        output
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: `law` is what `create` returned, and nothing uses it afterwards.
        unsafe { (self.destroy)(self.law.as_ptr()) };
    }
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    let unreadable = |error| format!("cannot be read: {error}");
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(format!("larger than {} MiB; is this a shared library?", MOST_BYTES >> 20));
    }
    Ok(bytes)
}

fn hex(digest: &[u8]) -> String {
    digest.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Whether the library needs none but those of the system: the digest covers no other, and two laws in one process could share it.
fn stands_alone(bytes: &[u8]) -> Result<(), String> {
    // What is no ELF file at all is told by the loader.
    let Ok(elf) = goblin::elf::Elf::parse(bytes) else { return Ok(()) };
    match elf.libraries.iter().find(|needed| !OF_THE_SYSTEM.iter().any(|own| needed.starts_with(own))) {
        None => Ok(()),
        Some(needed) => Err(format!(
            "needs `{needed}`, which its SHA-256 does not cover; link it statically (allowed: {})",
            OF_THE_SYSTEM.join(", ")
        )),
    }
}

/// Loads a library from a sealed copy of its bytes. Neither library nor copy is ever given back: descriptions and
/// functions stay valid, and the name of the copy cannot come to stand for another one.
fn open(bytes: &[u8]) -> Result<&'static Loaded, String> {
    let copied = || -> std::io::Result<std::fs::File> {
        let memory = memfd_create("law", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
        let mut file = std::fs::File::from(memory);
        file.write_all(bytes)?;
        fcntl_add_seals(&file, SealFlags::WRITE | SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        Ok(file)
    };
    let copy = Box::leak(Box::new(copied().map_err(|error| format!("cannot be copied to memory: {error}"))?));
    let name = format!("/proc/self/fd/{}", copy.as_raw_fd());
    // SAFETY: the caller has checked that these are the bytes whose digest somebody named; what the library does when
    // it is loaded is theirs to answer for.
    let loaded = unsafe { Loaded::open(Some(&name), RTLD_NOW | RTLD_LOCAL) };
    let loaded = loaded.map_err(|error| {
        let why = error.to_string().replace(&format!("{name}: "), "");
        format!("cannot be loaded: {why}; expected a shared library for {}", std::env::consts::ARCH)
    })?;
    Ok(Box::leak(Box::new(loaded)))
}

/// A function of a library, by its name.
fn function<F: Copy>(loaded: &'static Loaded, name: &str) -> Result<F, String> {
    // SAFETY: `F` is the type that bench_law.h gives to this name.
    let symbol = unsafe { loaded.get::<F>(name.as_bytes()) };
    symbol
        .map(|symbol| *symbol)
        .map_err(|_| format!("exports no function `{name}`; see bench_law.h, version {ABI_VERSION}"))
}

/// The description, once version and sizes are those of this bench.
fn checked(raw: NonNull<RawDescription>) -> Result<RawDescription, String> {
    // SAFETY: by the interface every version of the description begins with its version.
    let version = unsafe { raw.cast::<u32>().read() };
    if version != ABI_VERSION {
        return Err(format!(
            "expected version {ABI_VERSION} of the interface, found {version}; build it with the bench_law.h of this \
             bench"
        ));
    }
    // SAFETY: a description of this version has this layout.
    let raw = unsafe { raw.read() };
    for (row, found, expected) in [
        ("bench_law_parameter", raw.parameter_bytes, size_of::<RawParameter>()),
        ("bench_law_setup", raw.setup_bytes, size_of::<LawSetup>()),
        ("bench_law_input", raw.input_bytes, size_of::<LawInput>()),
        ("bench_law_output", raw.output_bytes, size_of::<LawOutput>()),
    ] {
        if found as usize != expected {
            return Err(format!(
                "{row}: expected {expected} bytes, found {found}; build it with the bench_law.h of this bench"
            ));
        }
    }
    Ok(raw)
}

fn parameters(raw: &RawDescription) -> Result<Vec<Parameter>, String> {
    let count = raw.parameter_count as usize;
    if count > MOST_PARAMETERS || count > 0 && raw.parameters.is_null() {
        return Err(format!(
            "expected at most {MOST_PARAMETERS} parameters and a list of them, found {count}"
        ));
    }
    let one = |index: usize| {
        // SAFETY: the list has `parameter_count` entries of the size that was checked.
        let raw = unsafe { raw.parameters.add(index).read() };
        Ok(Parameter {
            name: text(raw.name, "name of a parameter")?,
            unit: text(raw.unit, "unit of a parameter")?,
            default_si: Some(raw.default_value).filter(|value| value.is_finite()),
        })
    };
    (0..count).map(one).collect()
}

/// A text of a description: it goes into reports and onto terminals.
fn text(raw: *const c_char, what: &str) -> Result<String, String> {
    if raw.is_null() {
        return Err(format!("{what}: expected a text, found NULL"));
    }
    // SAFETY: by the interface a text is not NULL and ends with a zero.
    let text = unsafe { CStr::from_ptr(raw) }.to_str().map_err(|_| format!("{what}: expected UTF-8"))?;
    if text.chars().count() > MOST_LETTERS || text.chars().any(char::is_control) {
        return Err(format!("{what}: expected at most {MOST_LETTERS} letters on one line"));
    }
    Ok(text.to_owned())
}
