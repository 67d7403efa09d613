//! Fast steering mirror: analog and serial command channels, strain gauge feedback.
//!
//! The unit is configured over its serial line (CEDRAT CCBu40 style, see [`protocol`]); commands and feedback then go
//! over analog channels or over that line. Controllers that speak PI's GCS 2.0 have a driver of their own, [`crate::gcs`].
//!
//! Index 0 is azimuth (X on the unit), 1 elevation (Y). Angles are mechanical tilts of the mirror, not of the line of
//! sight.

pub(crate) mod analog;
pub mod protocol;
#[cfg(test)]
mod tests;
mod transaction;

use std::time::Duration;

use self::analog::{check_positive, within_stroke};
use self::protocol::{Command, ORDER_LIMIT_V, ParameterSet};
use self::transaction::{Reply, Transaction};
use crate::device::{Channel, DeviceError, Width};
use crate::wire::{AnalogPort, ByteLine};

/// Way of a command or of the feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Analog channels, new every tick.
    Analog,
    /// Serial line: one command or one feedback value per tick, in turn.
    Serial,
}

/// What the driver must know of a mirror. Pairs are azimuth, elevation.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorSettings {
    /// Name in errors and topics, e.g. `fsm`.
    pub name: String,
    /// Angle per volt of commands and feedback, analog and serial.
    pub scale_rad_per_v: [f64; 2],
    /// Commands stay within ± this.
    pub stroke_rad: [f64; 2],
    /// Way of the commands.
    pub command: Path,
    /// Way of the feedback.
    pub feedback: Path,
    /// Analog outputs wired to AIX and AIY.
    pub command_outputs: [usize; 2],
    /// Analog inputs wired to the strain gauge monitors.
    pub feedback_inputs: [usize; 2],
    /// Time allowed for the reply to a serial command.
    pub reply_timeout_s: f64,
}

/// What the unit says it is: one parameter set per axis, as read back after configuration.
pub type Identity = [ParameterSet; 2];

/// State of the mirror as the host knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuals {
    /// Commands really sent, after limits and rounding.
    pub command_rad: [f64; 2],
    /// Newest strain gauge feedback.
    pub angle_rad: [f64; 2],
    /// When it was taken, since the start of the run.
    pub feedback_at: Duration,
    /// Counts feedback values.
    pub feedback_counter: u32,
}

/// A mirror unit behind its line and its analog channels.
#[derive(Clone, Debug)]
pub struct Mirror {
    settings: MirrorSettings,
    transaction: Transaction,
    /// Next command of [`Mirror::configure`].
    configured: usize,
    /// A command of the tick was under way when the configuration began anew.
    awaits_old_reply: bool,
    /// The line is taken by a configuration that began anew.
    is_changing: bool,
    identity: Identity,
    /// Axis that the unit takes orders for; `None` where that is not known.
    selected: Option<usize>,
    /// Orders that the unit has, as sent; NaN where that is not known.
    order_v: [f64; 2],
    /// Next in the rota of serial commands: orders of both axes, feedback of both axes.
    turn: usize,
    actuals: Actuals,
}

/// Serial commands in turn: two orders, two feedback values.
const TURNS: usize = 4;
/// Commands that configure one axis.
const CONFIGURATION: usize = 5;
/// Resolution of an order on the line.
const ORDER_RESOLUTION_V: f64 = 1e-5;

impl Mirror {
    /// What the driver publishes each tick, in the order of [`Actuals::row`].
    pub const CHANNELS: &'static [Channel] = &[
        Channel { name: "command_az_rad", unit: "rad", width: Width::F32 },
        Channel { name: "command_el_rad", unit: "rad", width: Width::F32 },
        Channel { name: "angle_az_rad", unit: "rad", width: Width::F32 },
        Channel { name: "angle_el_rad", unit: "rad", width: Width::F32 },
        Channel { name: "feedback_counter", unit: "count", width: Width::U32 },
    ];

    /// A driver that has not spoken to its unit yet.
    ///
    /// # Errors
    /// [`DeviceError::Setting`] for a scale, stroke or timeout that cannot be.
    pub fn new(settings: MirrorSettings) -> Result<Self, DeviceError> {
        check(&settings)?;
        Ok(Self {
            settings,
            transaction: Transaction::default(),
            configured: 0,
            awaits_old_reply: false,
            is_changing: false,
            identity: Identity::default(),
            selected: Some(0),
            order_v: [0.0; 2],
            turn: 0,
            actuals: Actuals::default(),
        })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &MirrorSettings {
        &self.settings
    }

    /// Identifies and configures, one serial command after the other; call until it returns the identity. Orders
    /// start at zero; the loop is closed last. Nothing moves but the mirror, to its middle.
    ///
    /// # Errors
    /// No or a wrong reply; a setting that does not read back.
    pub fn configure(
        &mut self,
        line: &mut dyn ByteLine,
        now: Duration,
    ) -> Result<Option<Identity>, DeviceError> {
        let reply = self.transaction.poll(line, self.settings.reply_timeout_s, now)?;
        if reply.is_some() && self.awaits_old_reply {
            self.awaits_old_reply = false;
        } else if let Some(reply) = reply {
            if let Reply::Parameters(axis, set) = reply {
                self.check_read_back(axis, &set)?;
                self.identity[axis] = set;
            }
            self.configured += 1;
        }
        if self.configured == 2 * CONFIGURATION {
            self.is_changing = false;
            return Ok(Some(self.identity));
        }
        if self.transaction.is_idle() {
            let axis = self.configured / CONFIGURATION;
            let command = match self.configured % CONFIGURATION {
                0 => Command::SelectAxis(axis),
                1 => Command::Order(0.0),
                2 => Command::DigitalSource(self.settings.command == Path::Serial),
                3 => Command::CloseLoop(true),
                _ => Command::Parameters(axis),
            };
            self.selected = Some(axis);
            self.transaction.send(line, command, now)?;
        }
        Ok(None)
    }

    /// Begins to send commands another way; [`Mirror::configure`] must then be called until it is done. Meanwhile the line
    /// carries nothing else, and the mirror goes to its middle.
    pub fn change_command_path(&mut self, path: Path) {
        self.settings.command = path;
        self.configured = 0;
        self.order_v = [0.0; 2];
        self.awaits_old_reply = !self.transaction.is_idle();
        self.is_changing = true;
    }

    /// Whether [`Mirror::configure`] must be called until it is done.
    pub fn is_changing(&self) -> bool {
        self.is_changing
    }

    /// The way that commands are sent.
    pub fn command_path(&self) -> Path {
        self.settings.command
    }

    fn check_read_back(&self, axis: usize, set: &ParameterSet) -> Result<(), DeviceError> {
        let name = ["azimuth", "elevation"][axis];
        let failed = |what: &str| {
            Err(DeviceError::Bus {
                device: self.settings.name.clone(),
                reason: format!("{name}: {what}; check the switches and the stored parameters of the unit"),
            })
        };
        let digital = self.settings.command == Path::Serial;
        match () {
            () if !set.closed_loop => failed("strain gauge loop expected closed, found open"),
            () if set.digital_source != digital && digital => {
                failed("source expected digital (serial commands), found analog input")
            }
            () if set.digital_source != digital => {
                failed("source expected analog input, found digital (serial commands)")
            }
            () => Ok(()),
        }
    }

    /// One tick: sends the commands, takes the feedback that is there. Commands are limited to the stroke; one that
    /// is not a number is sent as 0.
    ///
    /// # Errors
    /// When a wire is gone, or the unit does not answer a serial command in time or not as it should.
    pub fn exchange(
        &mut self,
        line: &mut dyn ByteLine,
        analog: &mut dyn AnalogPort,
        command_rad: [f64; 2],
        now: Duration,
    ) -> Result<Actuals, DeviceError> {
        let command_v = [0, 1].map(|axis| self.volts(axis, command_rad[axis]));
        let MirrorSettings { scale_rad_per_v: scale, command_outputs, feedback_inputs, .. } = self.settings;
        if self.settings.command == Path::Analog {
            self.actuals.send_analog(analog, command_outputs, command_v, scale, now)?;
        }
        if self.settings.feedback == Path::Analog {
            self.actuals.take_analog(analog, feedback_inputs, scale, now)?;
        }
        self.serial_turn(line, command_v, now)?;
        Ok(self.actuals)
    }

    fn volts(&self, axis: usize, command_rad: f64) -> f64 {
        let command_rad = within_stroke(command_rad, self.settings.stroke_rad[axis]);
        (command_rad / self.settings.scale_rad_per_v[axis]).clamp(-ORDER_LIMIT_V, ORDER_LIMIT_V)
    }

    /// Takes a reply if it is complete, then sends the next command.
    fn serial_turn(
        &mut self,
        line: &mut dyn ByteLine,
        command_v: [f64; 2],
        now: Duration,
    ) -> Result<(), DeviceError> {
        if self.is_changing {
            return Ok(());
        }
        let reply = self.transaction.poll(line, self.settings.reply_timeout_s, now);
        let reply = reply.inspect_err(|_| self.forget_unit())?;
        if let Some(Reply::Feedback(axis, volts)) = reply {
            self.actuals.angle_rad[axis] = volts * self.settings.scale_rad_per_v[axis];
            self.actuals.is_fresh(now);
        }
        if self.transaction.is_idle()
            && let Some(command) = self.next_command(command_v)
        {
            self.transaction.send(line, command, now).inspect_err(|_| self.forget_unit())?;
        }
        Ok(())
    }

    /// Nobody knows what the unit has taken of a command that failed: axis and orders are sent anew.
    fn forget_unit(&mut self) {
        (self.selected, self.order_v) = (None, [f64::NAN; 2]);
    }

    /// Orders that changed and feedback, in turn; the axis is selected first where it is another one.
    fn next_command(&mut self, command_v: [f64; 2]) -> Option<Command> {
        for _ in 0..TURNS {
            let turn = self.turn;
            let axis = self.turn % 2;
            let order_v = (command_v[axis] / ORDER_RESOLUTION_V).round() * ORDER_RESOLUTION_V;
            let ordering = turn < 2 && self.settings.command == Path::Serial;
            let changed = ordering && order_v != self.order_v[axis];
            if changed && self.selected != Some(axis) {
                self.selected = Some(axis);
                return Some(Command::SelectAxis(axis));
            }
            self.turn = (turn + 1) % TURNS;
            if changed {
                self.order_v[axis] = order_v;
                self.actuals.command_rad[axis] = order_v * self.settings.scale_rad_per_v[axis];
                return Some(Command::Order(order_v));
            }
            if turn >= 2 && self.settings.feedback == Path::Serial {
                return Some(Command::Feedback(axis));
            }
        }
        None
    }
}

impl Actuals {
    /// The values in the order of [`Mirror::CHANNELS`].
    pub fn row(&self) -> [f64; 5] {
        let ([command_az, command_el], [angle_az, angle_el]) = (self.command_rad, self.angle_rad);
        [command_az, command_el, angle_az, angle_el, f64::from(self.feedback_counter)]
    }
}

fn check(settings: &MirrorSettings) -> Result<(), DeviceError> {
    let positive = [
        ("scale_rad_per_v of azimuth", settings.scale_rad_per_v[0].abs()),
        ("scale_rad_per_v of elevation", settings.scale_rad_per_v[1].abs()),
        ("stroke_rad of azimuth", settings.stroke_rad[0]),
        ("stroke_rad of elevation", settings.stroke_rad[1]),
        ("reply_timeout_s", settings.reply_timeout_s),
    ];
    check_positive(&settings.name, &positive)
}
