//! Public items that nothing but tests reaches.
//!
//! The compiler never calls a public item of a library dead. Sources are read as text: an item counts as reached where its
//! name stands anywhere in the product but in its own definition, in a list that passes it on, or at its own `impl`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates of the product. Controllers and drivers are libraries for others, too: what they offer is not listed.
const LISTED: [&str; 4] = ["procedures/analysis", "procedures", "sim-devices", "bench"];
const READ: [&str; 7] =
    ["procedures/analysis", "procedures", "sim-devices", "bench", "reports", "drivers", "controllers"];

const WORDS_OF_DEFINITIONS: [&str; 7] = ["fn", "struct", "enum", "const", "static", "trait", "type"];

/// Files of the product without tests, with their text.
fn sources() -> BTreeMap<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace").to_owned();
    let mut all = BTreeMap::new();
    let mut folders: Vec<PathBuf> = READ.iter().map(|krate| root.join(krate).join("src")).collect();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
            if path.is_dir() {
                folders.extend((name != "tests").then_some(path));
            } else if name.ends_with(".rs") && !name.ends_with("tests.rs") && !is_for_tests(&path) {
                let text = fs::read_to_string(&path).expect("a source");
                all.insert(path.strip_prefix(&root).expect("below the root").to_owned(), product(&text));
            }
        }
    }
    all
}

/// Files that a crate compiles for its tests alone.
fn is_for_tests(path: &Path) -> bool {
    ["procedures/src/synthetic.rs", "procedures/src/procedure/sample.rs"]
        .iter()
        .any(|file| path.ends_with(file))
}

/// A text without comments and without its module of tests.
fn product(text: &str) -> String {
    let before = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    before.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// Names that a text defines, and those of them that are public.
fn defined(text: &str) -> (Vec<&str>, BTreeSet<&str>) {
    let mut names = Vec::new();
    let mut public = BTreeSet::new();
    for line in text.lines() {
        let own: Vec<&str> = words(line).collect();
        let is_public = line.trim_start().starts_with("pub ");
        for pair in own.windows(2).filter(|pair| WORDS_OF_DEFINITIONS.contains(&pair[0])) {
            names.push(pair[1]);
            public.extend(is_public.then_some(pair[1]));
        }
    }
    (names, public)
}

/// Names in statements that only pass items on, and at `impl`.
fn passed_on(text: &str) -> Vec<&str> {
    let mut names = Vec::new();
    for statement in text.split("pub use ").skip(1) {
        names.extend(words(statement.split(';').next().unwrap_or_default()));
    }
    for line in text.lines().map(str::trim_start).filter(|line| line.starts_with("impl")) {
        names.extend(words(line));
    }
    names
}

#[test]
fn every_public_item_is_reached_by_the_product_or_stands_in_this_list() {
    let sources = sources();
    let mut uses: BTreeMap<&str, i64> = BTreeMap::new();
    for text in sources.values() {
        words(text).for_each(|word| *uses.entry(word).or_default() += 1);
        defined(text).0.into_iter().for_each(|name| *uses.entry(name).or_default() -= 1);
        passed_on(text).into_iter().for_each(|name| *uses.entry(name).or_default() -= 1);
    }
    let mut unreached = Vec::new();
    for krate in LISTED {
        let folder = Path::new(krate).join("src");
        for (path, text) in sources.iter().filter(|(path, _)| path.starts_with(&folder)) {
            let public = defined(text).1;
            let lonely = public.into_iter().filter(|name| uses.get(name).is_none_or(|count| *count <= 0));
            unreached.extend(lonely.map(|name| format!("{} {name}", path.display())));
        }
    }
    insta::assert_snapshot!(unreached.join("\n"));
}
