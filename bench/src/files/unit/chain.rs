//! A unit and its bases: each file names the one below it.

use std::path::Path;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::read_file;

use super::Parsed;
use crate::files::shipped::{self, Folder};

/// Longest chain of bases that makes sense.
const MAX_BASES: usize = 8;

/// The unit, then its base, then that one's base.
pub(super) fn of(own: SourceFile) -> Result<Vec<(SourceFile, Parsed)>, Vec<Diagnostic>> {
    let mut chain = vec![parsed(own)?];
    loop {
        let (source, last) = chain.last().expect("the chain holds the unit itself");
        let Some((base, span)) = &last.base else { return Ok(chain) };
        let point = |mistake: Diagnostic| mistake.at(source, span.clone());
        let found = shipped::find(Folder::Units, base, Some(&source.name))
            .map_err(|all| all.into_iter().map(point).collect::<Vec<_>>())?;
        if let Some(circle) = circle(&chain, &found) {
            return Err(vec![point(circle)]);
        }
        if chain.len() > MAX_BASES {
            return Err(vec![point(too_long())]);
        }
        chain.push(parsed(found)?);
    }
}

/// One file.
pub(super) fn parsed(source: SourceFile) -> Result<(SourceFile, Parsed), Vec<Diagnostic>> {
    let parsed = read_file(&source, super::fields_of(&source), super::read)?;
    Ok((source, parsed))
}

/// A file that is in the chain already. The same file may be named in several ways (`a.toml`, `../units/a.toml`), so
/// it is known by its last name and its text; a copy beside its original is none.
fn circle(chain: &[(SourceFile, Parsed)], next: &SourceFile) -> Option<Diagnostic> {
    let file_name = |source: &SourceFile| Path::new(&source.name).file_name().map(|n| n.to_owned());
    let same = |source: &SourceFile| source.text == next.text && file_name(source) == file_name(next);
    let first = chain.iter().position(|(source, _)| same(source))?;
    let files: Vec<&str> =
        chain[first..].iter().map(|(source, _)| source.name.as_str()).chain([next.name.as_str()]).collect();
    let message = format!("the bases form a circle: {}", files.join(" -> "));
    Some(Diagnostic::new(message).help("a unit must not be its own base, directly or through other units"))
}

fn too_long() -> Diagnostic {
    Diagnostic::new(format!("a chain of more than {MAX_BASES} bases"))
        .help("give the settings in fewer files")
}
