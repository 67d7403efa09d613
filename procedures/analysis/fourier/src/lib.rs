//! Plans of Fourier transforms of real numbers.
//!
//! `realfft` and `rustfft` are generic over the number: each crate that names `RealFftPlanner<f64>` compiles all of their
//! algorithms again, once for itself and once for its tests. They are named here and nowhere else, so that they are
//! compiled once.

use std::sync::Arc;

pub use realfft::{ComplexToReal, RealToComplex};

/// Transform of `length` real samples to their spectrum (`length` / 2 + 1 lines, not divided by `length`).
pub fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    realfft::RealFftPlanner::new().plan_fft_forward(length)
}

/// Transform of a spectrum (`length` / 2 + 1 lines) back to `length` real samples, multiplied by `length`.
pub fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    realfft::RealFftPlanner::new().plan_fft_inverse(length)
}
