//! How large a file that people write may be: looked at before anything of that size is allocated or searched.

use crate::diagnostic::{Diagnostic, SourceFile};

/// Largest file that people write, bytes: the longest shipped one has 60 kB.
pub const MOST_BYTES: usize = 1 << 20;

/// Mistakes of one file that are told; a file with more is not what it was taken for.
pub const MOST_MISTAKES: usize = 100;

/// Largest number of values in a list, of tables in an array, of entries in a table with free keys.
pub const MOST_ENTRIES: usize = 1000;

/// Largest number of steps (points, or segments of a point) that the lists and counts of one procedure may multiply to: the
/// longest shipped one has 500.
pub const MOST_STEPS: usize = 10_000;

/// Why a text is not even parsed.
pub(super) fn too_large(source: &SourceFile) -> Option<Diagnostic> {
    (source.text.len() > MOST_BYTES)
        .then(|| Diagnostic::new(size_message(source.text.len() as u64)).in_file(source).help(SIZE_HELP))
}

/// What is wrong with a file of this size that people are said to have written.
pub fn size_message(bytes: u64) -> String {
    format!("the file has {bytes} bytes; expected at most {MOST_BYTES}")
}

/// What to do about it.
pub const SIZE_HELP: &str = "this is no file of the bench that somebody wrote: check its name";

/// What stands in the place of mistakes that are not told.
pub(super) fn and_more(source: &SourceFile, more: usize) -> Diagnostic {
    let message = format!("and {more} more mistakes in this file");
    Diagnostic::new(message).in_file(source).help("mend the first ones and check again")
}
