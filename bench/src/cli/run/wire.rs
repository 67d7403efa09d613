//! What a run has on its EtherCAT interface: a tap and faults.

use std::path::{Path, PathBuf};

use super::super::output;
use super::wire_fault::{AskedFault, FORM, wire_fault};
use crate::exit;
use crate::model::rig::{Rig, Tier};
use crate::record::tap::{Format, TapCounts, WireTap};
use crate::site::interface::Kernel;
use crate::site::{OnWire, WireFaults};

#[derive(clap::Args, Debug)]
pub(super) struct WireArgs {
    /// Write every EtherCAT frame to this new file: `.pcapng` for Wireshark, `.mcap` to lie beside the logs; may be given
    /// twice. Only on rigs with wires of their own
    #[arg(long, value_name = "FILE")]
    tap: Vec<PathBuf>,
    /// Plant a fault on the wire, e.g. `back:drop@0.001`, `out:delay=300us@1000x3`; may be repeated. Refused where a
    /// device is real
    #[arg(long, value_name = "FAULT", value_parser = wire_fault, long_help = FORM)]
    wire_fault: Vec<AskedFault>,
}

/// What a run has on its interface, until it is over.
#[derive(Default)]
pub(super) struct RunWire {
    tap: Option<WireTap>,
    faults: Option<WireFaults>,
}

impl WireArgs {
    /// Refuses what cannot be; no file is made yet.
    pub(super) fn check(&self, rig: &Rig) -> Result<(), u8> {
        if !self.wire_fault.is_empty() {
            let option = format!("--wire-fault {}", self.wire_fault[0].text);
            let name = interface(rig, &option)?;
            // Not a frame goes to what may be hardware. Who is there is asked once more before the faults begin.
            if Kernel::default().interface(name).is_ok_and(|found| found.is_physical) {
                output::error(&format!(
                    "refused before motion: {option}: interface {name} has a physical device, and faults are planted on \
                     wires to simulated devices only; leave out --wire-fault"
                ));
                return Err(exit::REFUSED);
            }
        }
        for (k, path) in self.tap.iter().enumerate() {
            let option = format!("--tap {}", path.display());
            interface(rig, &option)?;
            let format = Format::of(path);
            let wrong = if format.is_none() {
                "expected a name that ends with `.pcapng` or `.mcap`"
            } else if self.tap[..k].iter().any(|other| Format::of(other) == format) {
                "expected one file of each format; leave one out"
            } else if path.symlink_metadata().is_ok() {
                "the file exists, and nothing is overwritten; choose another name"
            } else {
                continue;
            };
            output::error(&format!("{option}: {wrong}"));
            return Err(exit::USAGE);
        }
        Ok(())
    }

    /// Begins the files of the tap.
    pub(super) fn open(&self, rig: &Rig, seed: u64, folder: &Path) -> Result<RunWire, u8> {
        for path in &self.tap {
            if lies_in(path, folder) {
                output::error(&format!(
                    "--tap {}: a tap is no evidence and cannot lie in the run folder; choose another place",
                    path.display()
                ));
                return Err(exit::USAGE);
            }
        }
        let tap = match rig.interface() {
            Some(interface) if !self.tap.is_empty() => {
                Some(WireTap::create(&self.tap, interface).map_err(|why| {
                    output::error(&format!("--tap {why}; check folder, rights and free disk space"));
                    exit::BENCH
                })?)
            }
            _ => None,
        };
        let asked = self.wire_fault.iter().map(|fault| fault.text.clone()).collect();
        let faults = self.wire_fault.iter().map(|fault| fault.fault).collect();
        let faults = (!self.wire_fault.is_empty()).then(|| WireFaults::new(seed, asked, faults));
        Ok(RunWire { tap, faults })
    }
}

/// The interface of a rig that has one.
fn interface<'a>(rig: &'a Rig, option: &str) -> Result<&'a str, u8> {
    let tier = match rig.tier {
        Tier::Wired | Tier::Hardware => None,
        Tier::Virtual => Some("virtual"),
        Tier::Paced => Some("paced"),
    };
    let wrong = match (tier, rig.interface()) {
        (None, Some(name)) if rig.can.is_some() => format!("its drives are on the CAN bus {name}"),
        (None, Some(name)) => return Ok(name),
        (None, None) => "its drives have no network interface".to_owned(),
        (Some(tier), _) => format!("its tier is {tier}, whose frames pass no interface"),
    };
    output::error(&format!(
        "{option}: expected a rig of tier wired or hardware with an EtherCAT interface; rig `{}`: {wrong}; leave out the \
         option or choose another --rig",
        rig.id
    ));
    Err(exit::USAGE)
}

/// Whether a new file would lie in a folder, whatever links lead there.
fn lies_in(path: &Path, folder: &Path) -> bool {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (parent.canonicalize(), folder.canonicalize()) {
        (Ok(parent), Ok(folder)) => parent.starts_with(folder),
        _ => false,
    }
}

impl RunWire {
    /// What the site puts on its interface.
    pub(super) fn on_wire(&self) -> OnWire<'_> {
        OnWire { tap: self.tap.as_ref(), faults: self.faults.as_ref() }
    }

    /// Closes the files and tells what became of the frames; the exit code with that.
    pub(super) fn finish(self, code: u8) -> u8 {
        if let Some(faults) = &self.faults {
            output::note(&faults.told());
        }
        match self.tap.map(WireTap::finish) {
            None => code,
            Some(Ok(TapCounts { frames, lost: 0 })) => {
                output::note(&format!("tap: {frames} frames"));
                code
            }
            Some(Ok(TapCounts { frames, lost })) => {
                output::note(&format!(
                    "tap: {frames} frames; {lost} are missing, because the disk was too slow: write to a faster one"
                ));
                code
            }
            Some(Err(why)) => {
                output::error(&format!("tap: {why}; the frames after it are missing"));
                exit::worse(code, exit::BENCH)
            }
        }
    }
}
