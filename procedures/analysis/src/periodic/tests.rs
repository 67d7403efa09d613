//! Tests of the estimators on records whose response is known.

mod averaging;
mod distortion;
mod motorbench;
mod plant;
mod projection;
mod ranges;
mod refusals;
mod timing;
mod zero_order_hold;
