//! `bench devices`: who is there. Nothing moves.

use super::options::On;
use super::output;
use crate::exit;
use crate::site::{Purpose, site};

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
    let gains = match crate::files::parameters::load(&rig) {
        Ok(gains) => gains,
        Err(mistakes) => return output::mistakes(&mistakes),
    };
    let purpose = Purpose { procedure: "devices", ..Purpose::default() };
    match site(&rig, &unit, &[]).open(&rig, &gains, &purpose) {
        Ok(session) => {
            for device in crate::rig::identities::records(&rig, &session.rig, &session.grounds) {
                let what = if device.may_be_real { "real" } else { "simulated" };
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
