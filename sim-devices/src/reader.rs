//! The far end of a reader: an instrument that sends readings as lines of text, whatever its profile says that they look like.
//!
//! It knows of its profile how queries and lines look, never what its driver does with them. What it measures it is given by
//! whoever owns the world.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use drivers::reader::{ReaderProfile, Readings};

/// What it says it is: no maker's instrument.
const IDENTITY: &str = "Simulated,READER-SIM,SIM0004,1.0";
/// From the end of a query to the first byte of its answer.
const REACTION: Duration = Duration::from_millis(1);
/// Longest query; more is thrown away.
const LONGEST_QUERY: usize = 256;
/// Lines that wait to be taken by the host.
const MOST_WAITING_BYTES: usize = 16 << 10;

/// The instrument.
#[derive(Clone, Debug)]
pub struct Reader {
    profile: Arc<ReaderProfile>,
    input: Vec<u8>,
    /// Bytes on their way, and when the newest of them began to leave.
    output: VecDeque<u8>,
    leaves: Duration,
    /// When an instrument that sends by itself sends next.
    due: Duration,
}

impl Reader {
    /// Just powered.
    pub fn new(profile: Arc<ReaderProfile>) -> Self {
        Self {
            profile,
            input: Vec::new(),
            output: VecDeque::new(),
            leaves: Duration::ZERO,
            due: Duration::ZERO,
        }
    }

    /// Bytes from the host; `measure` gives what it measures now.
    pub fn receive(&mut self, now: Duration, bytes: &[u8], mut measure: impl FnMut() -> Readings) {
        for &byte in bytes {
            if byte != self.profile.terminator.last() {
                if self.input.len() < LONGEST_QUERY {
                    self.input.push(byte);
                }
                continue;
            }
            let query = String::from_utf8_lossy(&self.input).trim().to_owned();
            self.input.clear();
            let is =
                |known: &Option<String>| known.as_ref().is_some_and(|own| own.eq_ignore_ascii_case(&query));
            if is(&self.profile.identify) {
                self.send(now + REACTION, IDENTITY);
            } else if is(&self.profile.query) {
                let line = self.profile.line(&measure());
                self.send(now + REACTION, &line);
            }
        }
    }

    /// What has left by now; how much. `measure` gives what it measures now.
    pub fn take(&mut self, now: Duration, into: &mut [u8], mut measure: impl FnMut() -> Readings) -> usize {
        if self.profile.query.is_none() && now >= self.due {
            let period = Duration::from_secs_f64(self.profile.period_s);
            // Lines keep their beat; those of a time that nobody looked at are not made up.
            let passed = now.saturating_sub(self.due).as_secs_f64() / self.profile.period_s;
            self.due += period * (passed as u32).saturating_add(1);
            let line = self.profile.line(&measure());
            self.send(now, &line);
        }
        if now < self.leaves {
            return 0;
        }
        let count = into.len().min(self.output.len());
        into.iter_mut().zip(self.output.drain(..count)).for_each(|(place, byte)| *place = byte);
        count
    }

    fn send(&mut self, at: Duration, line: &str) {
        if self.output.len() < MOST_WAITING_BYTES {
            self.leaves = at;
            self.output.extend(line.bytes().chain(self.profile.terminator.bytes().iter().copied()));
        }
    }
}

#[cfg(test)]
mod tests {
    use drivers::device::DeviceError;
    use drivers::reader::{self, Measured, Pattern, Terminator, ValueScale};
    use drivers::wire::ByteLine;

    use super::*;

    /// A line with the instrument at its far end, which measures 1 mN more each millisecond.
    struct Line(Reader);

    fn force(now: Duration) -> Readings {
        Readings::default().with(Measured::Force, Some(now.as_secs_f64()))
    }

    impl ByteLine for Line {
        fn name(&self) -> &str {
            "line"
        }

        fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
            Ok(self.0.take(now, into, || force(now)))
        }

        fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
            self.0.receive(now, bytes, || force(now));
            Ok(())
        }
    }

    fn profile(query: Option<&str>, terminator: Terminator) -> Arc<ReaderProfile> {
        let scale = ValueScale { scale_si: 1e-3, range_si: [-10.0, 10.0], u_si: 1e-3, decimals: 0 };
        Arc::new(ReaderProfile {
            id: "gauge".to_owned(),
            identify: query.map(|_| "ID?".to_owned()),
            query: query.map(str::to_owned),
            terminator,
            period_s: 0.05,
            timeout_s: 0.1,
            pattern: Pattern::parse("F {force} mN").expect("a pattern"),
            nothing: "----".to_owned(),
            values: [None, None, Some(scale)],
        })
    }

    #[test]
    fn a_driver_reads_what_is_measured_whether_it_asks_or_listens() {
        for (query, terminator) in
            [(Some("READ?"), Terminator::Cr), (Some("READ?"), Terminator::Lf), (None, Terminator::CrLf)]
        {
            let profile = profile(query, terminator);
            let mut line = Line(Reader::new(Arc::clone(&profile)));
            let mut driver = reader::Reader::new("gauge", profile);
            let mut count = 0;
            for ms in 0..2000 {
                let now = Duration::from_millis(ms);
                if !driver.open(&mut line, now).expect("it answers") {
                    continue;
                }
                if driver.poll(&mut line, now).expect("it answers") {
                    let read = driver.readings(now).value(Measured::Force).expect("a reading");
                    assert!((read - now.as_secs_f64()).abs() < 0.0026, "{read} at {now:?}");
                    count += 1;
                }
            }
            assert!((38..=40).contains(&count), "{count} readings in 2 s at 50 ms");
            assert_eq!(driver.identity(), query.map(|_| IDENTITY));
        }
    }
}
