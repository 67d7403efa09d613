//! Monte-Carlo recovery of margins, delays and the current loop: truth in, estimates out, against what is demanded.
//!
//! `cargo run --release -p validation -- recovery_margins [seeds [text [first]]]` prints one table over 400 seeds
//! fixed beforehand, all studies or those with the text in a row's name, from the first seed on.

mod delays;
mod lags;
mod loops;
mod table;

pub(crate) fn study() {
    let seeds = crate::arguments().next().and_then(|n| n.parse().ok()).unwrap_or(400);
    table::head(seeds);
    lags::rows(seeds);
    delays::rows(seeds);
    loops::rows(seeds);
}
