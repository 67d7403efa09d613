//! Why a response, its modes or a latency gives no value.

use super::Reason;
use crate::measurement::Exclusion;
use crate::quantity::QuantityKind as Q;

/// Why a response, its modes or a latency gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum ResponseReason {
    #[error("the plan of the point has no level")]
    NoLevel,
    #[error("{0}")]
    Refused(String),
    #[error("measured at an elevation of {}, requested {}", Q::Angle.format(*.reached_rad), Q::Angle.format(*.asked_rad))]
    Elsewhere { reached_rad: f64, asked_rad: f64 },
    #[error(
        "target never acquired: check that it was where the procedure says and moved only once it was tracked"
    )]
    NeverAcquired,
    #[error("the record contains fewer than two windows of its plan")]
    TooFewWindows,
    #[error("fewer than two windows are left: {}", listed(.excluded))]
    FewWindowsLeft { excluded: Vec<Exclusion> },
    #[error("no response from {from} to {to}: one of them is not in the log, or stands still")]
    NoChannels { from: String, to: String },
    #[error("no point of the elevation contains a response")]
    NoResponseAtElevation,
    #[error("no line of the band was excited enough")]
    NotExcitedEnough,
    #[error("no line below {up_to_hz} Hz counts")]
    NoLineBelow { up_to_hz: f64 },
    #[error(
        "presliding: excitation below breakaway (mean rate {mean_rad_per_s:.3} rad/s), the contact acts as \
         a spring below {corner_hz:.1} Hz, whatever the coherence"
    )]
    Presliding { mean_rad_per_s: f64, corner_hz: f64 },
    #[error("loop rate {rate_hz} Hz: a bandwidth around 1 kHz needs samples at {least_hz} Hz")]
    SlowLoop { rate_hz: f64, least_hz: f64 },
    #[error(
        "no lag of first or second order describes the loop: chi2/dof {first:.1} and {second:.1}, expected about 1"
    )]
    NoLag { first: f64, second: f64 },
    #[error(
        "no two realisations with different phases have lines in common: use four or more realisations, \
         with random phases"
    )]
    NoSharedLines,
    #[error("no line to compare")]
    NothingToCompare,
    #[error("fewer than five lines count in both")]
    FewInBoth,
    #[error("{lines} lines up to {up_to_hz} Hz count, 3 are needed")]
    FewStiffLines { lines: usize, up_to_hz: f64 },
    #[error("not certified: coherence {found:.digits$} at {frequency_hz} Hz, at least {least} is needed")]
    LowCoherence { found: f64, digits: usize, frequency_hz: f64, least: f64 },
    #[error("not certified: no coherence was recorded at {frequency_hz} Hz, at least {least} is needed")]
    NoCoherence { frequency_hz: f64, least: f64 },
    #[error("not certified: the line at {frequency_hz} Hz is not above its noise")]
    InNoise { frequency_hz: f64 },
    #[error("{topic}, row {row}: a number that is not finite; leave out the row")]
    NotFinite { topic: String, row: usize },
    #[error("{topic}, row {row}: {found_hz} Hz after {last_hz} Hz; frequencies must ascend")]
    NotAscending { topic: String, row: usize, found_hz: f64, last_hz: f64 },
    #[error("uncertainty of the lines not known: the {missing} is not stated")]
    NotStated { missing: &'static str },
    #[error("{topic} has no line with a possible coherence")]
    NoPossibleLine { topic: String },
    #[error("{topic}: expected a response, found the same value on all lines, or fewer than three lines")]
    NotAResponse { topic: String },
    #[error("the log has no segment")]
    NoSegment,
    #[error("no line counts")]
    NoLine,
    #[error("no extreme inside the band with a prominence of {} of the largest", Q::Ratio.format(*.least_ratio))]
    NoExtreme { least_ratio: f64 },
    #[error("damping not resolved: {reason}")]
    DampingOfNoMode { reason: Box<Reason> },
    #[error("no line at {hz} Hz")]
    NoLineAt { hz: f64 },
    #[error("not above the noise of {}, or no line without excitation is available", Q::Ratio.format(*.noise))]
    InDistortionNoise { noise: f64 },
    #[error("no mode fits within {lines} lines of {at_hz} Hz")]
    NoMode { lines: f64, at_hz: f64 },
    #[error("damping not resolved: {ratio:.5} with a standard uncertainty of {u:.5}")]
    DampingUnresolved { ratio: f64, u: f64 },
    #[error("{rows} rows: expected a record")]
    NoImportedRecord { rows: usize },
    #[error(
        "row {row}: rows are not evenly spaced in time, expected one every {step_s} s; a periodic record needs a constant rate"
    )]
    Uneven { row: usize, step_s: f64 },
    #[error(
        "record too short: expected at least {least} periods of {length} samples after {dropped} dropped, found {samples} samples"
    )]
    ShortRecord { least: usize, length: usize, dropped: usize, samples: usize },
    #[error("{topic} has no channel {channel}; it has {}", known.join(", "))]
    NoChannelOf { topic: String, channel: String, known: Vec<String> },
    #[error("`{output}` does not follow `{input}`: no line is above its noise")]
    NotFollowing { output: String, input: String },
    #[error(
        "`{what}` is {hz} Hz: expected a whole multiple of 1/period = {step_hz} Hz, found {bin} times that"
    )]
    OffGrid { what: &'static str, hz: f64, step_hz: f64, bin: f64 },
    #[error(
        "input `{input}` at {frequency_hz} Hz: expected an amplitude above {expected:.3e}, found {found:.3e}; not a line of the excitation"
    )]
    WeakInput { input: String, frequency_hz: f64, expected: f64, found: f64 },
    #[error("channel `{channel}`, sample {sample}: expected a finite number")]
    SampleNotFinite { channel: String, sample: usize },
    #[error(
        "reference `{reference}`: {percent:.0} % of its samples differ from period to period, expected a command that repeats; check `period`"
    )]
    NotRepeating { reference: String, percent: f64 },
    #[error("the round trip was found at {levels} levels, at least 2 are needed")]
    FewLevels { levels: usize },
    #[error("no round trip")]
    NoRoundTrip,
    #[error("the corner of the current loop was not found at the loop rate")]
    NoCorner,
    #[error(
        "the delay jitters by {:.0} us from step to step (rms), so the averaged response does not show the \
         corner of the current loop; check bus and drive",
        1e6 * jitter_s
    )]
    DelayJitters { jitter_s: f64 },
    #[error("no response to slow commands was found")]
    NoSlowResponse,
    #[error("the round trip was not found")]
    RoundTripNotFound,
    #[error("the outward delay was not found: no record of a current probe")]
    NoWayOut,
    #[error("the excitation did not begin")]
    NotBegun,
    #[error("the record holds {windows} whole windows{}, at least 2 are needed", and_left_out(*.limited))]
    FewWholeWindows { windows: usize, limited: usize },
    #[error("loop rate {rate_hz} Hz: lag and transport can be separated only from {least_hz} Hz")]
    SlowForLag { rate_hz: f64, least_hz: f64 },
    #[error("the log has no rows of {topic}: no oscilloscope was read")]
    NoOscilloscope { topic: &'static str },
    #[error("none of {records} records shows an edge of sync_v and a step of current_a")]
    NoEdges { records: usize },
    #[error("saturation: torque at its limit, or an internal limit of the drive active")]
    Limited,
    #[error("there is no step in the record")]
    NoStep,
    #[error("no time constant")]
    NoTimeConstant,
    #[error("{shown} of {steps} steps are visible in the current, at least {least} are needed{}", left_out(*.limited))]
    FewSteps { shown: usize, steps: usize, least: usize, limited: usize },
    #[error("a single step has no scatter")]
    SingleStep,
    #[error("the log has no rows of {topic}: no analog loop-back was read")]
    NoLoopBack { topic: &'static str },
    #[error("{topic} is not logged at the loop rate: a gap after row {row} of the point")]
    Gap { topic: &'static str, row: usize },
    #[error(
        "presliding: the axis did not slide all the time (mean rate {mean_rad_per_s:.3} rad/s), the contact adds a spring to the structure"
    )]
    Sticking { mean_rad_per_s: f64 },
    #[error(
        "the {sensor} has {lines} lines with a signal to noise above {least_db} dB: expected at least {least}; raise `level` or `duration`"
    )]
    FewLines { sensor: &'static str, lines: usize, least_db: f64, least: usize },
    #[error("the log does not say at which elevation it was taken")]
    NoElevation,
    #[error("mode {mode} not visible: none found near {} whose residue exceeds 4 u", place(.range_hz))]
    NotVisible { mode: usize, range_hz: [f64; 2] },
    #[error(
        "the mode at {found_hz:.2} Hz may be mode {mode} or mode {other}: only one of the two is visible"
    )]
    OneOfTwo { found_hz: f64, mode: usize, other: usize },
}

fn listed(excluded: &[Exclusion]) -> String {
    let each: Vec<String> = excluded.iter().map(|e| format!("{} {}: {}", e.count, e.of, e.reason)).collect();
    each.join("; ")
}

fn and_left_out(limited: usize) -> String {
    match limited {
        0 => String::new(),
        n => format!(", and {n} that are left out ({})", ResponseReason::Limited),
    }
}

fn left_out(limited: usize) -> String {
    if limited == 0 { String::new() } else { format!("; {limited} left out, {}", ResponseReason::Limited) }
}

fn place([low_hz, high_hz]: &[f64; 2]) -> String {
    if low_hz == high_hz { format!("{low_hz:.1} Hz") } else { format!("{low_hz} Hz .. {high_hz} Hz") }
}
