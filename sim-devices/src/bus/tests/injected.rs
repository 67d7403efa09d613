//! Scheduled faults at the wire: what the host sees, what the drive does, what the axis does.

use super::*;
use crate::faults::Fault;

const AZ: usize = 0;

/// Azimuth turns at 20 °/s in CST, both drives in operation where `both`; then the fault, one tick later.
fn turning(unit: &UnitSettings, fault: Fault) -> Host {
    let mut host = Host::new(unit, start());
    host.write(0, 0x6007, 0, &1_i16.to_le_bytes());
    host.write(0, 0x2F00, 0, &200_u16.to_le_bytes());
    host.enable(AZ, 10);
    while host.velocity_deg_per_s(AZ) < 20.0 {
        host.set(AZ, 0x0F, 12_000, 0, 10);
        host.tick();
    }
    host.set(AZ, 0x0F, 3000, 0, 10);
    host.run(40);
    host.rig.schedule(host.now, fault);
    host.tick();
    host
}

fn true_deg(host: &Host) -> f64 {
    host.rig.truth_of_axes().angle_rad[AZ].to_degrees()
}

fn true_deg_per_s(host: &Host) -> f64 {
    host.rig.truth_of_axes().rate_rad_per_s[AZ].to_degrees()
}

fn digital_inputs(host: &mut Host) -> u32 {
    let bytes = host.bus.upload(1, 0x60FD, 0).expect("every drive has it");
    u32::from_le_bytes(bytes.try_into().expect("32 bits"))
}

fn counter(host: &mut Host) -> u16 {
    let exchange = host.bus.exchange(host.now, &mut host.image).expect("mapped");
    host.now += TICK;
    exchange.working_counter
}

#[test]
fn a_fault_acts_at_its_instant_and_not_before() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.rig.schedule(Duration::from_millis(100), Fault::HeatSink { drive: AZ, degc: 70.0 });
    let degc = |host: &Host| f64::from(i16::from_le_bytes(host.input(AZ, 22))) / 10.0;
    host.run(400);
    assert_eq!((host.now, degc(&host)), (Duration::from_millis(100), 40.0));
    host.tick();
    assert_eq!(degc(&host), 70.0);
}

/// Safe torque off: no torque from that instant on, so the axis coasts; the drive cannot be enabled until released.
#[test]
fn an_emergency_stop_takes_the_torque_from_both_drives_and_shows_in_bit_3() {
    let mut host = turning(&undelayed(), Fault::EmergencyStop { pressed: true });
    assert_eq!(host.word(AZ, STATUSWORD) & 0x4F, 0x40);
    assert_eq!(digital_inputs(&mut host) & 1 << 3, 1 << 3);
    let from = true_deg(&host);
    let speed = true_deg_per_s(&host);
    host.run(2);
    assert!(host.torque_permille(AZ).abs() < 40, "{}", host.torque_permille(AZ));
    for controlword in [0x06, 0x07, 0x0F] {
        host.set(AZ, controlword, 3000, 0, 10);
        host.run(4000);
        assert_eq!(host.word(AZ, STATUSWORD) & 0x4F, 0x40, "pressed");
    }
    let coasted = true_deg(&host) - from;
    assert!(speed > 19.0 && (coasted - 18.0).abs() < 3.0, "{coasted} deg from {speed} deg/s");
    host.rig.schedule(host.now, Fault::EmergencyStop { pressed: false });
    host.set(AZ, 0x06, 0, 0, 10);
    host.run(200);
    assert_eq!((host.pattern(AZ), digital_inputs(&mut host) & 1 << 3), (0x21, 0));
}

#[test]
fn safe_torque_off_of_one_drive_leaves_the_other_alone_and_no_trace_in_the_inputs() {
    let mut host = turning(&undelayed(), Fault::SafeTorqueOff { drive: 1, active: true });
    assert_eq!((host.pattern(AZ), digital_inputs(&mut host) & 1 << 3), (0x27, 0));
    host.rig.schedule(host.now, Fault::SafeTorqueOff { drive: AZ, active: true });
    host.tick();
    assert_eq!((host.word(AZ, STATUSWORD) & 0x4F, digital_inputs(&mut host) & 1 << 3), (0x40, 0));
}

/// A fault that brakes loses its brake, and stays a fault.
#[test]
fn safe_torque_off_ends_a_fault_reaction() {
    let mut host = turning(&undelayed(), Fault::Drive { drive: AZ, code: 0x4310 });
    assert_eq!(host.word(AZ, STATUSWORD) & 0x4F, 0x0F);
    host.rig.schedule(host.now, Fault::EmergencyStop { pressed: true });
    host.tick();
    assert_eq!((host.word(AZ, STATUSWORD) & 0x4F, host.word(AZ, ERROR_CODE)), (0x08, 0x4310));
}

#[test]
fn the_enabling_switch_shows_in_bit_16_and_takes_no_torque() {
    let mut host = turning(&undelayed(), Fault::EnablingSwitch { held: false });
    assert_eq!((host.pattern(AZ), digital_inputs(&mut host) & 1 << 16), (0x27, 0));
    host.rig.schedule(host.now, Fault::EnablingSwitch { held: true });
    host.tick();
    assert_eq!(digital_inputs(&mut host) & 1 << 16, 1 << 16);
}

/// The watchdog (20 ms) and 6007h = 1: the drive brakes by its fault reaction, with nobody to tell it.
#[test]
fn on_a_silent_bus_the_drive_stops_by_itself() {
    let mut host = turning(&UnitSettings::default(), Fault::BusSilent { lasting: None });
    let from = true_deg(&host);
    let speed = true_deg_per_s(&host);
    for _ in 0..12_000 {
        assert_eq!(counter(&mut host), 0);
    }
    assert!(true_deg_per_s(&host).abs() < 0.01, "{} deg/s", true_deg_per_s(&host));
    let travelled = true_deg(&host) - from;
    let allowed = speed * 0.022 + speed * speed / (2.0 * 90.0) + 0.3;
    assert!(travelled > speed * 0.02 && travelled < allowed, "{travelled} deg, {allowed} allowed");
}

#[test]
fn a_bus_that_comes_back_finds_the_drive_in_fault() {
    let lasting = Some(Duration::from_millis(500));
    let mut host = turning(&UnitSettings::default(), Fault::BusSilent { lasting });
    let silent = (0..4000).take_while(|_| counter(&mut host) == 0).count();
    assert_eq!(silent + 1, 2000, "500 ms at 4 kHz, the first of them in the tick of the fault");
    assert_eq!((host.word(AZ, STATUSWORD) & 0x4F, host.word(AZ, ERROR_CODE)), (0x08, 0x7500));
}

#[test]
fn lost_frames_are_lost_one_by_one_and_the_drive_goes_on() {
    let mut host = turning(&UnitSettings::default(), Fault::FramesLost { count: 3 });
    let counters: Vec<u16> = (0..4).map(|_| counter(&mut host)).collect();
    assert_eq!(counters, [0, 0, 6, 6], "the first went with the tick of the fault");
    assert_eq!(host.pattern(AZ), 0x27);
}

/// The axis brakes nothing back, friction is paid from the capacitor: the link falls until the drive gives up.
#[test]
fn without_mains_the_link_sinks_and_the_drive_trips_without_a_brake() {
    let mut host = turning(&UnitSettings::default(), Fault::SupplyLost);
    let volts = |host: &Host| f64::from(u32::from_le_bytes(host.input(AZ, 18))) / 1e3;
    let before = volts(&host);
    let ticks = (0..8000).take_while(|_| {
        host.set(AZ, 0x0F, 4000, 0, 10);
        host.tick();
        host.pattern(AZ) == 0x27
    });
    assert!(ticks.count() < 7999);
    assert_eq!((host.word(AZ, STATUSWORD) & 0x4F, host.word(AZ, ERROR_CODE)), (0x08, 0x3120));
    assert!(before > 500.0 && volts(&host) < 450.0, "{before} V, then {} V", volts(&host));
}

#[test]
fn a_heat_sink_beyond_the_shutdown_brakes_and_trips() {
    let mut host = turning(&UnitSettings::default(), Fault::HeatSink { drive: AZ, degc: 90.0 });
    host.run(45);
    assert_eq!((host.word(AZ, STATUSWORD) & 0x4F, host.word(AZ, ERROR_CODE)), (0x0F, 0x4310));
    host.run(2000);
    assert_eq!(host.word(AZ, STATUSWORD) & 0x4F, 0x08);
    host.run(8000); // the bristles relax once torque is off
    assert!(true_deg_per_s(&host).abs() < 0.01, "{} deg/s", true_deg_per_s(&host));
}

/// Position and velocity look like an axis that stands; the axis does not.
#[test]
fn a_frozen_encoder_looks_like_an_axis_at_rest() {
    let mut host = turning(&UnitSettings::default(), Fault::EncoderFrozen { drive: AZ });
    host.run(30); // velocity window and sensor delay
    let seen = host.angle_deg(AZ);
    let really = true_deg(&host);
    host.run(400);
    assert_eq!((host.angle_deg(AZ), host.velocity_deg_per_s(AZ), host.pattern(AZ)), (seen, 0.0, 0x27));
    assert!(true_deg(&host) > really + 1.0);
}

#[test]
fn a_slipped_scale_reads_more_by_the_slip() {
    let by_rad = 2.0_f64.to_radians();
    let mut host = Host::new(&UnitSettings::default(), start());
    host.rig.schedule(Duration::from_millis(10), Fault::EncoderJump { drive: AZ, by_rad });
    host.run(30);
    assert!(host.angle_deg(AZ).abs() < 0.01);
    host.run(30);
    assert!((host.angle_deg(AZ) - 2.0).abs() < 0.01, "{}", host.angle_deg(AZ));
    assert!(true_deg(&host).abs() < 0.01);
}

#[test]
fn an_encoder_fault_comes_and_goes_as_scheduled() {
    let fault = Some(EncoderFault::Error);
    let mut host = turning(&UnitSettings::default(), Fault::Encoder { drive: AZ, fault });
    assert_eq!((host.word(AZ, STATUSWORD) & 0x4F, host.word(AZ, ERROR_CODE)), (0x08, 0x7305));
    host.rig.schedule(host.now, Fault::Encoder { drive: AZ, fault: None });
    host.set(AZ, 0x00, 0, 0, 10);
    host.run(10);
    host.set(AZ, 0x80, 0, 0, 10);
    host.run(200);
    assert_eq!(host.word(AZ, STATUSWORD) & 0x4F, 0x40);
}

/// A broken power stage cannot brake; anything else does, by 605Eh.
#[test]
fn a_fault_of_the_power_stage_coasts_and_any_other_brakes() {
    for (code, first) in [(0x2310, 0x08), (0x5400, 0x08), (0x8611, 0x0F), (0xFF01, 0x0F)] {
        let host = turning(&UnitSettings::default(), Fault::Drive { drive: AZ, code });
        let found = (host.word(AZ, STATUSWORD) & 0x4F, host.word(AZ, ERROR_CODE));
        assert_eq!(found, (first, code), "{code:04X}h");
    }
}

#[test]
fn a_stuck_current_obeys_no_command_but_that_to_switch_off() {
    let mut host = turning(&undelayed(), Fault::CurrentStuck { drive: AZ, current_a: 4.0 });
    host.set(AZ, 0x0F, -3000, 0, 10);
    host.run(100);
    assert!((host.torque_permille(AZ) - 2000).abs() < 40, "{}", host.torque_permille(AZ));
    host.set(AZ, 0x00, 0, 0, 10);
    host.run(100);
    assert!(host.torque_permille(AZ).abs() < 40, "{}", host.torque_permille(AZ));
}
