//! `bench monitor`: the channels of one device, live. Nothing moves: no drive is spoken to unless the device hangs on their bus,
//! and then the bus goes no further than SAFE-OP.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::Duration;

use drivers::device::DeviceError;
use procedures::device::DeviceRole;
use procedures::quantity::QuantityKind;
use procedures::table::suggestion;

use super::options::On;
use super::output;
use crate::cycle::run::STOP_CODE;
use crate::exit;
use crate::model::device::DeviceEntry;
use crate::model::rig::{Rig, Tier};
use crate::people::lock::{self, Claim, Holder, LockError};
use crate::people::signals;
use crate::rig::devices;
use crate::site::unit::Unit;
use crate::site::{PacedSite, Site};

mod page;
mod watch;

use page::Page;
use watch::{Seen, Watched};

#[derive(clap::Args, Debug)]
#[command(
    after_help = "Ends with Ctrl-C (exit 130) or after --for (exit 0). Instruments that are given tasks, such as an \
                        oscilloscope, have no values between them: `bench devices` shows who they are."
)]
pub(super) struct Args {
    /// Name of the device in the rig file
    device: String,
    #[command(flatten)]
    on: On,
    /// End after this time
    #[arg(long = "for", value_name = "TIME", value_parser = time)]
    lasts: Option<Duration>,
    /// Time between two outputs
    #[arg(long, value_name = "TIME", default_value = "1 s", value_parser = time)]
    every: Duration,
    /// Print each output as a JSON object on a line of its own
    #[arg(long)]
    json: bool,
}

/// Shortest and longest time that can be asked for.
const TIMES_S: [f64; 2] = [0.05, 86_400.0];

fn time(text: &str) -> Result<Duration, String> {
    let expected = "expected a time from 50 ms to 24 h, e.g. `5 s`";
    let time_s = QuantityKind::Time.parse(text).map_err(|error| format!("{error}; {expected}"))?;
    if (TIMES_S[0]..=TIMES_S[1]).contains(&time_s) {
        return Ok(Duration::from_secs_f64(time_s));
    }
    Err(expected.to_owned())
}

pub(super) fn run(args: &Args) -> u8 {
    monitor(args).unwrap_or_else(|code| code)
}

fn monitor(args: &Args) -> Result<u8, u8> {
    let stop = signals::listen(|_| {}).map_err(|error| {
        output::error(&format!("signals: {error}; raise the limit of processes (`ulimit -u`)"));
        exit::BENCH
    })?;
    let (rig, unit) = args.on.load()?;
    let entry = find(&rig, &args.device)?;
    // The others are left alone, so that a rig of which only this device is connected can be looked at.
    let rig = rig.with_only(&entry);
    let needs_bus = needs_bus(&rig, &entry);
    let held = claim(&rig, &args.device, needs_bus);
    let _held = held.map_err(|error| {
        output::error(&error.to_string());
        exit::REFUSED
    })?;
    signals::begin(&stop)?;
    let watched = open(&rig, &unit, needs_bus).and_then(|mut watched| {
        let page = Page::new(&mut watched, &entry, args.json, std::io::stdout().is_terminal());
        watch(args, watched, page, &stop)
    });
    watched.map_err(|error| {
        output::error(&error.to_string());
        exit::BENCH
    })?;
    Ok(signals::exit_code(&stop))
}

/// The device of this name, if it has values of its own.
fn find(rig: &Rig, name: &str) -> Result<DeviceEntry, u8> {
    let Some(entry) = rig.devices.iter().find(|entry| entry.name == name) else {
        let known = rig.devices.iter().map(|entry| entry.name.as_str());
        output::error(&format!("rig `{}` has no device `{name}`; {}", rig.id, suggestion(name, known)));
        return Err(exit::USAGE);
    };
    if devices::closed(&rig.with_only(entry)).devices.is_empty() {
        output::error(&format!(
            "`{name}` (driver `{}`) is given tasks and has no values between them; `bench devices` shows who it is",
            entry.driver
        ));
        return Err(exit::USAGE);
    }
    Ok(entry.clone())
}

/// Whether a device says nothing unless the bus of the drives is exchanged with: what hangs on a terminal of a wire, and an
/// inertial unit without a rate of its own, of which each tick triggers a message.
fn needs_bus(rig: &Rig, entry: &DeviceEntry) -> bool {
    let is_on_terminal = rig.tier.is_wired() && entry.lines().count() < entry.ports.len();
    let is_triggered =
        entry.role == Some(DeviceRole::InertialUnit) && entry.optional_number("data-rate").is_none();
    is_on_terminal || is_triggered
}

/// Claims what must be held while somebody looks: the lines of the device, and the bus where it hangs on that.
fn claim(rig: &Rig, device: &str, needs_bus: bool) -> Result<Claim, LockError> {
    let verb = format!("monitor {device}");
    match needs_bus {
        true => lock::claim_wires(rig, &verb),
        false => lock::claim(&lock::system_folder(), &lock::lines(rig), &Holder::verb(&verb)),
    }
}

fn open(rig: &Rig, unit: &Unit, needs_bus: bool) -> Result<Watched, DeviceError> {
    let gains = match needs_bus {
        true => crate::files::parameters::load(rig).map_err(|mistakes| DeviceError::Bus {
            device: format!("rig `{}`", rig.id),
            reason: mistakes.first().map_or(String::new(), ToString::to_string),
        })?,
        false => return Watched::lines(&*site(rig, unit), rig),
    };
    Watched::bus(&*site(rig, unit), rig, &gains)
}

/// Where the device is opened. Virtual time would pass at once, so a rig of the virtual tier is looked at as a paced one.
fn site<'a>(rig: &Rig, unit: &'a Unit) -> Box<dyn Site + 'a> {
    match rig.tier {
        Tier::Virtual => Box::new(PacedSite::new(unit, &[])),
        _ => crate::site::site(rig, unit, &[]),
    }
}

/// Polls the device at the rate of the rig and shows it, until it is stopped.
fn watch(args: &Args, mut watched: Watched, mut page: Page, stop: &AtomicU16) -> Result<(), DeviceError> {
    let start = watched.now();
    let end = args.lasts.map(|lasts| start + lasts);
    let mut seen = Seen::begin(&mut watched, &args.device);
    let mut due = start + args.every;
    while stop.load(Ordering::Relaxed) & STOP_CODE == 0 {
        let now = watched.tick()?;
        seen.look(&mut watched, &args.device, now);
        let is_over = end.is_some_and(|end| now >= end);
        if now >= due || is_over {
            page.show(&seen.report(&mut watched, &args.device, now));
            while due <= now {
                due += args.every;
            }
        }
        if is_over {
            return Ok(());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_has_a_unit_and_a_length_that_can_be_waited_for() {
        assert_eq!(time("5 s"), Ok(Duration::from_secs(5)));
        assert_eq!(time("200 ms"), Ok(Duration::from_millis(200)));
        for text in ["5", "0 s", "-1 s", "1 us", "48 h", ""] {
            let error = time(text).expect_err(text);
            assert!(error.contains("50 ms to 24 h"), "{error}");
        }
    }
}
