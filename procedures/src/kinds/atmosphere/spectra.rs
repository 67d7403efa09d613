//! Responses of the closed loop, from the spectra of its readings e and of the mirror m with what the tracker makes of an
//! angle of the mirror.

use std::f64::consts::PI;

use analysis::frf::{C64, Frf, Line};

use super::point::{AVERAGES, LOOP, of};
use crate::measurement::PointResult;

/// Spectra of a line: S_ij is the mean of conj(X_i)·X_j; b is the mean of m over a frame.
struct Spectra {
    frequency_hz: f64,
    ee: f64,
    mm: f64,
    bb: f64,
    em: C64,
    eb: C64,
    mb: C64,
}

/// What the closed loop says of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Responses {
    /// Left of the line of sight at any time: 1 − g·M/D.
    pub(super) left: Frf,
    /// Left in the readings, which see the mirror at their exposures only: E/D.
    pub(super) read: Frf,
    /// Density of d, what moves the image: frequency, value.
    pub(super) input: Vec<[f64; 2]>,
    /// Density of the readings: frequency, value, degrees of freedom.
    pub(super) error: Vec<[f64; 3]>,
}

/// Responses of an axis: `sight` is the reading per angle of the mirror, so that d = e − sight·m.
///
/// `None` where the point has no spectra.
pub(super) fn responses(point: &PointResult, axis: usize, sight: f64, rate_hz: f64) -> Option<Responses> {
    let averages = *point.numbers.get(&of(axis, AVERAGES))?.first()?;
    let lines = point.numbers.get(&of(axis, LOOP))?.as_chunks::<10>().0;
    let mut all = Responses { left: Vec::new(), read: Vec::new(), input: Vec::new(), error: Vec::new() };
    let half_hz = 0.5 * rate_hz;
    for values in lines.iter().filter(|l| l[0] > 0.0 && l[0] < half_hz * (1.0 - 1e-9)) {
        let s = spectra(values);
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
        all.input.push([s.frequency_hz, dd]);
        all.error.push([s.frequency_hz, s.ee, 2.0 * averages]);
    }
    Some(all)
}

fn spectra(&[frequency_hz, ee, mm, bb, em_re, em_im, eb_re, eb_im, mb_re, mb_im]: &[f64; 10]) -> Spectra {
    let (em, eb, mb) = (C64::new(em_re, em_im), C64::new(eb_re, eb_im), C64::new(mb_re, mb_im));
    Spectra { frequency_hz, ee, mm, bb, em, eb, mb }
}
