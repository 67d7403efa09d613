//! Monte Carlo of the responses from designed excitation: bias, variance and coverage against plants that are known.
//!
//! `cargo run --release -p analysis --example recovery_responses [seeds]`, 400 seeds unless said.
//! Rows: multisine with errors in both channels (1), noise and distortion apart (3). The numbers demanded stand beside
//! those found.

#![allow(clippy::print_stdout)]

#[path = "recovery_responses/distortion.rs"]
mod distortion;
#[path = "recovery_responses/multisine.rs"]
mod multisine;
#[path = "../src/periodic/tests/plant.rs"]
mod plant;

/// One number against its demand.
pub(crate) struct Row {
    pub(crate) what: String,
    pub(crate) found: f64,
    /// Least and most.
    pub(crate) demand: [f64; 2],
}

impl Row {
    pub(crate) fn new(what: &str, found: f64, demand: [f64; 2]) -> Self {
        Self { what: what.to_owned(), found, demand }
    }
}

fn print(title: &str, rows: &[Row]) {
    println!("{title}");
    for row in rows {
        let [least, most] = row.demand;
        let told = if least.is_infinite() && most.is_infinite() {
            "for comparison".to_owned()
        } else {
            let verdict = if (least..=most).contains(&row.found) { "ok" } else { "MISSED" };
            format!("{least:>9.4} … {most:<9.4} {verdict}")
        };
        println!("  {:<66} {:>9.4}   {told}", row.what, row.found);
    }
}

fn main() {
    let seeds = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(400);
    println!("{seeds} seeds");
    print(
        "row 1: multisine, P = 8 windows anywhere, offset ½, cogging fitted beside",
        &multisine::rows(seeds),
    );
    print("row 3: robust method, R = 7, P = 4, y = u + 0.03·u³ + noise", &distortion::rows(seeds));
}
