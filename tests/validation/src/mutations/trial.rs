//! One seed: mutated files, the calls that read them, what came of it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use super::bed::{self, Bed};
use super::child::{Said, call};
use super::sorts::{Case, SORTS};

/// What became of a seed.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The seed.
    pub seed: u64,
    /// Sort of the mutated file.
    pub sort: &'static str,
    /// How it was mutated.
    pub how: &'static str,
    /// Whether the first call took it for right.
    pub accepted: bool,
    /// Bytes of all files.
    pub input_bytes: u64,
    /// Largest memory of a call, bytes.
    pub memory_bytes: u64,
    /// Longest processor time of a call, s.
    pub cpu_s: f64,
    /// What must not be.
    pub findings: Vec<String>,
}

/// Trials in the order of their seeds; `only` names the one sort that is wanted.
pub fn all(bed: &Bed, seeds: Range<u64>, only: Option<&str>) -> Vec<Trial> {
    let next = AtomicU64::new(seeds.start);
    let done = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= seeds.end {
                        break;
                    }
                    let sort = SORTS[(seed % SORTS.len() as u64) as usize].name;
                    if only.is_none_or(|only| only == sort) {
                        let trial = one(bed, seed);
                        done.lock().expect("no worker panics while it holds it").push(trial);
                    }
                }
            });
        }
    });
    let mut trials = done.into_inner().expect("all workers have ended");
    trials.sort_by_key(|trial| trial.seed);
    trials
}

/// The trial of a seed.
pub(super) fn one(bed: &Bed, seed: u64) -> Trial {
    let Case { sort, how, files, calls, promises } = bed.case(seed);
    let folder = bed.folder.join(format!("trial-{seed}"));
    bed::write(&folder, &files).expect("a writable folder");
    let input_bytes = files.iter().map(|(_, bytes)| bytes.len() as u64).sum();
    let mut trial = Trial {
        seed,
        sort,
        how,
        accepted: false,
        input_bytes,
        memory_bytes: 0,
        cpu_s: 0.0,
        findings: Vec::new(),
    };
    let mut said = Vec::<Said>::new();
    for mut arguments in calls {
        if arguments.iter().any(|a| a == "LOG") {
            let Some(log) = first_log(&folder.join("log")) else { break };
            arguments.iter_mut().filter(|a| *a == "LOG").for_each(|a| a.clone_from(&log));
        }
        if said.last().is_some_and(|last| last.code != Some(0) || promises && !is_short(&last.out)) {
            break;
        }
        let one = call(&bed.program, &folder, &arguments, input_bytes);
        trial.findings.extend(one.finding.clone().map(|found| format!("{}: {found}", arguments.join(" "))));
        trial.memory_bytes = trial.memory_bytes.max(one.memory_bytes);
        trial.cpu_s = trial.cpu_s.max(one.cpu_s);
        said.push(one);
    }
    trial.accepted = said.first().is_some_and(|first| first.code == Some(0));
    if let (true, [_, run]) = (promises, said.as_slice())
        && matches!(run.code, Some(2 | 4 | 6))
        // What a gate reads, only the rig can know.
        && !run.err.contains("refused before motion: gate `")
    {
        let why = run.err.lines().find(|l| l.starts_with("error")).unwrap_or_default();
        trial.findings.push(format!("check accepts what run refuses ({:?}): {why}", run.code));
    }
    let _ = std::fs::remove_dir_all(&folder);
    trial
}

/// Whether a check says that the run takes no longer than its simulation is worth waiting for.
fn is_short(checked: &str) -> bool {
    const LONGEST_S: f64 = 60.0;
    let counted = checked.split_once(" points, ").or_else(|| checked.split_once(" point, "));
    let planned = counted.and_then(|(_, rest)| rest.split(" s;").next());
    planned.and_then(|text| text.parse::<f64>().ok()).is_some_and(|planned_s| planned_s <= LONGEST_S)
}

fn first_log(folder: &Path) -> Option<String> {
    let entry = std::fs::read_dir(folder).ok()?.flatten().next()?;
    Some(format!("log/{}", entry.file_name().to_string_lossy()))
}

/// A line a sort.
pub fn table(trials: &[Trial]) -> String {
    let mut by_sort: BTreeMap<&str, Vec<&Trial>> = BTreeMap::new();
    for trial in trials {
        by_sort.entry(trial.sort).or_default().push(trial);
    }
    let mut text = String::from(
        "sort                    files  taken  findings  largest memory  largest input  longest\n",
    );
    for (sort, of_sort) in by_sort {
        let taken = of_sort.iter().filter(|t| t.accepted).count();
        let findings = of_sort.iter().filter(|t| !t.findings.is_empty()).count();
        let memory = of_sort.iter().map(|t| t.memory_bytes).max().unwrap_or(0) >> 20;
        let input = of_sort.iter().map(|t| t.input_bytes).max().unwrap_or(0) >> 10;
        let longest_s = of_sort.iter().map(|t| t.cpu_s).fold(0.0, f64::max);
        text += &format!(
            "{sort:22} {:6} {taken:6} {findings:9} {memory:11} MiB {input:10} KiB {longest_s:6.2} s\n",
            of_sort.len()
        );
    }
    text
}
