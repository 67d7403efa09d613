//! Why a tracker, or a loop that is closed on one, gives no value.

use analysis::least_squares::FitError;

use super::Reason;

/// Why a tracker, or a loop that is closed on one, gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum OpticsReason {
    #[error("the closed loop has no spectra")]
    NoClosedSpectra,
    #[error("the mirror was not moved by a sine")]
    NoMirrorSine,
    #[error("no line counts")]
    NoLine,
    #[error("the point {what} was not run")]
    NotRun { what: &'static str },
    #[error("{point} has no record")]
    NoRecord { point: String },
    #[error("the open loop has no spectrum")]
    NoOpenSpectrum,
    #[error("the closed loop has no spectrum")]
    NoClosedSpectrum,
    #[error("no power in the band")]
    NoPower,
    #[error("{percent:.0} % of the frames lost: too few are left")]
    FramesLost { percent: f64 },
    #[error("the closed loop has no sine of the mirror before it")]
    NoSineBefore,
    #[error("`{topic}` has no rows")]
    NoMirrorRows { topic: &'static str },
    #[error("the tracker does not see the mirror move: {size:.4} rad per rad, scatter {u:.4}")]
    NotSeen { size: f64, u: f64 },
    #[error(
        "the mirror is at the end of its stroke on {axis} for {percent:.0} % of the time: check the signs \
         of the optical gains"
    )]
    AtStroke { axis: &'static str, percent: f64 },
    #[error("`{topic}`: exposures do not advance at {at_s:.4} s")]
    ExposuresStand { topic: String, at_s: f64 },
    #[error(
        "the tracker saw the target in {found} frames within {within_s:.1} s, at least {least} are needed: \
         check that the target is in its field of view"
    )]
    TooFewSeen { found: usize, within_s: f64, least: usize },
    #[error(
        "the tracker delivers {found_hz:.1} frames/s, expected {asked_hz:.1}: set the camera to that rate"
    )]
    OtherRate { found_hz: f64, asked_hz: f64 },
    #[error("a block of the sine: {0}")]
    BlockOfSine(FitError),
    #[error("nothing was moved")]
    NothingMoved,
    #[error("the point moves no axis of the mirror")]
    NoMirrorAxis,
    #[error("the command was cut off: {found_urad:.1} urad of {asked_urad:.1} urad were sent")]
    CutOff { found_urad: f64, asked_urad: f64 },
    #[error(
        "the tracker does not see the mirror move in this axis: {size:.4} rad per rad of command, scatter {scatter:.4}; {other:.4} in the other axis, expected {expected:.4} in this one"
    )]
    NotSeenInAxis { size: f64, scatter: f64, other: f64, expected: f64 },
    #[error("the sign is not certain: the phase of the reading is {degrees:.0} deg against the command")]
    SignUncertain { degrees: f64 },
    #[error("there is no record")]
    NoTrackRecord,
    #[error("too few frames were left out")]
    LittleLeftOut,
    #[error("target never acquired: check that it was where the procedure says and stood still until it \
             was tracked{}", as_seen(.seen))]
    NeverAcquired { seen: Option<[TargetSeen; 2]> },
    #[error("the point did not complete")]
    NotCompleted,
    #[error("the point was aborted ({})", trips.join("; "))]
    BrokenOff { trips: Vec<String> },
    #[error("{topic} {channel} contains a value that is not a number")]
    NoNumber { topic: String, channel: String },
    #[error("{topic} position_rad contains a value that is not a number")]
    NoAngleNumber { topic: String },
    #[error("{frames} frames of {topic}, at least {least} are needed")]
    TooFewFrames { frames: usize, topic: String, least: usize },
    #[error("frames of {topic} are not consecutive: the tracker may have been restarted")]
    NotConsecutive { topic: String },
    #[error("{unseen:.0} frames of {topic} are not in the log: choose a `log-rate` above the frame rate")]
    FramesInNoRow { unseen: f64, topic: String },
    #[error("no coarse frame shows the target")]
    NoCoarseFrame,
    #[error("{rate_hz:.0} coarse frames per second are too few for accelerations up to {bandwidth_hz} Hz")]
    SlowFrames { rate_hz: f64, bandwidth_hz: f64 },
    #[error("too few coarse frames for the target's acceleration")]
    TooFewCoarse,
    #[error("{topic} has no rows")]
    NoRows { topic: String },
    #[error("no axis of a tracker")]
    NoTrackerAxis,
    #[error("nothing moved")]
    NothingMovedAtAll,
    #[error("{sines} sines are above their scatter, at least five are needed")]
    TooFewSines { sines: usize },
    #[error("`{topic}` has too few rows")]
    TooFewTrackerRows { topic: String },
    #[error("a period of the sines: {0}")]
    PeriodOfSines(FitError),
    #[error("scale of the tracker: {0}")]
    Scale(FitError),
    #[error("{share:.1} % of the record lies in windows, at most {most:.1} % is allowed")]
    InWindows { share: f64, most: f64 },
    #[error("the target neither jumped nor reversed, so the requirement to keep it in sight was not tested")]
    NotChallenged,
}

/// What a tracker saw of a target that was never acquired.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum TargetSeen {
    #[error("{topic} showed it in {shown} of {of} frames")]
    Frames { topic: &'static str, shown: usize, of: usize },
    #[error("{0}")]
    Nothing(Box<Reason>),
}

fn as_seen(seen: &Option<[TargetSeen; 2]>) -> String {
    seen.as_ref().map_or_else(String::new, |[coarse, fine]| format!(" {coarse}; {fine}"))
}
