//! Analog terminals on the bus of the drives: their voltages go with the process data.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::{
    AnalogPort, BusState, Exchange, Fieldbus, Notice, PdoTransport, ProcessImage, SdoAbort, SdoRequest,
    SdoWire, Slot,
};

/// Counts of ±10 V: 16 bit, signed.
const COUNTS_PER_V: f64 = 32_767.0 / 10.0;
/// Bytes of a channel.
const BYTES: usize = 2;

/// Stations of terminals, each with the process data that its port and the bus share.
pub(super) type Images = Vec<(u16, Rc<RefCell<CardImage>>)>;

/// Process data of a terminal, shared by its port and the bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct CardImage {
    /// How many channels there are is known.
    is_mapped: bool,
    inputs: Vec<u8>,
    outputs: Vec<u8>,
}

/// A terminal as an analog card.
pub(super) struct TerminalCard {
    name: String,
    image: Rc<RefCell<CardImage>>,
}

impl TerminalCard {
    /// The terminal at an address.
    pub(super) fn new(name: &str, image: Rc<RefCell<CardImage>>) -> Self {
        Self { name: name.to_owned(), image }
    }

    fn no_channel(&self, way: &str, channel: usize, bytes: usize) -> DeviceError {
        let reason = match bytes / BYTES {
            0 => format!("no {way} {channel}: the terminal has none; check the station in the rig file"),
            count => format!("no {way} {channel}: the terminal has 0 to {}", count - 1),
        };
        DeviceError::Bus { device: self.name.clone(), reason }
    }
}

impl AnalogPort for TerminalCard {
    fn name(&self) -> &str {
        &self.name
    }

    /// Goes out with the next exchange.
    fn write_v(&mut self, _now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        let mut image = self.image.borrow_mut();
        let at = channel * BYTES;
        let (length, is_mapped) = (image.outputs.len(), image.is_mapped);
        match image.outputs.get_mut(at..at + BYTES) {
            Some(bytes) => {
                let counts = (volts * COUNTS_PER_V).round_ties_even();
                let counts = counts.clamp(f64::from(-i16::MAX), f64::from(i16::MAX)) as i16;
                bytes.copy_from_slice(&counts.to_le_bytes());
                Ok(())
            }
            // Before the bus is mapped nobody knows how many channels there are, and all outputs stay at 0 V.
            None if !is_mapped => Ok(()),
            None => Err(self.no_channel("output", channel, length)),
        }
    }

    /// As sampled at the last exchange; 0 V before the first.
    fn read_v(&mut self, _now: Duration, channel: usize) -> Result<f64, DeviceError> {
        let image = self.image.borrow();
        let at = channel * BYTES;
        match image.inputs.get(at..at + BYTES) {
            Some(bytes) => Ok(f64::from(i16::from_le_bytes([bytes[0], bytes[1]])) / COUNTS_PER_V),
            None if !image.is_mapped => Ok(0.0),
            None => Err(self.no_channel("input", channel, image.inputs.len())),
        }
    }
}

/// A terminal on the bus: its station, its place in the process image, its port.
struct Terminal {
    station: u16,
    slot: Slot,
    image: Rc<RefCell<CardImage>>,
}

/// A bus whose terminals serve analog cards.
pub(super) struct WithTerminals<B: Fieldbus> {
    bus: B,
    terminals: Vec<Terminal>,
}

impl<B: Fieldbus> WithTerminals<B> {
    /// A bus with these terminals, by station.
    pub(super) fn new(bus: B, images: Images) -> Self {
        let terminal = |(station, image)| Terminal { station, slot: Slot::default(), image };
        Self { bus, terminals: images.into_iter().map(terminal).collect() }
    }
}

impl<B: Fieldbus> SdoWire for WithTerminals<B> {
    fn pdo_transport(&self) -> PdoTransport {
        self.bus.pdo_transport()
    }

    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        self.bus.start(now, request);
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        self.bus.poll(now, into)
    }
}

impl<B: Fieldbus> Fieldbus for WithTerminals<B> {
    fn name(&self) -> &str {
        self.bus.name()
    }

    fn stations(&self) -> Vec<u16> {
        self.bus.stations()
    }

    fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
        let (image, slots) = self.bus.map()?;
        for terminal in &mut self.terminals {
            let station = terminal.station;
            let found = slots.iter().find(|(own, _)| *own == station);
            let (_, slot) = found.ok_or_else(|| {
                let stations: Vec<u16> = slots.iter().map(|(own, _)| *own).collect();
                let reason = format!(
                    "no terminal at station {station}, found stations {stations:?}; check power, wiring and `ports` in \
                     the rig file"
                );
                DeviceError::Bus { device: self.bus.name().to_owned(), reason }
            })?;
            let mut card = terminal.image.borrow_mut();
            card.is_mapped = true;
            card.inputs.resize(slot.inputs.len(), 0);
            card.outputs.resize(slot.outputs.len(), 0);
            terminal.slot = slot.clone();
        }
        Ok((image, slots))
    }

    fn request(&mut self, state: BusState) {
        self.bus.request(state);
    }

    fn state(&self) -> BusState {
        self.bus.state()
    }

    fn lateness_ns(&self) -> Option<i64> {
        self.bus.lateness_ns()
    }

    fn tell_notices(&mut self, tell: &mut dyn FnMut(Notice)) {
        self.bus.tell_notices(tell);
    }

    fn exchange(&mut self, now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
        for terminal in &self.terminals {
            if let Some(bytes) = image.outputs.get_mut(terminal.slot.outputs.clone()) {
                bytes.copy_from_slice(&terminal.image.borrow().outputs);
            }
        }
        let exchanged = self.bus.exchange(now, image)?;
        if exchanged.working_counter == exchanged.expected {
            for terminal in &self.terminals {
                if let Some(bytes) = image.inputs.get(terminal.slot.inputs.clone()) {
                    terminal.image.borrow_mut().inputs.copy_from_slice(bytes);
                }
            }
        }
        Ok(exchanged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bus with one terminal of two inputs and one output: inputs repeat what was output.
    struct Loop;

    impl SdoWire for Loop {
        fn pdo_transport(&self) -> PdoTransport {
            PdoTransport::Assigned
        }

        fn start(&mut self, _now: Duration, _request: &SdoRequest<'_>) {}

        fn poll(&mut self, _now: Duration, _into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
            Ok(false)
        }
    }

    impl Fieldbus for Loop {
        fn name(&self) -> &str {
            "loop"
        }

        fn stations(&self) -> Vec<u16> {
            vec![7]
        }

        fn map(&mut self) -> Result<(ProcessImage, Vec<(u16, Slot)>), DeviceError> {
            let image = ProcessImage { outputs: vec![0; 2], inputs: vec![0; 4] };
            Ok((image, vec![(7, Slot { outputs: 0..2, inputs: 0..4 })]))
        }

        fn request(&mut self, _state: BusState) {}

        fn state(&self) -> BusState {
            BusState::Op
        }

        fn exchange(&mut self, _now: Duration, image: &mut ProcessImage) -> Result<Exchange, DeviceError> {
            image.inputs[..2].copy_from_slice(&image.outputs.clone());
            Ok(Exchange { working_counter: 3, expected: 3 })
        }
    }

    fn card(station: u16) -> (WithTerminals<Loop>, TerminalCard) {
        let image = Rc::new(RefCell::new(CardImage::default()));
        let bus = WithTerminals::new(Loop, vec![(station, Rc::clone(&image))]);
        (bus, TerminalCard::new("ethercat:ecm/7", image))
    }

    #[test]
    fn a_voltage_goes_out_with_the_next_exchange_and_comes_back_with_it() {
        let (mut bus, mut card) = card(7);
        let now = Duration::ZERO;
        assert_eq!(card.read_v(now, 0), Ok(0.0), "before the bus is mapped");
        let (mut image, _) = bus.map().expect("mapped");
        card.write_v(now, 0, -2.5).expect("an output");
        assert_eq!(card.read_v(now, 0), Ok(0.0), "not yet");
        bus.exchange(now, &mut image).expect("exchanged");
        let volts = card.read_v(now, 0).expect("an input");
        assert!((volts + 2.5).abs() < 0.5 / COUNTS_PER_V, "{volts}");
        card.write_v(now, 0, 99.0).expect("clipped");
        bus.exchange(now, &mut image).expect("exchanged");
        assert_eq!(card.read_v(now, 0), Ok(10.0));
    }

    #[test]
    fn a_channel_or_a_station_that_is_not_there_is_named() {
        let (mut bus, mut own) = card(7);
        bus.map().expect("mapped");
        let error = own.read_v(Duration::ZERO, 2).expect_err("two inputs").to_string();
        assert!(error.contains("ethercat:ecm/7") && error.contains("0 to 1"), "{error}");
        assert!(own.write_v(Duration::ZERO, 1, 0.0).is_err());
        let error = card(9).0.map().expect_err("no such station").to_string();
        assert!(error.contains("station 9") && error.contains("[7]"), "{error}");
    }
}
