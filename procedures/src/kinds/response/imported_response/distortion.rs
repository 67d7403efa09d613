//! Distortion at lines that are not excited.

use analysis::estimate::Estimate;
use analysis::frf::C64;
use analysis::periodic::{DetectionLine, LineKind, fast};

/// What the lines that are not excited hold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    /// Odd distortion over the output at excited lines; `None` without such lines or where it is no more than noise.
    pub(super) odd: Option<Estimate>,
    /// Even distortion over the output at excited lines; `None` as for odd.
    pub(super) even: Option<Estimate>,
    /// Noise of the mean at those lines, the same way, odd and even.
    pub(super) noise_ratio: [f64; 2],
    /// rms amplitude of the output's mean over the excited, odd and even lines, nothing taken off.
    pub(super) rms: [f64; 3],
}

/// `lines`: bin, frequency in Hz, whether it is excited; amplitudes are period × line.
pub(super) fn find(lines: &[(usize, f64, bool)], u: &[Vec<C64>], y: &[Vec<C64>]) -> Result<Found, String> {
    let kind = |&(bin, hz, excited): &(usize, f64, bool)| match (excited, bin % 2) {
        (true, _) => (hz, LineKind::Excited),
        (false, 1) => (hz, LineKind::Odd),
        (false, _) => (hz, LineKind::Even),
    };
    let kinds: Vec<(f64, LineKind)> = lines.iter().map(kind).collect();
    let found = fast(&kinds, u, y).map_err(|e| e.to_string())?;
    let rms = [LineKind::Excited, LineKind::Odd, LineKind::Even].map(|kind| rms_of(&kinds, y, kind));
    let linear = rms[0] * rms[0];
    let level_of = |kind| level(&found.lines, kind, linear);
    let noise = |kind: LineKind| {
        let own: Vec<f64> = found.lines.iter().filter(|l| l.kind == kind).map(|l| l.variance).collect();
        if own.is_empty() { 0.0 } else { (own.iter().sum::<f64>() / own.len() as f64 / linear).sqrt() }
    };
    Ok(Found {
        odd: level_of(LineKind::Odd),
        even: level_of(LineKind::Even),
        noise_ratio: [noise(LineKind::Odd), noise(LineKind::Even)],
        rms,
    })
}

fn rms_of(kinds: &[(f64, LineKind)], y: &[Vec<C64>], kind: LineKind) -> f64 {
    let own: Vec<f64> = (0..kinds.len())
        .filter(|&l| kinds[l].1 == kind)
        .map(|l| (y.iter().map(|w| w[l]).sum::<C64>() / y.len() as f64).norm_sqr())
        .collect();
    if own.is_empty() { 0.0 } else { (own.iter().sum::<f64>() / own.len() as f64).sqrt() }
}

/// rms of the levels with the noise taken off. The power |level|² of a line of noise v varies by 2v|level|² − v²
/// (non-central χ² of two), which carries over to the root.
fn level(lines: &[DetectionLine], kind: LineKind, linear: f64) -> Option<Estimate> {
    let own: Vec<&DetectionLine> = lines.iter().filter(|l| l.kind == kind).collect();
    let n = own.len() as f64;
    let power = own.iter().map(|l| l.level.norm_sqr() - l.variance).sum::<f64>() / n;
    let spread = |l: &&DetectionLine| {
        let v = l.variance;
        (2.0 * v * l.level.norm_sqr() - v * v).max(v * v)
    };
    let power_u = own.iter().map(spread).sum::<f64>().sqrt() / n;
    let stands = !own.is_empty() && power > 3.0 * power_u && linear > 0.0;
    stands.then(|| {
        let value = (power / linear).sqrt();
        Estimate { value, u: 0.5 * value * power_u / power, dof: f64::INFINITY, n: own.len() }
    })
}
