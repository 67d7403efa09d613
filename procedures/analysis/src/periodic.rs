//! Frequency responses from designed excitation.
//!
//! A record holds the logged reference r (exact) and channels. Windows of T_w are cut from it where the axis moves
//! evenly ([`Windows`]); each gives complex amplitudes X = a − j·b of a·cos ωt + b·sin ωt at the lines
//! ([`amplitudes`]), divided by the reference's ([`transfer`]). From the scatter between windows come the response
//! and its variance with errors in both channels ([`errors_in_variables`]), noise and distortion ([`robust`],
//! [`fast`]), and whether the first window still holds a transient ([`transient`]). Because both channels are divided
//! by the reference, this is the joint input–output estimate: unbiased in closed loop.

mod error;
mod fast;
mod projection;
mod ratio;
mod robust;
#[cfg(test)]
mod tests;
mod timing;
mod transient;
mod windows;

pub use error::PeriodicError;
pub use fast::{DetectionLine, Distortion, LineKind, fast};
pub use projection::{Channel, Drift, Prepared, Projection, amplitudes};
pub use ratio::{errors_in_variables, snr_db};
pub use robust::{Realisation, RobustLine, nonlinear_rms, robust};
pub use timing::{Timing, times_jw};
pub use transient::{Transient, transient};
pub use windows::{Windows, spectra, spectra_with, transfer};
