use super::*;
use crate::physics::lugre::LuGre;

/// Torque per disturbance of the loop below at a frequency, friction slope neglected (0.2 %):
/// (Kp·s + Ki)/(J·s² + Kp·s + Ki).
fn torque_per_disturbance(hz: f64) -> f64 {
    let w = std::f64::consts::TAU * hz;
    (23_600.0 * w).hypot(447_500.0) / (23_600.0 * w).hypot(447_500.0 - 1200.0 * w * w)
}

/// 2 °/s by a PI in the host (the director's gains, torque over the wire): the velocity settles and the torque shows
/// the cogging at 144 periods per revolution, fundamental and second harmonic, as large as the loop makes them.
#[test]
fn a_plain_pi_tracks_2_deg_per_s_and_its_torque_shows_the_cogging() {
    let mut host = Host::new(&UnitSettings::default(), start());
    host.enable(0, 10);
    let mut integral = 0.0_f64;
    let mut permille = 0_i16;
    let mut samples = Vec::new();
    while host.now < Duration::from_secs(8) {
        host.set(0, 0x0F, permille, 0, 10);
        host.tick();
        let error = (2.0 - host.velocity_deg_per_s(0)).to_radians();
        integral += 447_500.0 * 250e-6 * error;
        permille = ((23_600.0 * error + integral) / 0.12).round() as i16;
        if host.now >= Duration::from_secs(3) {
            let torque = f64::from(host.torque_permille(0)) * 0.12;
            samples.push((host.angle_deg(0), torque, host.velocity_deg_per_s(0)));
        }
    }
    assert!(samples.iter().all(|(_, _, velocity)| (velocity - 2.0).abs() < 0.1));
    let span = samples[samples.len() - 1].0 - samples[0].0;
    assert!((span - 10.0).abs() < 0.01, "four cogging periods in 5 s: {span}");
    let count = samples.len() as f64;
    let mean = samples.iter().map(|(_, torque, _)| torque).sum::<f64>() / count;
    let friction = LuGre::new(&UnitSettings::default().az, 50e-6).steady_torque_nm(2.0_f64.to_radians());
    assert!((mean - friction).abs() < 0.5, "{mean} instead of {friction}");
    let amplitude = [144.0, 288.0, 72.0].map(|order: f64| {
        let part = |f: fn(f64) -> f64| -> f64 {
            samples.iter().map(|(angle, torque, _)| (torque - mean) * f((order * angle).to_radians())).sum()
        };
        2.0 * part(f64::sin).hypot(part(f64::cos)) / count
    });
    let expected = [8.45 * torque_per_disturbance(0.8), 0.845 * torque_per_disturbance(1.6)];
    assert!((amplitude[0] / expected[0] - 1.0).abs() < 0.02, "{amplitude:?} instead of {expected:?}");
    assert!((amplitude[1] / expected[1] - 1.0).abs() < 0.05, "{amplitude:?} instead of {expected:?}");
    assert!(amplitude[2] < 0.1, "nothing at an order that the motor lacks: {amplitude:?}");
}

/// Everything the bus says over two seconds of motion.
fn transcript(seed: u64) -> Vec<u8> {
    let rig = SimulatedRig::new(&UnitSettings::default(), &address(seed), start());
    let mut bus = rig.bus();
    let (mut image, slots) = bus.map().expect("the default mapping is valid");
    bus.request(BusState::SafeOp);
    bus.request(BusState::Op);
    let mut bytes = Vec::new();
    for k in 0..8000_u32 {
        for (_, slot) in &slots {
            let word: u16 = if k < 100 {
                6
            } else if k < 200 {
                7
            } else {
                15
            };
            let torque = (4000.0 * (f64::from(k) * 1e-3).sin()) as i16;
            image.outputs[slot.outputs.start..][..2].copy_from_slice(&word.to_le_bytes());
            image.outputs[slot.outputs.start + 2..][..2].copy_from_slice(&torque.to_le_bytes());
            image.outputs[slot.outputs.start + 8] = 10;
        }
        bus.exchange(TICK * k, &mut image).expect("mapped");
        bytes.extend_from_slice(&image.inputs);
    }
    bytes
}

#[test]
fn the_same_address_gives_the_same_bytes_and_another_seed_others() {
    let first = transcript(7);
    assert!(first == transcript(7));
    assert!(first != transcript(8));
}

#[test]
fn a_crash_reaches_the_record() {
    let mut host = Host::new(&UnitSettings::default(), StartState { az_rad: 2.7, ..start() });
    host.enable(0, 10);
    host.set(0, 0x0F, 5000, 0, 10);
    host.run(8000);
    let crashes = host.rig.record().crashes;
    assert_eq!(crashes.len(), 1, "{crashes:?}");
    assert_eq!(crashes[0].0, "az");
    assert!(crashes[0].2 > 0.1);
}

/// 18 K of warm-up and −0.5 % a kelvin: an axis against the same current gets 9 % less torque late in the plan.
#[test]
fn a_motor_that_warmed_up_by_the_plan_gives_the_torque_of_its_temperature() {
    let torque_nm = |planned_s: f64| {
        let axis = crate::unit::AxisSettings {
            warm_up_degc: 18.0,
            torque_constant_per_k_ratio: -0.005,
            ..UnitSettings::default().az
        };
        let unit = UnitSettings { az: axis, planned_s, ..UnitSettings::default() };
        let address = address(1);
        let warm_degc = 40.0 + unit.az.warmed_degc(planned_s);
        let drive = crate::cia402::Drive::new("az", 1, &unit.az, &address, 0.0, warm_degc, 50e-6);
        let station = Station::new(drive, &unit.az, None);
        station.torque_nm(10.0)
    };
    assert_eq!(torque_nm(0.0), 600.0);
    assert!((torque_nm(36_000.0) / 600.0 - 0.91).abs() < 1e-9);
}
