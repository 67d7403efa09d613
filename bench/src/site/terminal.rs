//! Terminals on the bus of the drives: their voltages and digital inputs go with the process data.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::ethercat::terminal::{AnalogTerminal, DigitalTerminal, TerminalChannel};
use drivers::wire::{
    AnalogPort, BusState, DigitalPort, Exchange, Fieldbus, Notice, PdoTransport, ProcessImage, SdoAbort,
    SdoRequest, SdoWire, Slot,
};

/// Volts of one step of a channel: ±10 V in 16 bit, signed.
const V_PER_STEP: f64 = 10.0 / 32_767.0;
/// Bytes of a channel.
const BYTES: usize = 2;

/// Stations of terminals, each with the process data that its ports and the bus share.
pub(super) type Images = Vec<(u16, Rc<RefCell<TerminalImage>>)>;

/// Process data of a terminal, shared by its ports and the bus.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TerminalImage {
    /// What the process data mean; `None` before the bus is mapped.
    mapped: Option<Mapped>,
    /// The terminal's own part of the process image.
    image: ProcessImage,
    /// A good exchange has brought inputs.
    is_sampled: bool,
}

/// A terminal in both of its shapes; which of them makes sense is up to whoever wired it.
#[derive(Clone, Debug, PartialEq)]
struct Mapped {
    analog: AnalogTerminal,
    digital: DigitalTerminal,
}

impl TerminalImage {
    /// The bus is mapped, with the terminal's data at this slot.
    fn map(&mut self, name: &str, slot: &Slot) -> Result<(), DeviceError> {
        let own = Slot { outputs: 0..slot.outputs.len(), inputs: 0..slot.inputs.len() };
        let channels = |bytes: usize| {
            (0..bytes / BYTES).map(|k| TerminalChannel { byte: k * BYTES, v_per_step: V_PER_STEP }).collect()
        };
        let analog =
            AnalogTerminal::new(name, own.clone(), channels(own.inputs.len()), channels(own.outputs.len()))?;
        self.mapped = Some(Mapped { analog, digital: DigitalTerminal::new(name, &own) });
        self.image.outputs.resize(own.outputs.len(), 0);
        self.image.inputs.resize(own.inputs.len(), 0);
        self.is_sampled = false;
        Ok(())
    }
}

/// A terminal as an analog card, or as a card of digital inputs.
pub(super) struct TerminalCard {
    name: String,
    shared: Rc<RefCell<TerminalImage>>,
}

impl TerminalCard {
    /// The terminal at an address.
    pub(super) fn new(name: &str, shared: Rc<RefCell<TerminalImage>>) -> Self {
        Self { name: name.to_owned(), shared }
    }
}

impl AnalogPort for TerminalCard {
    fn name(&self) -> &str {
        &self.name
    }

    /// Goes out with the next exchange. Before the bus is mapped nobody knows which outputs there are, and all stay at 0 V.
    fn write_v(&mut self, _now: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        let TerminalImage { mapped, image, .. } = &mut *self.shared.borrow_mut();
        let Some(mapped) = mapped else { return Ok(()) };
        mapped.analog.write_v(image, channel, volts).map(|_| ())
    }

    /// As sampled at the last exchange; 0 V before the first.
    fn read_v(&mut self, _now: Duration, channel: usize) -> Result<f64, DeviceError> {
        let TerminalImage { mapped, image, .. } = &*self.shared.borrow();
        mapped.as_ref().map_or(Ok(0.0), |mapped| mapped.analog.read_v(image, channel))
    }
}

impl DigitalPort for TerminalCard {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_on(&mut self, _now: Duration, input: usize) -> Result<Option<bool>, DeviceError> {
        let TerminalImage { mapped, image, is_sampled } = &*self.shared.borrow();
        let Some(mapped) = mapped else { return Ok(None) };
        let is_on = mapped.digital.is_on(image, input)?;
        Ok(is_sampled.then_some(is_on))
    }
}

/// A terminal on the bus: its station, its place in the process image, its ports.
struct Terminal {
    station: u16,
    slot: Slot,
    shared: Rc<RefCell<TerminalImage>>,
}

/// A bus whose terminals serve analog cards and digital inputs.
pub(super) struct WithTerminals<B: Fieldbus> {
    bus: B,
    terminals: Vec<Terminal>,
}

impl<B: Fieldbus> WithTerminals<B> {
    /// A bus with these terminals, by station.
    pub(super) fn new(bus: B, images: Images) -> Self {
        let terminal = |(station, shared)| Terminal { station, slot: Slot::default(), shared };
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
            terminal.shared.borrow_mut().map(&format!("terminal at station {station}"), slot)?;
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

    fn took_part(&self, station: u16) -> bool {
        self.bus.took_part(station)
    }

    fn let_go(&mut self) {
        self.bus.let_go();
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
                bytes.copy_from_slice(&terminal.shared.borrow().image.outputs);
            }
        }
        let exchanged = self.bus.exchange(now, image)?;
        if exchanged.working_counter == exchanged.expected {
            for terminal in &self.terminals {
                if let Some(bytes) = image.inputs.get(terminal.slot.inputs.clone()) {
                    let mut shared = terminal.shared.borrow_mut();
                    shared.image.inputs.copy_from_slice(bytes);
                    shared.is_sampled = true;
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
    struct Loop {
        /// Frames come back with the expected working counter.
        is_whole: bool,
    }

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
            Ok(Exchange { working_counter: if self.is_whole { 3 } else { 1 }, expected: 3 })
        }
    }

    fn card(station: u16) -> (WithTerminals<Loop>, TerminalCard) {
        let shared = Rc::new(RefCell::new(TerminalImage::default()));
        let bus = WithTerminals::new(Loop { is_whole: true }, vec![(station, Rc::clone(&shared))]);
        (bus, TerminalCard::new("ethercat:ecm/7", shared))
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
        assert!((volts + 2.5).abs() < 0.5 * V_PER_STEP, "{volts}");
        card.write_v(now, 0, 99.0).expect("clipped");
        bus.exchange(now, &mut image).expect("exchanged");
        assert_eq!(card.read_v(now, 0), Ok(10.0));
    }

    #[test]
    fn a_digital_input_is_known_from_the_first_good_exchange_on_and_a_bad_one_leaves_the_last_good_sample() {
        let (mut bus, mut card) = card(7);
        let now = Duration::ZERO;
        assert_eq!(card.is_on(now, 0), Ok(None), "before the bus is mapped");
        let (mut image, _) = bus.map().expect("mapped");
        assert_eq!(card.is_on(now, 0), Ok(None), "before the first exchange");
        bus.bus.is_whole = false;
        card.write_v(now, 0, V_PER_STEP).expect("one step sets the lowest bit");
        bus.exchange(now, &mut image).expect("exchanged");
        assert_eq!(card.is_on(now, 0), Ok(None), "the working counter was wrong");
        bus.bus.is_whole = true;
        bus.exchange(now, &mut image).expect("exchanged");
        assert_eq!([card.is_on(now, 0), card.is_on(now, 1)], [Ok(Some(true)), Ok(Some(false))]);
        bus.bus.is_whole = false;
        card.write_v(now, 0, 0.0).expect("an output");
        bus.exchange(now, &mut image).expect("exchanged");
        assert_eq!(card.is_on(now, 0), Ok(Some(true)), "as before");
        let error = card.is_on(now, 32).expect_err("four bytes").to_string();
        assert!(error.contains("expected 0 to 31"), "{error}");
    }

    #[test]
    fn a_channel_or_a_station_that_is_not_there_is_named() {
        let (mut bus, mut own) = card(7);
        bus.map().expect("mapped");
        let error = own.read_v(Duration::ZERO, 2).expect_err("two inputs").to_string();
        assert!(error.contains("station 7") && error.contains("no input 2: the terminal has 2"), "{error}");
        assert!(own.write_v(Duration::ZERO, 1, 0.0).is_err());
        let error = card(9).0.map().expect_err("no such station").to_string();
        assert!(error.contains("station 9") && error.contains("[7]"), "{error}");
    }
}
