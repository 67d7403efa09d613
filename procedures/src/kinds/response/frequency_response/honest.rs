//! Which lines say something, and why the others do not.

use analysis::frf::{Frf, Line};

use crate::axis::AxisLimits;
use crate::kinds::response::excited::Measured;
use crate::measurement::Exclusion;

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// In presliding lines below this are those of the contact, not of the axis (director.md, 4.2), at least.
const PRESLIDING_HZ: f64 = 7.0;
/// Least frequency in presliding, as a multiple of the frequency at which inertia and bristles resonate.
const PRESLIDING_RATIO: f64 = 5.0;

/// Lines that count, and those that stay visible only.
#[derive(Clone, Debug, Default)]
pub(in crate::kinds) struct Judged {
    pub(in crate::kinds) lines: Frf,
    pub(in crate::kinds) hollow: Frf,
    pub(in crate::kinds) excluded: Vec<Exclusion>,
    /// Highest frequency that presliding spoils; none if the axis slid.
    pub(in crate::kinds) presliding_below_hz: Option<f64>,
}

/// Frequency below which a contact that sticks shows itself instead of the axis.
pub(super) fn presliding_hz(limits: &AxisLimits) -> f64 {
    let resonance = (limits.expected_presliding_stiffness_nm_per_rad / limits.inertia_kg_m2).sqrt();
    (PRESLIDING_RATIO * resonance / std::f64::consts::TAU).max(PRESLIDING_HZ)
}

/// Judges the lines of a response.
pub(super) fn judge(lines: Frf, measured: &Measured, limits: &AxisLimits) -> Judged {
    if measured.slides {
        return judge_noise(lines);
    }
    let corner_hz = presliding_hz(limits);
    let (sticking, others): (Frf, Frf) = lines.into_iter().partition(|l| l.frequency_hz < corner_hz);
    let mut judged = judge_noise(others);
    judged.presliding_below_hz = Some(corner_hz);
    if !sticking.is_empty() {
        let reason = presliding(measured, corner_hz);
        judged.excluded.insert(0, Exclusion { count: sticking.len(), of: "lines".to_owned(), reason });
        judged.hollow.splice(0..0, sticking);
    }
    judged
}

/// Judges lines by their noise alone.
pub(in crate::kinds) fn judge_noise(lines: Frf) -> Judged {
    let (lines, hollow): (Frf, Frf) = lines.into_iter().partition(|l| snr_db(l) >= LEAST_SNR_DB);
    let reason = format!("signal to noise below {LEAST_SNR_DB} dB");
    let noisy = Exclusion { count: hollow.len(), of: "lines".to_owned(), reason };
    let excluded = if hollow.is_empty() { Vec::new() } else { vec![noisy] };
    Judged { lines, hollow, excluded, presliding_below_hz: None }
}

/// Real degrees of freedom of a number that all lines have a part in: harmonic mean, few of them anywhere count.
pub(super) fn freedom(lines: &[Line]) -> f64 {
    2.0 * lines.len() as f64 / lines.iter().map(|l| 1.0 / l.dof.max(0.5)).sum::<f64>()
}

/// Why presliding lines do not count.
pub(super) fn presliding(measured: &Measured, corner_hz: f64) -> String {
    format!(
        "presliding: excitation below breakaway (mean rate {:.3} rad/s), the contact is a spring below {corner_hz:.1} Hz whatever the coherence",
        measured.mean_rate_rad_per_s
    )
}

/// Signal to noise of a line's mean.
fn snr_db(line: &Line) -> f64 {
    -20.0 * (2.0_f64.sqrt() * line.relative_sd()).log10()
}
