//! Every page, section, table and erratum that code, files and pages cite is in the repository.

use std::path::{Path, PathBuf};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
/// Files of these names are written by the bench or stand beside an estimator.
const NO_PAGES: [&str; 5] = ["comparison.md", "doc.md", "estimator/doc.md", "population.md", "regression.md"];
const DIRECTOR: &str = include_str!("../docs/director.md");

/// Text files of the repository.
fn texts() -> Vec<(PathBuf, String)> {
    let mut folders = vec![PathBuf::from(ROOT)];
    let mut all = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the repository").flatten() {
            let path = entry.path();
            let name = entry.file_name().to_string_lossy().into_owned();
            if path.is_dir() {
                let skipped = ["target", "snapshots", ".git", "runs", "data"].contains(&name.as_str());
                folders.extend((!skipped).then_some(path));
            } else if [".rs", ".toml", ".md"].iter().any(|end| name.ends_with(end)) && name != "sources.rs" {
                all.push((path.clone(), std::fs::read_to_string(&path).expect("text")));
            }
        }
    }
    all
}

/// Words between anything that is no part of a name or number.
fn words(line: &str) -> Vec<&str> {
    let splits = |c: char| !(c.is_alphanumeric() || matches!(c, '.' | '-' | '_' | '/' | '§'));
    line.split(splits)
        .map(|word| word.trim_matches(['.', '-', '/']))
        .filter(|word| !word.is_empty())
        .collect()
}

/// Whether a page has a section of this number.
fn has_section(page: &str, number: &str) -> bool {
    let heads = page
        .lines()
        .filter_map(|line| line.strip_prefix('#'))
        .map(|line| line.trim_start_matches('#').trim());
    heads.filter_map(|head| head.split(' ').next()).any(|first| first.trim_end_matches('.') == number)
}

fn page(name: &str) -> Option<String> {
    let file = name.rsplit('/').next().unwrap_or(name);
    let places = [Path::new(ROOT).join("docs").join(file), Path::new(ROOT).join(file)];
    places.iter().find_map(|place| std::fs::read_to_string(place).ok())
}

/// What is wrong with the citations of a line.
fn dangling(line: &str) -> Vec<String> {
    let words = words(line);
    let mut wrong = Vec::new();
    for (k, word) in words.iter().enumerate() {
        let next = words.get(k + 1).copied().unwrap_or_default();
        if word.ends_with(".md") && word.len() > 3 && !NO_PAGES.contains(word) && !word.ends_with("/doc.md") {
            match (page(word), next.strip_prefix('§')) {
                (None, _) => wrong.push(format!("`{word}` is no page")),
                (Some(page), Some(section)) if !has_section(&page, section) => {
                    wrong.push(format!("`{word}` has no section {section}"));
                }
                _ => {}
            }
        }
        if *word == "study" {
            let table = next == "T";
            let number = if table { words.get(k + 2).copied().unwrap_or_default() } else { next };
            let is_number = number.starts_with(|c: char| c.is_ascii_digit()) && number.contains('.');
            let cited = if table { format!("T {number}") } else { number.to_owned() };
            if is_number && !DIRECTOR.contains(&cited) {
                wrong.push(format!("docs/director.md does not name `{cited}` of the study"));
            }
        }
        let digits =
            word.strip_prefix('E').filter(|rest| rest.len() == 2 && rest.chars().all(|c| c.is_ascii_digit()));
        if let Some(digits) = digits
            && !DIRECTOR.contains(&format!("\n- E{digits} "))
            && !line.contains("issue")
        {
            wrong.push(format!("docs/director.md has no erratum E{digits}"));
        }
    }
    wrong
}

#[test]
fn no_citation_leads_nowhere() {
    let mut all = Vec::new();
    for (path, text) in texts() {
        let shown = path.strip_prefix(ROOT).unwrap_or(&path).display().to_string();
        for (number, line) in text.lines().enumerate() {
            all.extend(dangling(line).into_iter().map(|what| format!("{shown}:{}: {what}", number + 1)));
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn a_citation_of_a_page_or_section_that_is_not_there_is_found() {
    assert_eq!(dangling("see director.md §6 and docs/log.md"), Vec::<String>::new());
    assert_eq!(dangling("see nowhere.md"), ["`nowhere.md` is no page"]);
    assert_eq!(dangling("see director.md §16"), ["`director.md` has no section 16"]);
    assert_eq!(dangling("study T 3.5, study 9.9.9"), ["docs/director.md does not name `9.9.9` of the study"]);
    assert_eq!(dangling("the torque constant (E22), E99"), ["docs/director.md has no erratum E99"]);
}

#[test]
fn every_page_is_reached_from_the_readme() {
    let readme = include_str!("../README.md");
    for entry in std::fs::read_dir(Path::new(ROOT).join("docs")).expect("pages").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") {
            assert!(readme.contains(&format!("docs/{name}")), "README.md does not lead to docs/{name}");
        }
    }
}
