//! The production bus and drivers on a CAN interface, and a wire in the process with nodes at its far end.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use drivers::cia402::{
    Actuals, Cia402, CyclicMode, DriveCommand, DriveSettings, Identity, PowerState, PowerTarget, Waiting,
};
use drivers::device::DeviceError;
use drivers::wire::can::{CanEvent, CanFrame, CanLink};
use drivers::wire::canopen::{CanOpenBus, CanOpenSettings};
use drivers::wire::{BusState, Exchange, Fieldbus, ProcessImage, SdoAbort, SdoRequest, SdoWire, Slot};
use sim_devices::canopen::{InProcessCan, NodeFault};
use sim_devices::rig::{AxesTruth, SeedAddress, SimulatedRig, StartState};
use sim_devices::unit::UnitSettings;

/// Two drives with their six PDOs each fill 74 % of such a cycle at 1 Mbit/s.
pub(crate) const TICK: Duration = Duration::from_millis(2);

pub(crate) type Clock = Box<dyn Fn() -> Duration>;

pub(crate) fn rig() -> SimulatedRig {
    let address = SeedAddress { seed: 3, procedure: "TEST".into(), point: "1".into() };
    let start = StartState { az_rad: -1.0, el_rad: 0.7, heat_sink_degc: 45.0 };
    SimulatedRig::at_rate(&UnitSettings::default(), &address, start, 500.0)
}

/// A wire in the process, shared with the test.
#[derive(Clone)]
pub(crate) struct Wire {
    can: Rc<RefCell<InProcessCan>>,
    rig: SimulatedRig,
    /// Frames of somebody else.
    foreign: Rc<RefCell<VecDeque<CanFrame>>>,
    sent: Rc<RefCell<Vec<CanFrame>>>,
}

impl Wire {
    pub(crate) fn inject(&self, fault: NodeFault) {
        let now = self.now();
        self.can.borrow_mut().line().inject(now, fault).expect("there is such a node");
    }

    /// The host hears a frame of somebody else.
    pub(crate) fn hear(&self, frame: CanFrame) {
        self.foreign.borrow_mut().push_back(frame);
    }

    /// Frames that the host has sent since this was last asked.
    pub(crate) fn sent(&self) -> Vec<CanFrame> {
        std::mem::take(&mut self.sent.borrow_mut())
    }

    pub(crate) fn truth(&self) -> AxesTruth {
        self.rig.truth_of_axes()
    }

    pub(crate) fn rig(&self) -> &SimulatedRig {
        &self.rig
    }

    /// Frames that the nodes send while time passes.
    pub(crate) fn heard(&mut self, lasting: Duration) -> Vec<CanFrame> {
        let until = self.now() + lasting;
        let mut frames = Vec::new();
        while self.now() < until {
            self.wait(until).expect("the wire works");
            while let Some(event) = self.receive().expect("the wire works") {
                frames.extend(match event {
                    CanEvent::Frame(frame) => Some(frame),
                    CanEvent::Error(_) => None,
                });
            }
        }
        frames
    }
}

impl CanLink for Wire {
    fn name(&self) -> &str {
        "simulated CAN"
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.sent.borrow_mut().push(*frame);
        self.can.borrow_mut().send(frame)
    }

    fn receive(&mut self) -> io::Result<Option<CanEvent>> {
        match self.foreign.borrow_mut().pop_front() {
            Some(frame) => Ok(Some(CanEvent::Frame(frame))),
            None => self.can.borrow_mut().receive(),
        }
    }

    fn now(&self) -> Duration {
        self.can.borrow().now()
    }

    fn wait(&mut self, until: Duration) -> io::Result<()> {
        self.can.borrow_mut().wait(until)
    }
}

/// A wire to two drives, and its clock.
pub(crate) fn simulated() -> (Wire, Clock) {
    let rig = rig();
    let can = Rc::new(RefCell::new(InProcessCan::new(rig.canopen_line(), 1e6)));
    let wire = Wire { can, rig, foreign: Rc::default(), sent: Rc::default() };
    let clock = wire.clone();
    (wire, Box::new(move || clock.now()))
}

pub(crate) fn settings() -> CanOpenSettings {
    CanOpenSettings::usual("bus 0", TICK.as_secs_f64(), &[1, 2])
}

pub(crate) fn drive_settings(station: u16) -> DriveSettings {
    let az = station == 1;
    DriveSettings {
        name: if az { "az" } else { "el" }.into(),
        station,
        profile: super::profile::simulated(),
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
        watchdog_s: 0.1,
        cycle_s: TICK.as_secs_f64(),
        transition_timeout_s: 2.0,
    }
}

/// Bus and drives, mapped and in SAFE-OP.
pub(crate) struct Bench {
    pub(crate) bus: CanOpenBus,
    wire: Option<Wire>,
    pub(crate) drives: Vec<Cia402>,
    pub(crate) identities: Vec<Identity>,
    pub(crate) slots: Vec<(u16, Slot)>,
    pub(crate) image: ProcessImage,
    pub(crate) actuals: Vec<Actuals>,
    pub(crate) now: Duration,
    pub(crate) clock: Clock,
}

/// A bench in front of a wire in the process.
pub(crate) fn in_process() -> Bench {
    let (wire, clock) = simulated();
    let mut bench = Bench::open(Box::new(wire.clone()), clock, settings()).expect("two drives answer");
    wire.sent();
    bench.wire = Some(wire);
    bench
}

impl Bench {
    /// Opens bus and drives on an interface.
    pub(crate) fn open(
        link: Box<dyn CanLink>,
        clock: Clock,
        settings: CanOpenSettings,
    ) -> Result<Self, DeviceError> {
        // Process data stop a drive before heartbeats do.
        let watchdog_s = 2.0 * settings.heartbeat_s;
        let mut bus = CanOpenBus::open(link, settings)?;
        let (mut drives, mut identities) = (Vec::new(), Vec::new());
        for station in bus.stations() {
            let mut at = clock();
            let mut pause = || {
                at = clock().max(at) + Duration::from_micros(500);
                at
            };
            let mut waiting = Waiting { now: clock(), pause: &mut pause };
            let (drive, identity) = Cia402::open(
                &mut bus,
                DriveSettings { watchdog_s, ..drive_settings(station) },
                &mut waiting,
            )?;
            drives.push(drive);
            identities.push(identity);
        }
        let (image, slots) = bus.map()?;
        for (drive, (_, slot)) in drives.iter_mut().zip(&slots) {
            drive.attach(slot.clone());
        }
        let actuals = vec![Actuals::default(); drives.len()];
        let now = clock();
        Ok(Self { bus, wire: None, drives, identities, slots, image, actuals, now, clock })
    }

    pub(crate) fn wire(&self) -> Wire {
        self.wire.clone().expect("a bench in one process")
    }

    pub(crate) fn exchange(&mut self) -> Result<Exchange, DeviceError> {
        self.now = (self.now + TICK).max((self.clock)());
        self.bus.exchange(self.now, &mut self.image)
    }

    /// One tick on the way to a power state, in CSV.
    pub(crate) fn tick(&mut self, target: PowerTarget, az_rad_per_s: f64) -> Exchange {
        let exchange = self.exchange().expect("the wire works");
        for (k, drive) in self.drives.iter_mut().enumerate() {
            let actuals = drive.decode(&self.image.inputs);
            let controlword = drive
                .controlword(target, actuals.statusword, actuals.error_code, self.now)
                .expect("the twin follows in time");
            let velocity_rad_per_s = if k == 0 { az_rad_per_s } else { 0.0 };
            let mode = CyclicMode::Velocity;
            let command = DriveCommand { controlword, mode, torque_nm: 0.0, velocity_rad_per_s };
            drive.encode(&command, &mut self.image.outputs);
            self.actuals[k] = actuals;
        }
        exchange
    }

    pub(crate) fn move_for(&mut self, ticks: u32, az_rad_per_s: f64) {
        for _ in 0..ticks {
            self.tick(PowerTarget::Enabled, az_rad_per_s);
        }
    }

    pub(crate) fn states(&self) -> Vec<PowerState> {
        self.actuals.iter().map(|actuals| PowerState::of(actuals.statusword)).collect()
    }

    pub(crate) fn enter_op(&mut self) {
        self.bus.request(BusState::Op);
        self.tick(PowerTarget::Disabled, 0.0);
        assert_eq!(self.bus.state(), BusState::Op);
    }

    /// Both drives enabled, within a second.
    pub(crate) fn enable(&mut self) {
        self.enter_op();
        for _ in 0..500 {
            self.tick(PowerTarget::Enabled, 0.0);
            if self.states().iter().all(|state| *state == PowerState::OperationEnabled) {
                return;
            }
        }
        panic!("{:?}", self.states());
    }

    /// What was noticed since this was last asked: station and words.
    pub(crate) fn notices(&mut self) -> Vec<String> {
        let mut notices = Vec::new();
        self.bus
            .tell_notices(&mut |notice| notices.push(format!("{}: {}", notice.station, notice.news.text())));
        notices
    }

    /// One SDO transfer beside the exchanges; the number of ticks that it took.
    pub(crate) fn sdo(&mut self, request: &SdoRequest<'_>) -> (Result<Vec<u8>, SdoAbort>, u32) {
        self.bus.start(self.now, request);
        let mut read = Vec::new();
        for ticks in 1..2000 {
            self.tick(PowerTarget::Disabled, 0.0);
            match self.bus.poll(self.now, &mut read) {
                Ok(true) => return (Ok(read), ticks),
                Ok(false) => {}
                Err(abort) => return (Err(abort), ticks),
            }
        }
        panic!("no transfer takes 2000 ticks");
    }
}

pub(crate) const fn reading(station: u16, index: u16, sub: u8) -> SdoRequest<'static> {
    SdoRequest { station, index, sub, write: None }
}
