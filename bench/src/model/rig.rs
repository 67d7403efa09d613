//! A rig: its axes, its devices, its instruments, and the limits that the bench relies on.

use std::sync::Arc;

use drivers::cia402::profile::DriveProfile;
use procedures::axis::{Axes, Axis};
use procedures::device::DeviceRole;
use procedures::diagnostic::SourceFile;

use super::axis::RigAxis;
use super::device::DeviceEntry;
use super::instrument::Instrument;
use super::terminal::{Terminal, TerminalInput};

/// Fidelity of a rig: which wires, which clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// Simulated devices in process, virtual time, a world for each point.
    Virtual,
    /// Simulated devices in process, real time, one session.
    Paced,
    /// Simulated devices in another process, at the far end of real wires, real time, one session.
    Wired,
    /// The director, real time, one session. Differs from `Wired` in nothing but what the identities say.
    Hardware,
}

impl Tier {
    /// Whether its wires leave the process.
    pub fn is_wired(self) -> bool {
        matches!(self, Self::Wired | Self::Hardware)
    }
}

/// Indices of the two axes of a gimbal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gimbal {
    /// The axis that carries the other one: azimuth.
    pub outer: usize,
    /// The axis that is carried, with the payload on it: elevation.
    pub inner: usize,
}

impl Gimbal {
    /// The gimbal of these axes: `None` where no axis carries another one, or more than one does.
    pub fn of(axes: &[RigAxis]) -> Option<Self> {
        let index = |name: &str| axes.iter().position(|axis| axis.name == name);
        let pair = |(inner, axis): (usize, &RigAxis)| {
            Some(Self { outer: index(axis.carried_by.as_deref()?)?, inner })
        };
        let mut all = axes.iter().enumerate().filter_map(pair);
        let gimbal = all.next()?;
        all.next().is_none().then_some(gimbal)
    }

    /// Both axes in the order of pairs: outer, inner.
    pub fn both(self) -> [usize; 2] {
        [self.outer, self.inner]
    }

    /// Place of an axis in pairs: 0 for the outer axis, 1 for the inner one, `None` for any other.
    pub fn place_of(self, axis: usize) -> Option<usize> {
        self.both().iter().position(|own| *own == axis)
    }
}

/// A CAN bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CanBus {
    /// Bit rate that its interface is set to.
    pub bit_rate_hz: f64,
}

/// A rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// E.g. `sim`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Fidelity.
    pub tier: Tier,
    /// Network interface of the wire of the drives; `None` for drives in this process.
    pub interface: Option<String>,
    /// The CAN bus of the drives, also where it is rehearsed in this process; `None` for drives that are not on CAN.
    pub can: Option<CanBus>,
    /// Whether the drives follow SYNC0 of an EtherCAT wire, the frames passing half a cycle after each pulse.
    pub follows_sync0: bool,
    /// Loop rate.
    pub loop_rate_hz: f64,
    /// Longest run of missed periods that is tolerated.
    pub max_missed_periods: u32,
    /// Longest time for the answers of an external law in one tick, where time is real, s.
    pub law_deadline_s: f64,
    /// Controller parameters, by shipped name or path.
    pub parameters: String,
    /// Axes, in the order of the rig file; 1 to [`procedures::axis::MAX_AXES`].
    pub axes: Vec<RigAxis>,
    /// Bit of 60FDh of the first drive that is 1 while the emergency stop chain is open; `None` without a wire.
    pub emergency_stop_bit: Option<u32>,
    /// Input of a digital terminal that is on while the emergency stop chain is closed; `None` without one.
    pub emergency_stop_input: Option<TerminalInput>,
    /// Bit of 60FDh of the first drive that is 1 while the enabling switch is held; `None` without one.
    pub enabling_switch_bit: Option<u32>,
    /// Devices and instruments that the bench talks to, in the order in which they are opened and logged.
    pub devices: Vec<DeviceEntry>,
    /// SubDevices on the wire beside the drives, as the file names them; devices and the emergency stop name more.
    pub terminals: Vec<Terminal>,
    /// Instruments of the bench with their calibration.
    pub instruments: Vec<Instrument>,
    /// The file.
    pub source: SourceFile,
}

impl Rig {
    /// What planning and judging may know of the axes.
    pub fn limits(&self) -> Axes {
        let known = |axis: &RigAxis| Axis {
            name: axis.name.clone(),
            carried_by: axis.carried_by.clone(),
            limits: axis.limits.clone(),
        };
        Axes::new(self.axes.iter().map(known).collect())
    }

    /// Network interface of the wire of the drives, EtherCAT or CAN; `None` for drives in this process.
    pub fn interface(&self) -> Option<&str> {
        self.interface.as_deref()
    }

    /// The pair of axes of which one carries the other.
    pub fn gimbal(&self) -> Option<Gimbal> {
        Gimbal::of(&self.axes)
    }

    /// The axes to which devices belong that come in pairs, such as current probes and polygons: outer and inner axis, or the
    /// first two of a rig without gimbal.
    pub fn pair(&self) -> [Option<&RigAxis>; 2] {
        self.gimbal().map_or([0, 1], Gimbal::both).map(|axis| self.axes.get(axis))
    }

    /// The device of a role; `None` where the rig lacks it.
    pub fn device(&self, role: DeviceRole) -> Option<&DeviceEntry> {
        self.devices.iter().find(|entry| entry.role == Some(role))
    }

    /// Names of the axes in order.
    pub fn axis_names(&self) -> Vec<String> {
        self.axes.iter().map(|a| a.name.clone()).collect()
    }

    /// The rig with other inertias about some of its axes, as a build state has them.
    ///
    /// # Errors
    /// In words: an axis that it lacks, or one that would be heavier than the rig file says; stops are sized for that.
    pub fn with_inertia(&self, of_axes: &[(String, f64)]) -> Result<Self, String> {
        let mut built = self.clone();
        for (name, inertia_kg_m2) in of_axes {
            let index = self.axis_index(name).ok_or_else(|| format!("the rig has no axis `{name}`"))?;
            let axis = &mut built.axes[index];
            let text = |value| procedures::quantity::QuantityKind::Inertia.format(value);
            if *inertia_kg_m2 > axis.limits.inertia_kg_m2 {
                let asked = text(*inertia_kg_m2);
                let own = text(axis.limits.inertia_kg_m2);
                return Err(format!("axis `{name}` with {asked} is heavier than the rig file says: {own}"));
            }
            // Stops stay sized for the rig file's: what a campaign says of a build state is not trusted with that.
            axis.limits.inertia_kg_m2 = *inertia_kg_m2;
        }
        Ok(built)
    }

    /// The rig with simulated devices in this process instead of its wires, `profile` being that of the drives there. Drives
    /// keep their order: the one with the lowest address stands on the first station of the simulated bus.
    #[must_use]
    pub fn rehearsed_on(&self, tier: Tier, profile: &Arc<DriveProfile>) -> Self {
        let mut rehearsed = Self { tier, interface: None, ..self.in_station_order() };
        for axis in &mut rehearsed.axes {
            axis.drive.profile = Arc::clone(profile);
            axis.limits.torque_quantum_nm = axis.drive.torque_quantum_nm();
            axis.guard.watches_heat_sink = profile.heat_sink.is_some();
        }
        rehearsed
    }

    /// The rig with its drives on stations 1, 2, … in the order of their addresses, as a simulated bus has them.
    #[must_use]
    pub fn in_station_order(&self) -> Self {
        let mut numbered = self.clone();
        let mut addresses: Vec<u16> = self.axes.iter().map(|axis| axis.drive.station).collect();
        addresses.sort_unstable();
        for axis in &mut numbered.axes {
            let place = addresses.iter().position(|&own| own == axis.drive.station);
            axis.drive.station = place.map_or(axis.drive.station, |place| place as u16 + 1);
        }
        numbered
    }

    /// Index of an axis.
    pub fn axis_index(&self, name: &str) -> Option<usize> {
        self.axes.iter().position(|a| a.name == name)
    }
}
