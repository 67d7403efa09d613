//! Estimators: arrays in, numbers with uncertainty out. They know nothing of kinds or files.

pub mod angle_map;
pub mod breakaway;
pub mod circuit;
pub mod cogging;

pub mod delay;
pub mod derivative;
pub mod dwell;
pub mod effort;
pub mod excitation;
pub mod frf;
pub mod friction;
pub mod gravity;

pub mod lag;
pub mod least_squares;
pub mod load_map;
pub mod margins;
pub mod modal;
pub mod multisine;
pub mod nonlinear;
pub mod periodic;
pub mod plateau;
pub mod polarity;
pub mod presliding;
pub mod rational;
pub mod spectra;
pub mod stribeck;
pub mod tracking;
pub mod uncertainty;
