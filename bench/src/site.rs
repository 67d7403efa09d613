//! Where runs happen: a factory of sessions with a rig.
//!
//! Whoever runs, rehearses, inspects or lists devices asks a site to open the rig, and does not know whether its devices
//! exist.

use std::collections::BTreeMap;

use controllers::DirectorGains;
use drivers::device::DeviceError;
use procedures::case::Case;

use crate::clock::Clock;
use crate::model::rig::Rig;
use crate::rig::OpenRig;

mod unit_for_case;
mod r#virtual;

pub use unit_for_case::sim_unit_for_case;
pub use r#virtual::{VirtualSite, check_scenery};

/// Where runs happen.
pub trait Site: Send + Sync {
    /// The clock that its sessions run on.
    fn clock(&self) -> Clock;

    /// Opens every device of a rig, in the thread that will tick. Nothing can move yet.
    ///
    /// # Errors
    /// The first device that is missing, does not answer, refuses a setting or reads back something else.
    fn open(&self, rig: &Rig, gains: &DirectorGains, purpose: &Purpose<'_>) -> Result<Session, DeviceError>;
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
    /// Where the axes stand, by name; an axis that is not named stands at 0.
    pub pose_rad: BTreeMap<String, f64>,
}

/// A rig whose devices are open, and who sees what happens to it.
pub struct Session {
    /// Name of the bus of its drives.
    pub bus: String,
    /// The rig.
    pub rig: OpenRig,
    /// Sees what happens to it.
    pub witness: Box<dyn Witness>,
}

/// Who sees what happens to a rig without any device telling it.
pub trait Witness {
    /// Contacts with end stops so far.
    fn contacts(&self) -> Vec<Contact>;
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
