//! Lists the files that come with the program, from the folders that they lie in; `src/files/shipped.rs` includes the list.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs, io};

/// A folder whose TOML files are shipped.
struct Shipped {
    /// Variant of `Folder` in `src/files/shipped.rs`.
    variant: &'static str,
    /// Path from the package.
    path: &'static str,
    /// Entries that are not shipped, or not as this sort of file.
    without: &'static [&'static str],
}

const SHIPPED: [Shipped; 9] = [
    Shipped {
        variant: "Procedures",
        path: "../procedures",
        without: &["Cargo.toml", "analysis", "benches", "criteria", "examples", "src"],
    },
    Shipped { variant: "Criteria", path: "../procedures/criteria", without: &[] },
    Shipped { variant: "Rigs", path: "rigs", without: &[] },
    Shipped { variant: "Units", path: "../sim-devices/units", without: &["families", "states"] },
    Shipped { variant: "States", path: "../sim-devices/units/states", without: &[] },
    Shipped { variant: "Families", path: "../sim-devices/units/families", without: &[] },
    Shipped { variant: "Parameters", path: "../controllers/params", without: &[] },
    Shipped { variant: "Profiles", path: "../drivers/profiles", without: &[] },
    Shipped { variant: "Readers", path: "../drivers/readers", without: &[] },
];

#[allow(clippy::print_stdout, reason = "a build script talks to cargo on stdout")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let package = env::var("CARGO_MANIFEST_DIR")?;
    let mut list = String::from("&[\n");
    for Shipped { variant, path, without } in SHIPPED {
        println!("cargo:rerun-if-changed={path}");
        let mut files = Vec::new();
        collect(&Path::new(&package).join(path), "", without, &mut files)?;
        for file in files {
            // The list is the same in every checkout: the compiler completes the paths.
            let text = format!("include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{path}/{file}\"))");
            writeln!(list, "Embedded {{ folder: Folder::{variant}, path: {file:?}, text: {text} }},")?;
        }
    }
    list += "]\n";
    fs::write(Path::new(&env::var("OUT_DIR")?).join("shipped.rs"), list)?;
    Ok(())
}

/// Adds the paths of the TOML files below a folder, each after `prefix`: first those of the folder itself, then those of its
/// subfolders, in the order of their names.
fn collect(folder: &Path, prefix: &str, without: &[&str], into: &mut Vec<String>) -> io::Result<()> {
    let mut files = Vec::new();
    let mut folders = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        // Editors keep hidden files beside those that they change.
        if without.contains(&name.as_str()) || name.starts_with('.') {
            continue;
        }
        if entry.path().is_dir() {
            folders.push(name);
        } else if name.ends_with(".toml") {
            files.push(name);
        }
    }
    files.sort_unstable();
    folders.sort_unstable();
    into.extend(files.iter().map(|file| format!("{prefix}{file}")));
    for name in folders {
        collect(&folder.join(&name), &format!("{prefix}{name}/"), &[], into)?;
    }
    Ok(())
}
