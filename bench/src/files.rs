//! Readers of the files that people write about the bench: rigs, units, controller parameters, import maps.

pub mod answers;
pub mod bounded;
pub mod import_map;
pub mod parameters;
pub mod rig;
pub mod settings;
pub mod shipped;
pub mod unit;
pub mod waivers;
