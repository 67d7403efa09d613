//! The mirror has no watchdog: the bench brings it to its middle.

use std::time::Duration;

use bench::clock::Clock;
use bench::cycle::safe::{Exit, make_safe};
use bench::cycle::stops::Stops;
use bench::files::parameters;
use bench::rig::OpenRig;
use bench::rig::wires::Wires;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use super::bed::rig;

const TICK: Duration = Duration::from_micros(250);

#[test]
fn the_mirror_is_back_in_its_middle_within_100_ms_of_the_end() {
    let address = SeedAddress { seed: 1, procedure: "TEST".to_owned(), point: "one".to_owned() };
    let start = StartState { az_rad: 0.0, el_rad: 0.7, heat_sink_degc: 40.0 };
    let simulated = SimulatedRig::new(&UnitSettings::default(), &address, start);
    let rig = rig(&[]);
    let gains = parameters::load(&rig).expect("shipped parameters");
    let mut armed = OpenRig::open(Wires::simulated(&simulated), &rig, &gains, &Clock::Virtual)
        .and_then(|rig| rig.arm(&Clock::Virtual))
        .expect("a healthy rig");
    let mut now = armed.ready();
    armed.devices_mut().command_mirror([5e-4, -5e-4]);
    for _ in 0..4000 {
        armed.exchange(now);
        now += TICK;
    }
    let mut card = simulated.analog_card();
    let mut gauge_v = |at| [0, 1].map(|k| card.read_v(at, k).expect("wired").abs());
    assert!(gauge_v(now).iter().all(|v| *v > 0.8), "tilted by half of its stroke");
    let exit = Exit { clock: &Clock::Virtual, from: now, period: TICK, open_loop: false };
    let mut after_100_ms = [f64::NAN; 2];
    make_safe(&mut armed, &exit, &mut Stops::new(2), |_, woken| {
        let at = woken.now;
        if at <= now + Duration::from_millis(100) {
            after_100_ms = gauge_v(at);
        }
    });
    // 500 µrad are 1 V: what is left is noise and what the servo settles.
    assert!(after_100_ms.iter().all(|v| *v < 0.02), "{after_100_ms:?} V");
}
