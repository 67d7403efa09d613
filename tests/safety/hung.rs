//! Threads that panic or hang: the rig is safe, the log readable as far as it goes.

use std::io::{Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::time::Duration;

use bench::cycle::recorder::{Log, LogHead, Recorder};
use bench::cycle::run::PointError;
use bench::model::axis::VelocityFeedback;
use procedures::case::{Mode, Segment, Then};
use procedures::device::DeviceRole;
use procedures::log::PointStatus;

use super::bed::{Bed, case, go_to};
use super::troubled::{Trouble, troubled};

/// A move at 20 deg/s; the trouble comes in its midst, 2 s after the first tick.
fn moving(trouble: Trouble) -> Bed {
    let mut bed = Bed::new(case("az", [0.0, 0.0], vec![go_to(60.0, 6.0)]));
    bed.wrap = troubled(8000, trouble);
    bed
}

#[test]
fn a_panic_in_the_loop_ends_at_standstill_with_a_readable_log() {
    let ran = moving(Trouble::Panic).run();
    assert_eq!(ran.outcome.status, PointStatus::Errored);
    assert_eq!(ran.outcome.error, Some(PointError::Internal("the control loop panicked")));
    assert!(ran.outcome.safe.standstill && ran.contacts == 0, "{:?}", ran.outcome);
    let window = ran.window.as_ref().expect("a log");
    assert_eq!(window.status, PointStatus::Errored);
    let stop = &window.stops[0];
    assert!(stop.from_rad_per_s > 0.3 && stop.standstill, "{stop:?}");
    assert!(stop.reached_angle_rad <= stop.computed_angle_rad, "{stop:?}");
}

/// The loop itself hangs: nobody sends, the drives' watchdogs act. When the loop comes back it finds them stopped.
#[test]
fn a_loop_that_hangs_is_stopped_by_the_drives_own_watchdogs() {
    let mut bed = moving(Trouble::Hang(Duration::from_millis(400)));
    // The wrapping shifts the time of the bus alone: the gyro's line would lie behind.
    bed.rig.devices.retain(|entry| entry.role != Some(DeviceRole::InertialUnit));
    bed.rig.axes.iter_mut().for_each(|axis| axis.velocity_feedback = VelocityFeedback::Encoder);
    let ran = bed.run();
    let trip = ran.outcome.trip.expect("the drives have left operation");
    assert_eq!(trip.interlock, "drive state", "{trip:?}");
    assert_eq!((ran.outcome.status, ran.outcome.safe.standstill), (PointStatus::Aborted, true));
    // 20 deg/s for the 20 ms of the watchdog, then 100 deg/s²: 2.4 degrees.
    let positions = ran.column("/az", "position_rad");
    let before = positions[7998];
    let end = positions.last().expect("rows") - before;
    assert!((1.5..4.0).contains(&end.to_degrees()), "{} deg", end.to_degrees());
}

/// A disk that takes nothing any more, and does not say so.
struct Hanging {
    taken_bytes: u64,
    /// What is taken before it hangs.
    limit_bytes: u64,
}

impl Write for Hanging {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.taken_bytes > self.limit_bytes {
            loop {
                std::thread::park();
            }
        }
        self.taken_bytes += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Hanging {
    fn seek(&mut self, _: SeekFrom) -> std::io::Result<u64> {
        Ok(self.taken_bytes)
    }
}

/// A long move and a longer rest with a recorder whose disk hangs after a megabyte.
fn with_hanging_disk(waits: bool) -> Bed {
    let moved = Segment { then: Then::Next, ..go_to(100.0, 8.0) };
    let held = Segment { then: Then::Stop, ..Segment::hold("hold", Mode::Position, 40.0) };
    let mut bed = Bed::new(case("az", [0.0, 0.0], vec![moved, held]));
    bed.recorder = Some(Box::new(move |plan, rig| {
        let sink = Hanging { taken_bytes: 0, limit_bytes: 1 << 20 };
        let log = Log { sink, sync: |_| Ok(()), path: PathBuf::from("hanging.mcap") };
        let recorder = Recorder::over(log, LogHead::new(plan, rig), waits);
        recorder.expect("its head is taken").with_patience(0.3)
    }));
    bed
}

#[test]
fn a_recorder_that_hangs_stops_the_axis_and_does_not_hang_the_run() {
    let ran = with_hanging_disk(true).run();
    assert_eq!(ran.outcome.status, PointStatus::Errored);
    assert_eq!(ran.outcome.error, Some(PointError::Bench("the log can no longer be written".to_owned())));
    assert!(ran.outcome.safe.standstill && ran.contacts == 0, "{:?}", ran.outcome);
}

/// Where the loop does not wait for the disk, the ring takes what the disk does not for two seconds; then the axis is
/// stopped before a row is lost.
#[test]
fn a_recorder_that_hangs_in_real_time_ends_nothing_for_two_seconds_and_loses_no_row() {
    let ran = with_hanging_disk(false).run();
    let trip = ran.outcome.trip.expect("the ring is full in the end");
    assert_eq!(trip.interlock, "log ring", "{trip:?}");
    assert!(ran.outcome.loop_s > 2.0, "{} s", ran.outcome.loop_s);
    assert_eq!(ran.outcome.status, PointStatus::Errored);
    assert!(ran.outcome.safe.standstill && ran.contacts == 0, "{:?}", ran.outcome);
}
