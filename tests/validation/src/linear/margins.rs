//! Bandwidth and margins of an open loop, all crossings considered.

use num_complex::Complex64;

/// Points per octave of the search grid: a mode of ζ = 0.01 is several points wide.
const POINTS_PER_OCTAVE: f64 = 400.0;
/// Bisections of a crossing.
const HALVINGS: u32 = 50;

/// What a loop has in reserve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Open-loop bandwidth: the lowest 0 dB crossing.
    pub bandwidth_hz: f64,
    /// Smallest phase margin of all 0 dB crossings.
    pub phase_margin_deg: f64,
    /// Smallest gain margin of all −180° crossings.
    pub gain_margin_db: f64,
    /// Where that is.
    pub gain_margin_hz: f64,
}

/// Margins of an open loop between two frequencies; `None` where it never crosses 0 dB.
pub fn margins(open_loop: impl Fn(f64) -> Complex64, from_hz: f64, to_hz: f64) -> Option<Margins> {
    let count = ((to_hz / from_hz).log2() * POINTS_PER_OCTAVE).ceil();
    let grid = (0..=count as u32).map(|k| from_hz * (to_hz / from_hz).powf(f64::from(k) / count));
    let points: Vec<(f64, Complex64)> = grid.map(|hz| (hz, open_loop(hz))).collect();
    let mut found: Option<Margins> = None;
    let mut gain_margin_db = f64::INFINITY;
    let mut gain_margin_hz = f64::NAN;
    for pair in points.windows(2) {
        let ((low, at_low), (high, at_high)) = (pair[0], pair[1]);
        if (at_low.norm() > 1.0) != (at_high.norm() > 1.0) {
            let hz = bisect(low, high, |hz| open_loop(hz).norm() > 1.0);
            let margin = phase_margin_deg(open_loop(hz));
            let first = found.map_or(hz, |m| m.bandwidth_hz);
            let least = found.map_or(margin, |m| m.phase_margin_deg.min(margin));
            found = Some(Margins {
                bandwidth_hz: first,
                phase_margin_deg: least,
                gain_margin_db,
                gain_margin_hz,
            });
        }
        // The negative real axis is crossed where the imaginary part changes sign on the left.
        if (at_low.im > 0.0) != (at_high.im > 0.0) && at_low.re < 0.0 && at_high.re < 0.0 {
            let hz = bisect(low, high, |hz| open_loop(hz).im > 0.0);
            let margin = -20.0 * open_loop(hz).norm().log10();
            if margin < gain_margin_db {
                (gain_margin_db, gain_margin_hz) = (margin, hz);
            }
        }
    }
    found.map(|m| Margins { gain_margin_db, gain_margin_hz, ..m })
}

/// Angle above −180°, in −180…180.
fn phase_margin_deg(open: Complex64) -> f64 {
    (-open).arg().to_degrees()
}

fn bisect(mut low: f64, mut high: f64, state: impl Fn(f64) -> bool) -> f64 {
    let before = state(low);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if state(middle) == before { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// K·e^{−sτ}/s: crossover K, phase margin 90° − Kτ, −180° at ω = π/(2τ), gain margin π/(2Kτ).
    #[test]
    fn an_integrator_with_delay_has_its_textbook_margins() {
        let gain = 20.0;
        let delay = 0.01;
        let open = |hz: f64| {
            let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
            gain * (-s * delay).exp() / s
        };
        let found = margins(open, 0.1, 300.0).expect("it crosses 0 dB");
        assert!((found.bandwidth_hz - gain / std::f64::consts::TAU).abs() < 1e-9);
        assert!((found.phase_margin_deg - (90.0 - (gain * delay).to_degrees())).abs() < 1e-6);
        assert!((found.gain_margin_hz - 25.0).abs() < 1e-6);
        let expected_db = 20.0 * (std::f64::consts::FRAC_PI_2 / (gain * delay)).log10();
        assert!((found.gain_margin_db - expected_db).abs() < 1e-6);
    }

    #[test]
    fn a_loop_without_gain_has_no_margins() {
        assert_eq!(margins(|_| Complex64::new(0.5, 0.0), 0.1, 100.0), None);
    }
}
