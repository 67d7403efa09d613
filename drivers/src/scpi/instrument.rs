//! What instruments that speak SCPI have in common: they say who they are, then measure what they were prepared for.

use std::time::Duration;

use super::{FormatError, Identity, Progress, Session, Step};
use crate::device::DeviceError;
use crate::wire::ByteLine;

/// An instrument behind its line that takes one measurement at a time. No call waits.
///
/// A driver says how it looks at an identity and what it does with an answer; the dialogue itself is the same for all.
pub trait Instrument {
    /// Which query an answer belongs to.
    type Query: Copy;

    /// Message that ends a measurement.
    const ABORT: &'static str;

    /// The script under way and who the instrument is.
    fn dialogue(&mut self) -> &mut Dialogue<Self::Query>;

    /// Checks that the driver knows the commands of this instrument.
    ///
    /// # Errors
    /// A model whose commands are not those of the driver.
    fn check(&self, identity: &Identity) -> Result<(), DeviceError>;

    /// Forgets an earlier measurement of the same preparation.
    fn forget(&mut self) {}

    /// Takes the answer to a query of a measurement.
    ///
    /// # Errors
    /// An answer that is not valid, or does not belong to the measurement that was asked for.
    fn take(&mut self, query: Self::Query, now: Duration) -> Result<(), DeviceError>;

    /// Asks the instrument who it is; call until it returns the identity.
    ///
    /// # Errors
    /// As [`Session::poll`]; an answer that is no identity; a model whose commands are not those of the driver.
    fn identify(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<Option<Identity>, DeviceError> {
        let Dialogue { session, identity } = self.dialogue();
        if identity.is_none() && !session.is_running() {
            session.start(line, now)?;
        }
        while let Progress::Answered(_) = self.dialogue().session.poll(line, now)? {
            let session = &self.dialogue().session;
            let identity = Identity::parse(session.answer()).map_err(|source| session.unusable(source))?;
            self.check(&identity)?;
            self.dialogue().identity = Some(identity);
        }
        let Dialogue { session, identity } = self.dialogue();
        Ok(if session.is_running() { None } else { identity.clone() })
    }

    /// Begins the measurement that was prepared.
    ///
    /// # Errors
    /// When the line is gone.
    fn start(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        self.forget();
        self.dialogue().session.start(line, now)
    }

    /// Goes on with the measurement; whether it is done.
    ///
    /// # Errors
    /// As [`Session::poll`] and [`Instrument::take`].
    fn poll(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<bool, DeviceError> {
        loop {
            match self.dialogue().session.poll(line, now)? {
                Progress::Waiting => return Ok(false),
                Progress::Done => return Ok(true),
                Progress::Answered(query) => self.take(query, now)?,
            }
        }
    }

    /// Ends the measurement; nothing is waited for.
    ///
    /// # Errors
    /// When the line is gone.
    fn abort(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        self.dialogue().session.abort(line, now, Self::ABORT)
    }
}

/// The script under way with an instrument, and who it is once it has said so.
#[derive(Clone, Debug)]
pub struct Dialogue<T> {
    pub(crate) session: Session<T>,
    pub(crate) identity: Option<Identity>,
}

/// Room for the longest answer that is no measurement.
pub(crate) const LONGEST_TEXT: usize = 512;

impl<T: Copy> Dialogue<T> {
    /// A dialogue whose first script asks the instrument `name` who it is; `asked` marks that query.
    pub(crate) fn new(name: &str, asked: T, timeout_s: f64) -> Self {
        let ask = vec![Step::command("*CLS", timeout_s), Step::query("*IDN?", asked, timeout_s)];
        Self { session: Session::new(name, ask, LONGEST_TEXT, timeout_s), identity: None }
    }

    /// The answer that the script waited for, as an error: it cannot be used.
    pub(crate) fn unusable(&self, source: FormatError) -> DeviceError {
        self.session.unusable(source)
    }
}
