//! Transport through a loop whose lag is known from elsewhere.

use super::{LagError, Model, Settings, check};
use crate::frf::Line;
use crate::frf::pooled::with_pooled_variances;
use crate::goodness::Goodness;

/// Transport through a loop of known corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownLag {
    /// Pure delay, as [`LagFit::transport_s`](super::LagFit::transport_s), s.
    pub transport_s: f64,
    /// Standard uncertainty of `transport_s`, that of the corner included, s.
    pub transport_u_s: f64,
    /// Static gain, measured over commanded.
    pub gain: f64,
    /// How well the model describes the lines.
    pub goodness: Goodness,
}

/// Fits gain and delay where samples are too slow to hold the corner: `corner_hz` (and its standard uncertainty) is
/// given. The model is that of [`sampled_response`](super::sampled_response).
///
/// # Errors
/// Lines that are none; no fit; a model that does not describe the lines.
pub fn transport_at_known_corner(
    lines: &[Line],
    settings: &Settings,
    [corner_hz, corner_u_hz]: [f64; 2],
) -> Result<KnownLag, LagError> {
    check(lines, settings)?;
    let lines = &with_pooled_variances(lines);
    let fit_at = |hz: f64| {
        let model = Model { lines, settings: *settings, corner_hz: Some(hz) };
        model.best(model.starts()).ok_or(LagError::NoFit { most_delay_s: settings.most_delay_s })
    };
    let fit = fit_at(corner_hz)?;
    let by_corner_s = match corner_u_hz > 0.0 {
        true => (fit_at(corner_hz + corner_u_hz)?.parameters[1] - fit.parameters[1]).abs(),
        false => 0.0,
    };
    let goodness = Goodness::of_lines(lines, fit.residual_variance, fit.dof);
    goodness.check()?;
    let transport_u_s = fit.unscaled_covariance[(1, 1)].sqrt() * goodness.widening();
    Ok(KnownLag {
        transport_s: fit.parameters[1],
        transport_u_s: transport_u_s.hypot(by_corner_s),
        gain: fit.parameters[0],
        goodness,
    })
}
