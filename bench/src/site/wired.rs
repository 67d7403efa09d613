//! Real wires, real time, one session: simulated devices that `bench sim` serves, or the director. Both differ in nothing but
//! what the identities say.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use controllers::DirectorGains;
use drivers::cia402::profile::ProfileIdentity;
use drivers::device::DeviceError;
use drivers::wire::ethercat::{DistributedClocks, EtherCatBus, EtherCatSettings, ExpectedStation};
use drivers::wire::{EthernetLink, Fieldbus, PacketSocket, Tap};
use procedures::case::Case;

use super::can;
use super::interface::{self, Interface, Kernel};
use super::lines;
use super::order::Order;
use super::terminal::{Images, TerminalCard, TerminalImage, WithTerminals};
use super::{
    BusGrounds, Contact, Opened, OpenedPorts, Purpose, Site, Surroundings, WireFaults, path_for, tell,
};
use crate::clock::{self, Clock};
use crate::model::address::Address;
use crate::model::axis::RigAxis;
use crate::model::rig::{CanBus, Rig};
use crate::record::tap::WireTap;
use crate::rig::OpenRig;
use crate::rig::identities::LineGrounds;
use crate::rig::wires::{Ports, Wires};

/// How long an interface must be silent before this program sends the first frame.
const SILENCE: Duration = Duration::from_millis(100);

/// What a run has on its EtherCAT interface beside the bus.
#[derive(Clone, Copy, Default)]
pub struct OnWire<'a> {
    /// Whoever gets copies of all frames.
    pub tap: Option<&'a WireTap>,
    /// Faults of the interface.
    pub faults: Option<&'a WireFaults>,
}

/// The site of the wired and of the hardware tier.
#[derive(Clone, Copy, Default)]
pub struct WiredSite<'a> {
    on_wire: OnWire<'a>,
    /// Somebody has secured the axes: drives may let go of them when the bus is opened.
    are_axes_secured: bool,
}

impl<'a> WiredSite<'a> {
    /// A site with something on its interface.
    pub fn new(on_wire: OnWire<'a>) -> Self {
        Self { on_wire, are_axes_secured: false }
    }

    /// The site after somebody has secured the axes: drives that hold them may let go when the bus is opened.
    #[must_use]
    pub fn with_axes_secured(self) -> Self {
        Self { are_axes_secured: true, ..self }
    }

    /// An interface with all that is on it. The tap stands at the bus: it tells what the bus sends and gets, not what the
    /// faults make of it on the way out.
    fn link(&self, name: &str, clock: &Clock) -> Result<Box<dyn EthernetLink>, DeviceError> {
        let mut link: Box<dyn EthernetLink> = Box::new(PacketSocket::open(
            name,
            Box::new({
                let clock = clock.clone();
                move || clock.now()
            }),
        )?);
        if let Some(faults) = self.on_wire.faults {
            link = Box::new(faults.on(link));
        }
        if let Some(sink) = self.on_wire.tap.and_then(|tap| tap.sink(clock)) {
            link = Box::new(Tap::new(link, sink));
        }
        Ok(link)
    }
}

impl Site for WiredSite<'_> {
    fn keeps_session(&self) -> bool {
        true
    }

    /// Nothing of the purpose is read: devices are as they are.
    fn open(&self, rig: &Rig, gains: &DirectorGains, _purpose: &Purpose<'_>) -> Result<Opened, DeviceError> {
        let name = rig.interface().ok_or_else(|| DeviceError::Bus {
            device: format!("rig `{}`", rig.id),
            reason: "its drives have no network interface; give each axis `ports = { bus = \"ethercat:enp3s0/1001\" }`"
                .to_owned(),
        })?;
        if let Some(bus) = rig.can {
            return self.open_can(rig, bus, name, gains);
        }
        let interface = checked(name)?;
        let clock = Clock::real();
        let settings = self.settings(rig, &interface)?;
        let (ports, images) = terminals(rig);
        // A line that is missing is told before any drive is spoken to.
        let (ports, line_grounds) = lines::open(rig, ports, &clock)?;
        let bus = EtherCatBus::open(self.link(name, &clock)?, settings)?;
        let bus: Box<dyn Fieldbus> = Box::new(WithTerminals::new(bus, images));
        let bus_name = bus.name().to_owned();
        let rig = OpenRig::open(Wires { bus, ports }, rig, gains, &clock)?;
        let surroundings = Box::new(AroundWires { control: interface.peer.clone() });
        let grounds = self.grounds(&interface, line_grounds);
        Ok(Opened { bus: bus_name, grounds, rig, clock, surroundings })
    }

    fn open_ports(&self, rig: &Rig, _purpose: &Purpose<'_>) -> Result<OpenedPorts, DeviceError> {
        let clock = Clock::real();
        let (ports, lines) = lines::open(rig, Ports::default(), &clock)?;
        Ok(OpenedPorts { ports, clock, lines })
    }

    fn wire_faults(&self) -> Option<&WireFaults> {
        self.on_wire.faults
    }
}

impl WiredSite<'_> {
    /// Opens a rig whose drives are on a CAN bus. The bus listens before it sends and refuses another main device.
    fn open_can(
        &self,
        rig: &Rig,
        bus: CanBus,
        name: &str,
        gains: &DirectorGains,
    ) -> Result<Opened, DeviceError> {
        let interface = Kernel::default().interface(name)?;
        let clock = Clock::real();
        let (ports, line_grounds) = lines::open(rig, Ports::default(), &clock)?;
        // Behind a virtual interface no drive holds an axis that could fall.
        let may_let_go = self.are_axes_secured || !interface.is_physical;
        let bus = can::on_interface(rig, bus, name, &clock, may_let_go)?;
        let bus_name = bus.name().to_owned();
        let rig = OpenRig::open(Wires { bus, ports }, rig, gains, &clock)?;
        let surroundings = Box::new(AroundWires { control: Some(name.to_owned()) });
        let grounds = self.grounds(&interface, line_grounds);
        Ok(Opened { bus: bus_name, grounds, rig, clock, surroundings })
    }

    /// What the bus is told: the shortest watchdog that a rig's axis asks for holds for all its stations.
    ///
    /// # Errors
    /// Drives of which one needs another phase of SYNC0 than another.
    fn settings(&self, rig: &Rig, interface: &Interface) -> Result<EtherCatSettings, DeviceError> {
        let watchdog_s =
            rig.axes.iter().map(|axis| axis.guard.safety.watchdog_s).fold(f64::INFINITY, f64::min);
        let usual =
            EtherCatSettings::usual(&format!("EtherCAT on {}", interface.name), 1.0 / rig.loop_rate_hz);
        let distributed_clocks = match usual.distributed_clocks {
            Some(usual) => clocks(rig, usual)?,
            None => None,
        };
        // Behind a virtual interface no drive holds an axis that could fall.
        let may_let_go = self.are_axes_secured || !interface.is_physical;
        Ok(EtherCatSettings { watchdog_s, distributed_clocks, stations: expected(rig), may_let_go, ..usual })
    }

    /// What interface and lines say about whether there is hardware behind them.
    fn grounds(&self, interface: &Interface, lines: Vec<LineGrounds>) -> BusGrounds {
        let name = &interface.name;
        let text = match (interface.is_physical, interface.is_pair) {
            (true, _) => format!("interface {name} has a physical device"),
            (false, true) => format!("interface {name} is one end of a pair of virtual interfaces"),
            (false, false) => format!("interface {name} is virtual"),
        };
        let is_disturbed = self.on_wire.faults.is_some();
        BusGrounds { is_physical: interface.is_physical, is_disturbed, text, lines }
    }
}

/// An interface that nothing else uses.
fn checked(name: &str) -> Result<Interface, DeviceError> {
    let kernel = Kernel::default();
    let interface = kernel.interface(name)?;
    kernel.check_unused(name, &drivers::wire::addresses(name)?)?;
    let before = kernel.received(name);
    clock::rest(SILENCE);
    interface::check_silent(name, before, kernel.received(name))?;
    Ok(interface)
}

/// Distributed clocks as the profiles of the drives have them; `None` where all drives run by the frames.
fn clocks(rig: &Rig, usual: DistributedClocks) -> Result<Option<DistributedClocks>, DeviceError> {
    let with_sync0 = || rig.axes.iter().filter(|axis| axis.drive.profile.clock.has_sync0);
    if with_sync0().next().is_none() {
        return Ok(None);
    }
    let shift = |axis: &&RigAxis| axis.drive.profile.clock.sync0_shift_s;
    let first = with_sync0().find(|axis| shift(axis).is_some());
    if let Some(first) = first
        && let Some(other) = with_sync0().find(|axis| shift(axis).is_some() && shift(axis) != shift(&first))
    {
        return Err(DeviceError::Field {
            device: format!("rig `{}`", rig.id),
            field: "sync0-shift",
            expected: format!("one for all drives of the wire, as that of `{}`", first.name),
            found: format!("another one for `{}`", other.name),
            help: "the frame passes all drives at once: give their profiles the same shift",
        });
    }
    // Where all drives have SYNC0, terminals that can have it get it as well.
    let is_for_all = with_sync0().count() == rig.axes.len();
    let sync0_stations =
        if is_for_all { Vec::new() } else { with_sync0().map(|axis| axis.drive.station).collect() };
    let sync0_shift_s = first.and_then(|axis| shift(&axis)).unwrap_or(usual.sync0_shift_s);
    Ok(Some(DistributedClocks { sync0_stations, sync0_shift_s, ..usual }))
}

/// The stations that the rig file names, and what it says of each: drives by their profiles, everything else by `[[terminal]]`.
fn expected(rig: &Rig) -> Vec<ExpectedStation> {
    let drives = rig.axes.iter().map(|axis| {
        let ProfileIdentity { vendor, product, revisions } = axis.drive.profile.identity;
        let station = axis.drive.station;
        ExpectedStation { station, name: axis.name.clone(), vendor, product, revisions, serial: axis.serial }
    });
    let others = rig.stations_beside_drives().into_iter().map(|own| {
        let terminal = own.terminal.as_ref();
        ExpectedStation {
            station: own.station,
            name: own.names.join(", "),
            vendor: terminal.and_then(|terminal| terminal.vendor),
            product: terminal.and_then(|terminal| terminal.product),
            revisions: None,
            serial: terminal.and_then(|terminal| terminal.serial),
        }
    });
    drives.chain(others).collect()
}

/// Ports of the terminals that the devices and the emergency stop of a rig name, and what bus and ports share.
fn terminals(rig: &Rig) -> (Ports, Images) {
    let mut ports = Ports::default();
    let mut images = Images::new();
    for own in rig.stations_beside_drives() {
        let station = own.station;
        let address = card_address(rig, station);
        let shared = Rc::new(RefCell::new(TerminalImage::default()));
        if own.is_card {
            ports = ports.with_card(&address, Box::new(TerminalCard::new(&address, Rc::clone(&shared))));
        }
        if own.is_emergency_stop {
            let card = TerminalCard::new(&address, Rc::clone(&shared));
            ports = ports.with_emergency_stop(Box::new(card));
        }
        if own.is_card || own.is_emergency_stop {
            images.push((station, shared));
        }
    }
    (ports, images)
}

/// The address of a station on the wire of the drives, as devices have it.
pub(super) fn card_address(rig: &Rig, station: u16) -> String {
    // A rig that is rehearsed in this process has no wire, and its devices still have their addresses.
    let named = rig.devices.iter().flat_map(|device| device.ports.values()).find(|text| {
        Address::parse(text)
            .is_ok_and(|own| matches!(own, Address::EtherCat { station: own, .. } if own == station))
    });
    let interface = || rig.interface().unwrap_or_default().to_owned();
    named.cloned().unwrap_or_else(|| Address::EtherCat { interface: interface(), station }.to_string())
}

/// What is around a rig on real wires: people, or the simulator at the far end.
struct AroundWires {
    /// Interface of a simulator at the far end.
    control: Option<String>,
}

impl Surroundings for AroundWires {
    /// Only the simulator knows; its own log tells.
    fn contacts(&self) -> Vec<Contact> {
        Vec::new()
    }

    /// A simulator is told by another thread, so that nothing waits for it; where there is none, prompts have asked people.
    fn bring(&mut self, case: &Case) {
        let Some(path) = self.control.as_deref().and_then(|name| path_for(name).ok()) else { return };
        let order = Order::Bring(Box::new(case.clone()));
        let carry = move |path: PathBuf| {
            let _ = tell(&path, &order);
        };
        let _ = std::thread::Builder::new().name("scenery".to_owned()).spawn(move || carry(path));
    }
}

#[cfg(test)]
mod tests {
    use procedures::diagnostic::SourceFile;

    use super::*;
    use crate::files::rig::read_rig;
    use crate::files::shipped;

    /// Drives and terminal of the shipped wired rig after these replacements, each of the first place where the text stands.
    fn rig(edits: &[(&str, &str)]) -> Rig {
        let mut text = shipped::wired_without_lines();
        for (old, new) in edits {
            assert!(text.contains(old), "the rig file no longer says {old}");
            text = text.replacen(old, new, 1);
        }
        read_rig(SourceFile::new("rig.toml", text)).expect("it parses")
    }

    const AZ: &str = "ports = { bus = \"ethercat:ecm/1\" }";

    #[test]
    fn the_stations_of_a_rig_are_its_drives_and_whatever_else_it_names() {
        let named = |rig: &Rig| {
            let stations = expected(rig).into_iter();
            stations.map(|own| (own.station, own.name, own.vendor, own.serial)).collect::<Vec<_>>()
        };
        let plain = |station, name: &str| (station, name.to_owned(), None, None);
        let card = plain(3, "reference, supply, force");
        assert_eq!(named(&rig(&[])), [plain(1, "az"), plain(2, "el"), card.clone()]);
        let elmo = format!("{AZ}\nprofile = \"elmo-gold\"\nserial = 7");
        let more = [
            (AZ, elmo.as_str()),
            ("emergency-stop-bit = 3", "emergency-stop = \"ethercat:ecm/5#2\" #"),
            (
                "[[device]]\nname = \"supply\"",
                "[[terminal]]\nname = \"coupler\"\naddress = \"ethercat:ecm/4\"\nvendor = 0x2\n\n[[device]]\nname = \"supply\"",
            ),
        ];
        let az = (1, "az".to_owned(), Some(0x9A), Some(7));
        let coupler = (4, "coupler".to_owned(), Some(2), None);
        let found = named(&rig(&more));
        assert_eq!(found, [az, plain(2, "el"), card, coupler, plain(5, "emergency stop")]);
    }

    #[test]
    fn sync0_goes_to_the_drives_whose_profiles_want_it() {
        let interface = Interface { name: "ecm".to_owned(), is_physical: false, peer: None, is_pair: true };
        let settings = |rig: &Rig| WiredSite::default().settings(rig, &interface);
        let clocks_of = |rig: &Rig| settings(rig).expect("one phase").distributed_clocks;
        let all = clocks_of(&rig(&[])).expect("distributed clocks");
        assert_eq!(
            (all.sync0_stations.len(), all.sync0_shift_s),
            (0, 0.0005),
            "every station that can have it"
        );
        let mut one = rig(&[]);
        let with_clock = |rig: &mut Rig, axis: usize, has_sync0, sync0_shift_s| {
            let mut profile = (*rig.axes[axis].drive.profile).clone();
            (profile.clock.has_sync0, profile.clock.sync0_shift_s) = (has_sync0, sync0_shift_s);
            rig.axes[axis].drive.profile = profile.into();
        };
        with_clock(&mut one, 0, false, None);
        with_clock(&mut one, 1, true, Some(0.0002));
        let clocks = clocks_of(&one).expect("distributed clocks");
        assert_eq!((clocks.sync0_stations, clocks.sync0_shift_s), (vec![2], 0.0002));
        with_clock(&mut one, 0, true, Some(0.0003));
        let error = settings(&one).expect_err("two phases").to_string();
        assert!(error.contains("sync0-shift") && error.contains("`el`"), "{error}");
        with_clock(&mut one, 0, false, None);
        with_clock(&mut one, 1, false, None);
        assert_eq!(clocks_of(&one), None);
    }

    #[test]
    fn one_station_has_one_image_and_the_ports_that_are_needed() {
        let stop = ("emergency-stop-bit = 3", "emergency-stop = \"ethercat:ecm/4#0\" #");
        let (mut ports, images) = terminals(&rig(&[("ethercat:ecm/3", "ethercat:ecm/03"), stop]));
        let stations: Vec<u16> = images.iter().map(|(station, _)| *station).collect();
        assert_eq!(stations, [3, 4]);
        assert_eq!(ports.find_card("reference", "ethercat:ecm/3"), Ok(0));
        assert!(ports.emergency_stop().is_some());
    }
}
