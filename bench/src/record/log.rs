//! What a log says beside its rows: how it and its attachments are called, and what its devices make of it.

use procedures::log::Attachment;
use reports::record::{DeviceRecord, Origin};

/// How the name of a log ends.
pub(crate) const SUFFIX: &str = ".mcap";
/// Stem of the log of the time between points, where a session was kept; further ones are numbered from 2 on.
pub(crate) const SESSION: &str = "session";

/// Attachment with the procedure.
pub(crate) const PROCEDURE: &str = "procedure.toml";
/// Attachment with the requirements.
pub(crate) const REQUIREMENTS: &str = "requirements.toml";
/// Attachment with the rig.
pub(crate) const RIG: &str = "rig.toml";
/// Attachment with the build state of the unit; a log of the final state has none.
pub(crate) const STATE: &str = "state.toml";
/// Attachment with the devices that a log was measured with, as they identified themselves.
pub(crate) const DEVICES: &str = "devices.json";
/// Attachment with the external velocity laws of a run; a log of built-in laws has none.
pub(crate) const LAWS: &str = "laws.json";
/// Attachment with the worst cases that were computed before the run; a log of a procedure that moves nothing has none.
pub(crate) const COMPUTED: &str = "computed.json";

/// Name of the attachment with a unit file: 0 is the top layer, which the others lie below.
pub(crate) fn unit_layer(layer: usize) -> String {
    format!("unit.{layer}.toml")
}

/// An attachment.
pub(crate) fn attachment(name: &str, text: &str) -> Attachment {
    Attachment { name: name.to_owned(), text: text.to_owned() }
}

/// Real, simulated or mixed, from what is proven of each device.
pub(crate) fn origin(devices: &[DeviceRecord]) -> Origin {
    match devices.iter().filter(|d| d.proven_real).count() {
        0 => Origin::Simulated,
        real if real == devices.len() => Origin::Real,
        _ => Origin::Mixed,
    }
}

/// The word in the plan of a log that another tool made.
pub(crate) const IMPORTED: &str = "imported";

/// The word in a log's plan for what its devices make it.
pub(crate) fn mode_of(origin: Origin) -> &'static str {
    match origin {
        Origin::Real => "real",
        Origin::Mixed => "mixed",
        Origin::Simulated => "simulated",
        Origin::Imported => IMPORTED,
    }
}
