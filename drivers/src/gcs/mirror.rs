//! A two-axis mirror behind a controller that speaks GCS 2.0, exchanged with once a tick.
//!
//! Commands reach the controller as positions on the line (`MOV`), or as voltages at its analog inputs, which parameter 06000500h
//! makes the targets of the axes. The tick allocates nothing unless something is wrong.

#[cfg(test)]
mod tests;

use std::io::{Cursor, Write as _};
use std::time::Duration;

use super::request::values;
use super::{Gcs, GcsSettings, READ_BYTES, Reply, Request, error_meaning, is_complete};
use crate::answer::FormatError;
use crate::device::DeviceError;
use crate::mirror::analog::{check_positive, within_stroke};
use crate::mirror::{Actuals, Path};
use crate::wire::{AnalogPort, ByteLine};

/// Parameter: the input channel that is the target of an axis; 0 takes the target from commands (E727T0005).
const TARGET_INPUT: u32 = 0x0600_0500;
/// Longest identifier of an axis.
const LONGEST_AXIS: usize = 16;
/// Largest position in units of the controller; its text has at most ten digits before the point.
const LARGEST_POSITION: f64 = 1e9;
/// Positions are sent with six decimals.
const STEPS_PER_UNIT: f64 = 1e6;
/// Range of an analog output, V.
const ANALOG_LIMIT_V: f64 = 10.0;
/// Room for a command with both axes and the question behind it, and for the reply of both axes.
const TEXT_BYTES: usize = 128;

/// First of the requests that a change of the command path repeats, and how many there are in all.
const FIRST_OF_CHANGE: usize = 5;
const REQUESTS: usize = 12;

/// What the driver must know of a mirror. Pairs are azimuth, elevation.
#[derive(Clone, Debug, PartialEq)]
pub struct GcsMirrorSettings {
    /// Name in errors and topics, e.g. `fsm`.
    pub name: String,
    /// Identifiers of the axes, e.g. `1` and `2`.
    pub axes: [String; 2],
    /// Angle of one unit of position of the controller.
    pub position_unit_rad: f64,
    /// Angle per volt of the analog commands and of the analog feedback.
    pub scale_rad_per_v: [f64; 2],
    /// Commands stay within ± this.
    pub stroke_rad: [f64; 2],
    /// Way of the commands.
    pub command: Path,
    /// Way of the feedback.
    pub feedback: Path,
    /// Input channels of the controller that the analog commands are wired to, as parameter 06000500h numbers them.
    pub target_inputs: [u32; 2],
    /// Analog outputs of the bench that are wired to those.
    pub command_outputs: [usize; 2],
    /// Analog inputs of the bench that are wired to the position monitors.
    pub feedback_inputs: [usize; 2],
    /// Time without a byte after which a reply is given up, s.
    pub answer_timeout_s: f64,
}

/// What is under way on the line in the tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sent {
    /// `MOV`, and the question for the error number.
    Move,
    /// `POS?`
    Positions,
}

/// A controller and its mirror.
#[derive(Clone, Debug)]
pub struct GcsMirror {
    settings: GcsMirrorSettings,
    gcs: Gcs,
    /// Next request of [`GcsMirror::configure`].
    next: usize,
    is_changing: bool,
    identity: String,
    /// Travel that the controller allows, in its units: lower limits.
    lower: [f64; 2],
    /// Positions that the controller has, in millionths of its units; `None` if that is not known.
    ordered: Option<[i64; 2]>,
    sent: Option<Sent>,
    /// When the last byte came or went.
    last_byte_at: Duration,
    reply: [u8; TEXT_BYTES],
    length: usize,
    /// Feedback was the last to be asked for.
    asked_last: bool,
    actuals: Actuals,
}

impl GcsMirror {
    /// A driver that has not spoken to its controller yet.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] for a scale, stroke, unit or timeout that cannot be, [`DeviceError::Field`] for identifiers of axes
    /// that cannot be.
    pub fn new(settings: GcsMirrorSettings) -> Result<Self, DeviceError> {
        check(&settings)?;
        let gcs = Gcs::new(GcsSettings {
            name: settings.name.clone(),
            axes: settings.axes.clone(),
            answer_timeout_s: settings.answer_timeout_s,
        })?;
        Ok(Self {
            settings,
            gcs,
            next: 0,
            is_changing: false,
            identity: String::new(),
            lower: [0.0; 2],
            ordered: None,
            sent: None,
            last_byte_at: Duration::ZERO,
            reply: [0; TEXT_BYTES],
            length: 0,
            asked_last: false,
            actuals: Actuals::default(),
        })
    }

    /// Identifies and configures, one request after the other; call until it gives the answer to `*IDN?`. An error that the
    /// controller still has from somebody else is cleared. Both servos are closed; nothing moves but the mirror, to its middle.
    ///
    /// # Errors
    /// No or a wrong reply, an error that the controller reports, an axis that it lacks, travel that is shorter than the stroke, a
    /// setting that does not read back.
    pub fn configure(
        &mut self,
        line: &mut dyn ByteLine,
        now: Duration,
    ) -> Result<Option<String>, DeviceError> {
        // What the tick has sent is answered first: its reply must not be taken for another one.
        if self.sent.is_some() && !self.poll_tick(line, now)? {
            return Ok(None);
        }
        if let Some(reply) = self.gcs.poll(line, now)? {
            self.take(reply)?;
            self.next += 1;
        }
        let count = if self.settings.command == Path::Serial { REQUESTS } else { REQUESTS - 1 };
        if self.next >= count {
            self.is_changing = false;
            return Ok(Some(self.identity.clone()));
        }
        if self.gcs.is_idle() {
            self.gcs.send(line, self.request(), now)?;
        }
        Ok(None)
    }

    /// Begins to send commands another way; [`GcsMirror::configure`] must then be called until it is done.
    pub fn change_command_path(&mut self, path: Path) {
        self.settings.command = path;
        self.next = FIRST_OF_CHANGE;
        self.ordered = None;
        self.is_changing = true;
    }

    /// Whether [`GcsMirror::configure`] must be called until it is done.
    pub fn is_changing(&self) -> bool {
        self.is_changing
    }

    /// The way that commands are sent.
    pub fn command_path(&self) -> Path {
        self.settings.command
    }

    /// The next request of the dialogue.
    fn request(&self) -> Request {
        let set = |axis| Request::SetParameter { axis, id: TARGET_INPUT, value: self.target_input(axis) };
        let get = |axis| Request::Parameter { axis, id: TARGET_INPUT };
        match self.next {
            0 => Request::LastError,
            1 => Request::Identity,
            2 => Request::Axes,
            3 => Request::LowerLimits,
            4 => Request::UpperLimits,
            5 => set(0),
            6 => set(1),
            7 => Request::Servo([true; 2]),
            8 => Request::IsServoOn,
            9 => get(0),
            10 => get(1),
            _ => Request::Move([0.0; 2]),
        }
    }

    /// Input channel that is the target of an axis on the present path.
    fn target_input(&self, axis: usize) -> u32 {
        if self.settings.command == Path::Analog { self.settings.target_inputs[axis] } else { 0 }
    }

    /// Checks the reply to the present request.
    fn take(&mut self, reply: Reply) -> Result<(), DeviceError> {
        match (self.next, reply) {
            (1, Reply::Text(identity)) => self.identity = identity,
            (2, Reply::Lines(axes)) => self.check_axes(&axes)?,
            (3, Reply::Values(lower)) => self.lower = lower,
            (4, Reply::Values(upper)) => self.check_travel(upper)?,
            (8, Reply::Values(servos)) => self.check_servos(servos)?,
            (9 | 10, Reply::Number(input)) => self.check_target(self.next - 9, input)?,
            (11, Reply::Done) => self.ordered = Some([0; 2]),
            _ => {}
        }
        Ok(())
    }

    fn check_axes(&self, found: &[String]) -> Result<(), DeviceError> {
        let is_missing = |axis: &&String| !found.contains(axis);
        match self.settings.axes.iter().find(is_missing) {
            None => Ok(()),
            Some(axis) => Err(self.error(
                "axes (SAI?)",
                format!("axis `{axis}` among them"),
                found.join(", "),
                "correct the identifiers of the axes in the rig file",
            )),
        }
    }

    fn check_travel(&self, upper: [f64; 2]) -> Result<(), DeviceError> {
        for (axis, upper) in upper.into_iter().enumerate() {
            let stroke = self.settings.stroke_rad[axis] / self.settings.position_unit_rad;
            // The controller rounds to the decimals that it sends.
            let least = stroke - 1.0 / STEPS_PER_UNIT;
            if upper < least || self.lower[axis] > -least {
                return Err(self.error(
                    "travel (TMN?, TMX?)",
                    format!("-{stroke:.6} to {stroke:.6} for axis `{}`", self.settings.axes[axis]),
                    format!("{} to {upper}", self.lower[axis]),
                    "lower `stroke` in the rig file, or correct `position-unit`",
                ));
            }
        }
        Ok(())
    }

    fn check_servos(&self, servos: [f64; 2]) -> Result<(), DeviceError> {
        if servos == [1.0; 2] {
            return Ok(());
        }
        let found = format!("{} and {}", servos[0], servos[1]);
        let help = "the controller does not keep its servo on: look at its overflow and sensor state";
        Err(self.error("servo (SVO?)", "1 and 1".to_owned(), found, help))
    }

    fn check_target(&self, axis: usize, input: f64) -> Result<(), DeviceError> {
        let expected = self.target_input(axis);
        if input == f64::from(expected) {
            return Ok(());
        }
        let help = "the controller does not take commands the way that it was told: correct the input channels in the rig file";
        Err(self.error("target input (06000500h)", expected.to_string(), input.to_string(), help))
    }

    /// One tick: sends the commands, takes the feedback that is there. Commands are limited to the stroke; one that is not a number
    /// is sent as 0.
    ///
    /// # Errors
    /// When a wire is gone, or the controller does not answer in time or reports an error.
    pub fn exchange(
        &mut self,
        line: &mut dyn ByteLine,
        analog: &mut dyn AnalogPort,
        command_rad: [f64; 2],
        now: Duration,
    ) -> Result<Actuals, DeviceError> {
        let command_rad = [0, 1].map(|axis| within_stroke(command_rad[axis], self.settings.stroke_rad[axis]));
        let GcsMirrorSettings { scale_rad_per_v: scale, command_outputs, feedback_inputs, .. } =
            self.settings;
        if self.settings.command == Path::Analog {
            let volts =
                [0, 1].map(|axis| (command_rad[axis] / scale[axis]).clamp(-ANALOG_LIMIT_V, ANALOG_LIMIT_V));
            self.actuals.send_analog(analog, command_outputs, volts, scale, now)?;
        }
        if self.settings.feedback == Path::Analog {
            self.actuals.take_analog(analog, feedback_inputs, scale, now)?;
        }
        if !self.is_changing {
            self.line_turn(line, command_rad, now)?;
        }
        Ok(self.actuals)
    }

    /// Takes a reply if it is complete, then sends what is next: positions that changed and feedback, in turn.
    fn line_turn(
        &mut self,
        line: &mut dyn ByteLine,
        command_rad: [f64; 2],
        now: Duration,
    ) -> Result<(), DeviceError> {
        if !self.poll_tick(line, now)? {
            return Ok(());
        }
        let unit_rad = self.settings.position_unit_rad;
        let order = command_rad.map(|rad| (rad / unit_rad * STEPS_PER_UNIT).round() as i64);
        let moves = self.settings.command == Path::Serial && self.ordered != Some(order);
        let asks = self.settings.feedback == Path::Serial;
        match (moves, asks) {
            (true, true) if !self.asked_last => self.ask_positions(line, now),
            (true, _) => self.send_move(line, order, now),
            (false, true) => self.ask_positions(line, now),
            (false, false) => Ok(()),
        }
    }

    fn ask_positions(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<(), DeviceError> {
        self.asked_last = true;
        let [az, el] = &self.settings.axes;
        let mut text = Cursor::new([0; TEXT_BYTES]);
        writeln!(text, "POS? {az} {el}").expect(FITS);
        self.send(line, Sent::Positions, &text, now)
    }

    fn send_move(
        &mut self,
        line: &mut dyn ByteLine,
        order: [i64; 2],
        now: Duration,
    ) -> Result<(), DeviceError> {
        self.asked_last = false;
        let [az, el] = &self.settings.axes;
        let units = order.map(|steps| steps as f64 / STEPS_PER_UNIT);
        let mut text = Cursor::new([0; TEXT_BYTES]);
        writeln!(text, "MOV {az} {:.6} {el} {:.6}\nERR?", units[0], units[1]).expect(FITS);
        self.ordered = Some(order);
        self.actuals.command_rad = units.map(|unit| unit * self.settings.position_unit_rad);
        self.send(line, Sent::Move, &text, now)
    }

    fn send(
        &mut self,
        line: &mut dyn ByteLine,
        what: Sent,
        text: &Cursor<[u8; TEXT_BYTES]>,
        now: Duration,
    ) -> Result<(), DeviceError> {
        // What still comes of a request that was given up must not be taken for the reply.
        let mut late = [0; READ_BYTES];
        while line.read(now, &mut late)? == READ_BYTES {}
        (self.sent, self.length, self.last_byte_at) = (Some(what), 0, now);
        let length = usize::try_from(text.position()).unwrap_or(TEXT_BYTES).min(TEXT_BYTES);
        line.write(now, &text.get_ref()[..length])
    }

    /// Takes what has come of the reply in the tick; whether nothing is under way any more.
    fn poll_tick(&mut self, line: &mut dyn ByteLine, now: Duration) -> Result<bool, DeviceError> {
        let Some(sent) = self.sent else { return Ok(true) };
        while !is_complete(&self.reply[..self.length]) {
            let count = line.read(now, &mut self.reply[self.length..])?.min(TEXT_BYTES - self.length);
            if count == 0 {
                break;
            }
            (self.length, self.last_byte_at) = (self.length + count, now);
        }
        if !is_complete(&self.reply[..self.length]) {
            let is_over = self.length == TEXT_BYTES
                || now.saturating_sub(self.last_byte_at).as_secs_f64() > self.settings.answer_timeout_s;
            return if is_over { Err(self.give_up(sent)) } else { Ok(false) };
        }
        self.sent = None;
        self.finish(sent, now)?;
        Ok(true)
    }

    fn finish(&mut self, sent: Sent, now: Duration) -> Result<(), DeviceError> {
        let wrong = |command: &str, source| DeviceError::Answer {
            device: self.settings.name.clone(),
            command: command.to_owned(),
            source,
        };
        let text = std::str::from_utf8(&self.reply[..self.length]).unwrap_or_default();
        match sent {
            Sent::Positions => {
                let [az, el] = &self.settings.axes;
                let units = values(text, [az, el]).map_err(|source| wrong("POS?", source))?;
                self.actuals.angle_rad = units.map(|unit| unit * self.settings.position_unit_rad);
                self.actuals.is_fresh(now);
                Ok(())
            }
            Sent::Move => {
                let code: i32 = text.trim().parse().map_err(|_| {
                    let found = text.trim().to_owned();
                    wrong("ERR?", FormatError::Text { expected: "an error number", found })
                })?;
                if code == 0 {
                    return Ok(());
                }
                self.ordered = None;
                Err(DeviceError::Instrument {
                    device: self.settings.name.clone(),
                    command: "MOV".to_owned(),
                    code,
                    message: error_meaning(code).to_owned(),
                })
            }
        }
    }

    /// The reply that stays out; the next request begins anew.
    fn give_up(&mut self, sent: Sent) -> DeviceError {
        (self.sent, self.ordered) = (None, None);
        let command = if sent == Sent::Move { "MOV" } else { "POS?" };
        self.error(
            "reply",
            format!("one to {command}"),
            format!("{} bytes in {} s", self.length, self.settings.answer_timeout_s),
            "check power, cable and bit rate of the controller",
        )
    }

    fn error(&self, field: &'static str, expected: String, found: String, help: &'static str) -> DeviceError {
        DeviceError::Field { device: self.settings.name.clone(), field, expected, found, help }
    }
}

/// Why a command fits into its room.
const FITS: &str = "identifiers of axes and positions are checked: both have at most 17 characters";

fn check(settings: &GcsMirrorSettings) -> Result<(), DeviceError> {
    let positive = [
        ("scale_rad_per_v of azimuth", settings.scale_rad_per_v[0].abs()),
        ("scale_rad_per_v of elevation", settings.scale_rad_per_v[1].abs()),
        ("stroke_rad of azimuth", settings.stroke_rad[0]),
        ("stroke_rad of elevation", settings.stroke_rad[1]),
        ("position_unit_rad", settings.position_unit_rad),
    ];
    check_positive(&settings.name, &positive)?;
    let positions = settings.stroke_rad.map(|stroke_rad| stroke_rad / settings.position_unit_rad);
    if let Some(&value) = positions.iter().find(|position| **position >= LARGEST_POSITION) {
        let allowed = format!("the stroke must be below {LARGEST_POSITION:e} units of position");
        let setting = "stroke in units of position";
        return Err(DeviceError::Setting { device: settings.name.clone(), setting, value, allowed });
    }
    match settings.axes.iter().find(|axis| axis.len() > LONGEST_AXIS) {
        None => Ok(()),
        Some(axis) => Err(DeviceError::Field {
            device: settings.name.clone(),
            field: "axes",
            expected: format!("identifiers of at most {LONGEST_AXIS} characters"),
            found: axis.clone(),
            help: "SAI? lists the axes of the controller",
        }),
    }
}
