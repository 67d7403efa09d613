//! The data recorder: tables that take a value every n-th cycle of the servo, from a trigger until they are full.

use super::{Answer, ErrorCode, Mirror, NOT_A_NUMBER, OUT_OF_RANGE, URAD_PER_RAD, WRONG_COUNT, axis, number};

/// Number of tables.
pub(super) const TABLES: u32 = 8;
/// Points that a table holds.
pub(super) const MOST_POINTS: usize = 8192;
const NO_SUCH_TABLE: ErrorCode = 57;
const NO_SUCH_OPTION: ErrorCode = 58;
const NOT_ENOUGH_DATA: ErrorCode = 77;

/// What a table records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Target,
    Position,
    Error,
    Voltage,
}

impl Quantity {
    /// By the number of the record option.
    fn by_option(option: u32) -> Option<Self> {
        match option {
            1 => Some(Self::Target),
            2 => Some(Self::Position),
            3 => Some(Self::Error),
            7 => Some(Self::Voltage),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Target => "Target Position of axis",
            Self::Position => "Actual Position of axis",
            Self::Error => "Position Error of axis",
            Self::Voltage => "Voltage of output chan",
        }
    }

    fn of(self, mirror: &Mirror, target_urad: f64, axis: usize) -> f64 {
        let position_urad = mirror.sensed_rad()[axis] * URAD_PER_RAD;
        match self {
            Self::Target => target_urad,
            Self::Position => position_urad,
            Self::Error => target_urad - position_urad,
            Self::Voltage => mirror.drive_v()[axis] + 0.5 * mirror.settings.amplifier_voltage_v,
        }
    }
}

#[derive(Clone, Debug)]
struct Table {
    axis: usize,
    quantity: Quantity,
    points: Vec<f64>,
}

/// All tables and what starts them.
#[derive(Clone, Debug)]
pub(super) struct Recorder {
    tables: Vec<Table>,
    every: u32,
    /// A command that changes a position starts the recording.
    is_armed: bool,
    is_recording: bool,
    cycles: u32,
}

impl Default for Recorder {
    /// Positions of both axes in turn, every cycle, from the next command that changes a position.
    fn default() -> Self {
        let table =
            |k: u32| Table { axis: (k % 2) as usize, quantity: Quantity::Position, points: Vec::new() };
        Self {
            tables: (0..TABLES).map(table).collect(),
            every: 1,
            is_armed: true,
            is_recording: false,
            cycles: 0,
        }
    }
}

impl Recorder {
    /// A command has changed a position.
    pub(super) fn position_changed(&mut self) {
        if self.is_armed {
            self.start();
        }
    }

    fn start(&mut self) {
        self.tables.iter_mut().for_each(|table| table.points.clear());
        self.is_armed = false;
        self.is_recording = true;
        self.cycles = 0;
    }

    /// One cycle of the servo has ended.
    pub(super) fn cycle(&mut self, mirror: &Mirror, target_urad: [f64; 2]) {
        if !self.is_recording {
            return;
        }
        if self.cycles.is_multiple_of(self.every) {
            for table in &mut self.tables {
                let value = table.quantity.of(mirror, target_urad[table.axis], table.axis);
                table.points.push(value);
            }
            self.is_recording = self.tables[0].points.len() < MOST_POINTS;
        }
        self.cycles = self.cycles.wrapping_add(1);
    }

    /// Carries out a command of the recorder; `None` if it is none.
    pub(super) fn execute(&mut self, mnemonic: &str, arguments: &[&str], step_s: f64) -> Option<Answer> {
        Some(match mnemonic {
            "TNR?" => Ok(vec![TABLES.to_string()]),
            "RTR?" => Ok(vec![self.every.to_string()]),
            "RTR" => self.set_rate(arguments),
            "DRC" => self.set_source(arguments),
            "DRT" => self.set_trigger(arguments),
            "DRL?" => self.lengths(arguments),
            "DRR?" => self.read(arguments, step_s),
            _ => return None,
        })
    }

    fn set_rate(&mut self, arguments: &[&str]) -> Answer {
        let [cycles] = arguments else { return Err(WRONG_COUNT) };
        let cycles = whole(cycles)?;
        if cycles == 0 {
            return Err(OUT_OF_RANGE);
        }
        self.every = cycles;
        Ok(vec![])
    }

    fn set_source(&mut self, arguments: &[&str]) -> Answer {
        let [table, source, option] = arguments else { return Err(WRONG_COUNT) };
        let place = self.place(table)?;
        let axis = axis(source)?;
        let quantity = Quantity::by_option(whole(option)?).ok_or(NO_SUCH_OPTION)?;
        let table = &mut self.tables[place];
        table.axis = axis;
        table.quantity = quantity;
        Ok(vec![])
    }

    /// `DRT 0 source value`: 0 is the default of the controller, here the same as 1; 1 is a command that changes a position; 4 is
    /// at once.
    fn set_trigger(&mut self, arguments: &[&str]) -> Answer {
        let [table, source, _] = arguments else { return Err(WRONG_COUNT) };
        if *table != "0" {
            self.place(table)?;
        }
        match whole(source)? {
            0 | 1 => self.is_armed = true,
            4 => self.start(),
            _ => return Err(OUT_OF_RANGE),
        }
        Ok(vec![])
    }

    fn lengths(&self, arguments: &[&str]) -> Answer {
        let asked: Vec<usize> = if arguments.is_empty() {
            (0..self.tables.len()).collect()
        } else {
            arguments.iter().map(|name| self.place(name)).collect::<Result<_, _>>()?
        };
        let length = |place: usize| format!("{}={}", place + 1, self.tables[place].points.len());
        Ok(asked.into_iter().map(length).collect())
    }

    /// `DRR? first count table…`: header and rows.
    fn read(&self, arguments: &[&str], step_s: f64) -> Answer {
        let [first, count, names @ ..] = arguments else { return Err(WRONG_COUNT) };
        let first = whole(first)? as usize;
        let count = whole(count)? as usize;
        let places: Vec<usize> = names.iter().map(|name| self.place(name)).collect::<Result<_, _>>()?;
        if first == 0 || places.is_empty() {
            return Err(OUT_OF_RANGE);
        }
        let recorded = self.tables[0].points.len();
        let last = (first - 1).checked_add(count).filter(|last| *last <= recorded).ok_or(NOT_ENOUGH_DATA)?;
        let mut lines = vec![
            "# TYPE = 1".to_owned(),
            "# SEPARATOR = 32".to_owned(),
            format!("# DIM = {}", places.len()),
            format!("# SAMPLE_TIME = {}", step_s * f64::from(self.every)),
            format!("# NDATA = {count}"),
        ];
        for (column, &place) in places.iter().enumerate() {
            let table = &self.tables[place];
            lines.push(format!("# NAME{column} = {} {}", table.quantity.name(), table.axis + 1));
        }
        lines.push("# END_HEADER".to_owned());
        for row in first - 1..last {
            let values: Vec<String> =
                places.iter().map(|&place| format!("{:.6}", self.tables[place].points[row])).collect();
            lines.push(values.join(" "));
        }
        Ok(lines)
    }

    fn place(&self, name: &str) -> Result<usize, ErrorCode> {
        let table = whole(name)? as usize;
        (1..=self.tables.len()).contains(&table).then(|| table - 1).ok_or(NO_SUCH_TABLE)
    }
}

/// A whole number from 0 on.
fn whole(text: &str) -> Result<u32, ErrorCode> {
    let value = number(text)?;
    if value.fract() != 0.0 {
        return Err(NOT_A_NUMBER);
    }
    if !(0.0..=f64::from(u32::MAX)).contains(&value) {
        return Err(OUT_OF_RANGE);
    }
    Ok(value as u32)
}
