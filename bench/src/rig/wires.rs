//! The host's ends of all wires of a rig.

use drivers::wire::Fieldbus;

use super::device::Ports;

/// All wires.
pub struct Wires {
    /// The bus of the drives.
    pub bus: Box<dyn Fieldbus>,
    /// What devices and instruments hang on.
    pub ports: Ports,
}
