//! Tests of the estimators on records whose response is known.

mod averaging;
mod distortion;
mod local;
mod motorbench;
mod plant;
mod projection;
mod ranges;
mod refusals;
mod sweeps;
mod timing;
