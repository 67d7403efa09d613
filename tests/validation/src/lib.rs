//! What the simulator and the estimators are compared with: the linear model, predictions of what a unit will show, the
//! study's published tables, and trials over many seeds.
//!
//! Nothing of the product links this crate. Its tests run with all others; the longer checks are the studies of its program.

pub mod blind;
pub mod budget;
pub mod compiled;
pub mod conditions;
pub mod expected;
pub mod intercepted;
pub mod linear;
pub mod measured_flips;
pub mod measured_points;
pub mod mutations;
pub mod planted;
pub mod polarity;
pub mod prediction;
pub mod probe;
pub mod program;
pub mod published;
pub mod shipped;
pub mod signals;
pub mod spectrum;
pub mod trips;
pub mod twins;
