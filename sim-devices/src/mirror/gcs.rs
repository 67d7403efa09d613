//! The mirror unit behind a controller that speaks PI's GCS 2.0: the same servo, actuators and mechanism, other commands
//! (E-727 user manual E727T0005, PIPython 2.13).
//!
//! Axis `1` is azimuth, `2` elevation. Positions are mechanical tilts in µrad; so are open-loop values, at the nominal gain of the
//! actuators. Both servos are off at power-up. An analog input becomes the target of an axis by parameter 06000500h. Simulated: `*IDN? ERR? SAI? SVO MOV MVR SVA POS? ONT? OVF? TMN? TMX? VOL? STP SPA SPA?
//! DRC DRT RTR DRR? DRL? TNR?`, their queries, and the single characters #5 (axes in motion) and #24 (stop).

mod recorder;
#[cfg(test)]
mod tests;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::ByteLine;

use self::recorder::{MOST_POINTS, Recorder, TABLES};
use super::Mirror;
use crate::physics::noise::SeedAddress;
use crate::transmitter::{Transmitter, nanoseconds, whole_nanoseconds};
use crate::unit::MirrorSettings;

/// Bit rate of the serial line (PIPython's example; the controller can be set to others).
const BIT_RATE: f64 = 115_200.0;
/// Bytes that are put on the line at once.
const PIECE_BYTES: usize = 16;
/// Longest command.
const LINE_BYTES: usize = 255;
/// An axis is on target within this.
const ON_TARGET_URAD: f64 = 2.0;
/// An axis whose target is further away than this is in motion.
const MOVING_URAD: f64 = 20.0;
const URAD_PER_RAD: f64 = 1e6;
const IDENTITY: &str = "(c)2015 Physik Instrumente (PI) GmbH & Co. KG, E-727.3SDA, SIM0000727, 1.00";
/// Characters without a terminator.
const MOTION_STATUS: u8 = 5;
const STOP_ALL: u8 = 24;

/// Parameter: the input channel that is the target of an axis; 0 takes the target from commands.
const TARGET_INPUT: u32 = 0x0600_0500;
/// Input channels that the analog commands of both axes are wired to.
const ANALOG_INPUTS: [u8; 2] = [5, 6];

/// Number of an error, as `ERR?` tells it.
type ErrorCode = i32;
const UNKNOWN_COMMAND: ErrorCode = 2;
const TOO_LONG: ErrorCode = 3;
const SERVO_OFF: ErrorCode = 5;
const OUT_OF_LIMITS: ErrorCode = 7;
const STOPPED: ErrorCode = 10;
const NO_SUCH_AXIS: ErrorCode = 15;
const OUT_OF_RANGE: ErrorCode = 17;
const WRONG_COUNT: ErrorCode = 24;
const NOT_A_NUMBER: ErrorCode = 25;
const NO_SUCH_PARAMETER: ErrorCode = 54;
const READ_ONLY: ErrorCode = 64;
const ANALOG_TARGET: ErrorCode = 72;
const SERVO_ON: ErrorCode = 79;

/// Lines of a reply; none for what sets something.
type Answer = Result<Vec<String>, ErrorCode>;

/// The controller and its mirror.
#[derive(Clone, Debug)]
pub struct GcsMirror {
    mirror: Mirror,
    step_s: f64,
    /// Host to controller and back.
    incoming: Transmitter,
    outgoing: Transmitter,
    /// Replies that are not on the line yet.
    replies: VecDeque<u8>,
    line: Vec<u8>,
    error: ErrorCode,
    /// Closed-loop targets and open-loop values.
    target_urad: [f64; 2],
    recorder: Recorder,
}

impl GcsMirror {
    /// At rest in mid-stroke, servos off, stepped every `step_s`: the cycle of the servo.
    pub fn new(settings: &MirrorSettings, address: &SeedAddress, step_s: f64) -> Self {
        let mut mirror = Mirror::new(settings, address, step_s);
        for axis in 0..2 {
            mirror.axes[axis].digital_source = true;
            mirror.close_loop(axis, false);
        }
        Self {
            mirror,
            step_s,
            incoming: Transmitter::new(BIT_RATE),
            outgoing: Transmitter::new(BIT_RATE),
            replies: VecDeque::new(),
            line: Vec::new(),
            error: 0,
            target_urad: [0.0; 2],
            recorder: Recorder::default(),
        }
    }

    /// With a line of another bit rate, bit/s.
    #[must_use]
    pub fn with_bit_rate(self, bit_rate_hz: f64) -> Self {
        let [incoming, outgoing] = [0, 1].map(|_| Transmitter::new(bit_rate_hz));
        Self { incoming, outgoing, ..self }
    }

    /// Voltage at the analog input of an axis, from now on. It acts on an axis whose target is that input.
    pub fn command_analog_v(&mut self, axis: usize, volts: f64) {
        self.mirror.command_analog_v(axis, volts);
    }

    /// The mirror itself.
    pub fn mirror(&self) -> &Mirror {
        &self.mirror
    }

    /// One cycle of the servo; `step` counts from the start of the point. Commands that arrive in it are carried out first.
    pub fn step(&mut self, step: u64) {
        let now_ns = nanoseconds(step as f64 * self.step_s);
        let mut byte = [0];
        while self.incoming.take(now_ns, &mut byte) == 1 {
            self.receive(byte[0]);
        }
        self.send(now_ns);
        self.mirror.step(step);
        self.recorder.cycle(&self.mirror, self.target_urad);
    }

    /// Bytes that have arrived at the host by `now`.
    pub fn read(&mut self, now: Duration, into: &mut [u8]) -> usize {
        self.outgoing.take(whole_nanoseconds(now), into)
    }

    /// Bytes that leave the host from `now` on.
    pub fn write(&mut self, now: Duration, bytes: &[u8]) {
        self.incoming.append(whole_nanoseconds(now), bytes);
    }

    /// Puts replies on the line before it runs dry.
    fn send(&mut self, now_ns: u64) {
        while !self.replies.is_empty() && self.outgoing.is_free(now_ns + nanoseconds(self.step_s)) {
            let count = self.replies.len().min(PIECE_BYTES);
            let piece: Vec<u8> = self.replies.drain(..count).collect();
            self.outgoing.append(now_ns, &piece);
        }
    }

    fn receive(&mut self, byte: u8) {
        match byte {
            MOTION_STATUS => self.replies.extend(format!("{:X}\n", self.moving()).bytes()),
            STOP_ALL => self.stop(),
            b'\n' => {
                let line = std::mem::take(&mut self.line);
                let outcome = if line.len() > LINE_BYTES {
                    Err(TOO_LONG)
                } else {
                    self.execute(&String::from_utf8_lossy(&line))
                };
                match outcome {
                    Ok(lines) if lines.is_empty() => {}
                    // Every line but the last ends with a space.
                    Ok(lines) => self.replies.extend(format!("{}\n", lines.join(" \n")).bytes()),
                    Err(code) => self.error = code,
                }
            }
            _ if self.line.len() <= LINE_BYTES => self.line.push(byte),
            _ => {}
        }
    }

    fn execute(&mut self, line: &str) -> Answer {
        let mut words = line.split_whitespace();
        let Some(mnemonic) = words.next() else { return Ok(vec![]) };
        let arguments: Vec<&str> = words.collect();
        match mnemonic.to_ascii_uppercase().as_str() {
            "*IDN?" => Ok(vec![IDENTITY.to_owned()]),
            "ERR?" => Ok(vec![std::mem::take(&mut self.error).to_string()]),
            "SAI?" => Ok(vec!["1".to_owned(), "2".to_owned()]),
            "SVO" => self.servo(&arguments),
            "MOV" => self.move_to(&arguments, [0.0; 2]),
            "MVR" => self.move_to(&arguments, self.target_urad),
            "SVA" => self.open_loop(&arguments),
            "STP" => {
                self.stop();
                Ok(vec![])
            }
            "SPA" => self.set_parameter(&arguments),
            "SPA?" => self.parameter(&arguments),
            mnemonic => match self.recorder.execute(mnemonic, &arguments, self.step_s) {
                Some(answer) => answer,
                None => self.ask(mnemonic, &arguments),
            },
        }
    }

    /// Queries of a value for each axis.
    fn ask(&self, mnemonic: &str, arguments: &[&str]) -> Answer {
        let position_urad = self.mirror.sensed_rad().map(|rad| rad * URAD_PER_RAD);
        let stroke_urad = self.mirror.settings.stroke_rad.map(|rad| rad * URAD_PER_RAD);
        let error_urad = [0, 1].map(|axis| (self.target_urad[axis] - position_urad[axis]).abs());
        let half_range_v = 0.5 * self.mirror.settings.amplifier_voltage_v;
        let drive_v = self.mirror.drive_v();
        let is_servo_on = [0, 1].map(|axis| self.mirror.axes[axis].close_ordered);
        let flags = |flags: [bool; 2]| flags.map(|flag| u8::from(flag).to_string());
        let numbers = |values: [f64; 2]| values.map(|value| format!("{value:.6}"));
        let values = match mnemonic {
            "POS?" => numbers(position_urad),
            "MOV?" | "SVA?" => numbers(self.target_urad),
            "TMN?" => numbers(stroke_urad.map(|stroke| -stroke)),
            "TMX?" => numbers(stroke_urad),
            "VOL?" => numbers(drive_v.map(|volts| volts + half_range_v)),
            "SVO?" => flags(is_servo_on),
            "ONT?" => flags([0, 1].map(|axis| is_servo_on[axis] && error_urad[axis] < ON_TARGET_URAD)),
            "OVF?" => flags(drive_v.map(|volts| volts.abs() >= 0.999 * half_range_v)),
            _ => return Err(UNKNOWN_COMMAND),
        };
        let asked: Vec<usize> = if arguments.is_empty() {
            vec![0, 1]
        } else {
            arguments.iter().map(|name| axis(name)).collect::<Result<_, _>>()?
        };
        Ok(asked.into_iter().map(|axis| format!("{}={}", axis + 1, values[axis])).collect())
    }

    fn servo(&mut self, arguments: &[&str]) -> Answer {
        let pairs = pairs(arguments)?;
        if pairs.iter().any(|pair| pair.value != 0.0 && pair.value != 1.0) {
            return Err(OUT_OF_RANGE);
        }
        for pair in pairs {
            let was_on = self.mirror.axes[pair.axis].close_ordered;
            self.mirror.close_loop(pair.axis, pair.value == 1.0);
            if pair.value == 1.0 && !was_on {
                // Without a bump: the target is where the mirror is.
                self.order(pair.axis, self.mirror.sensed_rad()[pair.axis] * URAD_PER_RAD);
            }
        }
        Ok(vec![])
    }

    /// Closed-loop targets, from somewhere on.
    fn move_to(&mut self, arguments: &[&str], from_urad: [f64; 2]) -> Answer {
        let pairs = pairs(arguments)?;
        for pair in &pairs {
            let target_urad = from_urad[pair.axis] + pair.value;
            if !self.mirror.axes[pair.axis].close_ordered {
                return Err(SERVO_OFF);
            }
            if !self.mirror.axes[pair.axis].digital_source {
                return Err(ANALOG_TARGET);
            }
            if target_urad.abs() > self.mirror.settings.stroke_rad[pair.axis] * URAD_PER_RAD {
                return Err(OUT_OF_LIMITS);
            }
        }
        for pair in pairs {
            self.order(pair.axis, from_urad[pair.axis] + pair.value);
        }
        self.recorder.position_changed();
        Ok(vec![])
    }

    fn open_loop(&mut self, arguments: &[&str]) -> Answer {
        let pairs = pairs(arguments)?;
        for pair in &pairs {
            if self.mirror.axes[pair.axis].close_ordered {
                return Err(SERVO_ON);
            }
            if pair.value.abs() > self.mirror.settings.stroke_rad[pair.axis] * URAD_PER_RAD {
                return Err(OUT_OF_LIMITS);
            }
        }
        for pair in pairs {
            self.order(pair.axis, pair.value);
        }
        self.recorder.position_changed();
        Ok(vec![])
    }

    fn order(&mut self, axis: usize, urad: f64) {
        self.target_urad[axis] = urad;
        let volts = urad / URAD_PER_RAD / self.mirror.settings.scale_rad_per_v[axis];
        self.mirror.axes[axis].take_order(volts, 0.0);
    }

    /// The mirror stays where it is.
    fn stop(&mut self) {
        for axis in 0..2 {
            if self.mirror.axes[axis].close_ordered {
                self.order(axis, self.mirror.sensed_rad()[axis] * URAD_PER_RAD);
            }
        }
        self.error = STOPPED;
    }

    /// Bit k: axis k + 1 is in motion.
    fn moving(&self) -> u8 {
        let is_moving = |axis: usize| {
            let error_urad = self.target_urad[axis] - self.mirror.sensed_rad()[axis] * URAD_PER_RAD;
            self.mirror.axes[axis].close_ordered && error_urad.abs() > MOVING_URAD
        };
        u8::from(is_moving(0)) | u8::from(is_moving(1)) << 1
    }

    /// Sets parameters of axes, in the memory that is lost without supply. Only the target input can be set.
    fn set_parameter(&mut self, arguments: &[&str]) -> Answer {
        if arguments.is_empty() || !arguments.len().is_multiple_of(3) {
            return Err(WRONG_COUNT);
        }
        let group = |group: &[&str]| {
            self.parameter(&group[..2])?;
            let axis = axis(group[0])?;
            if parameter_id(group[1])? != TARGET_INPUT {
                return Err(READ_ONLY);
            }
            match number(group[2])? {
                0.0 => Ok((axis, true)),
                input if input == f64::from(ANALOG_INPUTS[axis]) => Ok((axis, false)),
                _ => Err(OUT_OF_RANGE),
            }
        };
        let groups: Vec<(usize, bool)> = arguments.chunks_exact(3).map(group).collect::<Result<_, _>>()?;
        for (axis, is_digital) in groups {
            if is_digital && !self.mirror.axes[axis].digital_source {
                // Without a bump: the target is where the mirror is.
                self.order(axis, self.mirror.sensed_rad()[axis] * URAD_PER_RAD);
            }
            self.mirror.axes[axis].digital_source = is_digital;
        }
        Ok(vec![])
    }

    /// A parameter of an axis.
    fn parameter(&self, arguments: &[&str]) -> Answer {
        let [name, id, ..] = arguments else { return Err(WRONG_COUNT) };
        let axis = axis(name)?;
        let settings = &self.mirror.settings;
        let value = match parameter_id(id)? {
            TARGET_INPUT if self.mirror.axes[axis].digital_source => 0.0,
            TARGET_INPUT => f64::from(ANALOG_INPUTS[axis]),
            0x0E00_0200 => self.step_s,
            0x0700_0300 => settings.proportional_gain_ratio,
            0x0700_0301 if settings.integral_gain_per_s > 0.0 => self.step_s / settings.integral_gain_per_s,
            0x0700_0301 => 0.0,
            0x0800_0100 => settings.notch_frequency_hz[axis],
            0x1600_0200 => MOST_POINTS as f64,
            0x1600_0300 => f64::from(TABLES),
            _ => return Err(NO_SUCH_PARAMETER),
        };
        Ok(vec![format!("{name} {id}={value:e}")])
    }
}

/// Number of a parameter, hexadecimal.
fn parameter_id(text: &str) -> Result<u32, ErrorCode> {
    let digits = text.trim_start_matches("0x").trim_start_matches("0X");
    u32::from_str_radix(digits, 16).map_err(|_| NOT_A_NUMBER)
}

/// A value for an axis.
struct Pair {
    axis: usize,
    value: f64,
}

/// Groups of axis and value. If any is bad, none counts.
fn pairs(arguments: &[&str]) -> Result<Vec<Pair>, ErrorCode> {
    if arguments.is_empty() || !arguments.len().is_multiple_of(2) {
        return Err(WRONG_COUNT);
    }
    let pair = |group: &[&str]| Ok(Pair { axis: axis(group[0])?, value: number(group[1])? });
    arguments.chunks_exact(2).map(pair).collect()
}

fn axis(name: &str) -> Result<usize, ErrorCode> {
    ["1", "2"].iter().position(|known| *known == name).ok_or(NO_SUCH_AXIS)
}

fn number(text: &str) -> Result<f64, ErrorCode> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or(NOT_A_NUMBER)
}

/// The host's end of the line to a controller that others hold too.
#[derive(Clone, Debug)]
pub struct GcsLine(pub Rc<RefCell<GcsMirror>>);

impl ByteLine for GcsLine {
    fn name(&self) -> &str {
        "mirror line"
    }

    fn read(&mut self, now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        Ok(self.0.borrow_mut().read(now, into))
    }

    fn write(&mut self, now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.0.borrow_mut().write(now, bytes);
        Ok(())
    }
}
