//! A simulated rig: the world and the far ends of all its wires.

use crate::unit::UnitSettings;
use drivers::wire::Fieldbus;

/// Address of a random stream: never by draw order, always by place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeedAddress {
    /// Seed of the run.
    pub seed: u64,
    /// Id of the procedure.
    pub procedure: String,
    /// Name of the point.
    pub point: String,
}

/// Where the world stands, at rest, when a point begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartState {
    /// Azimuth angle.
    pub az_rad: f64,
    /// Elevation angle.
    pub el_rad: f64,
    /// Heat sink temperature of both drives.
    pub heat_sink_degc: f64,
}

/// What really happened in the world, for the operator's eyes after a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldRecord {
    /// End-stop contacts: axis, time s, speed rad/s.
    pub crashes: Vec<(String, f64, f64)>,
}

/// World, drives and bus of one simulated director.
pub struct SimulatedRig {
    _todo: (),
}

impl SimulatedRig {
    /// A unit at rest, bristles relaxed, drives switched on but not enabled.
    pub fn new(unit: &UnitSettings, address: &SeedAddress, start: StartState) -> Self {
        let _ = (unit, address, start);
        todo!()
    }

    /// A handle to the one bus that carries both drives: station 1 azimuth, station 2 elevation.
    pub fn bus(&self) -> Box<dyn Fieldbus> {
        todo!()
    }

    /// What happened so far.
    pub fn record(&self) -> WorldRecord {
        todo!()
    }
}
