//! `bench sim`: a simulated rig in a process of its own, in real time, at the far end of real wires.
//!
//! Whoever runs the rig speaks to it as to hardware. Faults come over a control socket and can be injected nowhere else.

mod bus;
mod control;
mod lines;
mod server;
mod truth;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::AtomicU16;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::PacketSocket;
use drivers::wire::can::SocketCan;
use procedures::log::LogError;

use crate::clock::Clock;
use crate::model::rig::Rig;
use crate::people::lock::{self, Holder, LockError};
use crate::realtime::{Rights, privileges};
use crate::site::interface::{self, Kernel};
use crate::site::unit::Unit;
use crate::site::{Contact, FarBus, Purpose, Units, path_for};
use bus::{ServedBus, ServedCan, ServedEtherCat, Unserved};
use control::Control;
use lines::ServedLines;
use server::{Broken, Server};
use truth::TruthLog;

/// What a simulator serves, and where.
#[derive(Clone, Debug)]
pub struct Settings<'a> {
    /// The rig whose far ends are served.
    pub rig: &'a Rig,
    /// The unit that is simulated.
    pub unit: &'a Unit,
    /// Seed of everything random.
    pub seed: u64,
    /// Where the axes stand at the start, by name; an axis that is not named stands at 0.
    pub pose_rad: BTreeMap<String, f64>,
    /// Interface of the far end; the other end of the rig's own pair of virtual interfaces if left out.
    pub interface: Option<String>,
    /// Serial lines and sockets are served alone, without any interface.
    pub are_lines_alone: bool,
    /// Control socket; one in the user's own folder if left out.
    pub control: Option<PathBuf>,
    /// Log of the ground truth; none is written if left out.
    pub log: Option<PathBuf>,
}

/// Why a simulator cannot be served, or ended.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// An interface or line that another simulator has.
    #[error(transparent)]
    Locked(#[from] LockError),
    /// An interface or a unit.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The control socket.
    #[error("control socket {path}: {source}")]
    Control {
        /// Its path.
        path: String,
        /// Cause.
        source: std::io::Error,
    },
    /// The log of the ground truth.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The interface, while it was in use.
    #[error("interface {name}: {source}; the simulator ends")]
    Interface {
        /// Its name.
        name: String,
        /// Cause.
        source: std::io::Error,
    },
}

/// What a simulator has done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Frames that were answered.
    pub frames: u64,
    /// Frames that were not: lost by a fault, malformed, foreign.
    pub unanswered: u64,
    /// Answers that the interface did not take.
    pub unsent: u64,
    /// Rows of the truth that the disk was too slow for.
    pub lost_rows: u64,
    /// Contacts with end stops.
    pub contacts: Vec<Contact>,
}

/// Serves a rig until it is stopped. `say` is told where its far ends can be reached.
///
/// # Errors
/// What is missing before it begins, or fails meanwhile.
pub fn serve(
    settings: &Settings<'_>,
    stop: &AtomicU16,
    say: &mut dyn FnMut(&str),
) -> Result<Report, SimError> {
    let name = if settings.are_lines_alone { None } else { Some(far_interface(settings)?) };
    // Both ends of a CAN bus are on one interface.
    let end = if settings.rig.can.is_some() { "far end of interface" } else { "interface" };
    let interface = name.iter().map(|name| format!("{end} {name}")).collect();
    let served = [interface, lock::far_ends(settings.rig)].concat();
    let _claim = lock::claim(&lock::system_folder(), &served, &Holder::verb("sim"))?;
    let path = match &settings.control {
        Some(path) => path.clone(),
        None => control_of(name.as_deref().unwrap_or(&settings.rig.id))?,
    };
    let failed = |source| SimError::Control { path: path.display().to_string(), source };
    let control = Control::listen(&path).map_err(failed)?;
    let units = Units { unit: settings.unit, built: &[] };
    let pose_rad = settings.pose_rad.clone();
    let purpose = Purpose { seed: settings.seed, procedure: "sim", pose_rad, ..Purpose::default() };
    let far_ends = units.far_ends(settings.rig, &purpose)?;
    let world = far_ends.world;
    if name.is_none() {
        world.trigger_every(Duration::from_secs_f64(1.0 / settings.rig.loop_rate_hz));
    }
    let lines = ServedLines::open(far_ends.lines)?;
    let axes: Vec<String> = world.truth().into_iter().map(|axis| axis.name).collect();
    let open = |path: &PathBuf| TruthLog::create(path, settings.rig, &axes, settings.seed);
    let truth = settings.log.as_ref().map(open).transpose()?;
    if let Some(name) = &name {
        reached(settings.rig, name, &far_ends.bus).iter().for_each(|line| say(line));
    }
    lines.names().for_each(|(address, device)| say(&format!("{address}  {device}")));
    say(&format!("control  {}", path.display()));
    let bus = served_bus(name.as_deref(), far_ends.bus)?;
    let rights = Rights::ask();
    let given_up = privileges::give_up();
    for grant in rights.grants.iter().chain([&given_up]).filter(|grant| !grant.granted) {
        say(&format!("without  {}: {}", grant.what, grant.found));
    }
    let server = Server::new(bus, lines, world, truth);
    let broken = |why| match why {
        Broken::Interface(source) => SimError::Interface { name: name.clone().unwrap_or_default(), source },
        Broken::Line(error) => SimError::Device(error),
    };
    let (report, truth) = server.serve(&control, stop).map_err(broken)?;
    let lost_rows = truth.map_or(Ok(0), TruthLog::finish)?;
    Ok(Report { lost_rows, ..report })
}

/// The bus of the drives on an interface; one that nobody reaches without.
fn served_bus(name: Option<&str>, bus: FarBus) -> Result<Box<dyn ServedBus>, DeviceError> {
    let clock = Clock::real();
    let Some(name) = name else { return Ok(Box::new(Unserved { clock, bus })) };
    Ok(match bus {
        FarBus::EtherCat(line) => {
            let link = PacketSocket::far_end(name, Box::new(move || clock.now()))?;
            Box::new(ServedEtherCat::new(link, line))
        }
        FarBus::Can(line) => {
            let link = SocketCan::open(name, Box::new(move || clock.now()))?;
            Box::new(ServedCan::new(link, line))
        }
    })
}

/// A line for each station on an interface: address and name.
fn reached(rig: &Rig, name: &str, bus: &FarBus) -> Vec<String> {
    match bus {
        FarBus::EtherCat(line) => {
            let own = reached_by(name);
            (1..).zip(line.names()).map(|(device, of)| format!("ethercat:{own}/{device}  {of}")).collect()
        }
        FarBus::Can(_) => {
            let node = |axis: &crate::model::axis::RigAxis| (axis.drive.station, axis.name.clone());
            rig.axes.iter().map(node).map(|(node, axis)| format!("can:{name}/{node}  {axis} drive")).collect()
        }
    }
}

/// The control socket of whoever serves a rig.
///
/// # Errors
/// When the rig has no interface, or the user's folder cannot be had.
pub fn control_path(rig: &Rig, interface: Option<&str>) -> Result<PathBuf, SimError> {
    match interface {
        Some(name) => control_of(name),
        None => control_of(&peer_of(rig)?),
    }
}

/// The control socket of whoever serves the lines of a rig alone.
///
/// # Errors
/// When the user's folder cannot be had.
pub fn control_path_of_lines(rig: &Rig) -> Result<PathBuf, SimError> {
    control_of(&rig.id)
}

/// The control socket that is named after an interface or a rig.
fn control_of(name: &str) -> Result<PathBuf, SimError> {
    path_for(name).map_err(|source| SimError::Control { path: name.to_owned(), source })
}

/// The interface under which a MainDevice reaches this one.
fn reached_by(name: &str) -> String {
    let found = Kernel::default().interface(name).ok().and_then(|interface| interface.peer);
    found.unwrap_or_else(|| name.to_owned())
}

/// The interface to serve: the one that is asked for, or the far end of the rig's own.
fn far_interface(settings: &Settings<'_>) -> Result<String, DeviceError> {
    let kernel = Kernel::default();
    let rig = settings.rig;
    let name = match &settings.interface {
        Some(name) => name.clone(),
        None => peer_of(rig)?,
    };
    let found = kernel.interface(&name)?;
    if rig.can.is_some() {
        return if found.is_physical { Err(hardware_behind(&name)) } else { Ok(name) };
    }
    if !found.is_pair {
        let reason = "it is no pair of virtual interfaces (veth), and a simulator must not answer where hardware may \
                      be: expected one end of a pair, made with `ip link add ecm type veth peer name ecs`";
        return Err(interface::failure(&name, reason.to_owned()));
    }
    kernel.check_unused(&name, &drivers::wire::addresses(&name)?)?;
    Ok(name)
}

/// A CAN interface at which a simulator must not answer.
fn hardware_behind(name: &str) -> DeviceError {
    let reason = "it has a controller, and a simulator must not answer where hardware may be: expected a virtual \
                  interface, made with `ip link add dev can0 type vcan`";
    interface::failure(name, reason.to_owned())
}

/// Where whoever serves a rig is: both ends of a CAN bus are on one interface, those of EtherCAT on a pair of virtual ones.
fn peer_of(rig: &Rig) -> Result<String, DeviceError> {
    let Some(own) = rig.interface() else {
        let reason = "its drives have no network interface, so nothing can be served; choose a rig of tier `wired`, \
                      name the interface with `--interface`, or serve its serial lines and sockets alone with `--lines`";
        return Err(DeviceError::Bus { device: format!("rig `{}`", rig.id), reason: reason.to_owned() });
    };
    if rig.can.is_some() {
        return Ok(own.to_owned());
    }
    Kernel::default().interface(own)?.peer.ok_or_else(|| {
        let reason =
            "the other end of its pair is not in this network name space; name it with `--interface`";
        interface::failure(own, reason.to_owned())
    })
}
