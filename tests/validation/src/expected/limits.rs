//! Quantities of the predictions: their kinds, and their limits where the requirement states it in words or several.

use procedures::quantity::QuantityKind as K;

/// One predicted quantity of one requirement.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Requirement.
    pub requirement: &'static str,
    /// Name in the predictions.
    pub name: &'static str,
    /// Kind.
    pub kind: K,
    /// Limit; `None` where the requirement's own is one.
    pub limit: Option<&'static str>,
}

const fn own(requirement: &'static str, name: &'static str, kind: K) -> Quantity {
    Quantity { requirement, name, kind, limit: None }
}

const fn here(requirement: &'static str, name: &'static str, kind: K, limit: &'static str) -> Quantity {
    Quantity { requirement, name, kind, limit: Some(limit) }
}

/// "None" for an overshoot and for travel past a limit (director.md, POS-OVS): 3σ of the encoder is below 3 µrad.
const NO_OVERSHOOT: &str = "<= 3 urad";
/// Every quantity of every prediction. Limits here repeat the words of the requirements file, or are ours where said.
pub const QUANTITIES: &[Quantity] = &[
    own("MOT-ACC", "acceleration", K::AngularAcceleration),
    own("MOT-VEL", "velocity", K::AngularVelocity),
    own("MOT-RNG-AZ", "travel", K::Angle),
    here("MOT-RNG-EL", "lower-end", K::Angle, "<= -10 deg"),
    here("MOT-RNG-EL", "upper-end", K::Angle, ">= 90 deg"),
    here("MOT-SOFT", "travel-past-limit", K::Angle, NO_OVERSHOOT),
    here("MOT-MASK", "travel-past-limit", K::Angle, NO_OVERSHOOT),
    // A move whose torque saturates overshoots: the reserve of torque stands for "settles".
    here("MOT-CUE", "torque-reserve", K::Torque, ">= 0 N*m"),
    here("MOT-CUE", "overshoot", K::Angle, NO_OVERSHOOT),
    here("MOT-DUTY", "rms-current-az", K::Current, "<= 14.2 A"),
    here("MOT-DUTY", "peak-current-az", K::Current, "<= 42.6 A"),
    here("MOT-DUTY", "rms-current-el", K::Current, "<= 16.8 A"),
    here("MOT-DUTY", "peak-current-el", K::Current, "<= 36.2 A"),
    here("MOT-CUR-AZ", "rms-current-az", K::Current, "<= 14.2 A"),
    here("MOT-CUR-AZ", "peak-current-az", K::Current, "<= 42.6 A"),
    here("MOT-CUR-EL", "rms-current-el", K::Current, "<= 16.8 A"),
    here("MOT-CUR-EL", "peak-current-el", K::Current, "<= 36.2 A"),
    own("THM-SINK", "heat-sink", K::Temperature),
    here("PWR-BUS", "bus-low", K::Voltage, ">= 480 V"),
    here("PWR-BUS", "bus-high", K::Voltage, "<= 620 V"),
    here("PWR-BUS", "supply-rms", K::Current, "<= 30 A"),
    here("PWR-BUS", "supply-peak", K::Current, "<= 60 A"),
    here("PWR-BUS", "shunt-power", K::Power, "<= 6.7 kW"),
    here("PWR-BUS", "time-above-continuous", K::Time, "<= 3 s"),
    own("FRC-AZ", "friction", K::Torque),
    own("FRC-EL", "friction", K::Torque),
    own("UNB-AZ", "unbalance", K::Torque),
    own("UNB-EL", "unbalance", K::Torque),
    own("SPR-AZ", "spring", K::Torque),
    own("SPR-EL", "spring", K::Torque),
    own("HOLD-EL", "hold-margin", K::Torque),
    here("COG-AZ", "cogging-order-az", K::SpatialOrder, "143.5 .. 144.5 1/rev"),
    here("COG-AZ", "cogging-amplitude-az", K::Torque, "<= 12 N*m"),
    here("COG-AZ", "cogging-peak-az", K::Torque, "<= 14 N*m"),
    here("COG-EL", "cogging-order-el", K::SpatialOrder, "107.5 .. 108.5 1/rev"),
    here("COG-EL", "cogging-amplitude-el", K::Torque, "<= 8 N*m"),
    here("COG-EL", "cogging-peak-el", K::Torque, "<= 9.5 N*m"),
    own("POS-ACC", "accuracy", K::Angle),
    own("POS-REP", "repeatability", K::Angle),
    own("POS-TRK", "ramp-error", K::Angle),
    here("POS-OVS", "overshoot", K::Angle, NO_OVERSHOOT),
    here("ENC-RES", "resolution", K::Angle, "< 3 urad"),
    own("ENC-PITCH", "encoder-pitch-error", K::Angle),
    own("GYR-ARW", "angle-random-walk", K::AngleRandomWalk),
    here("STR-MODE-1", "frequency-departure", K::Ratio, "-8 % .. 8 %"),
    here("STR-MODE-1", "first-mode-az", K::Frequency, "34 Hz .. 43 Hz"),
    here("STR-MODE-1", "second-mode-az", K::Frequency, "44 Hz .. 57 Hz"),
    here("STR-MODE-2", "frequency-departure", K::Ratio, "-8 % .. 8 %"),
    here("STR-MODE-3", "frequency-departure", K::Ratio, "-8 % .. 8 %"),
    here("STR-XAX", "coupling-to-10-hz", K::Ratio, "<= 0.3 %"),
    here("STR-XAX", "coupling-above-10-hz", K::Ratio, "<= 3 %"),
    own("CUR-BW", "bandwidth", K::Frequency),
    own("LAT-RT", "round-trip", K::Time),
    own("VEL-BW", "bandwidth", K::Frequency),
    own("VEL-GM", "gain-margin", K::Decibel),
    own("VEL-PM", "phase-margin", K::Angle),
    own("TRK-BW", "bandwidth", K::Frequency),
    own("TRK-RMS-C", "coarse-rms", K::Angle),
    // Report only: its goal is no limit.
    own("TRK-RMS-F", "fine-rms", K::Angle),
    here("FSM-BW", "bandwidth", K::Frequency, ">= 80 Hz"),
    here("FSM-BW", "attenuation-100-hz", K::Decibel, "< 3 dB"),
    own("FSM-STR", "stroke", K::Angle),
    // Ours: the study names frequencies without a tolerance.
    here("FSM-MODE", "frequency-departure", K::Ratio, "-3 % .. 3 %"),
    here("FSM-CH", "channel-level", K::Decibel, "-0.5 dB .. 0.5 dB"),
    here("FSM-CH", "channel-phase", K::Angle, "<= 5 deg"),
    here("OPT-GAIN", "gain-departure", K::Ratio, "-3 % .. 3 %"),
    // The whole field: beyond it the target is lost.
    here("TRK-LOSS", "field-used", K::Ratio, "<= 100 %"),
    own("ENG-DWELL", "dwell", K::Time),
    here("ATM-REJ", "rejection-1-hz", K::Decibel, "<= -15 dB"),
    here("ATM-REJ", "rejection-3-hz", K::Decibel, "<= -6 dB"),
    here("ATM-REJ", "crossing", K::Frequency, ">= 7 Hz"),
    here("ATM-REJ", "amplification", K::Decibel, "<= 6 dB"),
];

/// What is known of a quantity.
pub(super) fn known(requirement: &str, name: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|q| q.requirement == requirement && q.name == name)
}
