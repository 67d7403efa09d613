//! Requests: how they are written and how their replies are read.

use super::{Record, Reply};
use crate::answer::FormatError;

/// What the data recorder writes into a table (subset of the options of the E-727).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordOption {
    /// Position that was asked for.
    Target,
    /// Position as measured.
    Position,
    /// Target minus measured position.
    PositionError,
    /// Piezo voltage of an output channel.
    PiezoVoltage,
}

impl RecordOption {
    const fn code(self) -> u8 {
        match self {
            Self::Target => 1,
            Self::Position => 2,
            Self::PositionError => 3,
            Self::PiezoVoltage => 7,
        }
    }
}

/// What starts the data recorder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriggerSource {
    /// The next command that changes a position.
    Move,
    /// At once.
    Immediate,
}

impl TriggerSource {
    const fn code(self) -> u8 {
        match self {
            Self::Move => 1,
            Self::Immediate => 4,
        }
    }
}

/// Something that the controller is asked or told. Pairs are azimuth, elevation, in the order of the settings' axes; positions are
/// in the unit that the controller is set to.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// `ERR?`: number of the last error, which it clears.
    LastError,
    /// `*IDN?`
    Identity,
    /// `SAI?`: identifiers of the axes.
    Axes,
    /// `SVO`: closed loop on or off.
    Servo([bool; 2]),
    /// `SVO?`: 1 closed, 0 open.
    IsServoOn,
    /// `MOV`: closed-loop targets.
    Move([f64; 2]),
    /// `MOV?`
    Targets,
    /// `MVR`: targets relative to the targets as they are.
    MoveBy([f64; 2]),
    /// `SVA`: open-loop values.
    OpenLoop([f64; 2]),
    /// `POS?`
    Positions,
    /// `ONT?`: 1 on target.
    OnTarget,
    /// `OVF?`: 1 if the drive is at its limit.
    Overflow,
    /// `TMN?`: lower limits of travel.
    LowerLimits,
    /// `TMX?`: upper limits of travel.
    UpperLimits,
    /// `VOL? 1 2`: piezo voltages of output channels 1 and 2.
    PiezoVoltages,
    /// `STP`: stop. It leaves error 10 behind, which is expected here.
    Stop,
    /// `SPA? axis id`: a parameter of an axis; the number of the axis counts from 0.
    Parameter {
        /// 0 azimuth, 1 elevation.
        axis: usize,
        /// Identifier, e.g. 0x0E000200, the update time of the servo.
        id: u32,
    },
    /// `SPA`: sets a parameter of an axis in memory that is lost without supply.
    SetParameter {
        /// 0 azimuth, 1 elevation.
        axis: usize,
        /// Identifier, e.g. 0x06000500, the input channel that is the target of the axis.
        id: u32,
        /// Value.
        value: u32,
    },
    /// `TNR?`: number of tables of the recorder.
    TablesCount,
    /// `RTR`: record every n-th servo cycle.
    RecordEvery(u32),
    /// `DRC`: what a table records of an axis.
    RecordInto {
        /// Table, from 1.
        table: u32,
        /// 0 azimuth, 1 elevation.
        axis: usize,
        /// Quantity.
        option: RecordOption,
    },
    /// `DRT 0 source 0`: what starts the recording of all tables.
    RecordOn(TriggerSource),
    /// `DRL? table`: points recorded.
    RecordedCount(u32),
    /// `DRR?`: points of tables.
    Recorded {
        /// First point, from 1.
        first: u32,
        /// Points of each table.
        count: u32,
        /// Tables, from 1.
        tables: Vec<u32>,
    },
}

/// Shape of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Nothing,
    Text,
    Lines,
    /// `axis=value` for both axes.
    Axes,
    /// `number=value` for output channels 1 and 2.
    Channels,
    /// `something=value`, or the value alone.
    Number,
    Record,
}

impl Request {
    pub(super) fn form(&self) -> Form {
        match self {
            Self::Servo(_)
            | Self::Move(_)
            | Self::MoveBy(_)
            | Self::OpenLoop(_)
            | Self::Stop
            | Self::SetParameter { .. }
            | Self::RecordEvery(_)
            | Self::RecordInto { .. }
            | Self::RecordOn(_) => Form::Nothing,
            Self::Identity => Form::Text,
            Self::Axes => Form::Lines,
            Self::IsServoOn
            | Self::Targets
            | Self::Positions
            | Self::OnTarget
            | Self::Overflow
            | Self::LowerLimits
            | Self::UpperLimits => Form::Axes,
            Self::PiezoVoltages => Form::Channels,
            Self::LastError | Self::Parameter { .. } | Self::TablesCount | Self::RecordedCount(_) => {
                Form::Number
            }
            Self::Recorded { .. } => Form::Record,
        }
    }

    /// The command without its line feed.
    ///
    /// # Errors
    /// A value that is not finite.
    pub(super) fn text(&self, axes: &[String; 2]) -> Result<String, f64> {
        let [az, el] = axes;
        let both = |mnemonic: &str| format!("{mnemonic} {az} {el}");
        let values = |mnemonic: &str, values: &[f64; 2]| match values.iter().find(|value| !value.is_finite())
        {
            None => Ok(format!("{mnemonic} {az} {:.6} {el} {:.6}", values[0], values[1])),
            Some(&value) => Err(value),
        };
        let name = |axis: usize| axes.get(axis).map_or("", String::as_str);
        Ok(match self {
            Self::LastError => "ERR?".to_owned(),
            Self::Identity => "*IDN?".to_owned(),
            Self::Axes => "SAI?".to_owned(),
            Self::Servo([a, e]) => format!("SVO {az} {} {el} {}", u8::from(*a), u8::from(*e)),
            Self::IsServoOn => both("SVO?"),
            Self::Move(targets) => values("MOV", targets)?,
            Self::Targets => both("MOV?"),
            Self::MoveBy(steps) => values("MVR", steps)?,
            Self::OpenLoop(open) => values("SVA", open)?,
            Self::Positions => both("POS?"),
            Self::OnTarget => both("ONT?"),
            Self::Overflow => both("OVF?"),
            Self::LowerLimits => both("TMN?"),
            Self::UpperLimits => both("TMX?"),
            Self::PiezoVoltages => "VOL? 1 2".to_owned(),
            Self::Stop => "STP".to_owned(),
            Self::Parameter { axis, id } => format!("SPA? {} 0x{id:08X}", name(*axis)),
            Self::SetParameter { axis, id, value } => format!("SPA {} 0x{id:08X} {value}", name(*axis)),
            Self::TablesCount => "TNR?".to_owned(),
            Self::RecordEvery(cycles) => format!("RTR {cycles}"),
            Self::RecordInto { table, axis, option } => {
                format!("DRC {table} {} {}", name(*axis), option.code())
            }
            Self::RecordOn(source) => format!("DRT 0 {} 0", source.code()),
            Self::RecordedCount(table) => format!("DRL? {table}"),
            Self::Recorded { first, count, tables } => {
                let tables: Vec<String> = tables.iter().map(u32::to_string).collect();
                format!("DRR? {first} {count} {}", tables.join(" "))
            }
        })
    }

    /// Reads a complete reply.
    pub(super) fn read(&self, text: &str, axes: &[String; 2]) -> Result<Reply, FormatError> {
        match self.form() {
            Form::Nothing => Ok(Reply::Done),
            Form::Text => Ok(Reply::Text(text.trim().to_owned())),
            Form::Lines => Ok(Reply::Lines(text.lines().map(|line| line.trim().to_owned()).collect())),
            Form::Axes => values(text, [&axes[0], &axes[1]]).map(Reply::Values),
            Form::Channels => values(text, ["1", "2"]).map(Reply::Values),
            Form::Number => {
                let line = text.trim();
                let value = line.rsplit_once('=').map_or(line, |(_, value)| value);
                number(value, 1).map(Reply::Number)
            }
            Form::Record => Record::read(text).map(Reply::Record),
        }
    }
}

/// Values of two lines `name=value`, in this order. Allocates nothing unless something is wrong.
pub(super) fn values(text: &str, names: [&str; 2]) -> Result<[f64; 2], FormatError> {
    let found = text.lines().count();
    if found != names.len() {
        return Err(FormatError::Count { expected: names.len(), found });
    }
    let mut values = [0.0; 2];
    for (place, line) in text.lines().map(str::trim).enumerate() {
        let value = line.strip_prefix(names[place]).and_then(|rest| rest.strip_prefix('='));
        let expected = "a line `axis=value` for each axis that was asked for, in order";
        let value = value.ok_or_else(|| FormatError::Text { expected, found: line.to_owned() })?;
        values[place] = number(value, place + 1)?;
    }
    Ok(values)
}

fn number(text: &str, place: usize) -> Result<f64, FormatError> {
    let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| FormatError::NotANumber { place, found: text.trim().to_owned() })
}
