//! A response that an analyser computed.

use super::answer::Answer;
use crate::analysis::frf::{C64, Line};
use crate::log::Rows;
use crate::measurement::Evidence;

/// Channels of such a record.
const CHANNELS: [&str; 3] = ["frequency_hz", "response_real", "response_imag"];
/// A coherence that single precision rounds above 1 is still 1.
const ROUNDING: f64 = 1e-6;
/// Impossible lines that are named one by one.
const NAMED: usize = 8;

/// The response in the rows; lines count from `least_coherence` on.
pub(super) fn read(rows: &Rows, least_coherence: f64, averages: Option<u32>) -> Result<Answer, String> {
    let topic = &rows.topic.name;
    let column = |name: &str| rows.column(name).ok_or_else(|| format!("{topic} has no channel {name}"));
    let [hz, re, im] = CHANNELS;
    let (hz, re, im) = (column(hz)?, column(re)?, column(im)?);
    let coherence = rows.column("coherence");
    let mut answer = Answer { least_coherence: Some(least_coherence), ..Answer::default() };
    let (mut impossible, mut standing, mut below) = (Vec::new(), 0, 0);
    let mut last_hz = f64::NEG_INFINITY;
    for k in 0..hz.len() {
        let share = coherence.map(|c| c[k]);
        if ![hz[k], re[k], im[k], share.unwrap_or(0.0)].iter().all(|v| v.is_finite()) {
            return Err(format!("{topic}, row {}: a number that is not finite; leave the row out", k + 1));
        }
        if hz[k] <= last_hz {
            return Err(format!(
                "{topic}, row {}: {} Hz after {last_hz} Hz; frequencies have to ascend",
                k + 1,
                hz[k]
            ));
        }
        last_hz = hz[k];
        match share {
            Some(share) if !(0.0..=1.0 + ROUNDING).contains(&share) => impossible.push((hz[k], share)),
            _ if hz[k] <= 0.0 => standing += 1,
            _ => {
                let line = line(hz[k], C64::new(re[k], im[k]), share.map(|c| c.min(1.0)), averages);
                if share.is_some_and(|c| c >= least_coherence) {
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
    answer.exclude(
        below,
        "lines",
        match coherence {
            Some(_) => format!("coherence below {least_coherence}"),
            None => "no coherence was recorded".to_owned(),
        },
    );
    if averages.is_none() || coherence.is_none() {
        let missing = if coherence.is_none() { "coherence" } else { "number of averages" };
        answer.unknown = Some(format!("uncertainty of the lines not known: the {missing} is not stated"));
    }
    answer.evidence = evidence(rows, coherence.is_some());
    Ok(answer)
}

/// Refuses lines that are no response.
fn varies(answer: &Answer, topic: &str) -> Result<(), String> {
    let values = || answer.lines.iter().chain(&answer.hollow).map(|l| l.value);
    let first = values().next().ok_or_else(|| format!("{topic} has no line of a possible coherence"))?;
    if values().count() < 3 || values().all(|v| v == first) {
        return Err(format!(
            "{topic}: expected a response, found the same value on all lines, or fewer than three lines"
        ));
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
    vec![Evidence { file: String::new(), channels, t0_s, t1_s }]
}
