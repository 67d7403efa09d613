//! A response with what is known of it, by an analyser that computed it or otherwise.

use analysis::frf::{C64, Frf, Line};

use super::Find;
use super::periodic::Found;
use crate::log::Rows;
use crate::measurement::{Evidence, Exclusion};
use crate::reason::{Reason, ResponseReason};

/// A response, judged line by line.
#[derive(Clone, Debug, Default)]
pub(super) struct Answer {
    /// Lines that count.
    pub(super) lines: Frf,
    /// Lines that stay visible only.
    pub(super) hollow: Frf,
    pub(super) excluded: Vec<Exclusion>,
    pub(super) flags: Vec<String>,
    /// Why variances are not known, if they are not.
    pub(super) unknown: Option<ResponseReason>,
    /// Coherence that a line needs, where it is judged by that.
    pub(super) least_coherence: Option<f64>,
    pub(super) distortion: Option<Found>,
    pub(super) evidence: Vec<Evidence>,
}

/// A response to measure: its name, number and what is looked for.
#[derive(Clone, Debug)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) number: usize,
    pub(super) find: Find,
    pub(super) answer: Result<Answer, Reason>,
}

impl Answer {
    /// All lines that are possible, ascending.
    pub(super) fn all(&self) -> Frf {
        let mut all: Vec<Line> = self.lines.iter().chain(&self.hollow).copied().collect();
        all.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        all
    }

    /// Why a line is not certified, if it is not.
    pub(super) fn doubt(&self, frequency_hz: f64) -> Option<ResponseReason> {
        let is_there = |l: &&Line| (l.frequency_hz - frequency_hz).abs() < 1e-6 * frequency_hz;
        let line = self.hollow.iter().find(is_there)?;
        Some(match (self.least_coherence, line.coherence) {
            (Some(least), Some(found)) => {
                // One that is just too low must not read as if it were enough.
                let digits = if found > least - 0.01 { 4 } else { 2 };
                ResponseReason::LowCoherence { found, digits, frequency_hz, least }
            }
            (Some(least), None) => ResponseReason::NoCoherence { frequency_hz, least },
            (None, _) => ResponseReason::InNoise { frequency_hz },
        })
    }

    /// Leaves lines out, with their count and why.
    pub(super) fn exclude(&mut self, count: usize, of: &str, reason: String) {
        if count > 0 {
            self.excluded.push(Exclusion { count, of: of.to_owned(), reason });
        }
    }
}

/// Channels of such a record.
const CHANNELS: [&str; 3] = ["frequency_hz", "response_real", "response_imag"];
/// A coherence that single precision rounds above 1 is still 1.
const ROUNDING: f64 = 1e-6;
/// Impossible lines that are named one by one.
const NAMED: usize = 8;
/// Share of lines of mere noise that may pass for coherent.
const BY_CHANCE: f64 = 1e-3;

/// What a line's coherence must be.
#[derive(Clone, Copy, Debug)]
struct Gate {
    least: f64,
    averages: Option<f64>,
}

impl Gate {
    /// Where the number of averages is stated, no less than noise reaches by chance: P(γ̂² > c) = (1 − c)^(n − 1) (Carter,
    /// Knapp & Nuttall, *IEEE Trans. Audio Electroacoust.* 21, 337, 1973), rounded up to three digits.
    fn new(least: f64, averages: Option<u32>) -> Self {
        let gate = Self { least, averages: averages.map(f64::from) };
        let Some(n) = gate.averages else { return gate };
        let chance = gate.corrected(1.0 - BY_CHANCE.powf((n - 1.0).recip()));
        Self { least: least.max((1e3 * chance).ceil() / 1e3), ..gate }
    }

    /// Coherence freed of its bias, γ̂² − (1 − γ̂²)²/n (the same source), as far as that is known.
    fn corrected(&self, raw: f64) -> f64 {
        self.averages.map_or(raw, |n| (raw - (1.0 - raw).powi(2) / n).max(0.0))
    }

    fn reason(&self) -> String {
        let of = self.averages.map_or(String::new(), |n| format!(", bias-corrected for {n} averages,"));
        format!("coherence{of} below {}", self.least)
    }
}

/// The response in the rows; lines count from `least_coherence` on.
pub(super) fn read(rows: &Rows, least_coherence: f64, averages: Option<u32>) -> Result<Answer, Reason> {
    let topic = &rows.topic.name;
    let [hz, re, im] = CHANNELS;
    let hz = rows.channel(hz)?;
    let re = rows.channel(re)?;
    let im = rows.channel(im)?;
    let coherence = rows.column("coherence");
    let gate = Gate::new(least_coherence, averages);
    let mut answer = Answer { least_coherence: Some(gate.least), ..Answer::default() };
    let mut impossible = Vec::new();
    let mut standing = 0;
    let mut below = 0;
    let mut last_hz = f64::NEG_INFINITY;
    for k in 0..hz.len() {
        let share = coherence.map(|c| c[k]);
        if ![hz[k], re[k], im[k], share.unwrap_or(0.0)].iter().all(|v| v.is_finite()) {
            return Err(ResponseReason::NotFinite { topic: topic.clone(), row: k + 1 }.into());
        }
        if hz[k] <= last_hz {
            return Err(ResponseReason::NotAscending {
                topic: topic.clone(),
                row: k + 1,
                found_hz: hz[k],
                last_hz,
            }
            .into());
        }
        last_hz = hz[k];
        match share {
            Some(share) if !(0.0..=1.0 + ROUNDING).contains(&share) => impossible.push((hz[k], share)),
            _ if hz[k] <= 0.0 => standing += 1,
            _ => {
                let raw = share.map(|c| c.min(1.0));
                let line = Line {
                    coherence: raw.map(|c| gate.corrected(c)),
                    ..line(hz[k], C64::new(re[k], im[k]), raw, averages)
                };
                if line.coherence.is_some_and(|c| c >= gate.least) {
                    answer.lines.push(line);
                } else {
                    below += 1;
                    answer.hollow.push(line);
                }
            }
        }
    }
    varies(&answer, topic)?;
    answer.exclude(impossible.len(), "lines", above_one(&impossible));
    answer.exclude(standing, "lines", "0 Hz has no phase".to_owned());
    let no_coherence = || "no coherence was recorded".to_owned();
    answer.exclude(below, "lines", coherence.map_or_else(no_coherence, |_| gate.reason()));
    if averages.is_none() || coherence.is_none() {
        let missing = if coherence.is_none() { "coherence" } else { "number of averages" };
        answer.unknown = Some(ResponseReason::NotStated { missing });
    }
    answer.evidence = evidence(rows, coherence.is_some());
    Ok(answer)
}

/// Refuses lines that are no response.
fn varies(answer: &Answer, topic: &str) -> Result<(), Reason> {
    let values = || answer.lines.iter().chain(&answer.hollow).map(|l| l.value);
    let first = values().next().ok_or_else(|| ResponseReason::NoPossibleLine { topic: topic.to_owned() })?;
    if values().count() < 3 || values().all(|v| v == first) {
        return Err(ResponseReason::NotAResponse { topic: topic.to_owned() }.into());
    }
    Ok(())
}

/// Var G = |G|²(1 − γ²)/(γ²·n) (Bendat & Piersol, 4th ed., eq. 9.52: real and imaginary part together); 0 on all
/// lines where it is not known.
fn line(frequency_hz: f64, value: C64, coherence: Option<f64>, averages: Option<u32>) -> Line {
    let (variance, dof) = match (coherence, averages) {
        (Some(share), Some(n)) => {
            let share = share.max(f64::EPSILON);
            // A coherence that is printed as 1 still has the doubt of its last digit.
            let rest = (1.0 - share).max(ROUNDING);
            (value.norm_sqr().max(f64::MIN_POSITIVE) * rest / (share * f64::from(n)), f64::from(n) - 1.0)
        }
        _ => (0.0, 0.0),
    };
    Line { frequency_hz, value, variance, dof, coherence }
}

fn above_one(lines: &[(f64, f64)]) -> String {
    let named: Vec<String> =
        lines.iter().take(NAMED).map(|(hz, share)| format!("{hz} Hz ({share:.3})")).collect();
    let rest = if lines.len() > NAMED { ", …" } else { "" };
    format!("coherence outside 0 … 1, which is impossible: {}{rest}", named.join(", "))
}

fn evidence(rows: &Rows, coherence: bool) -> Vec<Evidence> {
    let (Some(&t0_s), Some(&t1_s)) = (rows.time_s.first(), rows.time_s.last()) else { return Vec::new() };
    let names = CHANNELS.iter().copied().chain(coherence.then_some("coherence"));
    let channels = names.map(|name| format!("{} {name}", rows.topic.name)).collect();
    vec![Evidence::new(channels, [t0_s, t1_s])]
}
