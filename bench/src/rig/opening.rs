//! Opening a rig: every device is identified, configured and read back, and nothing can move. Whatever else is on the bus of the
//! drives is no drive.

use std::rc::Rc;
use std::time::Duration;

use controllers::DirectorGains;
use drivers::cia402::{Actuals, Cia402, Identity, Waiting, is_drive};
use drivers::device::DeviceError;
use drivers::wire::{BusState, Fieldbus};

use super::ArmedRig;
use super::believed::Reckoning;
use super::devices::{self, DIALOGUE_STEP, Devices, converse};
use super::emergency_stop::EmergencyStop;
use super::feedback::RateFeedback;
use super::instruments::Instruments;
use super::pace::Pace;
use super::phase::Phase;
use super::tracking::Tracking;
use super::wires::{Ports, Traffic, Wires};
use crate::clock::Clock;
use crate::model::axis::RigAxis;
use crate::model::rig::{Gimbal, Rig};

/// A rig whose devices were identified, configured and read back. Nothing can move yet.
pub struct OpenRig {
    bus: Box<dyn Fieldbus>,
    drives: Vec<Cia402>,
    axes: Vec<RigAxis>,
    identities: Vec<Identity>,
    /// Decelerations of the rig file.
    stated_rad_per_s2: Vec<f64>,
    emergency_stop: Option<EmergencyStop>,
    ports: Ports,
    devices: Devices,
    instruments: Instruments,
    feedback: RateFeedback,
    tracking: Tracking,
    /// When the dialogues with the devices were over.
    opened_at: Duration,
    pace: Pace,
}

impl OpenRig {
    /// Opens every device of the rig on these wires; dialogues take time, and that passes on `clock`.
    ///
    /// # Errors
    /// The first device that is missing, does not answer, refuses an object or reads back something else.
    pub fn open(wires: Wires, rig: &Rig, gains: &DirectorGains, clock: &Clock) -> Result<Self, DeviceError> {
        let Wires { mut bus, mut ports } = wires;
        let mut now = clock.wait_until(Duration::ZERO).max(bus.now().unwrap_or_default());
        let opened = open_drives(&mut *bus, rig, clock, &mut now)?;
        let closed = devices::closed(rig);
        let (devices, mut now) = Devices::open(closed.devices, &mut ports, clock, now)?;
        let mut instruments = Instruments::closed(closed.instruments);
        converse(clock, &mut now, "instruments", |at| instruments.identify(&mut ports, at))?;
        Ok(Self {
            bus,
            drives: opened.drives,
            axes: opened.axes,
            identities: opened.identities,
            stated_rad_per_s2: rig.axes.iter().map(|a| a.guard.stop.deceleration_rad_per_s2).collect(),
            emergency_stop: EmergencyStop::of(rig, &mut ports)?,
            ports,
            devices,
            instruments,
            feedback: RateFeedback::new(gains, 1.0 / rig.loop_rate_hz),
            tracking: Tracking::new(rig, gains),
            opened_at: now,
            pace: Pace::new(rig),
        })
    }

    /// From now on what passes lines and datagram ports is counted.
    pub(crate) fn count_traffic(&mut self) -> Rc<Traffic> {
        let (ports, traffic) = std::mem::take(&mut self.ports).counted();
        self.ports = ports;
        traffic
    }

    /// Who the drives said they are, in axis order.
    pub fn identities(&self) -> &[Identity] {
        &self.identities
    }

    /// Devices that are polled in the tick.
    pub fn devices(&self) -> &Devices {
        &self.devices
    }

    /// Instruments on the bench.
    pub fn instruments(&self) -> &Instruments {
        &self.instruments
    }

    /// Maps the process data and asks for SAFE-OP: inputs become valid, outputs are still ignored. That takes time on a wire,
    /// and the ticks begin after it.
    ///
    /// # Errors
    /// When a mapping is invalid or a drive has no slot.
    pub fn arm(mut self, clock: &Clock) -> Result<ArmedRig, DeviceError> {
        let (image, slots) = self.bus.map()?;
        for drive in &mut self.drives {
            let station = drive.settings().station;
            let slot = slots.iter().find(|(s, _)| *s == station).map(|(_, slot)| slot.clone());
            let slot = slot.ok_or_else(|| DeviceError::Bus {
                device: drive.settings().name.clone(),
                reason: format!("station {station} has no slot in the process image"),
            })?;
            drive.attach(slot);
        }
        if let Some(stop) = self.emergency_stop {
            stop.check(&mut self.ports, clock.now())?;
        }
        self.bus.request(BusState::SafeOp);
        self.opened_at = self.opened_at.max(clock.now()).max(self.bus.now().unwrap_or_default());
        let axes = self.drives.len();
        let phase = Phase::of(clock, &self.axes);
        let mut armed = ArmedRig {
            stated_rad_per_s2: self.stated_rad_per_s2,
            wanted: None,
            reads_heat_sink: None,
            emergency_stop: self.emergency_stop,
            bus: self.bus,
            drives: self.drives,
            gimbal: Gimbal::of(&self.axes),
            axes: self.axes,
            ports: self.ports,
            devices: self.devices,
            instruments: self.instruments,
            feedback: self.feedback,
            tracking: self.tracking,
            opened_at: self.opened_at,
            ready: self.opened_at,
            pace: self.pace,
            image,
            actuals: vec![Actuals::default(); axes],
            age_ticks: vec![u32::MAX; axes],
            reckoned: vec![Reckoning::default(); axes],
            distrusts_gyro: false,
            link_is_full: false,
            controlwords: vec![0; axes],
            working_counter: 0,
            bad_in_row: 0,
            recent_bad: 0,
            phase,
        };
        armed.begin_ticks_after(armed.opened_at);
        Ok(armed)
    }
}

/// Drives that were identified, configured and read back, and the axes as they allow them.
struct OpenedDrives {
    drives: Vec<Cia402>,
    identities: Vec<Identity>,
    axes: Vec<RigAxis>,
}

/// Opens the drives of a rig in the order of its axes, letting time pass on `clock`.
///
/// # Errors
/// The first station that is missing, is of another type, or refuses a setting.
fn open_drives(
    bus: &mut dyn Fieldbus,
    rig: &Rig,
    clock: &Clock,
    now: &mut Duration,
) -> Result<OpenedDrives, DeviceError> {
    let mut at = *now;
    let mut pause = || {
        at = clock.wait_until(at + DIALOGUE_STEP);
        at
    };
    let mut waiting = Waiting { now: *now, pause: &mut pause };

    let found = bus.stations();
    let mut drives = Vec::new();
    let mut identities = Vec::new();
    let mut axes = rig.axes.clone();
    for axis in &mut axes {
        if !found.contains(&axis.drive.station) {
            let (station, bus) = (axis.drive.station, bus.name());
            let reason = format!(
                "no station {station} on {bus}, found stations {found:?}; check power and wiring, and `station` in the rig file"
            );
            return Err(DeviceError::Bus { device: axis.name.clone(), reason });
        }
        let (drive, identity) = Cia402::open(bus, axis.drive.clone(), &mut waiting)?;
        axis.guard.rely_on(drive.available_torque_nm());
        if drives.is_empty() {
            check_inputs(rig, &drive)?;
        }
        drives.push(drive);
        identities.push(identity);
    }
    check_terminals(bus, rig, &found, &mut waiting)?;
    *now = waiting.now;
    Ok(OpenedDrives { drives, identities, axes })
}

/// Refuses a drive where the rig file has a terminal: what is written to it would be commands. Rigs in this process have no
/// terminals on their bus.
fn check_terminals(
    bus: &mut dyn Fieldbus,
    rig: &Rig,
    found: &[u16],
    waiting: &mut Waiting<'_>,
) -> Result<(), DeviceError> {
    let beside = rig.stations_beside_drives();
    for own in beside.iter().filter(|own| rig.interface.is_some() && found.contains(&own.station)) {
        if is_drive(bus, own.station, waiting) {
            let (names, station) = (own.names.join(", "), own.station);
            let reason = format!(
                "station {station} is a CiA 402 drive, but the rig file has {names} there; correct the address, or check the \
                 order of the line"
            );
            return Err(DeviceError::Bus { device: bus.name().to_owned(), reason });
        }
    }
    Ok(())
}

/// Refuses a first drive that does not send the inputs to which emergency stop or enabling switch are wired.
fn check_inputs(rig: &Rig, drive: &Cia402) -> Result<(), DeviceError> {
    let is_wired = rig.emergency_stop_bit.is_some() || rig.enabling_switch_bit.is_some();
    if !is_wired || drive.sends_digital_inputs() {
        return Ok(());
    }
    Err(DeviceError::Field {
        device: drive.settings().name.clone(),
        field: "digital inputs (60FDh)",
        expected: "among the process data: the rig file names bits of it".to_owned(),
        found: "not mapped".to_owned(),
        help: "add 60FDh to the inputs in the profile of the drive",
    })
}
