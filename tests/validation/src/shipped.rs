//! Shipped files as the values that they stand for.

use bench::files::parameters;
use bench::files::unit::load_unit;
use controllers::DirectorGains;
use sim_devices::unit::UnitSettings;

/// Settings of a shipped director.
///
/// # Panics
/// When no unit of this name is shipped, its file has a mistake, or it is no director.
pub fn director(name: &str) -> UnitSettings {
    let unit = load_unit(name).expect("a shipped unit");
    unit.director().expect("a director").clone()
}

/// Gains of the director's production controllers.
///
/// # Panics
/// When the shipped parameters have a mistake.
pub fn gains() -> DirectorGains {
    parameters::named("director", None).expect("shipped parameters").1
}
