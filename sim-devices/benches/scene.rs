//! What target, atmosphere and cameras cost: items per second are World steps.

use std::time::Duration;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use drivers::tracker::LENGTH;
use drivers::wire::DatagramPort;
use sim_devices::motion::Motion;
use sim_devices::rig::SeedAddress;
use sim_devices::scene::Scene;
use sim_devices::unit::UnitSettings;

/// One second.
const STEPS: u32 = 20_000;

fn main() {
    divan::main();
}

/// 20 kHz steps with both cameras, whose messages are taken once a millisecond; target 0 star, 1 rail, 2 drone.
#[divan::bench(args = [0.0, 1.0, 2.0])]
fn scene_steps(bencher: Bencher<'_, '_>, target: f64) {
    let mut unit = UnitSettings::default();
    unit.target.kind_count = target;
    let address = SeedAddress { seed: 1, procedure: "BENCH".into(), point: "1".into() };
    let mut scene = Scene::new(&unit, &address);
    let mut step = 0_u64;
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        for _ in 0..STEPS {
            let now = Duration::from_nanos(50_000 * step);
            scene.advance(black_box(now), &Motion::default(), [0.0; 2]);
            if step.is_multiple_of(20) {
                take_all(&mut scene, now);
            }
            step += 1;
        }
    });
}

fn take_all(scene: &mut Scene, now: Duration) {
    let mut bytes = [0; LENGTH];
    while let Ok(Some(_)) = scene.coarse_port().receive(now, &mut bytes) {
        black_box(&bytes);
    }
    while let Ok(Some(_)) = scene.fine_port().receive(now, &mut bytes) {
        black_box(&bytes);
    }
}
