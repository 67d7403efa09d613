//! The far ends, and the time that passes by itself.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::kvh::{Format, KvhSettings, Opening, Synchronisation};
use drivers::wire::ByteLine;
use drivers::wire::fault::{ByteFaultControl, ByteLineFaultPlan, FaultyByteLine};
use drivers::wire::lines::{HostLine, LineAddress, Lines};
use rustix::thread::{ClockId, clock_nanosleep_relative};
use rustix::time::{Timespec, clock_gettime};
use sim_devices::kvh::{Kvh, KvhLine};
use sim_devices::motion::Motion;
use sim_devices::rig::{SeedAddress, SimulatedRig};
use sim_devices::served::LinePump;
use sim_devices::unit::{ImuSettings, UnitSettings};
use sim_devices::world::StartState;

const BAUD: u32 = 921_600;
const MESSAGE_RATE_HZ: f64 = 1000.0;
pub(crate) const MESSAGE_PERIOD: Duration = Duration::from_millis(1);

/// Real time from 0 on.
#[derive(Clone, Copy)]
pub(crate) struct Timer(Duration);

impl Timer {
    pub(crate) fn start() -> Self {
        Self(monotonic())
    }

    pub(crate) fn now(self) -> Duration {
        monotonic() - self.0
    }
}

fn monotonic() -> Duration {
    let now = clock_gettime(ClockId::Monotonic);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).expect("less than a second"))
}

pub(crate) fn nap() {
    let _ = clock_nanosleep_relative(ClockId::Monotonic, &Timespec { tv_sec: 0, tv_nsec: 200_000 });
}

pub(crate) fn lines(timer: Timer) -> Lines {
    Lines::start(Box::new(move || timer.now())).expect("a thread")
}

fn address() -> SeedAddress {
    SeedAddress { seed: 2, procedure: "SERVED".into(), point: "1".into() }
}

pub(crate) fn rig() -> SimulatedRig {
    let start = StartState { az_rad: 0.0, el_rad: 0.3, heat_sink_degc: 25.0 };
    SimulatedRig::new(&UnitSettings::default(), &address(), start)
}

/// A device that has much to say at once.
pub(crate) struct Burst {
    bytes: Vec<u8>,
    said_count: usize,
}

impl Burst {
    pub(crate) fn new(bytes: Vec<u8>) -> Self {
        Self { bytes, said_count: 0 }
    }
}

impl ByteLine for Burst {
    fn name(&self) -> &str {
        "burst"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.bytes.len() - self.said_count);
        into[..count].copy_from_slice(&self.bytes[self.said_count..][..count]);
        self.said_count += count;
        Ok(count)
    }

    fn write(&mut self, _: Duration, _: &[u8]) -> Result<(), DeviceError> {
        Ok(())
    }
}

/// An inertial unit on a pty, with a pulse a millisecond.
pub(crate) struct Imu {
    unit: Rc<RefCell<Kvh>>,
    far: FaultyByteLine<KvhLine>,
    control: Arc<ByteFaultControl>,
    pub(crate) pump: LinePump,
    timer: Timer,
    tick: u64,
    lines: Option<Lines>,
}

/// A driver that has opened its unit.
pub(crate) struct Opened {
    pub(crate) driver: drivers::kvh::Kvh,
    pub(crate) line: HostLine,
}

impl Imu {
    pub(crate) fn new(plan: ByteLineFaultPlan) -> Self {
        let imu = ImuSettings { baud_count: BAUD.into(), startup_s: 0.0, ..UnitSettings::default().imu };
        let unit = Rc::new(RefCell::new(Kvh::new(&imu, &address(), MESSAGE_RATE_HZ)));
        let control = Arc::new(ByteFaultControl::default());
        let far = FaultyByteLine::new(KvhLine(Rc::clone(&unit)), plan, Arc::clone(&control));
        let pump = LinePump::pty(BAUD).expect("a pty");
        Self { unit, far, control, pump, timer: Timer::start(), tick: 0, lines: None }
    }

    pub(crate) fn settings() -> KvhSettings {
        KvhSettings {
            name: "imu".into(),
            baud: BAUD,
            format: Format::A,
            synchronisation: Synchronisation::External,
            message_rate_hz: MESSAGE_RATE_HZ,
            rate_output: true,
            answer_timeout_s: 1.0,
        }
    }

    pub(crate) fn now(&self) -> Duration {
        self.timer.now()
    }

    /// Waits for the next pulse and gives it; the far end moves bytes meanwhile.
    pub(crate) fn tick(&mut self) {
        self.tick += 1;
        let due = MESSAGE_PERIOD * u32::try_from(self.tick).expect("a short test");
        loop {
            let now = self.now();
            self.pump.pump(&mut self.far, now).expect("the line is there");
            if now >= due {
                break;
            }
            nap();
        }
        self.unit.borrow_mut().pulse(self.tick, &Motion::default());
    }

    /// The host's end.
    pub(crate) fn connect(&mut self) -> (Lines, HostLine) {
        let mut lines = lines(self.timer);
        let address = LineAddress::parse(self.pump.address()).expect("an address");
        let line = lines.open_line(&address).expect("opens");
        (lines, line)
    }

    pub(crate) fn open(&mut self) -> Opened {
        let (lines, mut line) = self.connect();
        self.lines = Some(lines);
        let mut opening = Opening::new(Self::settings()).expect("the messages fit");
        for _ in 0..10_000 {
            self.tick();
            if let Some(driver) = opening.poll(&mut line, self.now()).expect("it opens") {
                return Opened { driver, line };
            }
        }
        panic!("not open after ten seconds")
    }

    /// The error of an opening while the far end is not served.
    pub(crate) fn open_without_pump(&self, settings: KvhSettings, line: &mut HostLine) -> String {
        let mut opening = Opening::new(settings).expect("the messages fit");
        loop {
            match opening.poll(line, self.now()) {
                Ok(None) => nap(),
                Ok(Some(_)) => panic!("nobody answers"),
                Err(error) => return error.to_string(),
            }
        }
    }

    pub(crate) fn begin_faults(&self) {
        self.control.begin();
    }

    /// Pulls the plug: the far end is gone.
    pub(crate) fn unplug(&mut self) -> Timer {
        self.pump = LinePump::pty(BAUD).expect("another pty");
        self.timer
    }
}
