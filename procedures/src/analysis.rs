//! Estimators: arrays in, numbers with uncertainty out. They know nothing of kinds or files.

pub mod angle_map;
pub mod cogging;
pub mod derivative;
pub mod friction;
pub mod gravity;
pub mod least_squares;
pub mod plateau;
pub mod stribeck;
pub mod uncertainty;
