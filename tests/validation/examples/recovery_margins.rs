//! Monte-Carlo recovery of margins, delays and the current loop: truth in, estimates out, against what is demanded.
//!
//! `cargo run --release -p validation --example recovery_margins [seeds [text [first]]]` prints one table over 400 seeds
//! fixed beforehand, all studies or those with the text in a row's name, from the first seed on.

#![allow(clippy::print_stdout, reason = "a program that prints a table")]

#[path = "recovery_margins/delays.rs"]
mod delays;
#[path = "recovery_margins/lags.rs"]
mod lags;
#[path = "recovery_margins/loops.rs"]
mod loops;
#[path = "recovery_margins/table.rs"]
mod table;

fn main() {
    let seeds = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(400);
    table::head(seeds);
    lags::rows(seeds);
    delays::rows(seeds);
    loops::rows(seeds);
}
