//! `bench devices`: who is there. Nothing moves.

use std::io::IsTerminal;

use reports::record::DeviceRecord;

use super::options::On;
use super::output;
use crate::exit;
use crate::model::rig::{Rig, Tier};
use crate::people::{console, lock};
use crate::site::{Opened, Purpose, Site, WiredSite, site};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    #[command(flatten)]
    on: On,
    /// Let drives go of the axes that they hold: only with the axes secured mechanically, and confirmed at the terminal
    #[arg(long)]
    let_go: bool,
}

/// What is typed to confirm that the axes are secured.
const PHRASE: &str = "axes secured";

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
    let site = match rig.tier {
        Tier::Wired | Tier::Hardware if args.let_go => {
            if let Err(reason) = confirm_secured() {
                output::error(&reason);
                return exit::REFUSED;
            }
            Box::new(WiredSite::default().with_axes_secured()) as Box<dyn Site>
        }
        _ => site(&rig, &unit, &[]),
    };
    let _claim = match lock::claim_wires(&rig, "devices") {
        Ok(claim) => claim,
        Err(error) => {
            output::error(&error.to_string());
            return exit::REFUSED;
        }
    };
    match site.open(&rig, &gains, &purpose) {
        Ok(session) => {
            tell(&rig, &session);
            exit::PASS
        }
        Err(error) => {
            output::error(&error.to_string());
            exit::BENCH
        }
    }
}

/// Who is there, where, and how it is set up: drives, then the devices in the order of the rig file. A device that cannot say who
/// it is has its driver's name.
fn tell(rig: &Rig, session: &Opened) {
    let records = crate::rig::identities::records(rig, &session.rig, &session.grounds);
    let configurations = session.rig.devices().configurations();
    let told = |record: &DeviceRecord| {
        let what = if record.may_be_real { "real" } else { "simulated" };
        format!("{}: {}\n  {what}: {}", record.name, record.identity, record.grounds)
    };
    let is_device = |record: &&DeviceRecord| rig.devices.iter().any(|entry| entry.name == record.name);
    records.iter().filter(|record| !is_device(record)).for_each(|drive| output::say(&told(drive)));
    for entry in &rig.devices {
        let text = match records.iter().find(|record| record.name == entry.name) {
            Some(record) => told(record),
            None => format!("{}: driver `{}`, no identity of its own", entry.name, entry.driver),
        };
        let setup = configurations.iter().find(|(name, _)| *name == entry.name);
        let setup = setup.map_or(String::new(), |(_, text)| format!("\n  configuration: {text}"));
        output::say(&format!("{text}\n  at: {}{setup}", entry.addresses()));
    }
}

/// Drives let go of axes only after somebody at the terminal has said that these are secured.
///
/// # Errors
/// What to do instead.
fn confirm_secured() -> Result<(), String> {
    if !std::io::stdin().is_terminal() || !std::io::stderr().is_terminal() {
        return Err(
            "`--let-go` is confirmed by somebody who stands at the rig: run it in a terminal".to_owned()
        );
    }
    console::note(&format!(
        "Drives of this line may hold axes, and will let go of them now.\nSecure all axes mechanically and leave the \
         area, then type `{PHRASE}`:"
    ));
    let mut line = String::new();
    let read = std::io::stdin().read_line(&mut line);
    if read.is_ok() && line.trim() == PHRASE {
        return Ok(());
    }
    Err(format!("expected `{PHRASE}`, found `{}`: nothing was opened", reports::printable::text(line.trim())))
}
