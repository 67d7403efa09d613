//! Estimators: arrays in, numbers with uncertainty out. They know nothing of kinds or files.

pub mod derivative;
pub mod least_squares;
pub mod uncertainty;
