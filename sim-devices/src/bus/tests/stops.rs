use super::*;

/// Spun to about 20 °/s in CST, then a quick stop with option 6 at 90 °/s²: angle v²/2a, plus the ramp's lag.
#[test]
fn quick_stop_ends_within_the_computed_angle_and_holds() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x605A, 0, &6_i16.to_le_bytes());
    host.enable(0, 10);
    while host.velocity_deg_per_s(0) < 20.0 {
        host.set(0, 0x0F, 12_000, 0, 10);
        host.tick();
    }
    let from = host.angle_deg(0);
    let speed = host.velocity_deg_per_s(0);
    host.set(0, 0x02, 12_000, 0, 10);
    host.run(4000);
    assert_eq!(host.pattern(0), 0x07);
    assert_ne!(host.word(0, STATUSWORD) & 1 << 10, 0, "stopped");
    let travelled = host.angle_deg(0) - from;
    let computed = speed * speed / (2.0 * 90.0);
    assert!((travelled - computed).abs() < 0.1 * computed + 0.05, "{travelled} instead of {computed}");
    let rest = host.angle_deg(0);
    host.run(4000);
    assert!((host.angle_deg(0) - rest).abs() < 0.01);
    host.set(0, 0x0F, 0, 0, 10);
    host.run(90);
    assert_eq!(host.pattern(0), 0x27, "option 6 lets operation be enabled again");
}

#[test]
fn quick_stop_option_2_ends_with_torque_off() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(10.0), 9);
    host.run(4000);
    host.set(0, 0x02, 0, counts_per_s(10.0), 9);
    host.run(40);
    assert_eq!(host.pattern(0), 0x07);
    host.run(4000);
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x40);
    assert!(host.torque_permille(0).abs() < 30);
}

/// From 20 °/s without torque azimuth coasts 18° (safety.md §1): option 0 does that, option 3 stops far shorter.
#[test]
fn options_0_and_3_are_as_far_apart_as_coasting_and_braking() {
    let travelled = [0_i16, 3].map(|option| {
        let mut host = Host::new(&UnitSettings::default(), start());
        host.write(0, 0x605A, 0, &option.to_le_bytes());
        host.enable(0, 9);
        host.set(0, 0x0F, 0, counts_per_s(20.0), 9);
        host.run(8000);
        let from = host.angle_deg(0);
        host.set(0, 0x02, 0, 0, 9);
        host.run(16_000);
        assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x40);
        host.angle_deg(0) - from
    });
    assert!((travelled[0] - 18.0).abs() < 2.0, "{travelled:?}");
    assert!(travelled[1] < 2.0, "{travelled:?}");
}
