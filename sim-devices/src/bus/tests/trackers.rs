use super::*;
use crate::payload::DeviceTypes;
use drivers::tracker::{LENGTH, Sample, Source, decode};
use drivers::wire::DatagramPort;

/// What both trackers say about a second in which the mirror swings, on a bus that advances so many steps at a time.
fn samples(steps_at_a_time: usize) -> Vec<(Source, Sample)> {
    let mut unit = UnitSettings::default();
    unit.target.elevation_rad = start().el_rad;
    let mut bus = DirectorBus::of_director(&unit, &address(1), start(), 4000.0, DeviceTypes::default());
    for step in (0..=20_000).step_by(steps_at_a_time) {
        bus.advance_to(Duration::from_micros(50 * step));
        if step % 400 == 0 {
            let volts = if step % 800 == 0 { 0.3 } else { -0.3 };
            (0..2).for_each(|axis| bus.plant.payload.mirror.command_analog_v(axis, volts));
        }
    }
    let mut said = Vec::new();
    let scene = &mut bus.plant.payload.scene;
    let late = Duration::from_secs(10);
    let mut bytes = [0; LENGTH];
    while scene.coarse_port().receive(late, &mut bytes) == Ok(Some(LENGTH)) {
        said.push(decode(&bytes).expect("a whole message"));
    }
    while scene.fine_port().receive(late, &mut bytes) == Ok(Some(LENGTH)) {
        said.push(decode(&bytes).expect("a whole message"));
    }
    said
}

/// Shutters open at 50 µs and 0.5 ms after the frame's start, between the exchanges of every 250 µs.
#[test]
fn a_camera_sees_the_mirror_as_it_is_at_the_shutter_however_rarely_the_host_looks() {
    let every_step = samples(1);
    assert_eq!(every_step.len(), 50 + 200);
    assert!(every_step.iter().all(|(_, sample)| sample.is_valid()), "the target is in sight");
    assert_eq!(samples(5), every_step);
    assert_eq!(samples(400), every_step);
}
