//! Simulated worlds behind a rig: a director, or a rotary table.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::ethercat::EtherCatSettings;
use procedures::case::Case;
use sim_devices::canopen::CanOpenLine;
use sim_devices::ethercat::{EtherCatLine, Terminals};
use sim_devices::rig::{
    AxesTruth, AxisTruth, DriveType, Fault, SeedAddress, SimulatedRig, SimulatedTable, StartState,
};
use sim_devices::unit::{TableSettings, UnitSettings};
use sim_devices::world::AXIS_NAMES;

use super::can;
use super::far_lines::{FarEnd, FarLine, device_types, far_end, far_lines};
use super::unit_for_case::world_axis;
use super::wired::card_address;
use super::{Contact, Purpose, Surroundings, sim_unit_for_case};
use crate::model::rig::Rig;
use crate::rig::wires::{Ports, Wires};
use crate::site::unit::{Unit, World};

/// A unit, and the unit in the build state of each stage, `None` where that is the final one.
#[derive(Clone, Copy)]
pub(crate) struct Units<'a> {
    pub(crate) unit: &'a Unit,
    pub(crate) built: &'a [Option<Unit>],
}

/// Pulses that the drives of a rig follow on their real wire, rehearsed in process: without them a rehearsal would have a loop
/// of one tick less delay.
struct Sync0 {
    cycle: Duration,
    /// From a pulse to the frame.
    shift: Duration,
}

impl Sync0 {
    fn of(rig: &Rig) -> Option<Self> {
        let cycle_s = 1.0 / rig.loop_rate_hz;
        let clocks = EtherCatSettings::usual("", cycle_s).distributed_clocks.filter(|_| rig.follows_sync0)?;
        let [cycle, shift] = [clocks.sync0_period_s, clocks.sync0_shift_s].map(Duration::from_secs_f64);
        Some(Self { cycle, shift })
    }
}

/// A world behind a rig.
pub(super) struct Simulated {
    pub(super) wires: Wires,
    pub(super) surroundings: Box<dyn Surroundings>,
}

impl Units<'_> {
    /// A world for a purpose, at rest, bristles relaxed, heat sinks as warm as the plan has them. `wires` are those of a director.
    ///
    /// # Errors
    /// A unit that does not fit the rig, or that cannot bring what the purpose asks for.
    pub(super) fn simulate(
        &self,
        rig: &Rig,
        purpose: &Purpose<'_>,
        wires: fn(&SimulatedRig) -> Wires,
    ) -> Result<Simulated, DeviceError> {
        let unit = purpose.stage.and_then(|stage| self.built.get(stage)?.as_ref()).unwrap_or(self.unit);
        let point = purpose.case.map_or(String::new(), |case| case.point.clone());
        let address = SeedAddress { seed: purpose.seed, procedure: purpose.procedure.to_owned(), point };
        if let Some(case) = purpose.case {
            check_scenery(unit, case)?;
        }
        let settings = match &unit.world {
            World::Table(settings) => return table(settings, rig, purpose, &address),
            World::Director(settings) => settings,
        };
        let ambient_degc = self.unit.director().unwrap_or(settings).az.ambient_degc;
        let names = world_names(rig);
        let start = start_state(&names, purpose, ambient_degc);
        let mut brought = match purpose.case {
            Some(case) => sim_unit_for_case(settings, case, rig).into_owned(),
            None => settings.as_ref().clone(),
        };
        brought.planned_s = purpose.planned_s;
        let types = device_types(rig);
        let simulated = SimulatedRig::with_devices(&brought, &address, start, rig.loop_rate_hz, types);
        if let Some(sync0) = Sync0::of(rig) {
            simulated.follow_sync0(sync0.cycle, sync0.shift);
        }
        let mut wires = with_addresses(wires(&simulated), rig, &simulated)?;
        if let Some(bus) = rig.can {
            wires.bus = can::in_process(rig, bus, simulated.canopen_line())?;
        }
        let settings = settings.as_ref().clone();
        let rig = rig.clone();
        let surroundings = Box::new(AroundDirector { simulated, settings, rig, names, address });
        Ok(Simulated { wires, surroundings })
    }
}

/// A simulated world whose wires end in this process, for whoever serves them to another one.
pub(crate) struct FarEnds {
    /// What answers on the bus of its drives.
    pub(crate) bus: FarBus,
    /// Serial lines and sockets of its devices.
    pub(crate) lines: Vec<FarLine>,
    /// What is behind them.
    pub(crate) world: Box<dyn FarWorld>,
}

/// Simulated stations on the bus of the drives.
pub(crate) enum FarBus {
    /// SubDevices of an EtherCAT wire.
    EtherCat(Box<dyn EtherCatLine>),
    /// Nodes of a CAN bus.
    Can(Box<dyn CanOpenLine>),
}

/// The world behind far ends.
pub(crate) trait FarWorld {
    /// A fault acts at an instant of world time; one that is over means now.
    ///
    /// # Errors
    /// When it befalls what this world does not have.
    fn schedule(&self, at: Duration, fault: Fault) -> Result<(), DeviceError>;

    /// No frame of a bus will come: what its pulses trigger, such as an inertial unit, is triggered once a cycle.
    fn trigger_every(&self, cycle: Duration);

    /// Where the axes really are: name, angle, rate.
    fn truth(&self) -> Vec<AxisTruth>;

    /// What is around the unit.
    fn surroundings(&mut self) -> &mut dyn Surroundings;
}

impl Units<'_> {
    /// A world at rest at the far end of its wires.
    ///
    /// # Errors
    /// A unit that does not fit the rig.
    pub(crate) fn far_ends(&self, rig: &Rig, purpose: &Purpose<'_>) -> Result<FarEnds, DeviceError> {
        let mut far_ends = self.far_ends_without_aliases(rig, purpose)?;
        for (device, &station) in stations(rig).iter().enumerate().filter(|&(k, &s)| usize::from(s) != k + 1)
        {
            let failed = |reason| DeviceError::Bus { device: format!("rig `{}`", rig.id), reason };
            match &mut far_ends.bus {
                FarBus::EtherCat(line) => line.set_alias(device, station).map_err(failed)?,
                FarBus::Can(_) => return Err(other_node(rig, station)),
            }
        }
        Ok(far_ends)
    }

    fn far_ends_without_aliases(&self, rig: &Rig, purpose: &Purpose<'_>) -> Result<FarEnds, DeviceError> {
        let terminals = served(rig)?;
        let rig = &rig.in_station_order();
        let (seed, procedure) = (purpose.seed, purpose.procedure.to_owned());
        let address = SeedAddress { seed, procedure, point: String::new() };
        let settings = match &self.unit.world {
            World::Table(settings) => {
                check_names(settings, rig)?;
                let simulated = SimulatedTable::new(settings, &address, &purpose.pose_rad);
                let bus = match rig.can {
                    Some(_) => FarBus::Can(simulated.canopen_line()),
                    None => FarBus::EtherCat(simulated.ethercat_line(terminals)),
                };
                let lines = far_lines(rig, None)?;
                return Ok(FarEnds { bus, lines, world: Box::new(AroundTable { simulated }) });
            }
            World::Director(settings) => settings,
        };
        let names = world_names(rig);
        let start = start_state(&names, purpose, settings.az.ambient_degc);
        let types = device_types(rig);
        let simulated = SimulatedRig::with_devices(settings, &address, start, rig.loop_rate_hz, types);
        make_drives(rig, &simulated);
        let bus = match rig.can {
            Some(_) => FarBus::Can(simulated.canopen_line()),
            None => FarBus::EtherCat(simulated.ethercat_line(terminals)),
        };
        let lines = far_lines(rig, Some(&simulated))?;
        let (settings, rig) = (settings.as_ref().clone(), rig.clone());
        let world = Box::new(AroundDirector { simulated, settings, rig, names, address });
        Ok(FarEnds { bus, lines, world })
    }
}

/// A node-ID that no simulated node has: they are numbered from 1, in the order of the drives.
fn other_node(rig: &Rig, node: u16) -> DeviceError {
    DeviceError::Field {
        device: format!("rig `{}`", rig.id),
        field: "ports",
        expected: format!("node-IDs 1 to {}, as simulated drives have them", rig.axes.len()),
        found: format!("node {node}"),
        help: "number the drives from 1 in the rig file that is rehearsed",
    }
}

/// Drives at the far end of a wire are of the types that the rig names, as far as the simulator has them. Those of others are the
/// simulator's own, which a profile of another type refuses.
fn make_drives(rig: &Rig, simulated: &SimulatedRig) {
    for axis in rig.axes.iter().filter(|axis| axis.drive.profile.id == ELMO_GOLD) {
        if let Some(drive @ 0..=1) = usize::from(axis.drive.station).checked_sub(1) {
            simulated.make_drive(drive, DriveType::ElmoGold);
        }
    }
}

/// Profile of the drives that [`DriveType::ElmoGold`] is like.
const ELMO_GOLD: &str = "elmo-gold";

/// Stations of drives and terminals in the order in which a simulator puts them on the wire: drives by their addresses, the
/// analog terminal, the digital one.
fn stations(rig: &Rig) -> Vec<u16> {
    let mut drives: Vec<u16> = rig.axes.iter().map(|axis| axis.drive.station).collect();
    drives.sort_unstable();
    let beside = rig.stations_beside_drives();
    let analog = beside.iter().filter(|own| own.is_card);
    let digital = beside.iter().filter(|own| own.is_emergency_stop);
    drives.extend(analog.chain(digital).map(|own| own.station));
    drives
}

/// The terminals that a simulator serves for a rig.
///
/// # Errors
/// Terminals that it does not have: more than one of a sort, one that is both, one that only `[[terminal]]` names.
fn served(rig: &Rig) -> Result<Terminals, DeviceError> {
    let beside = rig.stations_beside_drives();
    let refused = |found: String| DeviceError::Field {
        device: format!("rig `{}`", rig.id),
        field: "terminals",
        expected:
            "at most one analog terminal and one digital one for the emergency stop, as a simulator has them"
                .to_owned(),
        found,
        help: "rehearse the rig without its other terminals, or with `--tier virtual`",
    };
    let odd = beside.iter().find(|own| own.is_card == own.is_emergency_stop);
    if let Some(own) = odd {
        return Err(refused(format!("station {} ({})", own.station, own.names.join(", "))));
    }
    let analog = beside.iter().filter(|own| own.is_card).count();
    if analog > 1 {
        return Err(refused(format!("{analog} analog terminals")));
    }
    Ok(Terminals { analog: analog == 1, digital: beside.len() > analog })
}

/// What a point asks of the surroundings of the rig and a simulated unit cannot bring.
///
/// # Errors
/// The first thing that is asked for in vain.
pub(crate) fn check_scenery(unit: &Unit, case: &Case) -> Result<(), DeviceError> {
    if let World::Director(_) = unit.world {
        return Ok(());
    }
    let asked = [
        ("target", case.target.is_some(), "a target, but a rotary table has no tracker"),
        ("pull", case.pull.is_some(), "a pull, but a rotary table has no force gauge"),
        (
            "frame rate",
            case.fine_frame_rate_hz.is_some(),
            "a frame rate, but a rotary table has no fine tracker",
        ),
    ];
    match asked.into_iter().find(|(_, is_asked, _)| *is_asked) {
        Some((field, _, found)) => Err(DeviceError::Field {
            device: format!("unit `{}`", unit.id),
            field,
            expected: "none".to_owned(),
            found: format!("{found}, at point `{}`", case.point),
            help: "leave the procedure out, or choose a director with `--unit`",
        }),
        None => Ok(()),
    }
}

fn table(
    settings: &TableSettings,
    rig: &Rig,
    purpose: &Purpose<'_>,
    address: &SeedAddress,
) -> Result<Simulated, DeviceError> {
    check_names(settings, rig)?;
    let settings = TableSettings { planned_s: purpose.planned_s, ..settings.clone() };
    let simulated = SimulatedTable::new(&settings, address, &purpose.pose_rad);
    if let Some(sync0) = Sync0::of(rig) {
        simulated.follow_sync0(sync0.cycle, sync0.shift);
    }
    let mut wires = Wires::table(&simulated);
    if let Some(bus) = rig.can {
        wires.bus = can::in_process(rig, bus, simulated.canopen_line())?;
    }
    if rig.emergency_stop_input.is_some() {
        wires.ports = wires.ports.with_emergency_stop(simulated.digital_card());
    }
    Ok(Simulated { wires, surroundings: Box::new(AroundTable { simulated }) })
}

/// Every axis of the rig has the name of the axis on its station, so that poses and contacts are about the same axis.
fn check_names(settings: &TableSettings, rig: &Rig) -> Result<(), DeviceError> {
    for axis in &rig.axes {
        let station = usize::from(axis.drive.station);
        let simulated = station.checked_sub(1).and_then(|place| settings.axes.get(place));
        let found = simulated.map_or("no axis".to_owned(), |own| format!("axis `{}`", own.name));
        if simulated.is_none_or(|own| own.name != axis.name) {
            return Err(DeviceError::Field {
                device: format!("rig `{}`", rig.id),
                field: "axis",
                expected: format!("axis `{}` on station {station} of the unit", axis.name),
                found,
                help: "name the axes of rig and unit file alike, in the order of their stations",
            });
        }
    }
    Ok(())
}

/// What a rig calls azimuth and elevation of the simulated director, by the stations of their drives.
fn world_names(rig: &Rig) -> [Option<String>; 2] {
    [0, 1].map(|index| {
        let axis = rig.axes.iter().find(|axis| world_axis(rig, &axis.name) == Some(index));
        axis.map(|axis| axis.name.clone())
    })
}

/// Where the world begins: at rest where the axes of a purpose stand.
fn start_state(names: &[Option<String>; 2], purpose: &Purpose<'_>, heat_sink_degc: f64) -> StartState {
    let place = |name: &Option<String>| purpose.pose_rad.get(name.as_ref()?).copied();
    let [az_rad, el_rad] = names.each_ref().map(|name| place(name).unwrap_or(0.0));
    StartState { az_rad, el_rad, heat_sink_degc }
}

/// The wires of a rig that names terminals on a bus and lines of the operating system, rehearsed in this process: each terminal is
/// the analog card behind the drives, the one at the emergency stop the digital one, and each line that of the simulated device of its role.
///
/// # Errors
/// A device on a line that a simulated director lacks.
fn with_addresses(mut wires: Wires, rig: &Rig, simulated: &SimulatedRig) -> Result<Wires, DeviceError> {
    for own in rig.stations_beside_drives().iter().filter(|own| own.is_card) {
        wires.ports = wires.ports.with_card(&card_address(rig, own.station), simulated.terminal_card());
    }
    for FarLine { address, end, .. } in far_lines(rig, Some(simulated))? {
        let address = address.to_string();
        wires.ports = match end {
            FarEnd::Line(line) => wires.ports.with_line(&address, line),
            FarEnd::Port(socket) => wires.ports.with_socket(&address, socket),
        };
    }
    // A reader is as its profile says: there is none before a rig file names one.
    for entry in rig.devices.iter().filter(|entry| entry.profile.is_some() && entry.lines().next().is_none())
    {
        if let Some(FarEnd::Line(line)) = far_end(entry, simulated) {
            wires.ports = wires.ports.with_line(entry.port("line"), line);
        }
    }
    if rig.emergency_stop_input.is_some() {
        wires.ports = wires.ports.with_emergency_stop(simulated.digital_card());
    }
    Ok(wires)
}

/// What is around a simulated director.
struct AroundDirector {
    simulated: SimulatedRig,
    settings: UnitSettings,
    rig: Rig,
    /// What the rig calls azimuth and elevation of the world.
    names: [Option<String>; 2],
    address: SeedAddress,
}

impl Surroundings for AroundDirector {
    fn bring(&mut self, case: &Case) {
        let address = SeedAddress { point: case.point.clone(), ..self.address.clone() };
        self.simulated.bring(&sim_unit_for_case(&self.settings, case, &self.rig), &address);
    }

    fn contacts(&self) -> Vec<Contact> {
        let called = |own: String| {
            let index = AXIS_NAMES.iter().position(|name| *name == own);
            index.and_then(|index| self.names[index].clone()).unwrap_or(own)
        };
        let crashes = self.simulated.record().crashes.into_iter();
        let contact = |(axis, at_s, speed_rad_per_s)| Contact { axis: called(axis), at_s, speed_rad_per_s };
        crashes.map(contact).collect()
    }
}

impl FarWorld for AroundDirector {
    fn schedule(&self, at: Duration, fault: Fault) -> Result<(), DeviceError> {
        let count = self.names.len();
        if let Some(drive) = fault.drive().filter(|&drive| drive >= count) {
            let reason = format!("fault of drive {drive}: expected 0 to {}", count - 1);
            return Err(DeviceError::Bus { device: "simulated director".to_owned(), reason });
        }
        self.simulated.schedule(at, fault);
        Ok(())
    }

    fn trigger_every(&self, cycle: Duration) {
        self.simulated.follow_sync0(cycle, Duration::ZERO);
    }

    fn truth(&self) -> Vec<AxisTruth> {
        let AxesTruth { angle_rad, rate_rad_per_s } = self.simulated.truth_of_axes();
        let axis = |k: usize| AxisTruth {
            name: self.names[k].clone().unwrap_or_else(|| AXIS_NAMES[k].to_owned()),
            angle_rad: angle_rad[k],
            rate_rad_per_s: rate_rad_per_s[k],
        };
        vec![axis(0), axis(1)]
    }

    fn surroundings(&mut self) -> &mut dyn Surroundings {
        self
    }
}

impl FarWorld for AroundTable {
    fn schedule(&self, at: Duration, fault: Fault) -> Result<(), DeviceError> {
        self.simulated.schedule(at, fault)
    }

    fn trigger_every(&self, cycle: Duration) {
        self.simulated.follow_sync0(cycle, Duration::ZERO);
    }

    fn truth(&self) -> Vec<AxisTruth> {
        self.simulated.truth_of_axes()
    }

    fn surroundings(&mut self) -> &mut dyn Surroundings {
        self
    }
}

/// What is around a simulated table.
struct AroundTable {
    simulated: SimulatedTable,
}

impl Surroundings for AroundTable {
    /// A point that asks for anything is refused before the run.
    fn bring(&mut self, _case: &Case) {}

    fn contacts(&self) -> Vec<Contact> {
        let crashes = self.simulated.record().crashes.into_iter();
        crashes.map(|(axis, at_s, speed_rad_per_s)| Contact { axis, at_s, speed_rad_per_s }).collect()
    }
}

impl Wires {
    /// The wires of a simulated director.
    pub fn simulated(rig: &SimulatedRig) -> Self {
        Self {
            bus: rig.bus(),
            ports: Ports::default()
                .with_line("sim:imu", rig.imu_line())
                .with_line("sim:mirror", rig.mirror_line())
                .with_line("sim:analyser", rig.analyser_line())
                .with_line("sim:scope", rig.scope_line())
                .with_line("sim:dc-supply", rig.supply_line())
                .with_card("sim:analog", rig.analog_card())
                .with_socket("sim:coarse", rig.coarse_port())
                .with_socket("sim:fine", rig.fine_port()),
        }
    }

    /// The wires of a simulated table: its bus, and no port.
    pub fn table(table: &SimulatedTable) -> Self {
        Self { bus: table.bus(), ports: Ports::default() }
    }
}

#[cfg(test)]
mod tests;
