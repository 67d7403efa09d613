//! An EtherCAT bus of the kernel's own master (IgH EtherLab 1.5), for sites that have it.
//!
//! **Never run**: there was no kernel module to run it against. It compiles, and follows what the master's documentation says.
//!
//! What differs from [`EtherCatBus`](super::ethercat::EtherCatBus):
//! - Inputs are those of the frame that the exchange before has sent, for the kernel takes replies when it is asked: one
//!   tick older than the trait promises, and the first exchange has working counter 0.
//! - The master brings all stations into OP by itself as soon as the bus is mapped and exchanges go on. Outputs are 0 until
//!   a driver sets them.
//! - Abort codes of refused transfers are lost in the binding: they read 0800_0000h, general error.
//! - No distributed clocks, no emergencies.

mod mapping;
mod worker;

use std::ops::Range;
use std::time::Duration;

use ethercat::{AlState, DomainIdx, Error, Master, MasterAccess, SlaveId, SlavePos, WcState};

use super::{BusState, Exchange, Fieldbus, PdoTransport, ProcessImage, SdoAbort, SdoRequest, SdoWire, Slot};
use crate::device::DeviceError;
use mapping::{Mapping, Target};
use worker::Worker;

/// The master that is used: that of `/dev/EtherCAT0`.
const MASTER: u32 = 0;
const DEVICE: &str = "/dev/EtherCAT0";
/// Divider of the watchdog for steps of 100 µs: 2498 + 2 periods of 25 MHz.
const WATCHDOG_DIVIDER: u16 = 2498;
const WATCHDOG_STEP_S: f64 = 100e-6;

/// A station, as the master found it.
#[derive(Clone, Copy, Debug)]
struct Station {
    /// Alias, or place on the line counted from 1.
    number: u16,
    position: SlavePos,
    id: SlaveId,
}

/// The same bytes in the master's domain and in our image.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Share {
    in_domain: Range<usize>,
    in_image: Range<usize>,
}

/// Where process data stand.
struct Mapped {
    outputs: Vec<Share>,
    inputs: Vec<Share>,
    output_bytes: usize,
    input_bytes: usize,
    working_counter: u16,
}

/// A bus of the kernel's EtherCAT master.
pub struct IghBus {
    name: String,
    watchdog_steps: u16,
    master: Master,
    domain: DomainIdx,
    stations: Vec<Station>,
    worker: Worker,
    mapped: Option<Mapped>,
    state: BusState,
}

impl IghBus {
    /// Takes master 0 for this program and looks who is there. `watchdog_s` is the process-data watchdog of all stations.
    ///
    /// # Errors
    /// When the kernel has no such master, another version of it, or another program uses it; when it is still looking for
    /// stations, or finds none.
    pub fn open(name: &str, watchdog_s: f64) -> Result<Self, DeviceError> {
        let failed = |what: &str, error: &Error| failure(name, format!("{DEVICE}: {what}{}", told(error)));
        let steps = (watchdog_s / WATCHDOG_STEP_S).round();
        if !(1.0..=f64::from(u16::MAX)).contains(&steps) {
            return Err(DeviceError::Field {
                device: name.to_owned(),
                field: "process-data watchdog",
                expected: "0.0001 s to 6.5535 s".to_owned(),
                found: format!("{watchdog_s} s"),
                help: "correct it in the rig file",
            });
        }
        let master = Master::open(MASTER, MasterAccess::ReadWrite).map_err(|error| failed("", &error))?;
        master.reserve().map_err(|error| failed("another program uses the master: ", &error))?;
        let stations = stations(name, &master)?;
        let domain = master.create_domain().map_err(|error| failed("no domain: ", &error))?;
        let worker = Worker::start(MASTER).map_err(|why| failure(name, why))?;
        Ok(Self {
            name: name.to_owned(),
            watchdog_steps: steps as u16,
            master,
            domain,
            stations,
            worker,
            mapped: None,
            state: BusState::PreOp,
        })
    }

    fn failed(&self, what: &str, error: &Error) -> DeviceError {
        failure(&self.name, format!("{what}: {}", told(error)))
    }

    /// Gives the master a station's mappings as the station has them; where its process data stand in the domain.
    fn configure(&mut self, station: Station) -> Result<Mapping, DeviceError> {
        let number = station.number;
        let read = mapping::read(&mut self.master, station.position);
        let mut mapping = read.map_err(|error| self.failed(&format!("station {number}: mapping"), &error))?;
        let target = Target { domain: self.domain, watchdog_steps: self.watchdog_steps };
        let placed = mapping.place(&mut self.master, &station, target);
        placed.map_err(|error| self.failed(&format!("station {number}: configuration"), &error))?;
        Ok(mapping)
    }

    /// The lowest state of all stations; unchanged where the master does not tell.
    fn look_at_states(&mut self) {
        /// Bits of the states below OP.
        const BELOW_SAFE_OP: u8 = 0x03;
        const SAFE_OP: u8 = 0x04;
        let Ok(found) = self.master.state() else { return };
        self.state = match found.al_states {
            0 => BusState::PreOp,
            states if states & BELOW_SAFE_OP != 0 => BusState::PreOp,
            states if states & SAFE_OP != 0 => BusState::SafeOp,
            _ => BusState::Op,
        };
    }

    /// One round of the master: the replies that have come, then the next frame.
    fn pass(&mut self, image: &mut ProcessImage) -> Result<u16, Error> {
        self.master.receive()?;
        self.master.domain(self.domain).process()?;
        let found = self.master.domain(self.domain).state()?;
        if let Some(mapped) = &self.mapped {
            let data = self.master.domain_data(self.domain)?;
            if !matches!(found.wc_state, WcState::Zero) {
                for Share { in_domain, in_image } in &mapped.inputs {
                    copy(data.get(in_domain.clone()), image.inputs.get_mut(in_image.clone()));
                }
            }
            for Share { in_domain, in_image } in &mapped.outputs {
                copy(image.outputs.get(in_image.clone()), data.get_mut(in_domain.clone()));
            }
        }
        self.master.domain(self.domain).queue()?;
        self.master.send()?;
        Ok(u16::try_from(found.working_counter).unwrap_or(u16::MAX))
    }
}

impl SdoWire for IghBus {
    fn pdo_transport(&self) -> PdoTransport {
        PdoTransport::Assigned
    }

    fn start(&mut self, _now: Duration, request: &SdoRequest<'_>) {
        let found = self.stations.iter().find(|station| station.number == request.station);
        self.worker.start_transfer(found.map(|station| station.position), request);
    }

    fn poll(&mut self, _now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        let Some(outcome) = self.worker.outcome() else { return Ok(false) };
        let read = outcome?;
        into.clear();
        into.extend_from_slice(&read);
        Ok(true)
    }
}

impl Fieldbus for IghBus {
    fn name(&self) -> &str {
        &self.name
    }

    fn stations(&self) -> Vec<u16> {
        self.stations.iter().map(|station| station.number).collect()
    }

    /// Ends configuration and hands the bus to the master's own cycle.
    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        let mut mapped = Mapped {
            outputs: Vec::new(),
            inputs: Vec::new(),
            output_bytes: 0,
            input_bytes: 0,
            working_counter: 0,
        };
        let mut slots = Vec::new();
        for station in self.stations.clone() {
            let Mapping { outputs, inputs, .. } = self.configure(station)?;
            let outputs = shares(&outputs, &mut mapped.outputs, &mut mapped.output_bytes);
            let inputs = shares(&inputs, &mut mapped.inputs, &mut mapped.input_bytes);
            mapped.working_counter += u16::from(!inputs.is_empty()) + 2 * u16::from(!outputs.is_empty());
            slots.push((station.number, Slot { outputs, inputs }));
        }
        self.master.activate().map_err(|error| self.failed("the bus cannot be activated", &error))?;
        let image =
            ProcessImage { outputs: vec![0; mapped.output_bytes], inputs: vec![0; mapped.input_bytes] };
        self.mapped = Some(mapped);
        Ok((image, slots))
    }

    /// Asks for a state. The helper thread passes it on; the master takes the stations to OP by itself.
    fn request(&mut self, state: BusState) {
        let state = match state {
            BusState::PreOp => AlState::PreOp,
            BusState::SafeOp => AlState::SafeOp,
            BusState::Op => AlState::Op,
        };
        for station in &self.stations {
            self.worker.request(station.position, state);
        }
    }

    fn state(&self) -> BusState {
        self.state
    }

    /// Takes the replies that have come, and sends the next frame. Never waits.
    fn exchange(&mut self, _now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        let Some(expected) = self.mapped.as_ref().map(|mapped| mapped.working_counter) else {
            return Err(failure(&self.name, "exchange before the bus was mapped".to_owned()));
        };
        let working_counter = self.pass(image).map_err(|error| self.failed("exchange", &error))?;
        self.look_at_states();
        Ok(Exchange { working_counter, expected })
    }
}

/// The stations on the line, in position order.
fn stations(name: &str, master: &Master) -> Result<Vec<Station>, DeviceError> {
    let failed = |error: Error| failure(name, format!("stations: {}", told(&error)));
    let info = master.get_info().map_err(failed)?;
    let wrong = match (info.link_up, info.scan_busy, info.slave_count) {
        (false, ..) => "the interface of the master has no link: check the cable",
        (true, true, _) => "the master is still looking for stations: begin again in a few seconds",
        (true, false, 0) => "expected at least one SubDevice, found none: check cables and supplies",
        _ => "",
    };
    if !wrong.is_empty() {
        return Err(failure(name, wrong.to_owned()));
    }
    let station = |place: u32| {
        let position = SlavePos::from(u16::try_from(place).unwrap_or(u16::MAX));
        let found = master.get_slave_info(position).map_err(failed)?;
        let place = found.ring_pos.saturating_add(1);
        Ok(Station { number: if found.alias == 0 { place } else { found.alias }, position, id: found.id })
    };
    (0..info.slave_count).map(station).collect()
}

/// Adds a station's places in the domain; its slot in our image.
fn shares(in_domain: &[Range<usize>], all: &mut Vec<Share>, end: &mut usize) -> Range<usize> {
    let begin = *end;
    for place in in_domain {
        let in_image = *end..*end + place.len();
        *end = in_image.end;
        all.push(Share { in_domain: place.clone(), in_image });
    }
    begin..*end
}

/// Copies where both are there and have the same length.
fn copy(from: Option<&[u8]>, into: Option<&mut [u8]>) {
    if let (Some(from), Some(into)) = (from, into)
        && from.len() == into.len()
    {
        into.copy_from_slice(from);
    }
}

/// An error with what to do about it.
fn told(error: &Error) -> String {
    match error {
        Error::Io(source) if source.kind() == std::io::ErrorKind::NotFound => {
            "there is no such device: is the kernel module ec_master loaded? (`ethercatctl start`)".to_owned()
        }
        Error::Io(source) if source.kind() == std::io::ErrorKind::PermissionDenied => {
            "permission denied: give this user read and write access to the device".to_owned()
        }
        Error::KernelModule(expected, found) => format!(
            "the kernel module speaks version {found} of the interface, expected {expected} (IgH EtherLab 1.5): load \
             that version, or build this program against the installed one"
        ),
        other => other.to_string(),
    }
}

fn failure(device: &str, reason: String) -> DeviceError {
    DeviceError::Bus { device: device.to_owned(), reason }
}
