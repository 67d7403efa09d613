//! Real wires, real time, one session: simulated devices that `bench sim` serves, or the director. Both differ in nothing but
//! what the identities say.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use controllers::DirectorGains;
use drivers::device::DeviceError;
use drivers::wire::ethercat::{EtherCatBus, EtherCatSettings};
use drivers::wire::{EthernetLink, Fieldbus, PacketSocket, Tap};
use procedures::case::Case;

use super::interface::{self, Interface, Kernel};
use super::order::Order;
use super::terminal::{CardImage, Images, TerminalCard, WithTerminals};
use super::{BusGrounds, Contact, Opened, Purpose, Site, Surroundings, WireFaults, path_for, tell};
use crate::clock::{self, Clock};
use crate::model::address::Address;
use crate::model::rig::Rig;
use crate::record::tap::WireTap;
use crate::rig::OpenRig;
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
        let interface = checked(name)?;
        let clock = Clock::real();
        let bus = EtherCatBus::open(self.link(name, &clock)?, self.settings(rig, &interface))?;
        let (ports, images) = terminals(rig);
        let bus: Box<dyn Fieldbus> = Box::new(WithTerminals::new(bus, images));
        let bus_name = bus.name().to_owned();
        let rig = OpenRig::open(Wires { bus, ports }, rig, gains, &clock)?;
        let surroundings = Box::new(AroundWires { control: interface.peer.clone() });
        Ok(Opened { bus: bus_name, grounds: self.grounds(&interface), rig, clock, surroundings })
    }

    fn wire_faults(&self) -> Option<&WireFaults> {
        self.on_wire.faults
    }
}

impl WiredSite<'_> {
    /// What the bus is told: the shortest watchdog that a rig's axis asks for holds for all its stations.
    fn settings(&self, rig: &Rig, interface: &Interface) -> EtherCatSettings {
        let watchdog_s =
            rig.axes.iter().map(|axis| axis.guard.safety.watchdog_s).fold(f64::INFINITY, f64::min);
        let usual =
            EtherCatSettings::usual(&format!("EtherCAT on {}", interface.name), 1.0 / rig.loop_rate_hz);
        // Behind a virtual interface no drive holds an axis that could fall.
        let may_let_go = self.are_axes_secured || !interface.is_physical;
        EtherCatSettings { watchdog_s, may_let_go, ..usual }
    }

    /// What the interface says about whether there is hardware behind it.
    fn grounds(&self, interface: &Interface) -> BusGrounds {
        let name = &interface.name;
        let text = match (interface.is_physical, interface.is_pair) {
            (true, _) => format!("interface {name} has a physical device"),
            (false, true) => format!("interface {name} is one end of a pair of virtual interfaces"),
            (false, false) => format!("interface {name} is virtual"),
        };
        let is_disturbed = self.on_wire.faults.is_some();
        BusGrounds { is_physical: interface.is_physical, is_disturbed, text }
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

/// Ports of the terminals that the devices of a rig name, and what bus and ports share.
fn terminals(rig: &Rig) -> (Ports, Images) {
    let mut ports = Ports::default();
    let mut images = Images::new();
    for (text, station) in terminal_addresses(rig) {
        let image = Rc::new(RefCell::new(CardImage::default()));
        ports = ports.with_card(&text, Box::new(TerminalCard::new(&text, Rc::clone(&image))));
        images.push((station, image));
    }
    (ports, images)
}

/// Addresses of the terminals of a rig, each once, as devices write them.
pub(super) fn terminal_addresses(rig: &Rig) -> Vec<(String, u16)> {
    let mut found: Vec<(String, u16)> = Vec::new();
    for text in rig.devices.iter().flat_map(|device| device.ports.values()) {
        if let Ok(Address::EtherCat { station, .. }) = Address::parse(text)
            && !found.iter().any(|(known, _)| known == text)
        {
            found.push((text.clone(), station));
        }
    }
    found
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
