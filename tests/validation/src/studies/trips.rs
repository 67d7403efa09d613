//! A thousand random trips of the simulated director, and what became of them.
//!
//! `cargo run --release -p validation -- trips [COUNT] [--from SEED] [--all]`
//!
//! Prints a line a cause (and with `--all` a line a trial); exits 1 where a trial broke a rule.

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use validation::trips::{Bed, CAUSES, Trial, UNITS};

pub(crate) fn study() -> ExitCode {
    let arguments: Vec<String> = crate::arguments().collect();
    let number = |text: Option<&String>| text.and_then(|t| t.parse::<u64>().ok());
    let count = number(arguments.first()).unwrap_or(1000);
    let from = arguments.iter().position(|a| a == "--from").and_then(|k| number(arguments.get(k + 1)));
    let from = from.unwrap_or(0);
    let trials = all(from, count);
    if arguments.iter().any(|a| a == "--all") {
        trials.iter().for_each(row);
        println!();
    }
    summary(&trials);
    let broken: Vec<&Trial> = trials.iter().filter(|t| !t.breaches.is_empty()).collect();
    for trial in &broken {
        println!("seed {}: {}", trial.plan.seed, CAUSES[trial.plan.cause].name);
        trial.breaches.iter().for_each(|breach| println!("    {breach}"));
    }
    println!("{count} trips, {} broke a rule", broken.len());
    if broken.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Trials in the order of their seeds, whoever ran them.
fn all(from: u64, count: u64) -> Vec<Trial> {
    let next = AtomicU64::new(from);
    let done = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                let bed = Bed::shipped();
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= from + count {
                        break;
                    }
                    let trial = bed.trial(seed);
                    done.lock().expect("no worker panics while it holds it").push(trial);
                }
            });
        }
    });
    let mut trials = done.into_inner().expect("all workers have ended");
    trials.sort_by_key(|trial| trial.plan.seed);
    trials
}

fn summary(trials: &[Trial]) {
    println!(
        "{:<28} {:>5} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6}",
        "cause",
        "count",
        "hidden",
        "answer",
        "reached",
        "computed",
        "reached/",
        "time",
        "time/",
        "closest",
        "residual",
        "broken"
    );
    println!(
        "{:<28} {:>5} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6}",
        "", "", "ms max", "ticks", "deg max", "deg max", "computed", "s max", "computed", "deg", "", ""
    );
    for (index, cause) in CAUSES.iter().enumerate() {
        let of: Vec<&Trial> = trials.iter().filter(|t| t.plan.cause == index).collect();
        let most = |f: &dyn Fn(&Trial) -> f64| of.iter().map(|t| f(t)).fold(f64::NEG_INFINITY, f64::max);
        let residual = of.iter().filter(|t| t.predicted.is_some()).count();
        let ratio = |t: &Trial| if t.computed_rad > 0.0 { t.reached_rad / t.computed_rad } else { 0.0 };
        println!(
            "{:<28} {:>5} {:>7.1} {:>7.0} {:>8.2} {:>8.2} {:>8.3} {:>8.2} {:>8.3} {:>8.3} {:>8} {:>6}",
            cause.name,
            of.len(),
            most(&|t| t.hidden_ticks as f64 * 0.25),
            most(&|t| t.answered_ticks.map_or(f64::INFINITY, |ticks| ticks as f64)),
            most(&|t| t.reached_rad.to_degrees()),
            most(&|t| t.computed_rad.to_degrees()),
            most(&|t| if t.predicted.is_none() { ratio(t) } else { 0.0 }),
            most(&|t| t.reached_s),
            most(&|t| t.computed_s.map_or(0.0, |s| t.reached_s / s)),
            -most(&|t| if t.predicted.is_none() { -t.room_rad.to_degrees() } else { f64::NEG_INFINITY }),
            residual,
            of.iter().filter(|t| !t.breaches.is_empty()).count(),
        );
    }
}

fn row(trial: &Trial) {
    let plan = &trial.plan;
    let deg = f64::to_degrees;
    let residual = trial.predicted.map_or(String::new(), |p| {
        let met = trial.impact_rad_per_s.map_or("no contact".to_owned(), |v| format!("{:.2} deg/s", deg(v)));
        format!(", residual {:.2} deg/s {:.0} J, {met}", deg(p.speed_rad_per_s), p.energy_j)
    });
    println!(
        "{:>4} {:<11} {} {:<26} {:>8.2} deg {:>7.2} deg/s, hidden {:>6.1} ms, answer {:?}, {:<18} {} {:.3} of {:.3} deg, {:.2} s, room {:.2} deg{residual}",
        plan.seed,
        UNITS[plan.unit],
        ["az", "el"][plan.axis],
        CAUSES[plan.cause].name,
        deg(trial.caused.angle_rad),
        deg(trial.caused.rate_rad_per_s),
        trial.hidden_ticks as f64 * 0.25,
        trial.answered_ticks,
        trial.first_out,
        if trial.lost_torque { "coasts" } else { "brakes" },
        deg(trial.reached_rad),
        deg(trial.computed_rad),
        trial.reached_s,
        deg(trial.room_rad),
    );
}
