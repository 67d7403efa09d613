//! Where runs happen: whoever opens a rig.
//!
//! Whoever runs, rehearses, inspects or lists devices asks a site to open the rig, and does not know whether its devices
//! exist.

use std::collections::BTreeMap;

use controllers::DirectorGains;
use drivers::device::DeviceError;
use procedures::case::Case;

use crate::clock::Clock;
use crate::model::rig::{Rig, Tier};
use crate::rig::OpenRig;
pub use crate::rig::identities::{BusGrounds, LineGrounds};
use crate::rig::wires::Ports;
use crate::site::unit::Unit;

mod can;
mod far_lines;
pub mod interface;
pub(crate) mod lines;
pub mod order;
mod paced;
mod simulated;
mod teller;
mod terminal;
pub mod unit;
mod unit_for_case;
mod r#virtual;
mod wire_faults;
mod wired;

pub(crate) use far_lines::{FarEnd, FarLine};
pub use paced::PacedSite;
pub(crate) use simulated::{FarBus, FarWorld, Units, check_scenery};
pub use teller::{path_for, tell};
pub(crate) use unit_for_case::sim_unit_for_case;
pub use r#virtual::VirtualSite;
pub use wire_faults::WireFaults;
pub use wired::{OnWire, WiredSite};

/// The site that a rig's tier asks for, with this unit. `built` is the unit in the build state of each stage, `None` where
/// that is the final one.
pub fn site<'a>(rig: &Rig, unit: &'a Unit, built: &'a [Option<Unit>]) -> Box<dyn Site + 'a> {
    match rig.tier {
        Tier::Virtual => Box::new(VirtualSite::new(unit, built)),
        Tier::Paced => Box::new(PacedSite::new(unit, built)),
        Tier::Wired | Tier::Hardware => Box::new(WiredSite::default()),
    }
}

/// Where runs happen.
pub trait Site: Send + Sync {
    /// Whether one session serves a whole run; otherwise every point has one of its own.
    fn keeps_session(&self) -> bool;

    /// Opens every device of a rig, in the thread that will tick. Nothing can move yet.
    ///
    /// # Errors
    /// The first device that is missing, does not answer, refuses a setting or reads back something else.
    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Opened, DeviceError>;

    /// Opens the serial ports, sockets and datagram ports of a rig alone; in process, its analog card too. Nothing is said to any
    /// device.
    ///
    /// # Errors
    /// The first line that is missing, refused or in use.
    fn open_ports(&self, rig: &Rig, purpose: &Purpose<'_>) -> Result<OpenedPorts, DeviceError>;

    /// Faults that are planted on its wires. They begin when it is known that none of its devices may be real.
    fn wire_faults(&self) -> Option<&WireFaults> {
        None
    }
}

/// What a session is opened for. A site whose devices exist reads nothing of it.
#[derive(Clone, Debug, Default)]
pub struct Purpose<'a> {
    /// Seed of everything random.
    pub seed: u64,
    /// Procedure, or the word for what is done instead of one, e.g. `identify`.
    pub procedure: &'a str,
    /// The point that is measured; `None` where nothing moves.
    pub case: Option<&'a Case>,
    /// Stage whose build state the unit is in; `None` for the final one.
    pub stage: Option<usize>,
    /// How long after the beginning of the campaign this begins, by the plan: what a campaign warms up is warm by then.
    pub planned_s: f64,
    /// Where the axes stand, by name; an axis that is not named stands at 0.
    pub pose_rad: BTreeMap<String, f64>,
}

/// A rig whose devices are open, and what is around it.
pub struct Opened {
    /// Name of the bus of its drives.
    pub bus: String,
    /// Whether there may be hardware at the far end of that bus.
    pub grounds: BusGrounds,
    /// The rig.
    pub rig: OpenRig,
    /// The clock that it is ticked by.
    pub clock: Clock,
    /// What is around it.
    pub surroundings: Box<dyn Surroundings>,
}

/// Ports of a rig whose drives were not spoken to.
pub struct OpenedPorts {
    /// The ports.
    pub ports: Ports,
    /// The clock that they are polled by.
    pub clock: Clock,
    /// Whether there may be hardware behind them.
    pub lines: Vec<LineGrounds>,
}

/// What is around a rig, and no device tells or brings.
pub trait Surroundings {
    /// Contacts with end stops so far.
    fn contacts(&self) -> Vec<Contact>;

    /// Brings what a point asks for beside the rig: its target, whoever pulls. Where people do that, prompts ask them.
    fn bring(&mut self, case: &Case);
}

/// An axis that met an end stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Axis.
    pub axis: String,
    /// Time of the session.
    pub at_s: f64,
    /// Speed of the axis.
    pub speed_rad_per_s: f64,
}
