//! As few poles as describe a response.

use super::lines::Data;
use super::{Delay, RationalError, RationalFit, Settings};
use crate::frf::Frf;

/// Orders tried beyond the best one so far: a pair of modes may only pay together.
const LOOK_AHEAD: usize = 5;

pub(super) fn select(
    frf: &Frf,
    settings: &Settings,
    most_poles: usize,
) -> Result<RationalFit, RationalError> {
    let frfs = std::slice::from_ref(frf);
    let data = Data::new(frfs, 0.0)?;
    let mut best: Option<(f64, usize, RationalFit)> = None;
    let mut error = RationalError::NotConverged;
    for poles in settings.poles..=most_poles.max(settings.poles) {
        if best.as_ref().is_some_and(|(_, found, _)| poles > found + LOOK_AHEAD) {
            break;
        }
        match RationalFit::new(frfs, &Settings { poles, ..settings.clone() }) {
            Ok(fit) => {
                let score = score(&fit, &data, settings);
                let better = best.as_ref().is_none_or(|(least, ..)| score < *least);
                if better && !bends_between_lines(&fit, &data) {
                    best = Some((score, poles, fit));
                }
            }
            Err(found @ RationalError::TooFew { .. }) => {
                error = found;
                break;
            }
            Err(found) => error = found,
        }
    }
    best.map(|(_, _, fit)| fit).ok_or(error)
}

/// Bayesian information criterion: with known variances from the cost, else from the logarithm of the residual.
fn score(fit: &RationalFit, data: &Data, settings: &Settings) -> f64 {
    let observed = (2 * data.line_count()) as f64;
    let delay = usize::from(matches!(settings.delay, Delay::Fitted(_)));
    let unknowns = (2 * fit.poles.len() + settings.terms.len() + delay) as f64;
    let misfit = if data.known { fit.cost } else { observed * fit.cost.max(f64::MIN_POSITIVE).ln() };
    misfit + unknowns * observed.ln()
}

/// Whether a pole inside the band has a half-power width below the spacing of the lines there.
fn bends_between_lines(fit: &RationalFit, data: &Data) -> bool {
    let s = &data.responses[0].s;
    let first = s[0].im;
    let last = s[s.len() - 1].im;
    fit.poles.iter().any(|p| {
        let width = 2.0 * p.re.abs() / data.scale_rad_per_s;
        let at = p.im / data.scale_rad_per_s;
        at > first && at < last && width < data.spacing_at(at)
    })
}
