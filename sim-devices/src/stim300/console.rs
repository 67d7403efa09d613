//! What the host types: commands of Normal mode without echo, and service mode with echo and prompt (TS1524, sections 8, 9).
//!
//! Simulated in service mode: `d i m r s u x ?`. The others (`a b c f g h t z`) and utility mode are unknown to this unit.

use drivers::stim300::{ForceUnit, GyroUnit, Input, SpecialKind};

use super::datagram::{PART_NUMBER, SERIAL_NUMBER};
use super::setup::Stim300Setup;

/// Size of the input buffer (TS1524, section 9).
const LINE_BYTES: usize = 80;
const BACKSPACE: u8 = 8;

/// What a command makes the unit do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Send a special datagram instead of the next measurement.
    Send(SpecialKind),
    Reset,
    EnterService,
    /// Leave service mode for Normal mode or for Init mode.
    Leave {
        to_init: bool,
    },
}

/// A question that service mode waits to be answered by `Y` or `N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    Save,
    Leave { to_init: bool },
}

/// What was typed so far, and what is stored.
#[derive(Clone, Debug)]
pub(super) struct Console {
    line: Vec<u8>,
    question: Option<Question>,
    /// What `s` has stored: power-up and reset go back to it.
    flash: Stim300Setup,
    saves_count: u32,
}

/// Outcome of a command of service mode: its text, and what the unit does afterwards.
#[derive(Default)]
struct Outcome {
    text: String,
    order: Option<Order>,
    /// No prompt: a question is open or the mode is left.
    is_open: bool,
}

impl Console {
    pub(super) fn new(setup: Stim300Setup) -> Self {
        Self { line: Vec::new(), question: None, flash: setup, saves_count: 0 }
    }

    /// What is stored.
    pub(super) fn flash(&self) -> Stim300Setup {
        self.flash
    }

    /// A character in Normal mode. Only a complete, correct command in upper case does anything.
    pub(super) fn normal_mode(&mut self, byte: u8) -> Option<Order> {
        if byte != b'\r' {
            if self.line.len() < LINE_BYTES {
                self.line.push(byte);
            }
            return None;
        }
        match std::mem::take(&mut self.line).as_slice() {
            b"N" => Some(Order::Send(SpecialKind::PartNumber)),
            b"I" => Some(Order::Send(SpecialKind::SerialNumber)),
            b"C" => Some(Order::Send(SpecialKind::Configuration)),
            b"T" => Some(Order::Send(SpecialKind::BiasTrim)),
            b"E" => Some(Order::Send(SpecialKind::ExtendedError)),
            b"R" => Some(Order::Reset),
            b"SERVICEMODE" => Some(Order::EnterService),
            _ => None,
        }
    }

    /// The listing at the begin of service mode, prompt included.
    pub(super) fn banner(setup: &Stim300Setup) -> String {
        format!("{}>", listing(setup))
    }

    /// A character in service mode: what goes back, and what the unit does.
    pub(super) fn service_mode(&mut self, byte: u8, setup: &mut Stim300Setup) -> (Vec<u8>, Option<Order>) {
        let mut reply = vec![byte];
        if let Some(question) = self.question.take() {
            let outcome = self.answer(question, byte, setup);
            reply.extend(format!("\r{}>", outcome.text).bytes());
            if outcome.is_open {
                reply.pop();
            }
            return (reply, outcome.order);
        }
        match byte {
            BACKSPACE => drop(self.line.pop()),
            b'\r' => {
                let line = String::from_utf8_lossy(&std::mem::take(&mut self.line)).into_owned();
                let outcome = self.execute(&line, setup);
                reply.extend(outcome.text.bytes());
                if !outcome.is_open {
                    reply.push(b'>');
                }
                return (reply, outcome.order);
            }
            _ if self.line.len() < LINE_BYTES => self.line.push(byte),
            _ => {}
        }
        (reply, None)
    }

    fn execute(&mut self, line: &str, setup: &mut Stim300Setup) -> Outcome {
        let (command, parameters) = line.split_once(' ').unwrap_or((line, ""));
        let parameters: Vec<&str> =
            if parameters.is_empty() { vec![] } else { parameters.split(',').collect() };
        let text = match (command, parameters.as_slice()) {
            ("", []) => String::new(),
            ("i", []) => listing(setup),
            ("i", [what]) => information(what, setup),
            ("m", [code]) => rate(code, setup),
            ("d", [letter, line_end]) => datagram(letter, line_end, setup),
            ("u", [sensor, code]) => unit(sensor, code, setup),
            ("r", [switch]) => match *switch {
                "0" | "1" => {
                    setup.is_terminated = *switch == "1";
                    information("r", setup)
                }
                _ => INVALID.to_owned(),
            },
            ("s", []) => {
                self.question = Some(Question::Save);
                let text = "SYSTEM PARAMETERS WILL BE PERMANENTLY CHANGED. CONFIRM SAVE(Y/N): ".to_owned();
                return Outcome { text, is_open: true, order: None };
            }
            ("x", [to]) => return self.exit(to, setup),
            ("?", []) => "d i m r s u x ?\r".to_owned(),
            ("i" | "m" | "d" | "u" | "r" | "s" | "x" | "?", _) => {
                "E002 INCORRECT NUMBER OF PARAMETERS\r".to_owned()
            }
            _ => "E001 UNKNOWN COMMAND\r".to_owned(),
        };
        Outcome { text, ..Outcome::default() }
    }

    fn exit(&mut self, to: &str, setup: &Stim300Setup) -> Outcome {
        let to_init = to.eq_ignore_ascii_case("i");
        match to {
            "N" | "I" => left(to_init),
            "n" | "i" if *setup == self.flash => left(to_init),
            "n" | "i" => {
                self.question = Some(Question::Leave { to_init });
                let text =
                    "CURRENT SYSTEM PARAMETERS DO NOT MATCH FLASH CONTENT. CONFIRM EXIT(Y/N): ".to_owned();
                Outcome { text, is_open: true, order: None }
            }
            _ => Outcome { text: INVALID.to_owned(), ..Outcome::default() },
        }
    }

    fn answer(&mut self, question: Question, byte: u8, setup: &Stim300Setup) -> Outcome {
        let text = match (question, byte) {
            (Question::Save, b'Y') => {
                self.flash = *setup;
                self.saves_count += 1;
                format!(
                    "SYSTEM PARAMETERS SUCCESSFULLY STORED IN FLASH.\rNUMBER OF SAVES = {}\r",
                    self.saves_count
                )
            }
            (Question::Leave { to_init }, b'Y') => return left(to_init),
            (Question::Save, b'N') => "SAVE COMMAND ABORTED.\r".to_owned(),
            (Question::Leave { .. }, b'N') => String::new(),
            (Question::Save, _) => format!("SAVE COMMAND ABORTED.\r{INVALID}"),
            (Question::Leave { .. }, _) => INVALID.to_owned(),
        };
        Outcome { text, ..Outcome::default() }
    }
}

const INVALID: &str = "E003 INVALID PARAMETER\r";
const TOO_LONG: &str = "E007 DATAGRAM WILL BE TOO LONG TO TRANSMIT\r";

fn left(to_init: bool) -> Outcome {
    let mode = if to_init { "INIT" } else { "NORMAL" };
    // Firmware of this revision leaves out the full stop that the datasheet prints.
    let text = format!("SYSTEM RETURNING TO {mode} MODE\r");
    Outcome { text, order: Some(Order::Leave { to_init }), is_open: true }
}

/// A rate that does not fit is set all the same, with a warning.
fn rate(code: &str, setup: &mut Stim300Setup) -> String {
    match code.parse().ok().and_then(|code| setup.set_rate(code)) {
        Some(()) if setup.fits() => information("m", setup),
        Some(()) => format!("{}{TOO_LONG}", information("m", setup)),
        None => INVALID.to_owned(),
    }
}

/// A datagram that does not fit is not set.
fn datagram(letter: &str, line_end: &str, setup: &mut Stim300Setup) -> String {
    let place =
        ["01234567", "lmnpqrst"].iter().zip([Input::None, Input::Pps]).find_map(|(letters, input)| {
            let place = letters.find(letter).filter(|_| letter.len() == 1)?;
            Some((place, input))
        });
    let (Some((place, input)), "0" | "1") = (place, line_end) else { return INVALID.to_owned() };
    let mut changed = *setup;
    changed.content.accelerometers = place & 1 != 0;
    changed.content.inclinometers = place & 2 != 0;
    changed.content.temperatures = place & 4 != 0;
    changed.content.input = input;
    changed.line_end = line_end == "1";
    if !changed.fits() {
        return TOO_LONG.to_owned();
    }
    *setup = changed;
    information("d", setup)
}

fn unit(sensor: &str, code: &str, setup: &mut Stim300Setup) -> String {
    let code = u8::from_str_radix(code, 16).ok();
    match (sensor, code) {
        ("g", Some(code @ (0..=3 | 8..=11))) => {
            setup.is_gyro_delayed = code & 8 != 0;
            setup.gyro_unit = [
                GyroUnit::Rate,
                GyroUnit::IncrementalAngle,
                GyroUnit::AverageRate,
                GyroUnit::IntegratedAngle,
            ][usize::from(code & 3)];
            information("g-unit", setup)
        }
        ("a", Some(code @ 0..=2)) => {
            setup.accelerometer_unit =
                [ForceUnit::Acceleration, ForceUnit::IncrementalVelocity, ForceUnit::AverageAcceleration]
                    [usize::from(code)];
            information("a-unit", setup)
        }
        _ => INVALID.to_owned(),
    }
}

fn listing(setup: &Stim300Setup) -> String {
    ["s", "n", "x", "p", "u", "m", "d", "t", "r"].iter().map(|what| information(what, setup)).collect()
}

/// Lines of the command `i`.
fn information(what: &str, setup: &Stim300Setup) -> String {
    let content = setup.content;
    match what {
        "s" => format!("SERIAL NUMBER = {SERIAL_NUMBER}\r"),
        "n" => "PRODUCT = STIM300\r".to_owned(),
        "x" => format!("PART NUMBER = {PART_NUMBER}\r"),
        "p" => "FW CONFIG = SIM REV 1\r".to_owned(),
        "u" => format!("{}{}", information("g-unit", setup), information("a-unit", setup)),
        "g-unit" => {
            let unit = match setup.gyro_unit {
                GyroUnit::Rate => "[deg/s] ANGULAR RATE",
                GyroUnit::IncrementalAngle => "[deg] INCREMENTAL ANGLE",
                GyroUnit::AverageRate => "[deg/s] AVERAGE ANGULAR RATE",
                GyroUnit::IntegratedAngle => "[deg] INTEGRATED ANGLE",
            };
            format!("GYRO OUTPUT UNIT = {unit}{}\r", if setup.is_gyro_delayed { " DELAYED" } else { "" })
        }
        "a-unit" => {
            let unit = match setup.accelerometer_unit {
                ForceUnit::Acceleration => "[g] ACCELERATION",
                ForceUnit::IncrementalVelocity => "[m/s] INCREMENTAL VELOCITY",
                ForceUnit::AverageAcceleration => "[g] AVERAGE ACCELERATION",
                ForceUnit::IntegratedVelocityGs => "[gs] INTEGRATED VELOCITY",
                ForceUnit::IntegratedVelocity => "[m/s] INTEGRATED VELOCITY",
            };
            format!("ACCELEROMETER OUTPUT UNIT = {unit}\r")
        }
        "m" => match setup.samples_per_measurement() {
            Some(samples) => format!("SAMPLE RATE [samples/s] = {}\r", 2000 / samples),
            None => "SAMPLE RATE = EXTERNAL TRIGGER\r".to_owned(),
        },
        "d" => {
            let parts = [
                (true, "RATE"),
                (content.accelerometers, "ACCELERATION"),
                (content.inclinometers, "INCLINATION"),
                (content.temperatures, "TEMPERATURE"),
                (content.input == Input::Pps, "PPS"),
                (content.input == Input::Aux, "AUX"),
            ];
            let parts: Vec<&str> =
                parts.into_iter().filter(|(is_in, _)| *is_in).map(|(_, name)| name).collect();
            let line_end = if setup.line_end { "<CR><LF>" } else { "NONE" };
            format!("DATAGRAM = {}\rDATAGRAM TERMINATION = {line_end}\r", parts.join(", "))
        }
        "t" => {
            format!("BIT-RATE [bits/s] = {}\rDATA LENGTH = 8\rSTOP BITS = 1\rPARITY = NONE\r", setup.bit_rate)
        }
        "r" => format!("LINE TERMINATION = {}\r", if setup.is_terminated { "ON" } else { "OFF" }),
        _ => INVALID.to_owned(),
    }
}
