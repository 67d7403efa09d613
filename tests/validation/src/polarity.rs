//! How surely the check of polarity finds what it is for, and how little moves meanwhile.

mod rows;
#[cfg(test)]
mod tests;
mod trial;

pub use rows::{Found, Row, pose_deg, rows};
pub use trial::{Trial, run};
