//! Responses of an axis to an excitation: frequency, modes, latency, imported records.

use crate::trace::{Plot, Scale, Series};

pub(in crate::kinds) mod excited;
pub(in crate::kinds) mod frequency_response;
pub(in crate::kinds) mod imported_response;
pub(in crate::kinds) mod latency;
pub(in crate::kinds) mod modes;

/// The phase below a plot of gain over the same frequencies.
fn phase_panel(gain: &Plot, series: Vec<Series>) -> Plot {
    let scale = Scale::linear("phase", "deg");
    Plot {
        series,
        ..Plot::new(format!("{}-phase", gain.id), format!("{}: phase", gain.title), gain.x.clone(), scale)
    }
    .panel_of(gain)
}

/// The coherence below a plot of gain over the same frequencies; `what` names it.
fn coherence_panel(gain: &Plot, what: &str, series: Vec<Series>) -> Plot {
    let scale = Scale::linear("coherence", "");
    Plot {
        series,
        y_range: Some([0.0, 1.0]),
        ..Plot::new(
            format!("{}-coherence", gain.id),
            format!("{}: {what}", gain.title),
            gain.x.clone(),
            scale,
        )
    }
    .panel_of(gain)
}
