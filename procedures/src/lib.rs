//! What to test and how to judge it.
//!
//! Text becomes a [`procedure::Procedure`], the procedure plans [`case::Case`]s, the bench runs them and writes a
//! log ([`log`], the only door between running and judging), a [`kinds::Experiment`] turns the log into
//! [`measurement::Measurement`]s, and [`verdict`] holds them against [`requirement`]s.
//!
//! Nothing here reads a clock, a locale or a random source: the same bytes in give the same numbers out.

pub mod agreement;
pub mod axis;
pub mod campaign;
pub mod case;
pub mod comparison;
pub mod condition;
pub mod device;
pub mod diagnostic;
pub mod drift;
pub mod excitation;
pub mod identification;
pub mod kinds;
pub mod log;
pub mod measurement;
pub mod missing;
pub mod population;
pub mod procedure;
pub mod pull;
pub mod quantity;
pub mod reason;
pub mod regression;
pub mod requirement;
pub mod schema;
pub mod stimulus;
#[cfg(test)]
mod synthetic;
pub mod table;
pub mod target;
pub mod trace;
pub mod verdict;
