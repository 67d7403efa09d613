//! Emulated SubDevices on a wire in the process, and the production bus and drivers in front of them.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use drivers::cia402::profile::DriveProfile;
use drivers::cia402::{
    Actuals, Cia402, CyclicMode, DriveCommand, DriveSettings, Identity, PowerState, PowerTarget, Waiting,
};
use drivers::device::DeviceError;
use drivers::wire::ethercat::{EtherCatBus, EtherCatSettings};
use drivers::wire::{
    BusState, EthernetLink, Exchange, Fieldbus, ProcessImage, SdoAbort, SdoRequest, SdoWire, Slot,
};
use sim_devices::ethercat::{InProcessLink, LineFault, Terminals};
use sim_devices::rig::{DriveType, SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

use crate::profile;

pub(crate) const TICK: Duration = Duration::from_micros(250);

/// The wire, shared with the test.
#[derive(Clone)]
pub(crate) struct SharedLink(Rc<RefCell<InProcessLink>>);

impl SharedLink {
    pub(crate) fn new() -> Self {
        Self::with_line(DriveType::Simulated, Terminals { analog: true, digital: false }).0
    }

    /// Drives of a type, with terminals behind them; and the rig behind the wire.
    pub(crate) fn with_line(drive_type: DriveType, terminals: Terminals) -> (Self, SimulatedRig) {
        let address = SeedAddress { seed: 3, procedure: "TEST".into(), point: "1".into() };
        let start = StartState { az_rad: -1.0, el_rad: 1.2, heat_sink_degc: 45.0 };
        let rig = SimulatedRig::new(&UnitSettings::default(), &address, start);
        [0, 1].into_iter().for_each(|drive| rig.make_drive(drive, drive_type));
        let line = rig.ethercat_line(terminals);
        (Self(Rc::new(RefCell::new(InProcessLink::new(line)))), rig)
    }

    pub(crate) fn inject(&self, fault: LineFault) {
        let now = self.now();
        self.0.borrow_mut().line().inject(now, fault).expect("there is such a device");
    }
}

impl EthernetLink for SharedLink {
    fn name(&self) -> &str {
        "wire"
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        self.0.borrow_mut().send(frame)
    }

    fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        self.0.borrow_mut().receive(into)
    }

    fn now(&self) -> Duration {
        self.0.borrow().now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.0.borrow_mut().wait(until)
    }
}

pub(crate) fn settings() -> EtherCatSettings {
    EtherCatSettings::usual("bus 0", TICK.as_secs_f64())
}

pub(crate) fn drive_settings(station: u16) -> DriveSettings {
    let az = station == 1;
    DriveSettings {
        name: if az { "az" } else { "el" }.into(),
        station,
        profile: profile::simulated(),
        torque_constant_nm_per_a: if az { 60.0 } else { 52.0 },
        rated_current_a: 2.0,
        rated_torque_nm: if az { 120.0 } else { 104.0 },
        max_torque_nm: if az { 2556.0 } else { 1882.0 },
        encoder_counts_per_rev: 1 << 26,
        encoder_offset_rad: 0.0,
        encoder_sign: 1.0,
        soft_limits_rad: if az { [-2.75, 2.75] } else { [-0.15, 1.55] },
        max_velocity_rad_per_s: 1.2,
        quick_stop_deceleration_rad_per_s2: 1.5,
        quick_stop_option: 6,
        fault_reaction_option: 2,
        abort_connection_option: 1,
        watchdog_s: 0.02,
        cycle_s: TICK.as_secs_f64(),
        transition_timeout_s: 2.0,
    }
}

/// Bus and drives, mapped and in SAFE-OP.
pub(crate) struct Bench {
    pub(crate) link: SharedLink,
    pub(crate) bus: EtherCatBus,
    pub(crate) drives: Vec<Cia402>,
    pub(crate) identities: Vec<Identity>,
    profile: Arc<DriveProfile>,
    pub(crate) slots: Vec<(u16, Slot)>,
    pub(crate) image: ProcessImage,
    pub(crate) actuals: [Actuals; 2],
    pub(crate) now: Duration,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::with(settings())
    }

    pub(crate) fn with(settings: EtherCatSettings) -> Self {
        Self::through(settings, |link| Box::new(link))
    }

    /// With something between bus and wire.
    pub(crate) fn through(
        settings: EtherCatSettings,
        between: impl FnOnce(SharedLink) -> Box<dyn EthernetLink>,
    ) -> Self {
        let link = SharedLink::new();
        let bus =
            EtherCatBus::open(between(link.clone()), settings).expect("two drives and a terminal answer");
        Self::on(link, bus, profile::simulated())
    }

    /// With drives of a type on this line.
    pub(crate) fn of_type(link: SharedLink, profile: Arc<DriveProfile>) -> Self {
        let bus = EtherCatBus::open(Box::new(link.clone()), settings()).expect("the line answers");
        Self::on(link, bus, profile)
    }

    /// Why the first drive of a line cannot be opened with a profile.
    pub(crate) fn refusal(link: SharedLink, profile: Arc<DriveProfile>) -> String {
        let bus = EtherCatBus::open(Box::new(link.clone()), settings()).expect("the line answers");
        let mut bench = Self::unopened(link, bus, profile);
        bench.open_drive(1).expect_err("another type").to_string()
    }

    pub(crate) fn on(link: SharedLink, bus: EtherCatBus, profile: Arc<DriveProfile>) -> Self {
        let mut bench = Self::unopened(link, bus, profile);
        bench.arm();
        bench
    }

    fn unopened(link: SharedLink, bus: EtherCatBus, profile: Arc<DriveProfile>) -> Self {
        Self {
            link,
            bus,
            drives: Vec::new(),
            identities: Vec::new(),
            profile,
            slots: Vec::new(),
            image: ProcessImage::default(),
            actuals: Default::default(),
            now: Duration::ZERO,
        }
    }

    /// Opens both drives and maps the bus.
    pub(crate) fn arm(&mut self) {
        (self.drives, self.identities) = (Vec::new(), Vec::new());
        for station in [1, 2] {
            let (drive, identity) = self.open_drive(station).expect("the twin answers");
            self.drives.push(drive);
            self.identities.push(identity);
        }
        (self.image, self.slots) = self.bus.map().expect("the driver's mapping is valid");
        for (drive, (_, slot)) in self.drives.iter_mut().zip(&self.slots) {
            drive.attach(slot.clone());
        }
        self.now = self.link.now();
    }

    fn open_drive(&mut self, station: u16) -> Result<(Cia402, Identity), DeviceError> {
        let link = self.link.clone();
        let mut at = self.link.now();
        let mut pause = || {
            at = link.now().max(at) + Duration::from_micros(500);
            at
        };
        let mut waiting = Waiting { now: self.link.now(), pause: &mut pause };
        let settings = DriveSettings { profile: Arc::clone(&self.profile), ..drive_settings(station) };
        Cia402::open(&mut self.bus, settings, &mut waiting)
    }

    pub(crate) fn exchange(&mut self) -> Exchange {
        self.now += TICK;
        self.bus.exchange(self.now, &mut self.image).expect("the wire works")
    }

    pub(crate) fn tick(&mut self, target: PowerTarget) -> Exchange {
        let exchange = self.exchange();
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let actuals = drive.decode(&self.image.inputs);
            let controlword = drive
                .controlword(target, actuals.statusword, actuals.error_code, self.now)
                .expect("the twin follows in time");
            let command = DriveCommand {
                controlword,
                mode: CyclicMode::Torque,
                torque_nm: 0.0,
                velocity_rad_per_s: 0.0,
            };
            drive.encode(&command, &mut self.image.outputs);
            self.actuals[k] = actuals;
        }
        exchange
    }

    pub(crate) fn states(&self) -> [PowerState; 2] {
        self.actuals.map(|actuals| PowerState::of(actuals.statusword))
    }

    /// Ticks until the bus is in a state; fails after a second.
    pub(crate) fn reach_bus_state(&mut self, state: BusState) {
        let end = self.now + Duration::from_secs(1);
        while self.bus.state() != state {
            if self.now >= end {
                let errors: Vec<_> = self.bus.al_errors().map(|error| error.to_string()).collect();
                panic!("{:?} instead of {state:?}: {errors:?}", self.bus.state());
            }
            self.tick(PowerTarget::Disabled);
        }
    }

    pub(crate) fn enter_op(&mut self) {
        self.bus.request(BusState::Op);
        self.reach_bus_state(BusState::Op);
    }

    /// One SDO transfer beside the exchanges; the number of ticks that it took.
    pub(crate) fn sdo(&mut self, request: &SdoRequest<'_>) -> (Result<Vec<u8>, SdoAbort>, u32) {
        self.bus.start(self.now, request);
        let mut read = Vec::new();
        for ticks in 1..10_000 {
            let exchange = self.exchange();
            assert!(exchange.working_counter == 0 || exchange.working_counter == exchange.expected);
            match self.bus.poll(self.now, &mut read) {
                Ok(true) => return (Ok(read), ticks),
                Ok(false) => {}
                Err(abort) => return (Err(abort), ticks),
            }
        }
        panic!("no transfer takes 10 000 ticks");
    }
}

pub(crate) const fn reading(station: u16, index: u16, sub: u8) -> SdoRequest<'static> {
    SdoRequest { station, index, sub, write: None }
}
