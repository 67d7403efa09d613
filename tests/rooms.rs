//! The rooms of the crate `bench`: a folder uses only those that stand above it in the list of `lib.rs`.

use std::path::{Path, PathBuf};

/// Names of the rooms, each with its row in the list; those of one row do not use each other.
fn listed(lib: &str) -> Vec<(usize, &str)> {
    let rows = lib.lines().filter_map(|line| line.strip_prefix("//! | ")?.split(" | ").next());
    // The names stand between backticks: every second piece.
    let named = rows.map(|cell| cell.split('`').skip(1).step_by(2)).enumerate();
    named.flat_map(|(row, names)| names.map(move |name| (row, name))).collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).expect("readable").flatten() {
        let path = entry.path();
        match path.is_dir() {
            true => all.extend(rust_files(&path)),
            false => all.push(path),
        }
    }
    all
}

/// Modules that a file declares for tests alone.
fn test_modules(path: &Path, text: &str) -> Vec<PathBuf> {
    let declared = text.split("#[cfg(test)]").skip(1).filter_map(|after| {
        let (declaration, _) = after.split_once(';')?;
        Some(path.with_extension("").join(declaration.rsplit_once("mod ")?.1))
    });
    declared.collect()
}

#[test]
fn a_room_uses_only_rooms_that_stand_above_it_in_the_list() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let lib = std::fs::read_to_string(src.join("lib.rs")).expect("readable");
    let rooms = listed(&lib);
    let row = |name: &str| rooms.iter().find(|(_, room)| *room == name).map(|(row, _)| *row);
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).expect("readable");
        (path, text)
    };
    let files: Vec<(PathBuf, String)> = rust_files(&src).into_iter().map(read).collect();
    let of_tests: Vec<PathBuf> = files.iter().flat_map(|(path, text)| test_modules(path, text)).collect();
    let is_test = |path: &Path| of_tests.iter().any(|module| path.with_extension("").starts_with(module));
    let mut wrong = Vec::new();
    for (path, text) in files.iter().filter(|(path, _)| !is_test(path)) {
        let inside = path.strip_prefix(&src).expect("below src").with_extension("");
        let own = inside.iter().next().and_then(|name| name.to_str()).expect("a name");
        if ["lib", "main"].contains(&own) {
            continue;
        }
        let own_row = row(own).unwrap_or_else(|| panic!("`{own}` is not in the list of lib.rs"));
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for used in code.lines().filter(|line| !line.trim_start().starts_with("//")).flat_map(rooms_in) {
            if used != own && row(used).is_none_or(|row| row >= own_row) {
                wrong.push(format!("{} uses `{used}`", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What stands behind each `crate::` of a line.
fn rooms_in(line: &str) -> impl Iterator<Item = &str> {
    line.split("crate::")
        .skip(1)
        .map(|path| path.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default())
}
