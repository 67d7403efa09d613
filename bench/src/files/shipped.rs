//! Files that come with the program, and the rule by which a name becomes a file.
//!
//! An argument with `/` or `.toml` is a path, otherwise a shipped name. On the command line a path that does not exist is looked up
//! among the shipped files, too, so that what `bench list` prints (`quick/az-friction`) can be typed. A path inside a file lies beside
//! that file, and nothing takes its place where it is missing: a shipped file is asked for as such, `shipped:fat/az-step.toml`.
//! Shipped files find each other among themselves.

use std::path::{Path, PathBuf};

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::MOST_BYTES;

use crate::record::bounded;

mod missing;
pub mod sort;
#[cfg(test)]
mod tests;

/// Every file that comes with the program: the TOML files of the folders, as the build script found them. Those of a folder
/// come before those of its subfolders, each in the order of names.
const EMBEDDED: &[Embedded] = include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// The shipped wired rig without its devices on lines: drives, and what hangs on the terminal beside them.
#[cfg(test)]
pub(crate) fn wired_without_lines() -> String {
    let text = find(Folder::Rigs, "wired", None).expect("a shipped rig").text;
    let has_line = |part: &&str| [" \"serial:", " \"tcp:", " \"udp:"].iter().any(|sort| part.contains(sort));
    let parts: Vec<&str> = text.split("\n[[").filter(|part| !has_line(part)).collect();
    parts.join("\n[[")
}

/// Where files of a sort live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Folder {
    /// Campaigns and procedures.
    Procedures,
    /// Requirements; they stand beside the campaigns that name them.
    Requirements,
    /// Rigs.
    Rigs,
    /// Simulated units and defects.
    Units,
    /// Build states that lie over a simulated unit.
    States,
    /// Distributions that units are drawn from.
    Families,
    /// Controller parameters.
    Parameters,
    /// Types of drives.
    Profiles,
    /// Types of instruments that send their readings as text.
    Readers,
    /// Criteria by which controllers are compared.
    Criteria,
}

impl Folder {
    /// What one of its files holds, with an article where there is one.
    pub fn content(self) -> &'static str {
        match self {
            Self::Procedures => "a campaign or procedure",
            Self::Requirements => "requirements",
            Self::Rigs => "a rig",
            Self::Units => "a unit",
            Self::States => "a build state",
            Self::Families => "a family of units",
            Self::Parameters => "controller parameters",
            Self::Profiles => "a drive profile",
            Self::Readers => "a reader profile",
            Self::Criteria => "criteria of a comparison of controllers",
        }
    }

    /// What one of its files is called in messages.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Procedures => "campaign or procedure",
            Self::Requirements => "requirements",
            Self::Rigs => "rig",
            Self::Units => "unit",
            Self::States => "build state",
            Self::Families => "family of units",
            Self::Parameters => "controller parameters",
            Self::Profiles => "drive profile",
            Self::Readers => "reader profile",
            Self::Criteria => "criteria",
        }
    }
}

/// A file that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Embedded {
    /// Where it lives.
    pub folder: Folder,
    /// Path below that folder, e.g. `fat/az-friction.toml`.
    pub path: &'static str,
    /// Text of the file.
    pub text: &'static str,
}

impl Embedded {
    /// Name of the file without folder and ending, e.g. `az-friction`.
    pub fn stem(&self) -> &'static str {
        let file = self.path.rsplit('/').next().unwrap_or(self.path);
        file.strip_suffix(".toml").unwrap_or(file)
    }

    /// Whether it holds requirements: they stand beside the campaigns that name them.
    pub fn is_requirements(&self) -> bool {
        self.folder == Folder::Procedures && self.stem().ends_with("requirements")
    }

    /// The file as a source for diagnostics.
    pub fn source(&self) -> SourceFile {
        SourceFile { name: format!("{SHIPPED}{}", self.path), text: self.text.to_owned() }
    }
}

/// The shipped files of a folder.
pub fn all(folder: Folder) -> impl Iterator<Item = &'static Embedded> {
    EMBEDDED.iter().filter(move |e| match folder {
        Folder::Requirements => e.is_requirements(),
        _ => e.folder == folder,
    })
}

/// What the name of a shipped file begins with, in messages and in files that ask for one.
pub const SHIPPED: &str = "shipped:";

/// Finds the file that `name` means; `beside` is the file that names it, if one does.
///
/// # Errors
/// When there is no such file or it cannot be read.
pub fn find(folder: Folder, name: &str, beside: Option<&str>) -> Result<SourceFile, Vec<Diagnostic>> {
    if let Some(asked) = name.strip_prefix(SHIPPED) {
        return by_path(folder, asked).ok_or_else(|| vec![missing::shipped(folder, asked, beside)]);
    }
    if !(name.contains('/') || name.ends_with(".toml")) {
        return shipped(folder, name, beside);
    }
    let path = match beside {
        Some(beside) if beside.starts_with(SHIPPED) => {
            return by_path(folder, name).ok_or_else(|| vec![missing::shipped(folder, name, Some(beside))]);
        }
        Some(beside) => Path::new(beside).parent().unwrap_or(Path::new("")).join(name),
        None => PathBuf::from(name),
    };
    if path.is_dir() {
        return Err(vec![missing::folder(folder, &path)]);
    }
    if path.exists() {
        return read(&path);
    }
    let shipped = by_path(folder, name);
    match (beside, shipped) {
        (None, Some(shipped)) => Ok(shipped),
        (None, None) => Err(vec![missing::path(folder, &path, None, false)]),
        (Some(beside), shipped) => Err(vec![missing::path(folder, &path, Some(beside), shipped.is_some())]),
    }
}

/// The shipped file of this path below its folder, with or without its ending.
fn by_path(folder: Folder, name: &str) -> Option<SourceFile> {
    let found = all(folder).find(|e| e.path == name || e.path.strip_suffix(".toml") == Some(name));
    found.map(Embedded::source)
}

fn shipped(folder: Folder, name: &str, beside: Option<&str>) -> Result<SourceFile, Vec<Diagnostic>> {
    // Without a slash a campaign's name comes before a procedure's of the same stem, then the first in the list counts.
    let by_stem = || all(folder).find(|e| e.stem() == name).map(Embedded::source);
    let none = || match beside {
        None if Path::new(name).is_dir() => missing::folder(folder, Path::new(name)),
        _ => missing::shipped(folder, name, beside),
    };
    by_path(folder, name).or_else(by_stem).ok_or_else(|| vec![none()])
}

/// Reads a file that a person named.
///
/// # Errors
/// With the operating system's reason.
pub fn read(path: &Path) -> Result<SourceFile, Vec<Diagnostic>> {
    let name = path.display().to_string();
    match bounded::read_to_string(path, MOST_BYTES as u64) {
        Ok(text) => Ok(SourceFile { name, text }),
        Err(error) => Err(vec![Diagnostic::new(format!("{name}: cannot be read: {error}"))]),
    }
}
