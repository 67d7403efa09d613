use super::*;

#[test]
fn csv_reaches_its_target_and_respects_speed_and_soft_limits() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x6080, 0, &counts_per_s(20.0).to_le_bytes());
    host.write(0, 0x607D, 1, &counts_per_s(-30.0).to_le_bytes());
    host.write(0, 0x607D, 2, &counts_per_s(30.0).to_le_bytes());
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(50.0), 9);
    host.run(4000);
    assert!((host.velocity_deg_per_s(0) - 20.0).abs() < 0.2, "{}", host.velocity_deg_per_s(0));
    let mut furthest = 0.0_f64;
    for _ in 0..16_000 {
        host.tick();
        furthest = furthest.max(host.angle_deg(0));
    }
    assert!(host.velocity_deg_per_s(0).abs() < 0.02);
    assert!(furthest > 29.0 && furthest < 30.01, "{furthest}");
    assert_ne!(host.word(0, STATUSWORD) & 1 << 11, 0, "the limit is reported");
}

#[test]
fn cst_passes_a_soft_limit_but_reports_it() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x607D, 1, &counts_per_s(-5.0).to_le_bytes());
    host.write(0, 0x607D, 2, &counts_per_s(5.0).to_le_bytes());
    host.enable(0, 10);
    host.set(0, 0x0F, 4000, 0, 10);
    host.run(8000);
    assert!(host.angle_deg(0) > 5.0);
    assert_ne!(host.word(0, STATUSWORD) & 1 << 11, 0);
}

#[test]
fn torque_is_limited_by_6072_and_6073_and_the_limit_is_reported() {
    for index in [0x6072, 0x6073] {
        let mut host = Host::new(&undelayed(), start());
        host.write(0, index, 0, &800_u16.to_le_bytes());
        host.enable(0, 10);
        host.set(0, 0x0F, i16::MIN, 0, 10);
        host.run(3);
        assert!((host.torque_permille(0) + 800).abs() < 40, "{}", host.torque_permille(0));
        assert_ne!(host.word(0, STATUSWORD) & 1 << 11, 0);
    }
}

#[test]
fn above_6080_torque_may_only_brake() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x6080, 0, &counts_per_s(5.0).to_le_bytes());
    host.enable(0, 10);
    host.set(0, 0x0F, 6000, 0, 10);
    let mut fastest = 0.0_f64;
    for _ in 0..8000 {
        host.tick();
        fastest = fastest.max(host.velocity_deg_per_s(0));
    }
    assert!(fastest > 4.9 && fastest < 5.2, "{fastest}");
}
