//! `bench devices`: who is there. Nothing moves.

use sim_devices::rig::{SeedAddress, SimulatedRig, StartState};

use super::check::On;
use super::output;
use crate::clock::Clock;
use crate::exit;
use crate::rig::OpenRig;
use crate::wires::Wires;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    #[command(flatten)]
    on: On,
}

pub(super) fn run(args: &Args) -> u8 {
    let (rig, unit) = match args.on.load() {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    let address = SeedAddress { seed: 0, procedure: "devices".to_owned(), point: String::new() };
    let start = StartState { az_rad: 0.0, el_rad: 0.0, heat_sink_degc: unit.settings.az.ambient_degc };
    let simulated = SimulatedRig::new(&unit.settings, &address, start);
    let gains = match crate::files::parameters::load(&rig) {
        Ok(gains) => gains,
        Err(mistakes) => return output::mistakes(&mistakes),
    };
    match OpenRig::open(Wires::simulated(&simulated), &rig, &gains, &Clock::Virtual) {
        Ok(open) => {
            for device in crate::devices::records(&rig, &open) {
                let what = if device.real { "real" } else { "simulated" };
                output::say(&format!("{}: {}\n  {what}: {}", device.name, device.identity, device.grounds));
            }
            exit::PASS
        }
        Err(error) => {
            output::error(&error.to_string());
            exit::BENCH
        }
    }
}
