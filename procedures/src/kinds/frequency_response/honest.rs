//! Which lines say something, and why the others do not.

use crate::analysis::frf::{Frf, Line};
use crate::axis::AxisLimits;
use crate::kinds::excited::Measured;
use crate::measurement::Exclusion;

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// In presliding lines below this are those of the contact, not of the axis (director.md, 4.2), at least.
const PRESLIDING_HZ: f64 = 7.0;
/// The same as a multiple of the frequency at which inertia and bristles resonate.
const PRESLIDING_RATIO: f64 = 5.0;

/// Lines that count, and those that stay visible only.
#[derive(Clone, Debug, Default)]
pub(super) struct Judged {
    pub(super) lines: Frf,
    pub(super) hollow: Frf,
    pub(super) excluded: Vec<Exclusion>,
    /// Highest frequency that presliding spoils; none if the axis slid.
    pub(super) presliding_below_hz: Option<f64>,
}

/// Frequency below which a contact that sticks shows itself instead of the axis.
pub(super) fn presliding_hz(limits: &AxisLimits) -> f64 {
    let resonance = (limits.expected_presliding_stiffness_nm_per_rad / limits.inertia_kg_m2).sqrt();
    (PRESLIDING_RATIO * resonance / std::f64::consts::TAU).max(PRESLIDING_HZ)
}

/// Judges the lines of a response.
pub(super) fn judge(lines: Frf, measured: &Measured, limits: &AxisLimits) -> Judged {
    let corner_hz = presliding_hz(limits);
    let mut judged =
        Judged { presliding_below_hz: (!measured.slides).then_some(corner_hz), ..Judged::default() };
    let (mut sticking, mut noisy) = (0, 0);
    for line in lines {
        if !measured.slides && line.frequency_hz < corner_hz {
            sticking += 1;
            judged.hollow.push(line);
        } else if snr_db(&line) < LEAST_SNR_DB {
            noisy += 1;
            judged.hollow.push(line);
        } else {
            judged.lines.push(line);
        }
    }
    for (count, reason) in [(sticking, presliding(measured, corner_hz)), (noisy, noise())] {
        if count > 0 {
            judged.excluded.push(Exclusion { count, of: "lines".to_owned(), reason });
        }
    }
    judged
}

/// Why presliding lines do not count.
pub(super) fn presliding(measured: &Measured, corner_hz: f64) -> String {
    format!(
        "presliding: excitation below breakaway (mean rate {:.3} rad/s), the contact is a spring below {corner_hz:.1} Hz whatever the coherence",
        measured.mean_rate_rad_per_s
    )
}

fn noise() -> String {
    format!("signal to noise below {LEAST_SNR_DB} dB")
}

/// Signal to noise of a line's mean.
fn snr_db(line: &Line) -> f64 {
    -20.0 * (2.0_f64.sqrt() * line.relative_sd()).log10()
}
