//! Lines of a response with what is known against each of them.

use analysis::frf::{C64, Line};

use crate::measurement::Exclusion;

/// Whether a line counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// It counts.
    Counts,
    /// Its mean does not stand out of its own scatter.
    Noise,
    /// Above 0.4 of the row rate: images of the hold fold back.
    Fast,
    /// Next to a resonance of the support: it belongs to what the mirror stands on.
    Reaction,
}

impl Standing {
    const ALL: [Self; 4] = [Self::Counts, Self::Noise, Self::Fast, Self::Reaction];

    /// Why it does not count.
    fn reason(self) -> Option<&'static str> {
        match self {
            Self::Counts => None,
            Self::Noise => Some("signal below the least ratio to its scatter"),
            Self::Fast => Some("above 0.4 of the row rate"),
            Self::Reaction => Some("next to the resonance of the support"),
        }
    }
}

/// A line, and whether it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judged {
    pub(super) line: Line,
    pub(super) standing: Standing,
}

impl Judged {
    pub(super) fn counts(&self) -> bool {
        self.standing == Standing::Counts
    }
}

const WIDTH: usize = 6;

/// As numbers of a point.
pub(super) fn to_numbers(lines: &[Judged]) -> Vec<f64> {
    let row = |l: &Judged| {
        let standing = Standing::ALL.iter().position(|s| *s == l.standing).unwrap_or(0) as f64;
        let Line { frequency_hz, value, variance, dof, .. } = l.line;
        [frequency_hz, value.re, value.im, variance, dof, standing]
    };
    lines.iter().flat_map(row).collect()
}

/// Back from numbers of a point.
pub(super) fn from_numbers(numbers: &[f64]) -> Vec<Judged> {
    let judged = |&[frequency_hz, re, im, variance, dof, standing]: &[f64; WIDTH]| Judged {
        line: Line { frequency_hz, value: C64::new(re, im), variance, dof, coherence: None },
        standing: Standing::ALL[(standing as usize).min(Standing::ALL.len() - 1)],
    };
    numbers.as_chunks::<WIDTH>().0.iter().map(judged).collect()
}

/// What was left out, by reason.
pub(super) fn exclusions(lines: &[Judged]) -> Vec<Exclusion> {
    let left_out = |standing: &Standing| {
        let count = lines.iter().filter(|l| l.standing == *standing).count();
        let reason = standing.reason().filter(|_| count > 0)?.to_owned();
        Some(Exclusion { count, of: "lines".to_owned(), reason })
    };
    Standing::ALL.iter().filter_map(left_out).collect()
}
