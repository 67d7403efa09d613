//! A response with what is known of it, whatever it comes from.

use analysis::frf::{Frf, Line};

use super::distortion::Found;
use super::keys::Find;
use crate::measurement::{Evidence, Exclusion};

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
    pub(super) unknown: Option<String>,
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
    pub(super) answer: Result<Answer, String>,
}

impl Answer {
    /// All lines that are possible, ascending.
    pub(super) fn all(&self) -> Frf {
        let mut all: Vec<Line> = self.lines.iter().chain(&self.hollow).copied().collect();
        all.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        all
    }

    /// Why a line is not certified, if it is not.
    pub(super) fn doubt(&self, frequency_hz: f64) -> Option<String> {
        let is_there = |l: &&Line| (l.frequency_hz - frequency_hz).abs() < 1e-6 * frequency_hz;
        let line = self.hollow.iter().find(is_there)?;
        Some(match (self.least_coherence, line.coherence) {
            (Some(least), Some(found)) => {
                // One that is just too low must not read as if it were enough.
                let digits = if found > least - 0.01 { 4 } else { 2 };
                format!(
                    "not certified: coherence {found:.digits$} at {frequency_hz} Hz, at least {least} is needed"
                )
            }
            (Some(least), None) => {
                format!(
                    "not certified: no coherence was recorded at {frequency_hz} Hz, at least {least} is needed"
                )
            }
            (None, _) => {
                format!("not certified: the line at {frequency_hz} Hz does not stand out of its noise")
            }
        })
    }

    /// Leaves lines out, with their count and why.
    pub(super) fn exclude(&mut self, count: usize, of: &str, reason: String) {
        if count > 0 {
            self.excluded.push(Exclusion { count, of: of.to_owned(), reason });
        }
    }
}
