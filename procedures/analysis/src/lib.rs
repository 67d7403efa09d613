//! Estimators: arrays in, numbers with uncertainty out.
//!
//! An estimator gets samples, spectra or measured values in SI units and gives an [`estimate::Estimate`] or a fitted
//! model with its covariance. No estimator knows kinds of procedures, logs, files or clocks.

pub mod allan;
pub mod angle_map;
pub mod breakaway;
pub mod circuit;
pub mod cogging;
pub mod copula;
pub mod delay;
pub mod derivative;
pub mod design;
pub mod dwell;
pub mod effort;
pub mod estimate;
pub mod even_rows;
pub mod excitation;
pub mod family_wise;
pub mod following;
pub mod frf;
pub mod friction;
pub mod goodness;
pub mod gravity;
pub mod heating;
pub mod lag;
pub mod least_squares;
pub mod load_cycle;
pub mod load_map;
pub mod local_fit;
pub mod lost_motion;
pub mod margins;
pub mod modal;
pub mod multisine;
pub mod nonlinear;
pub mod paired;
pub mod peaks;
pub mod periodic;
pub mod pitch;
pub mod plateau;
pub mod polarity;
pub mod positioning;
pub mod posterior;
pub mod presliding;
pub mod proportion;
pub mod quantile;
pub mod rank;
pub mod rational;
pub mod rejection;
pub mod residual;
pub mod spectra;
pub mod step;
pub mod stillness;
pub mod stribeck;
#[cfg(test)]
mod synthetic_noise;
pub mod tones;
pub mod tracking;
pub mod truncated_normal;
pub mod turning;
pub mod uncertainty;
