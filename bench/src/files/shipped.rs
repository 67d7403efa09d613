//! Files that come with the program, and the rule by which a name becomes a file.
//!
//! An argument with `/` or `.toml` is a path, otherwise a shipped name. A path inside a file is looked up beside that
//! file, then among the shipped files; a path on the command line that does not exist, too, so that what `bench list`
//! prints (`quick/az-friction`) can be typed.

use std::path::Path;

use procedures::diagnostic::{Diagnostic, SourceFile, nearest};
use procedures::table::MOST_BYTES;

use crate::record::bounded;

#[cfg(test)]
mod tests;

/// Every file that comes with the program: the TOML files of the folders, as the build script found them. Those of a folder
/// come before those of its subfolders, each in the order of names.
const EMBEDDED: &[Embedded] = include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// Where files of a sort live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Folder {
    /// Campaigns, procedures and requirements.
    Procedures,
    /// Rigs.
    Rigs,
    /// Simulated units and defects.
    Units,
    /// Build states that lie over a simulated unit.
    States,
    /// Controller parameters.
    Parameters,
}

impl Folder {
    /// What one of its files is called in messages.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Procedures => "campaign or procedure",
            Self::Rigs => "rig",
            Self::Units => "unit",
            Self::States => "build state",
            Self::Parameters => "controller parameters",
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
        SourceFile { name: self.path.to_owned(), text: self.text.to_owned() }
    }
}

/// The shipped files of a folder.
pub fn all(folder: Folder) -> impl Iterator<Item = &'static Embedded> {
    EMBEDDED.iter().filter(move |e| e.folder == folder)
}

/// Finds the file that `name` means; `beside` is the file that names it, if one does.
///
/// # Errors
/// When there is no such file or it cannot be read.
pub fn find(folder: Folder, name: &str, beside: Option<&str>) -> Result<SourceFile, Vec<Diagnostic>> {
    if !(name.contains('/') || name.ends_with(".toml")) {
        return shipped(folder, name);
    }
    if let Some(beside) = beside {
        let path = Path::new(beside).parent().unwrap_or(Path::new("")).join(name);
        if path.is_file() {
            return read(&path);
        }
    } else if Path::new(name).exists() {
        return read(Path::new(name));
    }
    match all(folder).find(|e| e.path == name || e.path.strip_suffix(".toml") == Some(name)) {
        Some(embedded) => Ok(embedded.source()),
        None => Err(vec![missing(folder, name, beside)]),
    }
}

fn shipped(folder: Folder, name: &str) -> Result<SourceFile, Vec<Diagnostic>> {
    // Without a slash a campaign's name comes before a procedure's of the same stem, then the first in the list counts.
    let by_path = all(folder).find(|e| e.path.strip_suffix(".toml") == Some(name));
    match by_path.or_else(|| all(folder).find(|e| e.stem() == name)) {
        Some(embedded) => Ok(embedded.source()),
        None => Err(vec![missing(folder, name, None)]),
    }
}

fn missing(folder: Folder, name: &str, beside: Option<&str>) -> Diagnostic {
    let place = beside.map_or(String::new(), |b| format!(", named in {b}"));
    let message = format!("no {} file `{name}`{place}", folder.noun());
    let known = all(folder).map(|e| match (name.contains('/'), name.ends_with(".toml")) {
        (true, _) => e.path,
        (false, true) => e.path.rsplit('/').next().unwrap_or(e.path),
        (false, false) => e.stem(),
    });
    let help = match nearest(name, known) {
        Some(near) => format!("did you mean `{near}`? `bench list` shows what is shipped"),
        None => "a name without `/` is a shipped file (`bench list`), otherwise give a path".to_owned(),
    };
    Diagnostic::new(message).help(help)
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
