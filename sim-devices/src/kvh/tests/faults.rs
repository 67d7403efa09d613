//! What the host sees of a unit that falls silent, freezes or reads too much.

use super::*;

fn turning(deg_per_s: f64) -> Motion {
    Motion { frame_rad_per_s: [0.0, deg_per_s.to_radians()], ..Motion::default() }
}

#[test]
fn a_silent_unit_sends_nothing_and_its_sample_ages() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &turning(0.0));
    (0..8).for_each(|_| {
        pair.tick(&turning(0.0));
    });
    pair.unit.borrow_mut().fall_silent();
    let taken: u32 = (0..400).map(|_| pair.tick(&turning(10.0))).sum();
    assert!(taken <= 1, "one message may have been under way, {taken} came");
    assert!(pair.driver.age_ticks() >= 398, "{}", pair.driver.age_ticks());
}

/// Numbered and summed as they should be: only that nothing changes any more tells of it.
#[test]
fn a_frozen_unit_goes_on_with_good_messages_of_the_same_rates() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &turning(0.0));
    // What it measures is the difference of angles between pulses.
    let mut angle_rad = 0.0_f64;
    let mut turn = |pair: &mut Pair, deg_per_s: f64| {
        angle_rad += deg_per_s.to_radians() * 250e-6;
        let motion = Motion { frame_rad: [0.0, angle_rad], ..turning(deg_per_s) };
        pair.tick(&motion)
    };
    (0..8).for_each(|_| {
        turn(&mut pair, 5.0);
    });
    pair.unit.borrow_mut().freeze();
    (0..400).for_each(|_| assert_eq!(turn(&mut pair, 20.0), 1));
    let rate = pair.driver.valid_sample().expect("healthy").rate_rad_per_s;
    let size = rate.iter().map(|r| r * r).sum::<f64>().sqrt().to_degrees();
    assert!((size - 5.0).abs() < 0.05, "{size} deg/s");
    assert_eq!((pair.driver.missed_count(), pair.driver.tally().bad_checksums_count), (0, 0));
}

#[test]
fn an_offset_is_added_to_every_gyro() {
    let mut pair = Pair::open(&perfect(), driver_settings(), &turning(0.0));
    pair.unit.borrow_mut().shift_gyros(0.05);
    (0..8).for_each(|_| {
        pair.tick(&turning(0.0));
    });
    let rate = pair.driver.valid_sample().expect("healthy").rate_rad_per_s;
    assert!(rate.iter().all(|r| (r - 0.05).abs() < 1e-6), "{rate:?}");
}
