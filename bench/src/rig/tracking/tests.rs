use drivers::tracker::Lock;

use super::*;
use crate::files::parameters;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};

/// Ticks of 250 µs.
const TICKS_PER_FRAME: u32 = 80;

fn tracking() -> Tracking {
    let rig = read_rig(shipped::find(Folder::Rigs, "sim", None).expect("shipped")).expect("it parses");
    Tracking::new(&rig, &parameters::load(&rig).expect("shipped parameters"))
}

const COARSE: Closed = Closed { coarse: true, fine: false, off_load: false };
const FINE: Closed = Closed { coarse: false, fine: true, off_load: false };

fn at(tick: u32) -> Duration {
    Duration::from_secs(1) + tick * Duration::from_micros(250)
}

/// The newest frame of a camera whose frames are 40 ms old when they come.
fn frame(tick: u32, error_rad: [f64; 2], lock: Lock) -> Actuals {
    let counter = tick / TICKS_PER_FRAME + 1;
    let exposure = at(counter * TICKS_PER_FRAME - TICKS_PER_FRAME) - Duration::from_millis(40);
    let [cross_elevation_rad, elevation_rad] = error_rad;
    Actuals {
        cross_elevation_rad,
        elevation_rad,
        exposure,
        stamp: exposure,
        counter,
        lock,
        ..Actuals::default()
    }
}

/// Plays ticks in which both cameras show the target at this error; the last that was asked.
fn play(
    tracking: &mut Tracking,
    closed: Closed,
    ticks: std::ops::Range<u32>,
    error_rad: [f64; 2],
    lock: Lock,
) -> Asked {
    play_at(tracking, closed, ticks, error_rad, lock)
}

/// The same in these ticks, which are some of all periods: those between them were missed.
fn play_at(
    tracking: &mut Tracking,
    closed: Closed,
    ticks: impl IntoIterator<Item = u32>,
    error_rad: [f64; 2],
    lock: Lock,
) -> Asked {
    let mut asked = Asked::default();
    let mut before = None;
    for tick in ticks {
        let steps = before.replace(tick).map_or(1, |before| tick - before);
        let frames = [frame(tick, error_rad, lock); 2];
        let rate_rad_per_s = [0.0; 2];
        let mirror_rad = [0.0; 2];
        let seen =
            Seen { now: at(tick), frames: &frames, rate_rad_per_s, elevation_rad: 1.05, mirror_rad, steps };
        asked = tracking.update(closed, &seen);
    }
    asked
}

#[test]
fn axes_turn_towards_the_target_and_azimuth_by_the_secant_more() {
    let mut tracking = tracking();
    let asked = play(&mut tracking, COARSE, 0..400, [100e-6, 100e-6], Lock::Tracking);
    let [az, el] = asked.rate_rad_per_s;
    // A target is taken up without a jump: from the first frame that the line of sight reaches back to, 60 ms ago, only the
    // integral has grown. 1/cos 60 deg doubles azimuth's error.
    let grown = |kt: f64, tt: f64, error_rad: f64| kt / tt * error_rad * 0.06;
    assert!((el / grown(5.51, 0.543, 100e-6) - 1.0).abs() < 0.03, "{el}");
    assert!((az / grown(4.95, 0.246, 200e-6) - 1.0).abs() < 0.03, "{az}");
    assert_eq!(asked.mirror_rad, None, "the fine loop is open");
}

#[test]
fn nothing_is_asked_without_a_target_and_nothing_counts_as_missing_before_it_was_there() {
    let mut tracking = tracking();
    let asked = play(&mut tracking, COARSE, 0..800, [1e-3, 1e-3], Lock::Lost);
    assert_eq!(asked.rate_rad_per_s, [0.0; 2]);
    assert_eq!((tracking.missing_s(at(800)), tracking.locked_since()), (None, None));
}

#[test]
fn a_target_that_went_is_missing_for_longer_than_three_frames_after_60_ms() {
    let mut tracking = tracking();
    play(&mut tracking, COARSE, 0..800, [0.0; 2], Lock::Tracking);
    assert!(tracking.locked_since().is_some());
    play(&mut tracking, COARSE, 800..960, [0.0; 2], Lock::Lost);
    let (missing_s, limit_s) = tracking.missing_s(at(960)).expect("it was there");
    assert!((limit_s - 0.06).abs() < 1e-12 && (missing_s - 0.06).abs() < 1e-9, "{missing_s}");
    assert_eq!(tracking.locked_since(), None);
    assert_eq!(tracking.row()[4], 1.0, "it is held");
}

#[test]
fn an_open_loop_asks_for_nothing_and_forgets_its_target() {
    let mut tracking = tracking();
    play(&mut tracking, COARSE, 0..800, [1e-4; 2], Lock::Tracking);
    let open = play(&mut tracking, Closed::default(), 800..801, [1e-4; 2], Lock::Tracking);
    assert_eq!(open, Asked::default());
    assert_eq!((tracking.missing_s(at(801)), tracking.locked_since()), (None, None));
    assert_eq!(tracking.row()[4..6], [-1.0, -1.0]);
}

/// 48 1/s · 2.5 per frame of 5 ms: a frame is taken once, though it is there for many ticks.
#[test]
fn the_mirror_takes_each_frame_once() {
    let mut tracking = tracking();
    let asked = play(&mut tracking, FINE, 0..TICKS_PER_FRAME, [0.0, 10e-6], Lock::Tracking);
    let [az, el] = asked.mirror_rad.expect("the fine loop is closed");
    assert!((el - 2.5 * 48.0 * 0.005 * 10e-6).abs() < 1e-12 && az == 0.0, "{el}");
    assert_eq!(asked.rate_rad_per_s, [0.0; 2], "the axes are not asked to move");
}

#[test]
fn the_laws_go_on_in_time_over_missed_periods() {
    let error_rad = [100e-6, -50e-6];
    let both = Closed { coarse: true, fine: true, off_load: true };
    let asked = |missed: std::ops::Range<u32>| {
        let ticks = (0..400).filter(|tick| !missed.contains(tick));
        play_at(&mut tracking(), both, ticks, error_rad, Lock::Tracking)
    };
    let whole = asked(0..0);
    let gap = asked(200..232);
    for (whole, gap) in whole.rate_rad_per_s.into_iter().zip(gap.rate_rad_per_s) {
        assert!((gap / whole - 1.0).abs() < 1e-9, "{gap} rad/s instead of {whole}");
    }
    assert_eq!(gap.mirror_rad, whole.mirror_rad);
}
