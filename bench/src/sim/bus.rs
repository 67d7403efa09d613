//! The bus of a served simulator: what comes is answered, and time passes at its stations.

mod can;
mod ethercat;

use std::io;
use std::time::Duration;

use crate::clock::Clock;
use crate::site::FarBus;
use crate::site::order::{NodeFault, WireFault};

use super::Report;

pub(super) use can::ServedCan;
pub(super) use ethercat::ServedEtherCat;

/// Something that an order lets go wrong on a bus, or puts right.
#[derive(Clone, Copy, Debug)]
pub(super) enum BusFault {
    /// Of EtherCAT.
    Wire(WireFault),
    /// Of a CAN bus.
    Node(NodeFault),
}

/// Why a fault of one bus cannot be injected on the other.
const OTHER_BUS: &str = "the drives of this rig are on another bus: `wire` faults are those of EtherCAT, `node` faults \
                         those of CAN";

/// A bus on an interface, whose stations are simulated.
pub(super) trait ServedBus {
    /// Time of the simulation.
    fn now(&self) -> Duration;

    /// Waits until something comes, or until an instant.
    ///
    /// # Errors
    /// When the interface is gone.
    fn wait(&mut self, until: Duration) -> io::Result<()>;

    /// When it has something to send, whatever comes.
    fn next_due(&self) -> Option<Duration> {
        None
    }

    /// Takes what has come, answers it, and lets time pass at the stations.
    ///
    /// # Errors
    /// When the interface is gone.
    fn exchange(&mut self, report: &mut Report) -> io::Result<()>;

    /// Something goes wrong from now on, or is put right.
    ///
    /// # Errors
    /// A fault that this bus, or its station, cannot have.
    fn inject(&mut self, now: Duration, fault: BusFault) -> Result<(), String>;
}

/// The bus of a simulator that serves lines alone: nothing ever comes.
pub(super) struct Unserved {
    /// Clock of the simulation.
    pub(super) clock: Clock,
    /// Stations that nobody reaches.
    pub(super) bus: FarBus,
}

impl ServedBus for Unserved {
    fn now(&self) -> Duration {
        self.clock.now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.clock.wait_until(until);
        Ok(())
    }

    fn exchange(&mut self, _report: &mut Report) -> io::Result<()> {
        match &mut self.bus {
            FarBus::EtherCat(line) => line.advance(self.clock.now()),
            FarBus::Can(line) => line.advance(self.clock.now()),
        }
        Ok(())
    }

    fn inject(&mut self, _now: Duration, _fault: BusFault) -> Result<(), String> {
        Err("lines are served alone, and no bus: begin the simulator without `--lines`".to_owned())
    }
}
