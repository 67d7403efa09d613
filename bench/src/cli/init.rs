//! `bench init`: a starter folder that passes on the simulator.

use std::path::{Path, PathBuf};

use super::schema::with_axes_of;
use super::{folders, output};
use crate::exit;
use crate::files::shipped::{self, Folder, SHIPPED};
use crate::record::durable;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Folder to create
    #[arg(default_value = "my-bench")]
    folder: PathBuf,
}

/// Shipped files that a starter folder holds, and under which name.
const STARTER: &[(Folder, &str, &str)] = &[
    (Folder::Procedures, "quick", "quick.toml"),
    (Folder::Requirements, "requirements", "requirements.toml"),
    (Folder::Procedures, "quick/az-friction.toml", "quick/az-friction.toml"),
    (Folder::Procedures, "quick/el-friction.toml", "quick/el-friction.toml"),
    (Folder::Procedures, "quick/az-breakaway.toml", "quick/az-breakaway.toml"),
    (Folder::Procedures, "quick/el-breakaway.toml", "quick/el-breakaway.toml"),
    (Folder::Rigs, "sim", "sim.toml"),
    (Folder::Units, "nominal", "nominal.toml"),
];

/// Folder of the schemas that the editor settings name.
const SCHEMAS: &str = "schemas";

/// Sorts of file of a starter folder and the paths that hold them, for editors.
const EDITED: &[(&str, &[&str])] = &[
    ("procedure", &["quick/*.toml"]),
    ("campaign", &["quick.toml"]),
    ("requirements", &["requirements.toml"]),
    ("rig", &["sim.toml"]),
    ("unit", &["nominal.toml"]),
];

pub(super) fn run(args: &Args) -> u8 {
    if folders::is_occupied(&args.folder) {
        let shown = args.folder.display();
        return output::mistake(&format!("{shown}: the folder is not empty; choose a new one"));
    }
    match write(&args.folder) {
        Ok(()) => {
            let at = args.folder.display();
            output::say(&format!(
                "{at}: campaign, procedures, requirements, rig and unit to edit; run it with"
            ));
            output::say(&format!("  bench run {at}/quick.toml --rig {at}/sim.toml --unit {at}/nominal.toml"));
            exit::PASS
        }
        Err(message) => {
            output::error(&message);
            exit::BENCH
        }
    }
}

fn write(folder: &Path) -> Result<(), String> {
    for (sort, name, file) in STARTER {
        let source = shipped::find(*sort, name, None).map_err(|_| format!("{name}: not shipped"))?;
        let text = if *file == "quick.toml" { starter(&source.text) } else { source.text };
        put(&folder.join(file), &text)?;
    }
    let schemas = with_axes_of("sim").map_err(|_| "sim: no rig".to_owned())?;
    for (sort, schema) in schemas.iter().filter(|(sort, _)| EDITED.iter().any(|(edited, _)| edited == sort)) {
        put(&folder.join(SCHEMAS).join(format!("{sort}.json")), &format!("{schema:#}\n"))?;
    }
    put(&folder.join(".taplo.toml"), &editor_settings())
}

fn put(path: &Path, text: &str) -> Result<(), String> {
    std::fs::create_dir_all(path.parent().unwrap_or(path))
        .and_then(|()| std::fs::write(path, text))
        .map_err(|e| format!("{}: {e}; {}", path.display(), durable::OUTPUT_HELP))
}

/// Settings of Taplo, the language server for TOML behind the extensions of most editors.
fn editor_settings() -> String {
    let head = "# Editors with Taplo (Even Better TOML) complete and underline with these schemas. Files of your own get a line in\n\
                # `include`. After an update of the program: `bench schema procedure --rig sim.toml > schemas/procedure.json`.\n";
    let rule = |(sort, paths): &(&str, &[&str])| {
        let paths: Vec<String> = paths.iter().map(|path| format!("\"{path}\"")).collect();
        let include = paths.join(", ");
        format!("\n[[rule]]\ninclude = [{include}]\n\n[rule.schema]\npath = \"{SCHEMAS}/{sort}.json\"\n")
    };
    head.to_owned() + &EDITED.iter().map(rule).collect::<String>()
}

/// The campaign of a starter folder: the files that lie beside it are its own, all others are asked for as shipped ones.
fn starter(campaign: &str) -> String {
    let is_own = |name: &str| STARTER.iter().any(|(_, _, file)| *file == name);
    let line = |line: &str| match line.strip_prefix("file = \"").and_then(|rest| rest.strip_suffix('"')) {
        Some(name) if !is_own(name) => format!("file = \"{SHIPPED}{name}\"\n"),
        _ => format!("{line}\n"),
    };
    campaign.lines().map(line).collect()
}
