//! Responses of the closed loop, from the spectra of its readings e and of the mirror m with what the tracker makes of an
//! angle of the mirror.

use std::f64::consts::PI;

use analysis::frf::{C64, Frf, Line};

use super::point::{Density, Spectra};

/// What the closed loop says of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Responses {
    /// Left of the line of sight at any time: 1 − g·M/D.
    pub(super) left: Frf,
    /// Left in the readings, which see the mirror at their exposures only: E/D.
    pub(super) read: Frf,
    /// Density of d, what moves the image.
    pub(super) input: Vec<Density>,
    /// Density of the readings.
    pub(super) error: Vec<Density>,
}

/// Responses of an axis: `sight` is the reading per angle of the mirror, so that d = e − sight·m.
pub(super) fn responses(lines: &[Spectra], averages: f64, sight: f64, rate_hz: f64) -> Responses {
    let mut all = Responses { left: Vec::new(), read: Vec::new(), input: Vec::new(), error: Vec::new() };
    let half_hz = 0.5 * rate_hz;
    for s in lines.iter().filter(|l| l.frequency_hz > 0.0 && l.frequency_hz < half_hz * (1.0 - 1e-9)) {
        let g = -sight;
        let dd = s.ee + 2.0 * g * s.em.re + g * g * s.mm;
        if dd <= 0.0 {
            continue;
        }
        let de = C64::new(s.ee, 0.0) + s.em.conj() * g;
        // The mean over a frame is smaller by sin x/x.
        let turn = PI * s.frequency_hz / rate_hz;
        let db = (s.eb + s.mb * g) / (turn.sin() / turn);
        let bb = s.bb / (turn.sin() / turn).powi(2);
        let taken = db * (g / dd);
        let line = |value: C64, cross: C64, out: f64, size: f64| {
            let coherence = if out > 0.0 { (cross.norm_sqr() / (dd * out)).min(1.0) } else { 0.0 };
            let variance = size * (1.0 - coherence) / coherence.max(1e-12) / (averages - 1.0).max(1.0);
            let dof = (averages - 1.0).max(1.0);
            Line { frequency_hz: s.frequency_hz, value, variance, dof, coherence: Some(coherence) }
        };
        all.left.push(line(C64::new(1.0, 0.0) - taken, db, bb, taken.norm_sqr()));
        all.read.push(line(de / dd, de, s.ee, (de / dd).norm_sqr()));
        let dof = 2.0 * averages;
        all.input.push(Density { frequency_hz: s.frequency_hz, value: dd, dof });
        all.error.push(Density { frequency_hz: s.frequency_hz, value: s.ee, dof });
    }
    all
}
