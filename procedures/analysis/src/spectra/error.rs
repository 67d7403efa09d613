//! Why no spectrum or response came out.

use thiserror::Error;

/// What is wrong with records, settings or a question; channels count from 0.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SpectraError {
    /// No channel at all.
    #[error("expected at least one channel, found none")]
    NoChannels,
    /// Sample rate without meaning.
    #[error("expected a sample rate above 0 Hz, found {found} Hz")]
    SampleRate {
        /// As given, Hz.
        found: f64,
    },
    /// Overlap without meaning.
    #[error("expected an overlap of at least 0 and below 1, found {found}")]
    Overlap {
        /// As given.
        found: f64,
    },
    /// Segment too short for a spectrum.
    #[error("expected segments of at least 8 samples, found {found}")]
    Segment {
        /// As given, samples.
        found: usize,
    },
    /// Record shorter than a segment.
    #[error(
        "channel {channel}: expected at least one segment of {expected} samples, found {found}: use a \
         longer record or shorter segments"
    )]
    TooShort {
        /// Channel.
        channel: usize,
        /// Samples of a segment.
        expected: usize,
        /// Samples there are.
        found: usize,
    },
    /// Channels of one record must have one length.
    #[error("channel {channel}: expected {expected} samples as in channel 0, found {found}")]
    UnequalLengths {
        /// Channel.
        channel: usize,
        /// Samples of channel 0.
        expected: usize,
        /// Samples of this channel.
        found: usize,
    },
    /// A value that is no number.
    #[error(
        "channel {channel}: expected finite values, found {found} at sample {index}: leave out that interval"
    )]
    NotFinite {
        /// Channel.
        channel: usize,
        /// First such sample.
        index: usize,
        /// The value that was found.
        found: f64,
    },
    /// Values of which the square is no number.
    #[error(
        "channel {channel}: expected values that can be squared, found a sum beyond 1e308: change the unit"
    )]
    TooLarge {
        /// Channel.
        channel: usize,
    },
    /// A segment that ends after the record.
    #[error(
        "segment {segment}: expected {length} samples from sample {start} on, found a record of {found} samples"
    )]
    SegmentOutside {
        /// Segment, from 0.
        segment: usize,
        /// First sample of the segment.
        start: usize,
        /// Samples of the segment.
        length: usize,
        /// Samples of the record.
        found: usize,
    },
    /// A channel that is not there.
    #[error("expected a channel below {found}, found {channel}")]
    NoSuchChannel {
        /// Asked for.
        channel: usize,
        /// Channels there are.
        found: usize,
    },
    /// A channel without variation has no response.
    #[error("channel {channel}: expected a signal, found the same value throughout every segment")]
    Constant {
        /// Channel.
        channel: usize,
    },
    /// One average has coherence 1 and no uncertainty.
    #[error(
        "expected at least 2 averages, found {segments} segments worth {averages:.2}: use a longer record \
         or shorter segments"
    )]
    TooFewAverages {
        /// Segments.
        segments: usize,
        /// Independent averages that they are worth.
        averages: f64,
    },
    /// A probability without meaning.
    #[error("expected a probability above 0 and below 1, found {found}")]
    Probability {
        /// As given.
        found: f64,
    },
}
