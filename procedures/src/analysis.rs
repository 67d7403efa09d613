//! Estimators: arrays in, numbers with uncertainty out. They know nothing of kinds or files.

pub mod breakaway;
pub mod derivative;
pub mod dwell;
pub mod effort;
pub mod least_squares;
pub mod load_map;
pub mod multisine;
pub mod nonlinear;
pub mod presliding;
pub mod uncertainty;
