use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

const COARSE: fn() -> TrackerSettings = || TrackerSettings {
    name: "coarse".to_owned(),
    source: Source::Coarse,
    ifov_rad: [27.27e-6, 36.36e-6],
    map: [[0.0, 1.0], [1.0, 0.0]],
    declared_delay: DeclaredDelay { delay_s: 0.02, u_s: 1e-3 },
    poll_period: Duration::ZERO,
};

/// Between the clock of the camera and that of the loop.
const BEGAN_LATER: Duration = Duration::from_secs(7);

/// A frame that was exposed at this time of the loop.
fn sample(counter: u32, exposure_ms: u64) -> Sample {
    let stamp = BEGAN_LATER + Duration::from_millis(exposure_ms);
    Sample { counter, stamp, x_px: 10.0, y_px: -4.0, quality: 1.0, lock: Lock::Tracking }
}

fn tracker() -> Tracker {
    Tracker::new(COARSE()).expect("the settings are good")
}

/// Hands over a message as far after its exposure as is declared.
fn hand_over(tracker: &mut Tracker, source: Source, sample: &Sample) -> bool {
    let arrival = (sample.stamp + Duration::from_millis(20)).saturating_sub(BEGAN_LATER);
    tracker.accept(&encode(source, sample), arrival)
}

/// Messages with the time at which they arrive.
struct Port(VecDeque<(Duration, Vec<u8>)>);

impl DatagramPort for Port {
    fn name(&self) -> &str {
        "test"
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        if self.0.front().is_none_or(|(arrival, _)| *arrival > now) {
            return Ok(None);
        }
        Ok(self.0.pop_front().map(|(_, bytes)| {
            let length = bytes.len().min(into.len());
            into[..length].copy_from_slice(&bytes[..length]);
            length
        }))
    }

    fn send(&mut self, _: Duration, _: &[u8]) -> Result<(), DeviceError> {
        Ok(())
    }
}

#[test]
fn a_rotated_camera_gives_elevation_along_its_rows() {
    let mut tracker = tracker();
    assert!(hand_over(&mut tracker, Source::Coarse, &sample(1, 20)));
    assert!((tracker.last.elevation_rad - 272.7e-6).abs() < 1e-12);
    assert!((tracker.last.cross_elevation_rad + 145.44e-6).abs() < 1e-12);
}

#[test]
fn gaps_in_the_counter_are_lost_frames_even_across_its_wrap() {
    let mut tracker = tracker();
    for (counter, exposure_ms) in [(u32::MAX - 1, 20), (u32::MAX, 40), (2, 100), (3, 120)] {
        hand_over(&mut tracker, Source::Coarse, &sample(counter, exposure_ms));
    }
    assert_eq!((tracker.last.lost_frames, tracker.last.rejected), (2, 0));
}

#[test]
fn a_restarted_camera_is_heard_and_counts_no_loss() {
    let mut tracker = tracker();
    hand_over(&mut tracker, Source::Coarse, &sample(5000, 20));
    assert!(hand_over(&mut tracker, Source::Coarse, &sample(0, 40)));
    assert_eq!((tracker.last.counter, tracker.last.lost_frames), (0, 0));
}

#[test]
fn late_double_foreign_and_damaged_messages_change_only_the_count_of_rejects() {
    let mut tracker = tracker();
    hand_over(&mut tracker, Source::Coarse, &sample(7, 140));
    let before = tracker.last;
    let mut damaged = encode(Source::Coarse, &sample(8, 160));
    damaged[20] ^= 1;
    let messages = [
        encode(Source::Coarse, &sample(6, 120)),
        encode(Source::Coarse, &sample(7, 140)),
        encode(Source::Fine, &sample(8, 160)),
        damaged,
    ];
    assert!(messages.iter().all(|message| !tracker.accept(message, Duration::from_millis(180))));
    assert_eq!(tracker.last, Actuals { rejected: 4, ..before });
}

#[test]
fn a_lost_target_leaves_the_last_angles_standing_but_is_not_valid() {
    let mut tracker = tracker();
    hand_over(&mut tracker, Source::Coarse, &sample(1, 20));
    let angle = tracker.last.elevation_rad;
    hand_over(&mut tracker, Source::Coarse, &Sample { lock: Lock::Lost, x_px: 0.0, ..sample(2, 40) });
    assert!(!tracker.last.is_valid());
    assert_eq!(tracker.last.elevation_rad, angle);
}

#[test]
fn polling_takes_everything_that_arrived_and_tells_its_age() {
    let at = Duration::from_millis;
    let message = |counter, exposure_ms| encode(Source::Coarse, &sample(counter, exposure_ms)).to_vec();
    let mut port = Port(VecDeque::from([
        (at(60), message(1, 40)),
        (at(80), [message(2, 50), vec![0]].concat()),
        (at(80), message(3, 60)),
    ]));
    let mut tracker = tracker();
    let mut poll = |now| tracker.poll(&mut port, now).expect("the port is there");
    assert!(!poll(at(59)).1 && poll(at(60)).1);
    let (actuals, fresh) = poll(at(81));
    assert!(fresh);
    assert_eq!((actuals.counter, actuals.age, actuals.rejected), (3, at(21), 1));
    assert_eq!(actuals.row().len(), Tracker::CHANNELS.len());
}

#[test]
fn settings_that_make_no_angles_are_refused() {
    for ifov_rad in [[0.0, 1e-6], [f64::NAN, 1e-6], [1e-6, -1e-6]] {
        assert!(Tracker::new(TrackerSettings { ifov_rad, ..COARSE() }).is_err());
    }
    assert!(Tracker::new(TrackerSettings { map: [[f64::NAN, 0.0], [0.0, 1.0]], ..COARSE() }).is_err());
}

fn any_lock() -> impl Strategy<Value = Lock> {
    prop_oneof![Just(Lock::Lost), Just(Lock::Reacquiring), Just(Lock::Tracking)]
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_refused_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        prop_assert!(decode(&bytes).is_err());
        prop_assert!(!tracker().accept(&bytes, Duration::from_secs(1)));
    }

    /// A right checksum over arbitrary fields: decoded or refused, never a number that is none.
    #[test]
    fn forged_messages_give_finite_numbers_or_nothing(mut bytes in any::<[u8; LENGTH]>()) {
        bytes[..6].copy_from_slice(b"VTRK\x01\x01");
        bytes[6] %= 4;
        datagram::seal(&mut bytes);
        let mut tracker = tracker();
        let taken = tracker.accept(&bytes, Duration::from_secs(1));
        prop_assert_eq!(taken, decode(&bytes).is_ok());
        prop_assert!(tracker.last.row().iter().all(|value| value.is_finite()));
    }

    #[test]
    fn what_was_encoded_is_decoded(
        counter in any::<u32>(),
        stamp_ns in any::<u64>(),
        offset_px in any::<[i16; 2]>(),
        quality in any::<u8>(),
        lock in any_lock(),
        fine in any::<bool>(),
    ) {
        let source = if fine { Source::Fine } else { Source::Coarse };
        let sample = Sample {
            counter,
            stamp: Duration::from_nanos(stamp_ns),
            x_px: f32::from(offset_px[0]) / 64.0,
            y_px: f32::from(offset_px[1]) / 64.0,
            quality: f32::from(quality) / 255.0,
            lock,
        };
        prop_assert_eq!(decode(&encode(source, &sample)), Ok((source, sample)));
    }

    #[test]
    fn a_flipped_bit_is_noticed(counter in any::<u32>(), bit in 0_usize..8 * LENGTH) {
        let mut bytes = encode(Source::Coarse, &sample(counter, 20));
        bytes[bit / 8] ^= 1 << (bit % 8);
        prop_assert!(decode(&bytes).is_err());
    }
}
