//! How surely the check of polarity finds what it is for, and how little moves meanwhile.
//!
//! Each fault on many seeds (noise and pose), both axes where it belongs to one: how often it is caught, by which
//! sentence, largest true motion and rate of either axis; then units without such a fault, on which it must stay silent.
//! Ends with 1 if a row does not hold.
//!
//! `cargo run --release -p validation -- polarity [SEEDS]`

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use validation::polarity::{self, Found, Row, pose_deg, rows};

/// One in this many seeds of the table; 1 runs 100 seeds a fault and 200 nominal units.
const SEEDS: u64 = 100;

pub(crate) fn study() {
    let argument = crate::arguments().next().and_then(|n| n.parse().ok());
    let only = crate::arguments().nth(1);
    let share = argument.unwrap_or(SEEDS) as f64 / SEEDS as f64;
    let folder = std::env::temp_dir().join(format!("polarity-{}", std::process::id()));
    let mut all_hold = true;
    println!("unit                        caught     motion deg  rate deg/s  first sentence");
    for row in rows().iter().filter(|row| only.as_ref().is_none_or(|only| row.name.contains(only.as_str()))) {
        let seeds = ((row.seeds as f64 * share).round() as u64).max(1);
        let found = run(row, seeds, &folder.join(row.name.replace(' ', "-")));
        all_hold &= found.holds(row, seeds);
        println!("{}", found.line(row, seeds));
    }
    let _ = std::fs::remove_dir_all(&folder);
    std::process::exit(i32::from(!all_hold));
}

/// All seeds of a row, on both processors.
fn run(row: &Row, seeds: u64, folder: &Path) -> Found {
    std::fs::create_dir_all(folder).expect("a temporary folder");
    let next = AtomicU64::new(1);
    let found = Mutex::new(Found::default());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed > seeds {
                        break;
                    }
                    let trial = polarity::run(&row.unit, pose_deg(seed), seed, folder);
                    found.lock().unwrap_or_else(PoisonError::into_inner).take(row, seed, &trial);
                }
            });
        }
    });
    found.into_inner().unwrap_or_else(PoisonError::into_inner)
}
