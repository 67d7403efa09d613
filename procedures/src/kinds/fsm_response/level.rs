//! Where a response crosses a level, and its level at a frequency: by a parabola through the lines around.

use analysis::least_squares::LinearFit;

use super::lines::{Judged, Standing};

/// Lines of a parabola.
const LINES: usize = 11;
/// Fewest of them.
const FEWEST: usize = 7;
/// 20·lg(1/√2).
pub(super) const HALF_POWER_DB: f64 = -3.010_299_956_639_812;

/// A number read from a response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    pub(super) value: f64,
    pub(super) u: f64,
    pub(super) dof: f64,
    pub(super) n: usize,
}

/// Gain in dB around a frequency: a parabola over ln f.
struct Parabola {
    fit: LinearFit,
    centre_hz: f64,
    /// Standard uncertainty of one line by its own scatter, dB.
    line_u_db: f64,
    n: usize,
}

impl Parabola {
    /// Through the lines nearest to a frequency that count.
    fn around(lines: &[Judged], centre_hz: f64) -> Option<Self> {
        let mut near: Vec<&Judged> = lines.iter().filter(|l| l.counts()).collect();
        let distance = |l: &Judged| (l.line.frequency_hz / centre_hz).ln().abs();
        near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        near.truncate(LINES);
        if near.len() < FEWEST {
            return None;
        }
        let x: Vec<f64> = near.iter().map(|l| (l.line.frequency_hz / centre_hz).ln()).collect();
        let gain_db: Vec<f64> = near.iter().map(|l| l.line.gain_db()).collect();
        let columns = [vec![1.0; x.len()], x.clone(), x.iter().map(|x| x * x).collect()];
        let fit = LinearFit::new(&columns, &gain_db, None).ok()?;
        let square = near.iter().map(|l| (decibel(l.line.relative_sd())).powi(2)).sum::<f64>();
        Some(Self { fit, centre_hz, line_u_db: (square / near.len() as f64).sqrt(), n: near.len() })
    }

    fn row(&self, frequency_hz: f64) -> [f64; 3] {
        let x = (frequency_hz / self.centre_hz).ln();
        [1.0, x, x * x]
    }

    fn gain_db(&self, frequency_hz: f64) -> f64 {
        self.fit.at(&self.row(frequency_hz))
    }

    /// What the lines leave of the parabola holds their distortion, which repeats in every period, too; where chance
    /// made them leave little, their own scatter counts.
    fn u_db(&self, frequency_hz: f64) -> f64 {
        let spread = self.fit.residual_variance.sqrt();
        let own = if spread > 0.0 { (self.line_u_db / spread).max(1.0) } else { 1.0 };
        let u = self.fit.u_at(&self.row(frequency_hz)) * own;
        if spread > 0.0 { u } else { self.line_u_db }
    }

    fn slope_db(&self, frequency_hz: f64) -> f64 {
        let [_, x, _] = self.row(frequency_hz);
        self.fit.coefficients[1] + 2.0 * x * self.fit.coefficients[2]
    }

    fn reading(&self, value: f64, u: f64) -> Reading {
        Reading { value, u, dof: self.fit.dof as f64, n: self.n }
    }
}

/// A small relative change in dB.
pub(super) fn decibel(ratio: f64) -> f64 {
    20.0 / std::f64::consts::LN_10 * ratio
}

/// Gain at a frequency, dB; u includes that of the sensor's scale.
pub(super) fn gain_at(lines: &[Judged], frequency_hz: f64, scale_u_ratio: f64) -> Result<Reading, String> {
    let inside = |l: &&Judged| l.counts();
    let (first, last) = (lines.iter().find(inside), lines.iter().rfind(inside));
    let covered =
        |l: &Judged, m: &Judged| l.line.frequency_hz <= frequency_hz && m.line.frequency_hz >= frequency_hz;
    if !first.zip(last).is_some_and(|(l, m)| covered(l, m)) {
        return Err(format!("no lines that count on both sides of {frequency_hz} Hz"));
    }
    let parabola = Parabola::around(lines, frequency_hz)
        .ok_or_else(|| format!("too few lines that count around {frequency_hz} Hz"))?;
    let u = parabola.u_db(frequency_hz).hypot(decibel(scale_u_ratio));
    Ok(parabola.reading(parabola.gain_db(frequency_hz), u))
}

/// Whether noise leaves at least half of the lines up to a frequency.
fn trusted(lines: &[Judged], up_to_hz: f64) -> bool {
    let inside = || lines.iter().filter(|l| l.line.frequency_hz <= up_to_hz);
    2 * inside().filter(|l| l.standing != Standing::Noise).count() >= inside().count()
}

fn oscillates(hz: f64) -> String {
    format!("most lines up to {hz:.0} Hz stay below their scatter: does the mirror oscillate, or not move?")
}

/// First frequency at which the gain falls to −3 dB of the command.
///
/// Bracketed by two neighbouring lines that count, then read from the parabola around them.
pub(super) fn bandwidth_hz(lines: &[Judged], scale_u_ratio: f64) -> Result<Reading, String> {
    let counting: Vec<&Judged> = lines.iter().filter(|l| l.counts()).collect();
    let first = counting.first().ok_or("no line counts")?;
    let below = |l: &Judged| l.line.gain_db() <= HALF_POWER_DB;
    if below(first) {
        // It does not follow at all, and the lowest line is an upper bound; but a few lines that chance lifted out of an
        // oscillation bound nothing.
        return match trusted(lines, first.line.frequency_hz) {
            true => Ok(Reading { value: first.line.frequency_hz, u: 0.0, dof: f64::INFINITY, n: 1 }),
            false => Err(oscillates(first.line.frequency_hz)),
        };
    }
    let pair = counting.windows(2).find(|pair| below(pair[1])).ok_or_else(|| {
        let last_hz = counting.last().map_or(0.0, |l| l.line.frequency_hz);
        format!("the gain does not fall by 3 dB up to {last_hz:.0} Hz")
    })?;
    let [low, high] = [pair[0].line, pair[1].line];
    if !trusted(lines, high.frequency_hz) {
        return Err(oscillates(high.frequency_hz));
    }
    let share = (low.gain_db() - HALF_POWER_DB) / (low.gain_db() - high.gain_db());
    let mut at_hz = low.frequency_hz * (high.frequency_hz / low.frequency_hz).powf(share);
    let parabola = Parabola::around(lines, at_hz)
        .ok_or_else(|| format!("too few lines that count around {at_hz:.0} Hz"))?;
    // Newton on ln f: the parabola is nearly straight between neighbours.
    for _ in 0..4 {
        let slope_db = parabola.slope_db(at_hz);
        if slope_db >= 0.0 {
            return Err(format!("the gain does not fall steadily around {at_hz:.0} Hz"));
        }
        at_hz *= ((HALF_POWER_DB - parabola.gain_db(at_hz)) / slope_db).clamp(-0.2, 0.2).exp();
    }
    let u_db = parabola.u_db(at_hz).hypot(decibel(scale_u_ratio));
    Ok(parabola.reading(at_hz, at_hz * u_db / parabola.slope_db(at_hz).abs()))
}
