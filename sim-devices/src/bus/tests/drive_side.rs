//! What safety.md §2 (6) wants of a drive, object by object: the drive that stops does it as its objects say.
//!
//! Watchdog 2F00h and abort connection 6007h stand in `faults`, quick stop 605Ah in `stops`, torque, current and speed
//! limits 6072h, 6073h, 6080h and soft limits 607Dh in `limits`.

use super::*;

/// Azimuth at this rate in CSV, with objects written before.
fn cruising(objects: &[(u16, i64)], deg_per_s: f64) -> Host {
    let mut host = Host::new(&UnitSettings::default(), start());
    for &(index, value) in objects {
        let bytes = value.to_le_bytes();
        let width = if matches!(index, 0x6084 | 0x6085) { 4 } else { 2 };
        host.write(0, index, 0, &bytes[..width]);
    }
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(deg_per_s), 9);
    host.run(6000);
    host
}

/// Degrees to standstill, and whether the drive had torque on the way.
fn stopped(host: &mut Host) -> f64 {
    let from = host.rig.truth_of_axes().angle_rad[0];
    host.run(16_000);
    let truth = host.rig.truth_of_axes();
    assert!(truth.rate_rad_per_s[0].abs() < 1e-3, "{} rad/s", truth.rate_rad_per_s[0]);
    (truth.angle_rad[0] - from).to_degrees()
}

/// v²/2a of a ramp, the reaction of about 2 ms not counted.
fn ramp_deg(deg_per_s: f64, deg_per_s2: f64) -> f64 {
    deg_per_s * deg_per_s / (2.0 * deg_per_s2)
}

fn counts(deg: f64) -> i64 {
    i64::from(counts_per_s(deg))
}

#[test]
fn fault_reaction_605e_coasts_slows_down_quick_stops_or_brakes_with_all_it_has() {
    const V: f64 = 20.0;
    let ramps = [(0x6084, counts(30.0)), (0x6085, counts(60.0))];
    // Lowest and highest angle: coasting as safety.md §1, ramps with 0.2° for the loop, the limit below 90 °/s²'s.
    for (option, first, low, high) in [
        (0, 0x08, 15.0, 21.0),
        (1, 0x0F, ramp_deg(V, 30.0) - 0.2, ramp_deg(V, 30.0) + 0.2),
        (2, 0x0F, ramp_deg(V, 60.0) - 0.2, ramp_deg(V, 60.0) + 0.2),
        (3, 0x0F, 0.5, ramp_deg(V, 90.0)),
    ] {
        let mut host = cruising(&[ramps[0], ramps[1], (0x605E, option)], V);
        host.rig.schedule(host.now, crate::faults::Fault::Drive { drive: 0, code: 0xFF01 });
        host.tick();
        assert_eq!(host.word(0, STATUSWORD) & 0x4F, first, "option {option}");
        let reached = stopped(&mut host);
        assert!((low..high).contains(&reached), "option {option}: {reached} deg, {low} to {high}");
        assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x08, 0xFF01));
    }
}

#[test]
fn quick_stop_6085_is_the_deceleration_of_option_6() {
    for (deg_per_s, deg_per_s2) in [(10.0, 30.0), (20.0, 30.0), (20.0, 60.0), (40.0, 90.0)] {
        let mut host = cruising(&[(0x605A, 6), (0x6085, counts(deg_per_s2))], deg_per_s);
        host.set(0, 0x02, 0, 0, 9);
        let reached = stopped(&mut host);
        let ramp = ramp_deg(deg_per_s, deg_per_s2);
        // The command waits 0.85 ms and one tick; 2 % and 0.05° for the loop.
        let late = deg_per_s * 0.0015;
        assert!((reached - ramp - late).abs() < 0.02 * ramp + 0.05, "{reached} deg instead of {ramp}");
        assert_eq!(host.pattern(0), 0x07, "option 6 holds");
    }
}

#[test]
fn the_watchdog_2f00_bites_after_the_time_that_it_was_given() {
    for (written, ticks) in [(25_u16, 10), (200, 80), (500, 200), (1000, 400)] {
        let mut host = cruising(&[(0x2F00, i64::from(written)), (0x6007, 1)], 10.0);
        host.write(1, 0x2F00, 0, &0_u16.to_le_bytes());
        host.rig.schedule(host.now, crate::faults::Fault::BusSilent { lasting: Some(TICK * ticks) });
        host.run(ticks + 1);
        assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x0F, "{written}: silent for one tick too long");
        let mut host = cruising(&[(0x2F00, i64::from(written)), (0x6007, 1)], 10.0);
        host.rig.schedule(host.now, crate::faults::Fault::BusSilent { lasting: Some(TICK * (ticks - 1)) });
        host.run(ticks);
        assert_eq!(host.pattern(0), 0x27, "{written}: silent for just as long as allowed");
    }
}

#[test]
fn what_the_drive_is_given_it_reads_back() {
    let mut host = Host::new(&UnitSettings::default(), start());
    let objects: [(u16, u8, &[u8]); 12] = [
        (0x2F00, 0, &[200, 0]),
        (0x6007, 0, &[3, 0]),
        (0x605A, 0, &[6, 0]),
        (0x605E, 0, &[2, 0]),
        (0x6065, 0, &[1, 2, 3, 4]),
        (0x6066, 0, &[5, 0]),
        (0x6072, 0, &[0x20, 3]),
        (0x6073, 0, &[0x20, 3]),
        (0x607D, 1, &[0, 0, 0xF0, 0xFF]),
        (0x607D, 2, &[0, 0, 0x10, 0]),
        (0x6080, 0, &[0, 0, 0x20, 0]),
        (0x6085, 0, &[0, 0, 0, 1]),
    ];
    for (index, sub, bytes) in objects {
        host.bus.download(1, index, sub, bytes).expect("writable");
        assert_eq!(host.bus.upload(1, index, sub).expect("readable"), bytes, "{index:04X}h:{sub:02}");
    }
}
