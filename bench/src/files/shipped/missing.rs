//! What is said of a file that is not there: what was probably meant.

use std::path::Path;

use procedures::diagnostic::{Diagnostic, nearest};
use procedures::kinds::KINDS;

use super::sort::Sort;
use super::{Folder, SHIPPED, all};

/// Folders whose files are named by an option of their own.
const ELSEWHERE: [(Folder, &str); 5] = [
    (Folder::Procedures, "name it without an option, `bench run"),
    (Folder::Units, "give it with `--unit"),
    (Folder::Families, "draw units from it with `bench draw"),
    (Folder::Rigs, "give it with `--rig"),
    (Folder::Requirements, "give them with `--requirements"),
];

/// No shipped file has this name.
pub(super) fn shipped(folder: Folder, name: &str, beside: Option<&str>) -> Diagnostic {
    let message = format!("no {} `{name}` is shipped{}", folder.noun(), named_in(beside));
    let known = all(folder).map(|e| match (name.contains('/'), name.ends_with(".toml")) {
        (true, _) => e.path,
        (false, true) => e.path.rsplit('/').next().unwrap_or(e.path),
        (false, false) => e.stem(),
    });
    if let Some(help) = another_sort(folder, name) {
        return Diagnostic::new(message).help(help);
    }
    let beside = name_beside(Path::new(name), folder);
    let help = match (nearest(name, known), beside) {
        (Some(near), _) => format!("did you mean `{near}`? `bench list` shows what is shipped"),
        (None, Some(path)) => format!("did you mean the file `{path}`?"),
        (None, None) => {
            "a name without `/` and `.toml` refers to a shipped file (`bench list`); a path contains one of them"
                .to_owned()
        }
    };
    Diagnostic::new(message).help(help)
}

/// There is no file at this path; `is_shipped`: a shipped one has the name.
pub(super) fn path(folder: Folder, path: &Path, beside: Option<&str>, is_shipped: bool) -> Diagnostic {
    let message = format!("there is no file `{}`{}", path.display(), named_in(beside));
    let near = name_beside(path, folder);
    let help = match near {
        _ if is_shipped => {
            let name = path.strip_prefix(beside.and_then(|b| Path::new(b).parent()).unwrap_or(Path::new("")));
            let name = name.unwrap_or(path).display();
            format!("a shipped file has this name; write `{SHIPPED}{name}` to use it, or create the file")
        }
        Some(near) => format!("did you mean `{near}`?"),
        None if path.parent().is_some_and(|p| !p.as_os_str().is_empty() && !p.is_dir()) => {
            let parent = path.parent().unwrap_or(path).display();
            format!("there is no folder `{parent}` either; paths start at the current working directory")
        }
        None => format!(
            "give the path of a file with {}; `bench list` shows what is shipped, and `{SHIPPED}` before a \
             name selects it",
            folder.content()
        ),
    };
    Diagnostic::new(message).help(help)
}

/// A folder stands where a file must.
pub(super) fn folder(folder: Folder, path: &Path) -> Diagnostic {
    let message = format!("`{}` is a folder; expected a file with {}", path.display(), folder.content());
    let inside: Vec<String> =
        fitting(path, folder).into_iter().take(5).map(|name| format!("`{name}`")).collect();
    let help = match inside.is_empty() {
        true if path.join("run.json").exists() => {
            "it is a run folder; use `bench report` or `bench rejudge` for it".to_owned()
        }
        true => format!("it contains no file with {}", folder.content()),
        false => format!("it contains {}", inside.join(", ")),
    };
    Diagnostic::new(message).help(help)
}

fn named_in(beside: Option<&str>) -> String {
    beside.map_or_else(String::new, |file| format!(", named in {file}"))
}

/// A shipped file of another sort has this name, or a kind of experiment.
fn another_sort(folder: Folder, name: &str) -> Option<String> {
    let has = |other: Folder| {
        all(other).any(|e| e.stem() == name && (other != Folder::Procedures || !e.is_requirements()))
    };
    let found = ELSEWHERE.iter().find(|(other, _)| *other != folder && has(*other));
    if let Some((other, option)) = found {
        return Some(format!("`{name}` is {}: {option} {name}`", other.content()));
    }
    if let Some(help) = id_of(folder, name) {
        return Some(help);
    }
    let kind = KINDS.iter().any(|kind| kind.name == name) && folder == Folder::Procedures;
    kind.then(|| {
        format!(
            "`{name}` is a kind of procedure: `bench list procedures` shows the procedures of each kind, \
             `--select {name}` runs them"
        )
    })
}

/// A shipped procedure or requirement has this id.
fn id_of(folder: Folder, name: &str) -> Option<String> {
    let line = format!("id = \"{name}\"");
    let has = |file: &&super::Embedded| file.text.lines().any(|l| l.trim() == line);
    if folder != Folder::Procedures {
        return None;
    }
    if all(Folder::Requirements).any(|file| has(&file)) {
        return Some(format!(
            "`{name}` is a requirement: `bench run --select {name}` runs the procedures that measure it"
        ));
    }
    let files: Vec<String> = all(Folder::Procedures)
        .filter(|file| !file.is_requirements() && has(file))
        .map(|file| format!("`{}`", file.path.trim_end_matches(".toml")))
        .collect();
    (!files.is_empty())
        .then(|| format!("`{name}` is the id of a procedure: name its file, {}", files.join(" or ")))
}

/// The file beside this path whose name is nearest, as a path.
fn name_beside(path: &Path, folder: Folder) -> Option<String> {
    let parent = path.parent().unwrap_or(Path::new(""));
    let wanted = path.file_name()?.to_str()?;
    let here = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let names = fitting(here, folder);
    let names: Vec<&str> = names.iter().filter_map(|name| Path::new(name).file_name()?.to_str()).collect();
    let stem = |name: &str| name.strip_suffix(".toml").unwrap_or(name).to_owned();
    let stems: Vec<String> = names.iter().map(|name| stem(name)).collect();
    let near = nearest(&stem(wanted), stems.iter().map(String::as_str))?;
    let name = names[stems.iter().position(|other| other == near)?];
    let near = parent.join(name).display().to_string();
    // A bare name would be that of a shipped file, unless it ends like a path.
    (near != path.display().to_string()).then_some(near)
}

/// Files in a folder that hold what is expected, in the order of their names.
fn fitting(folder: &Path, expected: Folder) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let hidden = |path: &Path| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    let is_toml = |path: &Path| path.extension().is_some_and(|end| end == "toml") && path.is_file();
    let toml = entries.filter(|path| is_toml(path) && !hidden(path));
    let fits = |path: &std::path::PathBuf| {
        let source = super::read(path).ok();
        source.is_some_and(|source| Sort::of(&source).is_none_or(|sort| sort.fits(expected)))
    };
    let mut names: Vec<String> = toml.filter(fits).map(|path| path.display().to_string()).collect();
    names.sort();
    names
}
