use super::*;

/// Turns azimuth at 10 °/s, falls silent, comes back after `silence`.
fn after_silence(option: i16, silence: Duration) -> Host {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.write(0, 0x6007, 0, &option.to_le_bytes());
    host.write(0, 0x2F00, 0, &200_u16.to_le_bytes());
    host.write(1, 0x2F00, 0, &0_u16.to_le_bytes());
    host.enable(0, 9);
    host.set(0, 0x0F, 0, counts_per_s(10.0), 9);
    host.run(4000);
    host.now += silence;
    host.tick();
    host
}

#[test]
fn the_watchdog_is_content_with_20_ms_and_trips_after() {
    let host = after_silence(1, Duration::from_micros(19_750));
    assert_eq!((host.bus.state(), host.pattern(0)), (BusState::Op, 0x27));
    let mut host = after_silence(1, Duration::from_millis(22));
    assert_eq!((host.bus.state(), host.word(0, STATUSWORD) & 0x4F), (BusState::SafeOp, 0x0F));
    assert_eq!(host.word(0, ERROR_CODE), 0x7500);
    host.run(4000);
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x08);
    assert!(host.velocity_deg_per_s(0).abs() < 0.1, "braked by the fault reaction");
}

#[test]
fn abort_connection_options_do_nothing_disable_or_stop() {
    let silence = Duration::from_millis(400);
    let host = after_silence(0, silence);
    assert_eq!(host.pattern(0), 0x27);
    assert!((host.velocity_deg_per_s(0) - 10.0).abs() < 0.3, "a hung host is not noticed with option 0");
    let host = after_silence(2, silence);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x40, 0x7500));
    let host = after_silence(3, silence);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x40, 0x7500));
    let mut host = host;
    host.run(8000); // the bristles relax once torque is off
    assert!(host.velocity_deg_per_s(0).abs() < 0.1);
}

#[test]
fn a_fault_is_left_by_a_rising_edge_only_and_after_its_cause_is_gone() {
    let mut host = after_silence(1, Duration::from_millis(22));
    host.run(4000);
    host.bus.request(BusState::Op);
    host.set(0, 0x0F, 0, 0, 10);
    host.run(200);
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x08, "enabling does not leave a fault");
    host.set(0, 0x80, 0, 0, 10);
    host.run(200);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x40, 0));
}

#[test]
fn a_hot_heat_sink_warns_then_trips_and_stays_tripped_while_hot() {
    let mut unit = UnitSettings::default();
    (unit.az.heat_sink_warning_degc, unit.az.heat_sink_shutdown_degc) = (39.0, 41.0);
    unit.az.heat_sink_time_s = 1.0;
    (unit.az.loss_power_w, unit.az.ambient_degc) = (400.0, 40.0);
    let mut host = Host::new(&unit, start());
    host.enable(0, 10);
    assert_ne!(host.word(0, STATUSWORD) & 1 << 7, 0, "warning");
    let mut sign = 1;
    while host.now < Duration::from_secs(3) {
        sign = -sign; // ±14.2 A, no motion
        host.set(0, 0x0F, 7100 * sign, 0, 10);
        host.tick();
    }
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x08, 0x4310));
    assert_eq!(host.torque_permille(0) / 100, 0);
    let mut hot = Host::new(&UnitSettings::default(), StartState { heat_sink_degc: 87.0, ..start() });
    hot.bus.request(BusState::Op);
    hot.run(400);
    hot.set(0, 0x80, 0, 0, 10);
    hot.run(400);
    assert_eq!((hot.word(0, STATUSWORD) & 0x4F, hot.word(0, ERROR_CODE)), (0x08, 0x4310));
}

#[test]
fn a_dc_link_out_of_range_trips() {
    for (voltage, code) in [(300.0, 0x3120), (800.0, 0x3110)] {
        let mut unit = UnitSettings::default();
        unit.supply.open_voltage_v = voltage;
        let mut host = Host::new(&unit, start());
        host.bus.request(BusState::Op);
        for controlword in [0x06, 0x07] {
            host.set(0, controlword, 0, 0, 10);
            host.run(200);
        }
        assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x08, code));
    }
}

/// Error and damaged frame take the torque away at once: without a position nothing can be braked; a warning does not.
#[test]
fn encoder_faults_are_reported_as_the_drive_sees_them_and_cannot_be_reset_while_they_last() {
    for (fault, code) in [(EncoderFault::Error, 0x7305), (EncoderFault::Crc, 0x7306)] {
        let mut host = Host::new(&UnitSettings::default(), start());
        host.enable(0, 10);
        host.rig.inject_encoder_fault(0, Some(EncoderFault::Warning));
        host.run(2);
        assert_eq!((host.pattern(0), host.word(0, STATUSWORD) & 1 << 7), (0x27, 1 << 7));
        host.rig.inject_encoder_fault(0, Some(fault));
        host.run(2);
        assert_eq!((host.pattern(0), host.word(0, ERROR_CODE)), (0x08, code));
        assert_eq!(host.pattern(1), 0x40, "the other axis is not concerned");
        host.set(0, 0x80, 0, 0, 10);
        host.run(200);
        assert_eq!(host.pattern(0), 0x08, "the cause is still there");
        host.rig.inject_encoder_fault(0, None);
        host.set(0, 0x00, 0, 0, 10);
        host.run(10);
        host.set(0, 0x80, 0, 0, 10);
        host.run(200);
        assert_eq!(host.pattern(0), 0x40);
    }
}

/// The axis coasts while its encoder is dead: the drive knows nothing of it.
#[test]
fn a_drive_without_an_encoder_sends_its_last_good_position_and_no_velocity() {
    for fault in [EncoderFault::Error, EncoderFault::Crc] {
        let mut host = Host::new(&UnitSettings::default(), start());
        host.enable(0, 9);
        host.set(0, 0x0F, 0, counts_per_s(10.0), 9);
        host.run(4000);
        let last_deg = host.angle_deg(0);
        host.rig.inject_encoder_fault(0, Some(fault));
        for _ in 0..400 {
            host.tick();
            assert_eq!((host.angle_deg(0), host.velocity_deg_per_s(0)), (last_deg, 0.0), "{fault:?}");
        }
        host.rig.inject_encoder_fault(0, None);
        host.tick();
        assert!(host.angle_deg(0) > last_deg + 0.5, "it coasted on and is found again");
        assert!(host.velocity_deg_per_s(0) > 1.0);
    }
}

/// The fault reaction brakes by the encoder's velocity too.
#[test]
fn braking_ends_where_the_encoder_does() {
    let mut host = after_silence(1, Duration::from_millis(22));
    assert_eq!(host.word(0, STATUSWORD) & 0x4F, 0x0F, "the fault reaction brakes");
    host.rig.inject_encoder_fault(0, Some(EncoderFault::Error));
    host.run(2);
    assert_eq!((host.word(0, STATUSWORD) & 0x4F, host.word(0, ERROR_CODE)), (0x08, 0x7305));
}
