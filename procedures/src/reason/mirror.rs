//! Why impedance or response of the mirror gives no value.

use crate::quantity::QuantityKind as Q;

/// Why impedance or response of the mirror gives no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the sentence of each says what it is")]
pub enum MirrorReason {
    #[error("no impedance in the log: check that the rig has an analyser and that its sweep ran")]
    NoImpedance,
    #[error("the sweep broke off: expected {expected} points, found {found}")]
    SweepBrokeOff { expected: u32, found: usize },
    #[error("the sweep spans {}, expected {}: the analyser did not accept its settings",
 span(.found_hz), span(.expected_hz))]
    OtherSpan { found_hz: [f64; 2], expected_hz: [f64; 2] },
    #[error("the sweep does not ascend: {} after {}",
 Q::Frequency.format(*.later_hz), Q::Frequency.format(*.before_hz))]
    NotAscending { later_hz: f64, before_hz: f64 },
    #[error("{found} lines count in both channels, at least {least} are needed for a smooth difference")]
    TooFewForDifference { found: usize, least: usize },
    #[error("{point}: no lines")]
    NoLines { point: String },
    #[error("{common} of {planned} lines up to {} count in both channels, at least {least_percent} % are needed",
 Q::Frequency.format(*.up_to_hz))]
    TooFewCommon { common: usize, planned: usize, up_to_hz: f64, least_percent: f64 },
    #[error("no line between {from_hz:.1} Hz and {} counts in both channels", Q::Frequency.format(*.up_to_hz))]
    NoneNearTop { from_hz: f64, up_to_hz: f64 },
    #[error("no positions in the log")]
    NoPositions,
    #[error("no autocollimator: the gauge alone cannot show its own scale")]
    NoAutocollimator,
    #[error(
        "gauge only: the servo follows its own gauge, so a wrong scale of the gauge does not show; connect \
         the autocollimator, or state `gauge-u` from a certificate"
    )]
    GaugeOnly,
    #[error("positions of one side are missing")]
    OneSided,
    #[error("the point excites no axis of the mirror")]
    NothingExcited,
    #[error("the log has no rows of the mirror, `/fsm`")]
    NoRowsOfMirror,
    #[error("`/fsm` has no channel `{channel}`")]
    NoMirrorChannel { channel: String },
    #[error("segment `{label}` is not in the log")]
    SegmentNotLogged { label: String },
    #[error("a segment without its excitation")]
    NoExcitation,
    #[error("expected {expected} rows of the mirror, found {found}")]
    FewerRows { expected: usize, found: usize },
    #[error("too few rows of the mirror")]
    TooFewRows,
    #[error("rows of the mirror are missing at {at_s:.4} s")]
    RowsMissing { at_s: f64 },
    #[error("the response needs a multisine")]
    NotAMultisine,
    #[error("the sent command does not contain all lines")]
    LinesMissing,
    #[error("saturation: the command was cut off at {low_urad:.0} and {high_urad:.0} urad")]
    Saturation { low_urad: f64, high_urad: f64 },
    #[error("too few rows at a position")]
    TooFewAtPosition,
    #[error("harmonics need a single sine")]
    NotASine,
    #[error("a sine shorter than {periods} periods")]
    ShortSine { periods: usize },
    #[error("no sine in the log")]
    NoSine,
    #[error("a period of {rows:.3} rows, expected a whole number: see the log rate")]
    BrokenPeriod { rows: f64 },
    #[error("the delay of the command is not known well enough: {:.3} ms more or less leave none", 1e3 * .delay_u_s)]
    DelayUnknown { delay_u_s: f64 },
    #[error("none visible: the response is smooth in the band of the support")]
    NoResonance,
    #[error("no lines that count on both sides of {frequency_hz} Hz")]
    NoneOnBothSides { frequency_hz: f64 },
    #[error("too few lines that count around {frequency_hz} Hz")]
    TooFewAround { frequency_hz: f64 },
    #[error("too few lines that count around {at_hz:.0} Hz")]
    TooFewAroundDrop { at_hz: f64 },
    #[error(
        "most lines up to {up_to_hz:.0} Hz are below their scatter: the mirror oscillates or does not move"
    )]
    Oscillates { up_to_hz: f64 },
    #[error("no line counts")]
    NoLineCounts,
    #[error("the gain does not fall by 3 dB up to {last_hz:.0} Hz")]
    NoDrop { last_hz: f64 },
    #[error("the gain does not fall steadily around {at_hz:.0} Hz")]
    NotFalling { at_hz: f64 },
}

fn span([low_hz, high_hz]: &[f64; 2]) -> String {
    format!("{} .. {}", Q::Frequency.format(*low_hz), Q::Frequency.format(*high_hz))
}
