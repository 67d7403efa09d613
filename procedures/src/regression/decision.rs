//! What comes of a comparison: a call for each criterion and one for all of them.

use serde::{Deserialize, Serialize};

use super::{Criterion, Look};

/// What is said of a criterion, or of all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Call {
    /// Every unit gave the same value in both arms, up to 1e-9 of the values.
    Identical,
    /// The interval of the mean shift lies inside the margins.
    Equivalent,
    /// The interval lies below zero and not inside the margins.
    Better,
    /// The interval lies above zero and not inside the margins.
    Worse,
    /// None of these.
    Inconclusive,
}

/// Why a criterion is inconclusive, or why a worse one does not block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Undecided {
    /// Fewer than two units.
    #[error("{units} unit(s) with values of both arms, at least 2 are needed")]
    FewUnits {
        /// Units with values of both arms.
        units: usize,
    },
    /// A value that has no logarithm.
    #[error(
        "unit {unit}: a log-ratio needs values above zero, found {baseline:e} (baseline) and {candidate:e} \
         (candidate), SI; compare this measurand with `scale = \"difference\"`"
    )]
    NotPositive {
        /// Number of the unit.
        unit: u32,
        /// Value of the baseline, SI.
        baseline: f64,
        /// Value of the candidate, SI.
        candidate: f64,
    },
    /// The candidate gives no value where the baseline gives one.
    #[error("the candidate has no value on {units} unit(s) where the baseline has one")]
    CandidateWithout {
        /// Units, with any seed.
        units: usize,
    },
    /// Most units have no value in both arms.
    #[error("only {units} of {of} samples have values of both arms")]
    MostLeftOut {
        /// Samples with values of both arms.
        units: usize,
        /// All samples.
        of: usize,
    },
    /// The interval holds zero and crosses a margin.
    #[error("the interval of the mean shift is too wide")]
    Wide,
    /// The interval lies above zero, but among so many criteria chance explains one that does.
    #[error(
        "worse by itself, but not in the family: adjusted p {adjusted_p:.3}, below {level} is needed to block"
    )]
    NotUpheld {
        /// One-sided p after the adjustment.
        adjusted_p: f64,
        /// Level of the family.
        level: f64,
    },
}

/// One arm of a criterion over all units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Mean of the units, each the mean of its seeds, SI.
    pub mean: f64,
    /// Root mean square of the standard uncertainties of single values, SI.
    pub u: f64,
    /// Units that pass with every seed.
    pub passed: usize,
}

/// The shift of one unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnitShift {
    /// Number of the unit.
    pub unit: u32,
    /// Mean of its seeds: candidate less baseline or logarithm of the ratio, + is worse.
    pub shift: f64,
}

/// A unit that passes with the baseline and does not with the candidate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LostPass {
    /// Number of the unit.
    pub unit: u32,
    /// Seeds with which it happens, ascending.
    pub seeds: Vec<u64>,
}

/// What comes of one criterion.
///
/// Shifts, interval and scatter are in the SI unit of the measurand, or logarithms of a ratio, by the scale of the criterion;
/// + is worse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The criterion.
    pub criterion: Criterion,
    /// The call.
    pub call: Call,
    /// Whether the call stops the candidate: worse, blocking, and upheld in the family.
    pub blocks: bool,
    /// Whether zero lies outside the interval.
    pub differs: bool,
    /// Why the call is inconclusive, or why a worse criterion that may block does not.
    pub why: Option<Undecided>,
    /// Units with values of both arms.
    pub units: usize,
    /// Samples without a value in one arm or both, which were left out.
    pub left_out: usize,
    /// The baseline; `None` without units.
    pub baseline: Option<Arm>,
    /// The candidate; `None` without units.
    pub candidate: Option<Arm>,
    /// Mean shift; `None` where there is none.
    pub shift: Option<f64>,
    /// Interval of the mean shift at the level of the decision; `None` for fewer than two units.
    pub interval: Option<[f64; 2]>,
    /// Standard deviation of the shift from unit to unit; `None` for fewer than two units.
    pub scatter: Option<f64>,
    /// One-sided p of "the mean shift is not above zero"; `None` for fewer than two units.
    pub p: Option<f64>,
    /// The same, adjusted for the family of blocking criteria and for the number of looks; `None` for one that does not block.
    pub adjusted_p: Option<f64>,
    /// How many units more, of this scatter and mean, would make the interval narrow enough to decide; `None` where it is
    /// narrow enough, or where no number of units up to a thousand million would do.
    pub units_needed: Option<u64>,
    /// Shift of each unit, by number of the unit.
    pub shifts: Vec<UnitShift>,
    /// Units that lose a pass, by number of the unit.
    pub lost: Vec<LostPass>,
}

/// What comes of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// When it was looked at.
    pub look: Look,
    /// Two-sided level of all intervals.
    pub level: f64,
    /// Over all: see [`Decision::call_of`].
    pub call: Call,
    /// One for each criterion, in the order of the criteria file.
    pub outcomes: Vec<Outcome>,
}

impl Call {
    /// Exit code of a comparison: 1 worse, 3 inconclusive, otherwise 0.
    pub const fn exit_code(self) -> u8 {
        match self {
            Self::Identical | Self::Equivalent | Self::Better => 0,
            Self::Worse => 1,
            Self::Inconclusive => 3,
        }
    }

    /// Exit code for `git bisect run`: 0 good, 1 bad, 125 for a commit that cannot be told.
    pub const fn bisect_code(self) -> u8 {
        match self {
            Self::Identical | Self::Equivalent | Self::Better => 0,
            Self::Worse => 1,
            Self::Inconclusive => 125,
        }
    }
}

impl Decision {
    /// The call over all: worse where a criterion blocks; inconclusive where a blocking criterion is inconclusive, or is worse by
    /// itself and not in the family; identical where every criterion is, those included that are only reported; better where
    /// a blocking criterion is; otherwise equivalent.
    pub fn call_of(outcomes: &[Outcome]) -> Call {
        let blocking = || outcomes.iter().filter(|outcome| outcome.criterion.blocking);
        if blocking().any(|outcome| outcome.blocks) {
            return Call::Worse;
        }
        if blocking().any(|outcome| matches!(outcome.call, Call::Inconclusive | Call::Worse)) {
            return Call::Inconclusive;
        }
        if outcomes.iter().all(|outcome| outcome.call == Call::Identical) {
            return Call::Identical;
        }
        if blocking().any(|outcome| outcome.call == Call::Better) { Call::Better } else { Call::Equivalent }
    }
}
