//! The largest gain of a closed loop, read across gaps between its lines.

use std::f64::consts::TAU;

use super::{C64, LEAST_LINES, Line, MarginError, check};
use crate::goodness::Goodness;
use crate::least_squares::LinearFit;

/// Powers of s above the denominator.
const TERMS: usize = 4;
/// Rounds of the weighted linear fit: the weights hold its denominator (Sanathanan & Koerner 1963).
const ROUNDS: usize = 6;
/// Points of the search.
const POINTS: usize = 4000;

/// Largest |T| of a closed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Where, Hz.
    pub frequency_hz: f64,
    /// 20·log₁₀|T| there, dB.
    pub gain_db: f64,
    /// Standard uncertainty of `gain_db`, dB: that of the lines, of lines that scatter about the curve by more than they should,
    /// and what a curve of one term more says otherwise.
    pub gain_u_db: f64,
    /// How well the curve describes the lines.
    pub goodness: Goodness,
}

/// The largest gain of a closed loop with a PI controller around an inertia, from the lines up to a frequency.
///
/// `1/T = 1 + (a₁s + … + a₄s⁴)/(1 + b·s)`: the loop integrates, so T(0) = 1; 1/T has the zero of the PI controller as
/// its pole; inertia, friction and delays above it are a power series, which holds well below the first mode. So a peak
/// is found where lines had to leave a gap. Fitted by weighted least squares of the linearised equation, repeated.
///
/// # Errors
/// Lines that are none, fewer than [`LEAST_LINES`] of them in the band, or none that the curve fits; see [`MarginError`].
pub fn peak(closed: &[Line], up_to_hz: f64) -> Result<Peak, MarginError> {
    check::lines(closed)?;
    let band: Vec<Line> = closed.iter().filter(|l| l.frequency_hz <= up_to_hz).copied().collect();
    let few = MarginError::TooFewLines { found: band.len() };
    if band.len() < LEAST_LINES {
        return Err(few);
    }
    let (Some(chosen), more) = (Curve::new(&band, TERMS), Curve::new(&band, TERMS + 1)) else {
        return Err(few);
    };
    let (frequency_hz, nepers) = chosen.top(&band);
    let otherwise = more.map_or(0.0, |more| more.top(&band).1 - nepers);
    let db = 20.0 * std::f64::consts::LOG10_E;
    Ok(Peak {
        frequency_hz,
        gain_db: db * nepers,
        gain_u_db: db * chosen.u_nepers(frequency_hz).hypot(otherwise),
        goodness: chosen.goodness,
    })
}

/// 1/T over the band.
struct Curve {
    /// s is counted in this many rad/s, so that powers stay near 1.
    scale_rad_per_s: f64,
    terms: usize,
    fit: LinearFit,
    goodness: Goodness,
}

impl Curve {
    /// `None` where the lines do not determine it.
    fn new(band: &[Line], terms: usize) -> Option<Self> {
        let scale_rad_per_s = TAU * band.last()?.frequency_hz;
        let s = |l: &Line| C64::new(0.0, TAU * l.frequency_hz / scale_rad_per_s);
        let exact = band.iter().all(|l| l.variance <= 0.0);
        let mut curve: Option<Self> = None;
        for _ in 0..ROUNDS {
            let mut columns = vec![Vec::new(); terms + 1];
            let mut y = Vec::new();
            let mut w = Vec::new();
            for line in band {
                let s = s(line);
                let inverse = line.value.inv();
                let under = curve.as_ref().map_or(C64::new(1.0, 0.0), |c| 1.0 + c.pole() * s);
                // Variance of the real and the imaginary part of 1/T, and of the equation: |dT⁻¹| = |dT|/|T|².
                let own = if exact { 1.0 } else { 0.5 * line.variance / line.value.norm_sqr().powi(2) };
                let weight = 1.0 / (own * under.norm_sqr());
                let mut row: Vec<C64> = (1..=terms).map(|k| s.powu(k as u32)).collect();
                row.push(-s * (inverse - 1.0));
                for part in [|v: C64| v.re, |v: C64| v.im] {
                    columns.iter_mut().zip(&row).for_each(|(column, v)| column.push(part(*v)));
                    y.push(part(inverse - 1.0));
                    w.push(weight);
                }
            }
            let fit = LinearFit::new(&columns, &y, Some(&w)).ok()?;
            let goodness = Goodness::of_lines(band, fit.residual_variance, fit.dof);
            curve = Some(Self { scale_rad_per_s, terms, fit, goodness });
        }
        curve
    }

    fn pole(&self) -> f64 {
        self.fit.coefficients[self.terms]
    }

    fn s(&self, frequency_hz: f64) -> C64 {
        C64::new(0.0, TAU * frequency_hz / self.scale_rad_per_s)
    }

    /// 1/T, and its derivatives by the coefficients.
    fn at(&self, frequency_hz: f64) -> (C64, Vec<C64>) {
        let s = self.s(frequency_hz);
        let under = 1.0 + self.pole() * s;
        let by = |k: usize| s.powu(k as u32) / under;
        let over: C64 = (1..=self.terms).map(|k| by(k) * self.fit.coefficients[k - 1]).sum();
        let gradient = (1..=self.terms).map(by).chain([-over * s / under]).collect();
        (1.0 + over, gradient)
    }

    /// Where |T| is largest up to the last line, Hz, and its logarithm there. T(0) = 1 holds the curve below the first line,
    /// too: the search begins a decade and a half below the last.
    fn top(&self, band: &[Line]) -> (f64, f64) {
        let last_hz = band.last().map_or(0.0, |l| l.frequency_hz);
        let [from, to] = [last_hz / 30.0, last_hz].map(f64::ln);
        let hz = |k: usize| (from + (to - from) * k as f64 / POINTS as f64).exp();
        let gains = (0..=POINTS).map(|k| (hz(k), -self.at(hz(k)).0.norm().ln()));
        gains.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, f64::NEG_INFINITY))
    }

    /// Standard uncertainty of the logarithm of |T|; at the top the frequency does not count.
    fn u_nepers(&self, frequency_hz: f64) -> f64 {
        let (value, gradient) = self.at(frequency_hz);
        let slope = nalgebra::DVector::from_iterator(gradient.len(), gradient.iter().map(|g| (g / value).re));
        let variance = slope.dot(&(&self.fit.unscaled_covariance * &slope)).max(0.0);
        variance.sqrt() * self.goodness.widening()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PI controller of 3 Hz and its zero at 3.15 Hz around an inertia, 3 ms of delay.
    fn closed(hz: f64) -> C64 {
        let s = C64::new(0.0, TAU * hz);
        let open = (18.7 * s + 370.0) / (s * s) * (-0.003 * s).exp();
        open / (1.0 + open)
    }

    #[test]
    fn a_peak_in_a_gap_between_lines_is_found_and_its_uncertainty_covers_the_miss() {
        let fine = (1000..6000).map(|k| closed(1e-3 * f64::from(k)).norm());
        let truth_db = 20.0 * fine.fold(0.0, f64::max).log10();
        let grid = [0.5, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0];
        let exact = grid.map(|hz| Line::exact(hz, closed(hz)));
        let on_lines_db = exact.iter().map(Line::gain_db).fold(f64::NEG_INFINITY, f64::max);
        let found = peak(&exact, 8.0).expect("a peak");
        assert!(truth_db - on_lines_db > 0.3, "{truth_db} dB lies between lines of {on_lines_db} dB");
        assert!((found.gain_db - truth_db).abs() < 0.01, "{found:?}, truth {truth_db}");
        assert!((2.0..3.3).contains(&found.frequency_hz), "{found:?}");
        // 0.1 % of noise known as such.
        let noisy = exact.map(|l| Line { variance: 2e-6 * l.value.norm_sqr(), ..l });
        let noisy = peak(&noisy, 8.0).expect("a peak");
        assert!((0.002..0.1).contains(&noisy.gain_u_db), "{noisy:?}");
    }

    #[test]
    fn few_lines_or_bad_ones_are_refused() {
        let lines: Vec<Line> = (1..9).map(|k| Line::exact(f64::from(k), closed(f64::from(k)))).collect();
        assert_eq!(peak(&lines, 4.0), Err(MarginError::TooFewLines { found: 4 }));
        let broken: Vec<Line> = lines.iter().map(|l| Line { variance: f64::NAN, ..*l }).collect();
        assert!(matches!(peak(&broken, 8.0), Err(MarginError::NotFinite { .. })));
    }
}
