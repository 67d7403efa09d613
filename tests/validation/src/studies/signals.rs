//! Signals at random instants: no run goes on, hangs, or leaves a point without its end.
//!
//! Each seed draws signals, an instant, whether stdout and stderr have a reader, and whether events are asked for; then a
//! run of the program gets them. Ends with 1 if a rule is broken.
//!
//! `cargo run --release -p validation -- signals [SEEDS] [FIRST]`
use std::process::ExitCode;

use nix::sys::signal::Signal;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use validation::program::built;
use validation::signals::{Attack, Outcome, carry_out};

const SEEDS: u64 = 40;
/// The latest instant, s: polarity is over by then, and both axes turn.
const LATEST_S: f64 = 8.0;

/// What is sent.
const SENT: &[&[Signal]] = &[
    &[Signal::SIGTERM],
    &[Signal::SIGINT],
    &[Signal::SIGINT, Signal::SIGINT],
    &[Signal::SIGHUP],
    &[Signal::SIGQUIT],
    &[Signal::SIGXCPU],
    &[Signal::SIGUSR1, Signal::SIGUSR2, Signal::SIGIO],
    &[Signal::SIGALRM, Signal::SIGVTALRM, Signal::SIGPROF],
    &[Signal::SIGTSTP, Signal::SIGTERM, Signal::SIGINT, Signal::SIGINT],
    &[Signal::SIGTTOU, Signal::SIGTTIN],
    &[Signal::SIGPIPE, Signal::SIGXFSZ, Signal::SIGPWR],
];

pub(crate) fn study() -> ExitCode {
    let mut arguments = crate::arguments().map(|n| n.parse().ok());
    let seeds = arguments.next().flatten().unwrap_or(SEEDS);
    let first: u64 = arguments.next().flatten().unwrap_or(0);
    let program = built();
    let folder = std::env::temp_dir().join(format!("signals-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a writable folder");
    let mut broken = 0;
    let mut slowest_s = 0.0_f64;
    println!("seed  after s  stalled        json   code  took s  points  signals");
    for seed in first..first + seeds {
        let attack = drawn(seed);
        let run = folder.join(seed.to_string());
        let outcome = carry_out(&program, &run, &attack);
        println!("{}", line(seed, &attack, &outcome));
        outcome.breaches.iter().for_each(|breach| println!("      {breach}"));
        broken += usize::from(!outcome.breaches.is_empty());
        slowest_s = slowest_s.max(outcome.took_s);
        let _ = std::fs::remove_dir_all(&run);
    }
    let _ = std::fs::remove_dir_all(&folder);
    println!("{seeds} runs, {broken} broke a rule, {slowest_s:.1} s from the signal to the end at the most");
    ExitCode::from(u8::from(broken > 0))
}

fn drawn(seed: u64) -> Attack {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut below = |n: u64| random.next_u64() % n;
    Attack {
        signals: SENT[below(SENT.len() as u64) as usize].to_vec(),
        after_s: LATEST_S * below(1000) as f64 / 1000.0,
        // Every fourth run has two readers that stall, one run in four has none.
        stalled: [seed & 1 != 0, seed & 2 != 0],
        json: below(2) == 0,
    }
}

fn line(seed: u64, attack: &Attack, outcome: &Outcome) -> String {
    let stalled = match attack.stalled {
        [false, false] => "nothing",
        [true, false] => "stdout",
        [false, true] => "stderr",
        [true, true] => "stdout, stderr",
    };
    let code = outcome.code.map_or("-".to_owned(), |code| code.to_string());
    let sent: Vec<&str> = attack.signals.iter().map(|signal| signal.as_str()).collect();
    format!(
        "{seed:4}  {:7.2}  {stalled:<14} {:<5} {code:>5}  {:6.2}  {:6}  {}",
        attack.after_s,
        attack.json,
        outcome.took_s,
        outcome.points,
        sent.join(" ")
    )
}
