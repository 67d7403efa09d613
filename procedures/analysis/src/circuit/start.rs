//! First values of the circuit.

use std::f64::consts::TAU;

use super::super::frf::{C64, Line};
use super::model::{Motion, Values};

/// Damping ratios that are tried at every line.
const DAMPINGS: [f64; 4] = [0.003, 0.01, 0.03, 0.1];

/// Capacitance alone: median of −1/(ω·X), no loss.
pub(super) fn dielectric(lines: &[Line], reference_hz: f64) -> Option<Values> {
    let mut all: Vec<f64> = lines.iter().map(|l| -1.0 / (TAU * l.frequency_hz * l.value.im)).collect();
    all.sort_by(f64::total_cmp);
    let capacitance_f = all[all.len() / 2];
    (capacitance_f > 0.0 && capacitance_f.is_finite()).then_some(Values {
        capacitance_f,
        series_ohm: 0.0,
        loss_exponent: 0.0,
        resonance: None,
        reference_hz,
    })
}

/// Of resonances at every line and several dampings that with the least residual in the admittance, where C_0 and C_1
/// are linear.
pub(super) fn resonance(lines: &[Line], roots: &[f64], plain: &Values) -> Option<Values> {
    let admittances: Vec<(C64, f64)> = lines
        .iter()
        .zip(roots)
        .map(|(l, root)| {
            let inner = l.value - plain.series_ohm;
            (inner.inv(), root * inner.norm_sqr())
        })
        .collect();
    let mut best: Option<(f64, Values)> = None;
    for line in &lines[1..lines.len() - 1] {
        for damping in DAMPINGS {
            let unit = Motion { motional_f: 1.0, series_hz: line.frequency_hz, damping };
            let Some((cost, [clamped_f, motional_f])) = linear(lines, &admittances, &unit) else { continue };
            let passive = clamped_f > 0.0 && motional_f > 0.0;
            if passive && best.as_ref().is_none_or(|(least, _)| cost < *least) {
                let resonance = Some(Motion { motional_f, ..unit });
                let values = Values { capacitance_f: clamped_f, resonance, ..plain.clone() };
                best = Some((cost, values));
            }
        }
    }
    best.map(|(_, values)| values)
}

/// C_0 (without loss) and C_1 of a resonance with `unit` shape, with the residual.
fn linear(lines: &[Line], admittances: &[(C64, f64)], unit: &Motion) -> Option<(f64, [f64; 2])> {
    let mut aa = 0.0;
    let mut ab = 0.0;
    let mut bb = 0.0;
    let mut ay = 0.0;
    let mut by = 0.0;
    let mut yy = 0.0;
    for (line, (y, root)) in lines.iter().zip(admittances) {
        let a = C64::new(0.0, TAU * line.frequency_hz) * *root;
        let b = unit.admittance(line.frequency_hz) * *root;
        let y = y * *root;
        aa += a.norm_sqr();
        bb += b.norm_sqr();
        yy += y.norm_sqr();
        ab += (a.conj() * b).re;
        ay += (a.conj() * y).re;
        by += (b.conj() * y).re;
    }
    let determinant = aa * bb - ab * ab;
    if !(determinant.is_finite() && determinant > 1e-12 * aa * bb) {
        return None;
    }
    let x = (ay * bb - by * ab) / determinant;
    let z = (by * aa - ay * ab) / determinant;
    Some((yy - x * ay - z * by, [x, z]))
}
