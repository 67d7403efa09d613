//! A run over real wires beside the scatter of the same campaign in virtual time: is what is measured over a wire what is
//! measured in process?
//!
//! `cargo run --release -p validation -- wired_scatter RUN [--seeds N] [--program BENCH]`: runs the campaign of RUN on its rig
//! with `--tier virtual` for seeds 1 to N (20), and prints for each value its mean, its scatter and two distances of the value
//! of RUN from that mean:
//! - *by scatter*: in standard deviations of the virtual values alone. Most values have next to no scatter in virtual time, because
//!   no noise reaches a step, a stop or a margin; any difference is then many standard deviations.
//! - *z*: in the root of the sum of the squares of that scatter and of the standard uncertainty that the value itself states.
//!
//! The drives of a rehearsal follow SYNC0 as those on the wire do, so that the transport offset of one tick is in both. What is left
//! of it is where the tick lies between two pulses: that offset is read from the transport delays, printed and taken out of them.
//!
//! Verdicts must be equal, |z| <= 2 for 90 % of the other values and <= 4 for all. Ends with 1 where that is not so.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use procedures::quantity::QuantityKind;
use reports::record::Results;

/// Where most values must lie, and all.
const MOST_WITHIN: f64 = 2.0;
const ALL_WITHIN: f64 = 4.0;
/// Share of the values that must lie within the first.
const MOST: f64 = 0.9;

/// Measurands that are the transport offset itself.
const TRANSPORT_DELAYS: [&str; 3] = [" transport-out ", " transport-back ", " transport-round-trip "];

/// A value by its place: procedure, point, measurand, axis, conditions.
type Values = BTreeMap<String, (f64, f64)>;

/// What a run came to.
struct Run {
    values: Values,
    /// Verdict by requirement.
    verdicts: BTreeMap<String, String>,
}

struct Options {
    run: PathBuf,
    seeds: u64,
    program: PathBuf,
}

pub(crate) fn study() -> ExitCode {
    let Some(options) = options() else {
        println!("usage: wired_scatter RUN [--seeds N] [--program BENCH]");
        return ExitCode::from(2);
    };
    match compare(&options) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(reason) => {
            println!("{reason}");
            ExitCode::from(2)
        }
    }
}

fn options() -> Option<Options> {
    let mut arguments = crate::arguments();
    let run = PathBuf::from(arguments.next()?);
    let (mut seeds, mut program) = (20, None);
    while let Some(name) = arguments.next() {
        let value = arguments.next()?;
        match name.as_str() {
            "--seeds" => seeds = value.parse().ok().filter(|&n: &u64| n > 1)?,
            "--program" => program = Some(PathBuf::from(value)),
            _ => return None,
        }
    }
    let program = program.unwrap_or_else(validation::program::built);
    Some(Options { run, seeds, program: std::fs::canonicalize(program).ok()? })
}

fn compare(options: &Options) -> Result<bool, String> {
    let over_wire = read(&options.run)?;
    let page = std::fs::read_to_string(options.run.join("run.json")).map_err(|e| e.to_string())?;
    let page: serde_json::Value = serde_json::from_str(&page).map_err(|e| e.to_string())?;
    let campaign = page["campaign"].as_str().ok_or("run.json names no campaign")?.to_owned();
    let rig = page["rig"]["name"].as_str().ok_or("run.json names no rig")?.to_owned();
    let loop_rate_hz = loop_rate_hz(page["rig"]["text"].as_str().unwrap_or_default())?;
    let rig = rig.trim_start_matches("shipped:").trim_end_matches(".toml").to_owned();
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let mut virtual_runs = Vec::new();
    for seed in 1..=options.seeds {
        let out = folder.path().join(seed.to_string());
        let mut command = Command::new(&options.program);
        command.args(["run", &campaign, "--rig", &rig, "--tier", "virtual", "--yes", "--non-interactive"]);
        command.arg("--seed").arg(seed.to_string()).arg("--out").arg(&out);
        command.output().map_err(|e| format!("{}: {e}", options.program.display()))?;
        virtual_runs.push(read(&out)?);
    }
    Ok(print(&over_wire, &virtual_runs, loop_rate_hz))
}

/// Distances of a value over the wire from the values in virtual time.
struct Distance {
    mean: f64,
    scatter: f64,
    /// In standard deviations of the virtual values.
    by_scatter: f64,
    /// In standard deviations and the value's own standard uncertainty together.
    z: f64,
}

impl Distance {
    /// `None` for fewer than two virtual values.
    fn new(value: f64, u: f64, others: &[f64]) -> Option<Self> {
        if others.len() < 2 {
            return None;
        }
        let n = others.len() as f64;
        let mean = others.iter().sum::<f64>() / n;
        let scatter = (others.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        // The mean has an uncertainty of its own.
        let of_one = scatter * (1.0 + 1.0 / n).sqrt();
        let over = |unit: f64| if value == mean { 0.0 } else { (value - mean) / unit };
        Some(Self { mean, scatter, by_scatter: over(of_one), z: over(of_one.hypot(u)) })
    }
}

/// Prints the table; whether everything is as it must be.
fn print(over_wire: &Run, virtual_runs: &[Run], loop_rate_hz: f64) -> bool {
    let (mut by_scatter, mut sizes) = (Vec::new(), Vec::new());
    println!(
        "{:>7} {:>11} {:>13} {:>13} {:>10} {:>10}  value",
        "z", "by scatter", "wired", "mean", "scatter", "u"
    );
    for (name, &(value, u)) in &over_wire.values {
        let others: Vec<f64> = virtual_runs.iter().filter_map(|run| Some(run.values.get(name)?.0)).collect();
        let Some(distance) = Distance::new(value, u, &others) else {
            println!(
                "{:>7} {:>11} {value:>13.6e} {:>13} {:>10} {u:>10.2e}  {name}",
                "-", "-", "not measured", ""
            );
            continue;
        };
        let Distance { mean, scatter, by_scatter: alone, z } = distance;
        println!("{z:>7.2} {alone:>11.3e} {value:>13.6e} {mean:>13.6e} {scatter:>10.2e} {u:>10.2e}  {name}");
        if TRANSPORT_DELAYS.iter().any(|delay| name.contains(delay)) {
            println!("{:>7} transport offset: {:.3} ticks", "", loop_rate_hz * (value - mean));
            continue;
        }
        by_scatter.push(alone.abs());
        sizes.push(z.abs());
    }
    let within = |sizes: &[f64], limit: f64| sizes.iter().filter(|&&z| z <= limit).count();
    let (most, all) = (within(&sizes, MOST_WITHIN), within(&sizes, ALL_WITHIN));
    println!("{} values: |z| of {most} within {MOST_WITHIN}, of {all} within {ALL_WITHIN}", sizes.len());
    let [most_alone, all_alone] = [MOST_WITHIN, ALL_WITHIN].map(|limit| within(&by_scatter, limit));
    println!("by scatter alone: {most_alone} within {MOST_WITHIN}, {all_alone} within {ALL_WITHIN}");
    let mut are_equal = true;
    for (id, verdict) in &over_wire.verdicts {
        let others: Vec<&str> =
            virtual_runs.iter().filter_map(|r| Some(r.verdicts.get(id)?.as_str())).collect();
        let same = others.iter().filter(|other| *other == verdict).count();
        println!("{id}: {verdict} over the wire, in {same} of {} virtual runs", others.len());
        are_equal &= 2 * same > others.len();
    }
    are_equal && !sizes.is_empty() && all == sizes.len() && most as f64 >= MOST * sizes.len() as f64
}

/// The loop rate that a rig file names.
fn loop_rate_hz(rig: &str) -> Result<f64, String> {
    let named = rig.lines().find_map(|line| line.strip_prefix("loop-rate = \"")?.split('"').next());
    let named = named.ok_or("the rig of run.json names no loop rate")?;
    QuantityKind::Frequency.parse(named).map_err(|error| format!("loop-rate: {error}"))
}

fn read(folder: &Path) -> Result<Run, String> {
    let path = folder.join("results.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let results: Results = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut values = Values::new();
    for procedure in &results.findings.procedures {
        for m in &procedure.measurements {
            let conditions: Vec<String> =
                m.conditions.iter().map(|c| format!("{}={:.6}", c.name, c.requested)).collect();
            let point = m.point.as_deref().unwrap_or("-");
            let name =
                format!("{} [{point}] {} {} {}", procedure.id, m.axis, m.measurand, conditions.join(" "));
            if let Some(value) = m.value {
                values.insert(name, (value, m.u));
            }
        }
    }
    let outcomes = &results.findings.outcomes;
    let verdicts =
        outcomes.iter().map(|outcome| (outcome.requirement.clone(), format!("{:?}", outcome.verdict)));
    Ok(Run { values, verdicts: verdicts.collect() })
}
