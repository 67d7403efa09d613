use super::*;
use crate::unit::UnitSettings;
use dictionary::OBJECTS;
use drivers::cia402::objects;
use proptest::prelude::*;

fn drive() -> Drive {
    let address = SeedAddress { seed: 1, procedure: "TEST".into(), point: "1".into() };
    Drive::new("az", 7, &UnitSettings::default().az, &address, 0.25, 40.0, 50e-6)
}

fn mapped(drive: &mut Drive, index: u16, words: &[u32]) -> Result<(), u32> {
    drive.download(index, 0, &[0])?;
    for (sub, word) in (1..).zip(words) {
        drive.download(index, sub, &word.to_le_bytes())?;
    }
    drive.download(index, 0, &[words.len() as u8]).map(|_| ())
}

#[test]
fn refusals_carry_the_abort_code_of_their_reason() {
    let mut drive = drive();
    let short = [0_u8; 1];
    let cases: [(u16, u8, &[u8], u32); 12] = [
        (0x2222, 0, &short, abort::NO_OBJECT),
        (0x1018, 9, &short, abort::NO_SUB_INDEX),
        (0x1008, 1, &short, abort::NO_SUB_INDEX),
        (0x1008, 0, b"x", abort::READ_ONLY),
        (0x6041, 0, &[0, 0], abort::READ_ONLY),
        (0x6072, 0, &short, abort::LENGTH),
        (0x6072, 0, &[0, 0, 0, 0], abort::LENGTH),
        (0x605A, 0, &[4, 0], abort::INVALID_VALUE),
        (0x605A, 0, &[8, 0], abort::TOO_HIGH),
        (0x605A, 0, &[0xFF, 0xFF], abort::TOO_LOW),
        (0x6060, 0, &[8], abort::TOO_LOW),
        (0x1C12, 0, &[5], abort::TOO_HIGH),
    ];
    for (index, sub, data, code) in cases {
        assert_eq!(drive.download(index, sub, data), Err(code), "{index:04X}:{sub}");
    }
    assert_eq!(drive.upload(0x2222, 0), Err(abort::NO_OBJECT));
    assert_eq!(drive.upload(0x607D, 3), Err(abort::NO_SUB_INDEX));
    assert_eq!(drive.upload(0x1A00, 17), Err(abort::NO_SUB_INDEX));
}

#[test]
fn identity_says_that_it_is_simulated() {
    let drive = drive();
    let name = String::from_utf8(drive.upload(0x1008, 0).expect("1008h")).expect("ASCII");
    assert!(name.contains("SIM"), "{name}");
    assert_eq!(drive.upload(0x1018, 4), Ok(vec![7, 0, 0, 0]));
    assert_eq!(drive.upload(0x6075, 0), Ok(2000_u32.to_le_bytes().to_vec()));
    assert_eq!(drive.upload(0x6076, 0), Ok(120_000_u32.to_le_bytes().to_vec()));
    assert_eq!(drive.upload(0x608F, 1), Ok((1_u32 << 26).to_le_bytes().to_vec()));
}

#[test]
fn every_object_of_the_driver_exists_here_with_its_width_and_access() {
    let mut drive = drive();
    for object in objects::OBJECTS {
        let data =
            drive.upload(object.index, object.sub).unwrap_or_else(|code| panic!("{object:?}: {code:08X}"));
        if let Some(bytes) = object.data_type.bytes() {
            assert_eq!(data.len(), bytes, "{object:?}");
        }
        let refused = drive.download(object.index, object.sub, &data) == Err(abort::READ_ONLY);
        assert_eq!(refused, object.access == objects::Access::ReadOnly, "{object:?}");
    }
}

#[test]
fn objects_are_sorted_so_that_they_are_found() {
    for (slot, object) in OBJECTS.iter().enumerate() {
        assert_eq!(Dictionary::find(object.index, object.sub), Ok(slot));
    }
}

#[test]
fn a_mapping_of_ones_own_defines_the_layout() {
    let mut drive = drive();
    mapped(&mut drive, 0x1A00, &[0x6064_0020]).expect("mappable");
    mapped(&mut drive, 0x1A01, &[0x0000_0018, 0x6061_0008, 0x6041_0010]).expect("mappable");
    drive.download(0x1C13, 0, &[0]).expect("PRE-OP");
    drive.download(0x1C13, 1, &0x1A01_u16.to_le_bytes()).expect("a PDO");
    drive.download(0x1C13, 2, &0x1A00_u16.to_le_bytes()).expect("a PDO");
    drive.download(0x1C13, 0, &[2]).expect("two PDOs");
    assert_eq!(drive.map(), Ok((10, 10)));
    let mut inputs = [0xAA; 10];
    drive.send(0, 0.25, &mut inputs);
    assert_eq!((inputs[0], inputs[3]), (0xAA, 10));
    let counts = Encoder::new(&UnitSettings::default().az).counts(0.25) as i32;
    assert_eq!(inputs[6..10], counts.to_le_bytes());
}

#[test]
fn a_mapping_is_refused_where_it_is_wrong() {
    let mut drive = drive();
    let refused = |drive: &mut Drive, word: u32| mapped(drive, 0x1A00, &[word]);
    assert_eq!(refused(&mut drive, 0x606C_0010), Err(abort::NOT_MAPPABLE), "width of another object");
    assert_eq!(refused(&mut drive, 0x6040_0010), Err(abort::NOT_MAPPABLE), "an output among the inputs");
    assert_eq!(refused(&mut drive, 0x607D_0120), Err(abort::NOT_MAPPABLE), "a setting");
    assert_eq!(refused(&mut drive, 0x7777_0010), Err(abort::NO_OBJECT));
    assert_eq!(mapped(&mut drive, 0x1A00, &[0x6079_0020; 16]), Ok(()));
    assert_eq!(drive.download(0x1A00, 1, &0x6079_0020_u32.to_le_bytes()), Err(abort::COUNT_NOT_ZERO));
    assert_eq!(mapped(&mut drive, 0x1A00, &[0x0000_0040; 9]), Err(abort::PDO_TOO_LONG));
    assert_eq!(mapped(&mut drive, 0x1A00, &[0x0000_0004, 0x6041_0010]), Ok(()));
    assert_eq!(drive.map(), Err(abort::NOT_MAPPABLE), "an object across bytes");
    drive.set_bus_state(BusState::SafeOp);
    assert_eq!(drive.download(0x1A00, 0, &[0]), Err(abort::DEVICE_STATE));
    assert_eq!(drive.download(0x1C12, 0, &[0]), Err(abort::DEVICE_STATE));
}

#[test]
fn a_drive_that_holds_in_safe_op_lets_go_below_it() {
    let mut drive = drive();
    drive.map().expect("default mapping");
    drive.set_bus_state(BusState::Op);
    drive.download(0x6007, 0, &[3, 0]).expect("quick stop when the connection is lost");
    drive.download(0x605A, 0, &[6, 0]).expect("and stay there");
    drive.enter(State::OperationEnabled);
    drive.set_bus_state(BusState::SafeOp);
    assert_eq!(drive.state(), State::QuickStopActive, "it holds by itself");
    drive.set_bus_state(BusState::PreOp);
    drive.leave_safe_op();
    assert_eq!(drive.state(), State::SwitchOnDisabled);
    assert_eq!(drive.current_a(1, 0.25), 0.0);
}

#[test]
fn a_mode_that_the_drive_lacks_is_not_taken_from_the_process_data() {
    let mut drive = drive();
    drive.map().expect("default mapping");
    drive.set_bus_state(BusState::Op);
    for (mode, shown) in [(9_u8, 9_u8), (8, 9), (10, 10)] {
        drive.receive(0, &[0, 0, 0, 0, 0, 0, 0, 0, mode, 0]);
        drive.act_on_outputs(20);
        assert_eq!(drive.upload(0x6060, 0), Ok(vec![shown]));
    }
}

proptest! {
    #[test]
    fn no_sdo_and_no_process_data_brings_current_without_a_state_that_allows_it(
        accesses in prop::collection::vec((any::<u16>(), any::<u8>(), prop::collection::vec(any::<u8>(), 0..9)), 1..60),
        near in prop::collection::vec((0usize..51, prop::collection::vec(any::<u8>(), 0..5)), 1..60),
        outputs in prop::collection::vec(prop::collection::vec(any::<u8>(), 10), 1..60),
    ) {
        let mut drive = drive();
        for (index, sub, data) in &accesses {
            let _ = drive.download(*index, *sub, data);
        }
        for (slot, data) in &near {
            let _ = drive.download(OBJECTS[*slot].index, OBJECTS[*slot].sub, data);
        }
        if drive.map() == Ok((10, 14)) {
            drive.set_bus_state(BusState::Op);
        }
        for (step, bytes) in (0..).zip(&outputs) {
            let current_a = drive.current_a(step * 400, 0.25 + 1e-4 * step as f64);
            prop_assert!(current_a.abs() <= 42.6);
            prop_assert!(drive.state().has_torque() || current_a == 0.0);
            drive.receive(step * 400, bytes);
        }
    }
}

/// One exchange per step on a drive with an ideal current loop, while the angle grows.
fn drive_with_delays(command_steps: u32, sensor_steps: u32) -> (AxisSettings, Drive) {
    let mut settings = UnitSettings::default().az;
    settings.command_delay_s = 50e-6 * f64::from(command_steps);
    settings.sensor_delay_s = 50e-6 * f64::from(sensor_steps);
    (settings.delay_jitter_s, settings.current_noise_a, settings.current_bandwidth_hz) = (0.0, 0.0, 0.0);
    let address = SeedAddress { seed: 1, procedure: "TEST".into(), point: "1".into() };
    let mut drive = Drive::new("az", 7, &settings, &address, growing(0), 40.0, 50e-6);
    drive.map().expect("default mapping");
    drive.set_bus_state(BusState::Op);
    drive.enter(State::OperationEnabled);
    (settings, drive)
}

fn growing(step: u64) -> f64 {
    0.25 + 1e-6 * step as f64
}

/// A command of step 20 flows from the instant `20 + command delay` on; whoever looks then sees what was just before,
/// and the step after is the first whose sample holds it. What is sent is that sample, a sensor delay later: current
/// and position of one message are of one instant.
#[test]
fn current_and_position_are_sent_exactly_the_sensor_delay_later() {
    for (command_steps, sensor_steps) in [(0, 0), (0, 1), (3, 2), (17, 25)] {
        let (settings, mut drive) = drive_with_delays(command_steps, sensor_steps);
        let mut encoder = Encoder::new(&settings);
        let mut seen = None;
        for step in 0..120_u64 {
            drive.send(step, growing(step), &mut [0; 14]);
            if step >= u64::from(sensor_steps) {
                let counts = encoder.counts(growing(step - u64::from(sensor_steps))) as i32;
                assert_eq!(drive.upload(0x6064, 0), Ok(counts.to_le_bytes().to_vec()), "step {step}");
            }
            if drive.upload(0x6077, 0) != Ok(vec![0, 0]) {
                seen = seen.or(Some(step));
            }
            let torque = if step >= 20 { 100 } else { 0 };
            drive.receive(step, &[0x0F, 0, torque, 0, 0, 0, 0, 0, 10, 0]);
            drive.current_a(step, growing(step));
        }
        assert_eq!(seen, Some(20 + 1 + u64::from(command_steps + sensor_steps)), "{sensor_steps} steps");
    }
}

/// An axis that stands: the counts that are sent scatter by the noise of the encoder, and not without it.
#[test]
fn noise_of_the_encoder_is_in_the_position_that_is_sent_and_new_with_each_sample() {
    let address = SeedAddress { seed: 1, procedure: "TEST".into(), point: "1".into() };
    let count_rad = std::f64::consts::TAU / f64::from(1 << 26);
    let counts = |noise_rad: f64| -> Vec<f64> {
        let axis = AxisSettings { encoder_noise_rad: noise_rad, ..UnitSettings::default().az };
        let mut drive = Drive::new("az", 7, &axis, &address, 0.25, 40.0, 50e-6);
        let mut sent = |step: u64| {
            drive.refresh(100 + step, 0.25);
            drive.dictionary.get(at::POSITION) as f64
        };
        (0..2000).map(&mut sent).collect()
    };
    let spread = |counts: Vec<f64>| {
        let mean = counts.iter().sum::<f64>() / 2000.0;
        (counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / 2000.0).sqrt() * count_rad
    };
    assert_eq!(spread(counts(0.0)), 0.0);
    // 2000 values: 1.6 % is a standard error.
    let found = spread(counts(2e-6));
    assert!((found / 2e-6 - 1.0).abs() < 0.065, "{found}");
}
