//! Instruments of the bench, and until when they may be believed.

/// Until when an instrument may be believed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Calibration {
    /// The instrument is simulated.
    Simulated,
    /// By a certificate.
    Certified {
        /// Number of the certificate.
        certificate: String,
        /// Day, ISO 8601.
        calibrated: String,
        /// Last day on which it holds, ISO 8601.
        due: String,
    },
}

/// An instrument of the bench.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instrument {
    /// E.g. `autocollimator`.
    pub name: String,
    /// Part of the rig file that reads it, e.g. `reference`.
    pub role: String,
    /// Who made it; empty where nobody says.
    pub maker: String,
    /// Model; empty where nobody says.
    pub model: String,
    /// Serial number; empty where nobody says.
    pub serial_number: String,
    /// As the certificate says.
    pub uncertainty: Option<String>,
    /// Until when it may be believed.
    pub calibration: Calibration,
}
