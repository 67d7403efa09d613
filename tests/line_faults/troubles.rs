//! Faults that begin at an instant of a session.

use std::sync::Arc;
use std::time::Duration;

use bench::rig::wires::{Ports, Wires};
use drivers::device::DeviceError;
use drivers::wire::fault::{
    ByteFaultControl, ByteFaultKind, ByteLineFault, ByteLineFaultPlan, CounterJump, FaultControl, FaultKind,
    FaultPlan, FaultyByteLine, FaultyDatagramPort, FrameFault, Occurrence, PortFaultPlan, PortSilence,
};
use drivers::wire::{ByteLine, DatagramPort, Way};
use sim_devices::rig::SimulatedRig;

/// What goes wrong with a line of bytes.
#[derive(Clone)]
pub(super) enum Trouble {
    /// Nothing passes for a time, either way.
    Silence(Duration),
    /// So many bytes that nobody sent come in before some of those that the device sends.
    Garbage(usize, Occurrence),
    /// So many bytes of what the device sends are lost.
    Cut(u64),
    /// One bit of a byte that the device sends is wrong, with this probability.
    Damage(f64),
    /// The line is gone, as one of the operating system says it.
    Gone { address: &'static str, found: &'static str, help: &'static str },
    /// A block of the device says another length than it has.
    WrongBlock,
}

/// A line with a trouble from an instant on.
struct Troubled {
    line: Box<dyn ByteLine>,
    from: Duration,
    control: Arc<ByteFaultControl>,
    trouble: Trouble,
    header: Header,
}

/// Where a stream of answers is in the header of its first block, `#` and the number of digits before the length.
#[derive(Clone, Copy)]
enum Header {
    Awaited,
    Mark,
    Digits(u8),
    Passed,
}

impl Header {
    /// Changes the last digit of the length.
    fn pass(&mut self, byte: &mut u8) {
        *self = match (*self, *byte) {
            (Self::Awaited, b'#') => Self::Mark,
            (Self::Awaited, _) => Self::Awaited,
            (Self::Mark, digits) => Self::Digits(digits - b'0'),
            (Self::Digits(1), last) => {
                *byte = if last == b'0' { b'9' } else { last - 1 };
                Self::Passed
            }
            (Self::Digits(left), _) => Self::Digits(left - 1),
            (Self::Passed, _) => Self::Passed,
        };
    }
}

/// The line of a device with a trouble that begins at `from`, the time of the session.
pub(super) fn troubled(rig: &SimulatedRig, port: &str, from: Duration, trouble: Trouble) -> Wires {
    let Wires { bus, ports } = Wires::simulated(rig);
    let control = Arc::<ByteFaultControl>::default();
    let through = |line| -> Box<dyn ByteLine> {
        let plan = ByteLineFaultPlan { seed: 1, faults: faults(&trouble) };
        let line = Box::new(FaultyByteLine::new(line, plan, Arc::clone(&control)));
        Box::new(Troubled {
            line,
            from,
            control: Arc::clone(&control),
            trouble: trouble.clone(),
            header: Header::Awaited,
        })
    };
    Wires { bus, ports: ports.with_line_through(port, through) }
}

fn faults(trouble: &Trouble) -> Vec<ByteLineFault> {
    let first = |count| Occurrence::At { first: 1, count };
    let back = |kind, when| vec![ByteLineFault { way: Way::Back, kind, when }];
    match *trouble {
        Trouble::Silence(lasts) => [Way::Out, Way::Back]
            .map(|way| ByteLineFault { way, kind: ByteFaultKind::Silence { lasts }, when: first(1) })
            .into(),
        Trouble::Garbage(bytes, when) => back(ByteFaultKind::Insert { bytes }, when),
        Trouble::Cut(count) => back(ByteFaultKind::Drop, first(count)),
        Trouble::Damage(probability) => back(ByteFaultKind::Corrupt, Occurrence::Chance(probability)),
        Trouble::Gone { .. } | Trouble::WrongBlock => Vec::new(),
    }
}

impl Troubled {
    /// Begins what is due; the error of a line that is gone.
    fn befall(&self, now: Duration) -> Result<(), DeviceError> {
        if now < self.from {
            return Ok(());
        }
        self.control.begin();
        let Trouble::Gone { address, found, help } = self.trouble else { return Ok(()) };
        Err(DeviceError::Field {
            device: address.to_owned(),
            field: "line",
            expected: "an open line".to_owned(),
            found: found.to_owned(),
            help,
        })
    }
}

impl ByteLine for Troubled {
    fn name(&self) -> &str {
        self.line.name()
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        self.befall(now)?;
        let count = self.line.read(now, into)?;
        if matches!(self.trouble, Trouble::WrongBlock) {
            into[..count].iter_mut().for_each(|byte| self.header.pass(byte));
        }
        Ok(count)
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.befall(now)?;
        self.line.write(now, bytes)
    }
}

/// What goes wrong with a port of datagrams.
#[derive(Clone)]
pub(super) enum PortTrouble {
    /// Nothing arrives for a time.
    Silence(Duration),
    /// Every datagram has a wrong bit.
    Damage,
    /// Every datagram is cut in half.
    Half,
    /// The counter of the device jumps by so much, and the first datagram after that has a wrong bit.
    CounterJumpAndDamage(u32),
}

struct TroubledPort {
    port: FaultyDatagramPort<Box<dyn DatagramPort>>,
    from: Duration,
    control: Arc<FaultControl>,
}

/// The ports of trackers, that of the coarse one with a trouble that begins at `from`, the time of the session.
pub(super) fn troubled_coarse(rig: &SimulatedRig, from: Duration, trouble: &PortTrouble) -> Wires {
    let control = Arc::<FaultControl>::default();
    let port = FaultyDatagramPort::new(rig.coarse_port(), plan(trouble), Arc::clone(&control));
    let ports = Ports::default()
        .with_socket("sim:coarse", Box::new(TroubledPort { port, from, control }))
        .with_socket("sim:fine", rig.fine_port())
        .with_card("sim:analog", rig.analog_card())
        .with_line("sim:imu", rig.imu_line())
        .with_line("sim:mirror", rig.mirror_line())
        .with_line("sim:analyser", rig.analyser_line())
        .with_line("sim:scope", rig.scope_line());
    Wires { bus: rig.bus(), ports }
}

fn plan(trouble: &PortTrouble) -> PortFaultPlan {
    let all = Occurrence::Chance(1.0);
    let of_all = |kind, when| PortFaultPlan {
        datagrams: FaultPlan { seed: 1, faults: vec![FrameFault { way: Way::Back, kind, when }] },
        ..PortFaultPlan::default()
    };
    match *trouble {
        PortTrouble::Silence(lasts) => {
            PortFaultPlan { silences: vec![PortSilence { first: 1, lasts }], ..PortFaultPlan::default() }
        }
        PortTrouble::Damage => of_all(FaultKind::Corrupt { byte: None }, all),
        PortTrouble::Half => of_all(FaultKind::Truncate { bytes: 16 }, all),
        PortTrouble::CounterJumpAndDamage(by) => PortFaultPlan {
            jumps: vec![CounterJump { first: 1, by, add: drivers::tracker::advance_counter }],
            ..of_all(FaultKind::Corrupt { byte: None }, Occurrence::At { first: 1, count: 1 })
        },
    }
}

impl DatagramPort for TroubledPort {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn receive(&mut self, now: Duration, into: &mut [u8]) -> Result<Option<usize>, DeviceError> {
        if now >= self.from {
            self.control.begin();
        }
        self.port.receive(now, into)
    }

    fn send(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.port.send(now, bytes)
    }
}
