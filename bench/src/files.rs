//! Readers of the files that people write about the bench: rigs, units and families of them, controller parameters, import maps.

pub(crate) mod answers;
pub mod family;
pub(crate) mod import_map;
pub mod parameters;
pub mod profile;
pub mod reader;
pub mod rig;
pub(crate) mod settings;
pub mod shipped;
pub mod unit;
pub(crate) mod waivers;
