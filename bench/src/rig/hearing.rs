//! How devices are heard that send messages by themselves: silence, and what their lines have lost.

use drivers::device::DeviceError;

/// Frames after which a missing target is no gap any more, and a tracker is silent (safety.md: deadlines).
pub(super) const FRAMES_TO_LOSE: f64 = 3.0;
/// Silences of a device that are told in a point; more say nothing new.
const MOST_SILENCES: u32 = 100;

/// How a device is heard now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hearing {
    /// Time between two of its messages, s.
    pub period_s: f64,
    /// Time since its newest message, s.
    pub silent_s: f64,
    /// The longest such time that is no silence, s.
    pub stale_s: f64,
    /// What its line has lost since it was opened.
    pub losses: Losses,
}

/// What a line has lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Messages that never came, by the gaps in their numbers.
    pub messages_count: u64,
    /// Messages that were not taken: wrong checksum or content, late, or twice.
    pub rejected_count: u64,
    /// Bytes that belong to no message.
    pub skipped_bytes_count: u64,
}

impl Losses {
    fn since(self, before: Self) -> Self {
        Self {
            messages_count: self.messages_count.saturating_sub(before.messages_count),
            rejected_count: self.rejected_count.saturating_sub(before.rejected_count),
            skipped_bytes_count: self.skipped_bytes_count.saturating_sub(before.skipped_bytes_count),
        }
    }
}

/// What is to be told of a device that is listened to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HearingNews {
    /// It is silent.
    Silent {
        /// Time between two of its messages, s.
        period_s: f64,
        /// Time since its newest message, s.
        silent_s: f64,
    },
    /// It was silent and is heard again.
    HeardAgain {
        /// How long it was silent, s.
        silent_s: f64,
    },
    /// What its line has lost in a point.
    Lost(Losses),
}

impl HearingNews {
    /// One line about the device of this name.
    pub fn text(self, device: &str) -> String {
        match self {
            Self::Silent { period_s, silent_s } => silence(device, period_s, silent_s).to_string(),
            Self::HeardAgain { silent_s } => {
                format!("{device}: messages: heard again after {:.2} ms", 1e3 * silent_s)
            }
            Self::Lost(Losses { messages_count, rejected_count, skipped_bytes_count }) => format!(
                "{device}: messages: expected all, found {messages_count} lost, {rejected_count} rejected (checksum, \
                 content, late or twice), {skipped_bytes_count} bytes that belong to none; check cable, shield and bit \
                 rate of the device"
            ),
        }
    }
}

/// A device that is silent, as its error.
pub(super) fn silence(device: &str, period_s: f64, silent_s: f64) -> DeviceError {
    DeviceError::Field {
        device: device.to_owned(),
        field: "messages",
        expected: format!("one every {:.2} ms", 1e3 * period_s),
        found: format!("none for {:.2} ms", 1e3 * silent_s),
        help: "check power, cable and bit rate or address of the device",
    }
}

/// What was told of a device.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Listener {
    before: Losses,
    is_silent: bool,
    /// The longest silence since it began.
    silent_s: f64,
    told_count: u32,
}

impl Listener {
    /// A point begins: what was lost before is none of its losses.
    pub(super) fn begin(&mut self, hearing: &Hearing) {
        (self.before, self.told_count) = (hearing.losses, 0);
    }

    /// Once a tick: what is to be told of silence.
    pub(super) fn tick(&mut self, hearing: &Hearing) -> Option<HearingNews> {
        let Hearing { period_s, silent_s, stale_s, .. } = *hearing;
        let was_silent = std::mem::replace(&mut self.is_silent, silent_s > stale_s);
        let news = match (was_silent, self.is_silent) {
            (false, true) => HearingNews::Silent { period_s, silent_s },
            (true, false) => HearingNews::HeardAgain { silent_s: self.silent_s },
            _ => {
                self.silent_s = silent_s;
                return None;
            }
        };
        self.silent_s = silent_s;
        self.told_count = self.told_count.saturating_add(1);
        (self.told_count <= MOST_SILENCES).then_some(news)
    }

    /// What the line has lost since the point began; `None` if that is nothing.
    pub(super) fn lost(&self, hearing: &Hearing) -> Option<HearingNews> {
        let losses = hearing.losses.since(self.before);
        (losses != Losses::default()).then_some(HearingNews::Lost(losses))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEARD: Hearing = Hearing {
        period_s: 1e-3,
        silent_s: 0.0,
        stale_s: 1e-2,
        losses: Losses { messages_count: 7, rejected_count: 0, skipped_bytes_count: 3 },
    };

    #[test]
    fn a_silence_is_told_when_it_begins_and_when_it_ends() {
        let mut listener = Listener::default();
        listener.begin(&HEARD);
        let at = |listener: &mut Listener, silent_s| listener.tick(&Hearing { silent_s, ..HEARD });
        assert_eq!(at(&mut listener, 0.01), None, "ten periods are no silence");
        let told = at(&mut listener, 0.011).expect("eleven are one").text("imu");
        assert_eq!(
            told,
            "imu: messages: expected one every 1.00 ms, found none for 11.00 ms; check power, cable and bit rate or \
             address of the device"
        );
        assert_eq!(at(&mut listener, 0.3), None, "once is enough");
        let told = at(&mut listener, 0.0).expect("it is over").text("imu");
        assert_eq!(told, "imu: messages: heard again after 300.00 ms");
    }

    #[test]
    fn losses_are_those_since_the_point_began() {
        let mut listener = Listener::default();
        listener.begin(&HEARD);
        assert_eq!(listener.lost(&HEARD), None);
        let losses = Losses { messages_count: 9, rejected_count: 2, skipped_bytes_count: 39 };
        let told = listener.lost(&Hearing { losses, ..HEARD }).expect("two messages").text("imu");
        assert!(told.contains("found 2 lost, 2 rejected") && told.contains("36 bytes"), "{told}");
    }

    #[test]
    fn a_device_that_comes_and_goes_is_told_a_hundred_times_a_point() {
        let mut listener = Listener::default();
        let mut told_count = 0;
        for k in 0..1000 {
            let silent_s = if k % 2 == 0 { 1.0 } else { 0.0 };
            told_count += u32::from(listener.tick(&Hearing { silent_s, ..HEARD }).is_some());
        }
        assert_eq!(told_count, MOST_SILENCES);
        listener.begin(&HEARD);
        assert!(listener.tick(&Hearing { silent_s: 1.0, ..HEARD }).is_some(), "the next point tells anew");
    }
}
