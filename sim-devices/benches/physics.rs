//! How fast friction, world and bus are: items per second are steps, axis steps and exchanges.

use std::time::Duration;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use drivers::wire::BusState;
use sim_devices::physics::lugre::{Contact, LuGre};
use sim_devices::physics::supply::Supply;
use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::{SupplySettings, UnitSettings};
use sim_devices::world::World;

const STEPS: u32 = 20_000;

fn main() {
    divan::main();
}

fn start() -> StartState {
    StartState { az_rad: 0.1, el_rad: 1.0, heat_sink_degc: 40.0 }
}

/// LuGre alone at an oscillating velocity, amplitude in rad/s: 0.05 stays in the Stribeck range, 1 mostly above it.
#[divan::bench(args = [0.05, 1.0])]
fn lugre_steps(bencher: Bencher<'_, '_>, amplitude_rad_per_s: f64) {
    let law = LuGre::new(&UnitSettings::default().az, 50e-6);
    let velocities: Vec<f64> =
        (0..STEPS).map(|k| amplitude_rad_per_s * (f64::from(k) * 3e-4).sin()).collect();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut contact = Contact::default();
        velocities.iter().map(|&velocity| law.advance(&mut contact, black_box(velocity))).sum::<f64>()
    });
}

/// Both axes sliding back and forth under a torque that changes every step.
#[divan::bench]
fn world_axis_steps(bencher: Bencher<'_, '_>) {
    let mut world = World::new(&UnitSettings::default(), start());
    bencher.counter(ItemsCount::new(2 * STEPS)).bench_local(|| {
        for k in 0..STEPS {
            let torque = 400.0 * (f64::from(k) * 3.14e-4).cos();
            world.axes.iter_mut().for_each(|axis| axis.step(black_box(torque)));
        }
    });
}

/// The DC link under a load that changes every step.
#[divan::bench]
fn supply_steps(bencher: Bencher<'_, '_>) {
    let mut supply = Supply::new(&SupplySettings::default(), 50e-6);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        (0..STEPS).map(|k| supply.step(black_box(f64::from(k % 8000) - 3000.0))).sum::<f64>()
    });
}

/// The other extreme: both axes stand.
#[divan::bench]
fn standing_axis_steps(bencher: Bencher<'_, '_>) {
    let mut world = World::new(&UnitSettings::default(), start());
    (0..2_000_000).for_each(|_| world.axes.iter_mut().for_each(|axis| axis.step(0.0)));
    bencher.counter(ItemsCount::new(2 * STEPS)).bench_local(|| {
        (0..STEPS).for_each(|_| world.axes.iter_mut().for_each(|axis| axis.step(black_box(0.0))));
    });
}

/// A tick of the whole rig: 5 world steps of both axes, both drives following torque commands.
#[divan::bench]
fn exchanges(bencher: Bencher<'_, '_>) {
    let address = SeedAddress { seed: 1, procedure: "BENCH".into(), point: "1".into() };
    let rig = SimulatedRig::new(&UnitSettings::default(), &address, start());
    let mut bus = rig.bus();
    let (mut image, slots) = bus.map().expect("the default mapping is valid");
    bus.request(BusState::Op);
    let mut tick = 0_u32;
    bencher.counter(ItemsCount::new(4000_u32)).bench_local(|| {
        for _ in 0..4000 {
            let controlword: u16 = [6, 7, 15][(tick / 200).min(2) as usize];
            let permille = (3000.0 * (f64::from(tick) * 1.5e-3).cos()) as i16;
            for (_, slot) in &slots {
                let outputs = &mut image.outputs[slot.outputs.clone()];
                outputs[..2].copy_from_slice(&controlword.to_le_bytes());
                outputs[2..4].copy_from_slice(&permille.to_le_bytes());
                outputs[8] = 10;
            }
            bus.exchange(Duration::from_micros(250) * tick, &mut image).expect("mapped");
            tick += 1;
        }
    });
}
