//! Why there is no response.

/// Why there is no response.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PeriodicError {
    /// A channel does not move.
    #[error(
        "channel `{channel}`: expected a signal, found the same value throughout samples {from}…{to}: is it connected?"
    )]
    Constant {
        /// Name of the channel.
        channel: String,
        /// First sample.
        from: usize,
        /// Last sample.
        to: usize,
    },
    /// A sample is NaN or infinite.
    #[error("channel `{channel}`, sample {sample}: expected a finite number; leave out that interval")]
    NotFinite {
        /// Name of the channel.
        channel: String,
        /// Index of the sample.
        sample: usize,
    },
    /// Not enough samples for the unknowns.
    #[error("expected more than {expected} {what}, found {found}: use a longer record or request less")]
    TooShort {
        /// What there is too little of.
        what: &'static str,
        /// At least one more than this.
        expected: usize,
        /// Found.
        found: usize,
    },
    /// A channel or column differs in length from the rest.
    #[error("`{channel}`: expected {expected} values, found {found}")]
    Length {
        /// Name of channel or column.
        channel: String,
        /// Expected.
        expected: usize,
        /// Found.
        found: usize,
    },
    /// Numbers of which the square leaves the range of a double.
    #[error("{what}: expected numbers whose square lies below 1e308, found larger: change the unit")]
    TooLarge {
        /// What is too large.
        what: &'static str,
    },
    /// Lines do not ascend.
    #[error(
        "line {line} is at {frequency_hz} Hz: expected finite frequencies that ascend from 0, none twice"
    )]
    NotAscending {
        /// Index of the line.
        line: usize,
        /// Frequency of the line, Hz.
        frequency_hz: f64,
    },
    /// The plant does not answer.
    #[error("expected an output at the excited lines, found none: is the channel connected?")]
    Silent,
    /// Nothing is excited at a line.
    #[error(
        "reference at {frequency_hz} Hz: expected an amplitude above {expected}, found {found}: not a line of the excitation"
    )]
    MissingReference {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Smallest amplitude that counts.
        expected: f64,
        /// Amplitude found.
        found: f64,
    },
    /// The window is no whole number of samples.
    #[error(
        "expected a window of a whole number of samples, found {window_s} s · {sample_rate_hz} Hz = {samples}: change the window"
    )]
    NonIntegerWindow {
        /// Window, s.
        window_s: f64,
        /// Sample rate, Hz.
        sample_rate_hz: f64,
        /// Product of both: samples in a window.
        samples: f64,
    },
    /// Lines are no whole number of 1/T_w apart.
    #[error(
        "line {frequency_hz} Hz: expected (whole number + {offset})/T_w, found {turns} periods in a window of {samples} samples"
    )]
    NotOnGrid {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Offset of the first line, 0…1.
        offset: f64,
        /// Periods of the line in the window.
        turns: f64,
        /// Length of the window.
        samples: usize,
    },
    /// A line above 0.4 of the sample rate.
    #[error("expected lines up to {limit_hz} Hz (0.4 of the sample rate), found {frequency_hz} Hz")]
    TooFast {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Limit, Hz.
        limit_hz: f64,
    },
    /// Too few windows, periods or realisations for a variance.
    #[error("expected at least {expected} {what}, found {found}: without them there is no variance")]
    TooFew {
        /// Windows, realisations, …
        what: &'static str,
        /// Least number.
        expected: usize,
        /// Found.
        found: usize,
    },
    /// A nuisance column is a combination of lines, offset, slope and the columns before it.
    #[error(
        "nuisance column {column} is not independent of the lines, offset, slope and the columns before \
         it: leave it out"
    )]
    Dependent {
        /// Index of the column; those of offset and slope come first if they are at fault.
        column: usize,
    },
    /// A quantity that must be positive and finite (or a line frequency).
    #[error("{what}: expected a finite number above 0, found {found}")]
    NotPositive {
        /// Name of the quantity with its unit.
        what: &'static str,
        /// Found.
        found: f64,
    },
    /// A hold or delay is not finite.
    #[error("expected a hold and delays that are finite, found a sum of {found} s")]
    Timing {
        /// Sum of both, s.
        found: f64,
    },
    /// The hold lets nothing pass at a frequency.
    #[error("{frequency_hz} Hz: a hold of {hold_s} s passes no signal there: leave out the line")]
    HoldZero {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Hold, s.
        hold_s: f64,
    },
}

/// Refuses what is not positive and finite.
pub(super) fn positive(what: &'static str, found: f64) -> Result<(), PeriodicError> {
    if found > 0.0 && found.is_finite() { Ok(()) } else { Err(PeriodicError::NotPositive { what, found }) }
}

/// Refuses frequencies that are not finite, below 0, or not above the one before.
pub(super) fn ascending(frequencies_hz: impl Iterator<Item = f64>) -> Result<(), PeriodicError> {
    let mut last_hz = None;
    for (line, frequency_hz) in frequencies_hz.enumerate() {
        let follows = last_hz.is_none_or(|last| frequency_hz > last);
        if !(frequency_hz.is_finite() && frequency_hz >= 0.0 && follows) {
            return Err(PeriodicError::NotAscending { line, frequency_hz });
        }
        last_hz = Some(frequency_hz);
    }
    Ok(())
}

/// Refuses what overflowed.
pub(super) fn within_range(what: &'static str, found: f64) -> Result<(), PeriodicError> {
    if found.is_finite() { Ok(()) } else { Err(PeriodicError::TooLarge { what }) }
}

/// Refuses windows of a channel with holes or without a signal; `from` is the window's place in the record.
pub(super) fn alive(channel: &str, samples: &[f64], from: usize) -> Result<(), PeriodicError> {
    if let Some(i) = samples.iter().position(|v| !v.is_finite()) {
        return Err(PeriodicError::NotFinite { channel: channel.to_owned(), sample: from + i });
    }
    let first = samples.first().map_or(0, |v| v.to_bits());
    if samples.iter().all(|v| v.to_bits() == first) {
        let to = (from + samples.len()).saturating_sub(1);
        return Err(PeriodicError::Constant { channel: channel.to_owned(), from, to });
    }
    Ok(())
}
