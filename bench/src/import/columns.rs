//! The columns of one segment, read from a CSV file row by row and scaled to SI.

use std::collections::BTreeSet;

use procedures::diagnostic::{Diagnostic, nearest};

use super::map::{ImportMap, SegmentMap, TimeSource};
use super::table::{Mistake, Table, mistake};

/// Time between the rows of a static map, which has none: only for the order of rows in the log.
const STATIC_STEP_S: f64 = 1e-3;
/// Longest segment, s: log time counts nanoseconds, and no record of an axis is a year long.
const LONGEST_S: f64 = 366.0 * 86_400.0;
/// Shortest time between rows, s: log time has no finer step.
const SHORTEST_STEP_S: f64 = 1e-9;
/// Largest value in SI units, far beyond any angle, rate, torque, current or ratio: more would overflow where it is squared.
const LARGEST_SI: f64 = 1e30;
/// Values that a map may take out of its tables though they have fewer bytes: a segment or a column may be taken twice.
const MOST_VALUES: u64 = 8 << 20;

/// Bytes that all segments of a map may read: each reads its tables from the start.
const MOST_READ_BYTES: u64 = 1 << 30;

/// How much a map has taken out of its tables.
#[derive(Debug, Default)]
pub(super) struct Taken {
    values: u64,
    /// Bytes of all tables, each counted once.
    size_bytes: u64,
    /// Bytes read, of a table as often as it was read.
    read_bytes: u64,
    files: BTreeSet<String>,
}

/// One segment.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Columns {
    /// Time of each row since the first.
    pub(super) time_s: Vec<f64>,
    /// One column per channel of the map.
    pub(super) columns: Vec<Vec<f64>>,
}

impl Columns {
    /// Duration with one step beyond the last row.
    pub(super) fn duration_s(&self) -> f64 {
        let last_s = self.time_s.last().copied().unwrap_or(0.0);
        let steps = self.time_s.len().saturating_sub(1).max(1) as f64;
        last_s + if last_s > 0.0 { last_s / steps } else { STATIC_STEP_S }
    }

    /// Values of one row in the order of the map's channels.
    pub(super) fn row(&self, row: usize) -> Vec<f64> {
        self.columns.iter().map(|c| c[row]).collect()
    }

    /// First value of a channel; 0 if the map has no such channel.
    pub(super) fn first(&self, channel: &str, map: &ImportMap) -> f64 {
        let index = map.channels.iter().position(|c| c.channel == channel);
        index.and_then(|i| self.columns[i].first()).copied().unwrap_or(0.0)
    }
}

/// Smallest and largest value of a channel over all tables.
pub(super) fn span(map: &ImportMap, tables: &[Columns], channel: &str) -> [f64; 2] {
    let Some(index) = map.channels.iter().position(|c| c.channel == channel) else { return [0.0, 0.0] };
    let values = || tables.iter().flat_map(|t| t.columns[index].iter().copied());
    [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
}

/// Median time between rows over all tables.
pub(super) fn median_step_s(tables: &[Columns]) -> f64 {
    let mut steps: Vec<f64> =
        tables.iter().flat_map(|t| t.time_s.windows(2).map(|w| w[1] - w[0])).filter(|s| *s > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(STATIC_STEP_S)
}

/// Reads one segment.
///
/// # Errors
/// File, line, column, expected and found.
pub(super) fn read(map: &ImportMap, segment: &SegmentMap, taken: &mut Taken) -> Result<Columns, Mistake> {
    let mut table = Table::open(map, segment)?;
    taken.tables(&table)?;
    let find = |column: &str| place(table.file(), &table.header, column);
    let time_column = match &map.time {
        TimeSource::Column { column, scale_s } => Some((find(column)?, *scale_s)),
        TimeSource::Rate { .. } | TimeSource::None => None,
    };
    let places = map.channels.iter().map(|c| find(&c.column)).collect::<Result<Vec<_>, _>>()?;
    let most_rows =
        table.lines.min(segment.rows.map_or(usize::MAX, |[first, last]| (last - first) as usize + 1));
    let mut columns = vec![Vec::new(); places.len()];
    let mut time_s: Vec<f64> = Vec::new();
    while table.next_row()? {
        let row = table.rows();
        if segment.rows.is_some_and(|[first, last]| row < first || row > last) {
            continue;
        }
        let cell = Cell { file: table.file(), record: &table.record, row, header: &table.header };
        let t_s = match (&map.time, time_column) {
            (_, Some((at, scale_s))) => cell.number(at, scale_s)?,
            (TimeSource::Rate { rate_hz }, None) => time_s.len() as f64 / rate_hz,
            _ => time_s.len() as f64 * STATIC_STEP_S,
        };
        if segment.from_s.is_some_and(|from_s| t_s < from_s) {
            continue;
        }
        if let Some(&last_s) = time_s.last() {
            cell.follows(t_s, last_s, time_s[0])?;
        } else {
            columns.iter_mut().chain([&mut time_s]).for_each(|column| column.reserve_exact(most_rows));
        }
        taken.row(places.len(), table.file())?;
        time_s.push(t_s);
        for ((column, &at), channel) in columns.iter_mut().zip(&places).zip(&map.channels) {
            column.push(cell.number(at, channel.scale_factor)?);
        }
    }
    if time_s.len() < 2 {
        let message = format!(
            "{}: {} rows in segment `{}`, expected at least 2",
            table.file(),
            time_s.len(),
            segment.branch
        );
        return Err(mistake(message, "check `rows` and `from`"));
    }
    let start_s = time_s[0];
    time_s.iter_mut().for_each(|t| *t -= start_s);
    columns.iter_mut().chain([&mut time_s]).for_each(Vec::shrink_to_fit);
    Ok(Columns { time_s, columns })
}

impl Taken {
    /// Counts the tables of a segment.
    fn tables(&mut self, table: &Table) -> Result<(), Mistake> {
        for (file, size_bytes) in table.files() {
            self.read_bytes += size_bytes;
            if self.files.insert(file.to_owned()) {
                self.size_bytes += size_bytes;
            }
        }
        if self.read_bytes <= MOST_READ_BYTES {
            return Ok(());
        }
        let message = format!(
            "{}: all segments together read more than {MOST_READ_BYTES} bytes (each segment reads its \
             tables from the start)",
            table.file()
        );
        Err(mistake(message, "import the segments one by one, or put each into a table of its own"))
    }

    /// Counts a row with this many channels.
    fn row(&mut self, channels: usize, file: &str) -> Result<(), Mistake> {
        self.values += channels as u64 + 1;
        let most = MOST_VALUES.max(self.size_bytes);
        if self.values <= most {
            return Ok(());
        }
        let message = format!(
            "{file}: the segments take more values ({most}) than their tables have bytes ({})",
            self.size_bytes
        );
        Err(mistake(message, "import the segments one by one: each into a log of its own"))
    }
}

fn place(file: &str, header: &csv::StringRecord, column: &str) -> Result<usize, Mistake> {
    header.iter().position(|h| h == column).ok_or_else(|| {
        let message =
            format!("{file}: no column `{column}`, found {}", header.iter().collect::<Vec<_>>().join(", "));
        let near = nearest(column, header.iter()).map(|n| format!("did you mean `{n}`?"));
        Box::new(near.into_iter().fold(Diagnostic::new(message), Diagnostic::help))
    })
}

struct Cell<'a> {
    file: &'a str,
    record: &'a csv::StringRecord,
    row: u64,
    header: &'a csv::StringRecord,
}

impl Cell<'_> {
    fn line(&self) -> u64 {
        self.record.position().map_or(self.row + 1, csv::Position::line)
    }

    /// The number of a column in SI units.
    fn number(&self, at: usize, scale_factor: f64) -> Result<f64, Mistake> {
        let text = self.record.get(at).unwrap_or("");
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| {
            let help = "leave such rows out with `rows` or `from`, or correct the record";
            mistake(format!("{}: expected a number, found `{text}`", self.place(at)), help)
        })?;
        let value = number * scale_factor;
        if value.abs() <= LARGEST_SI {
            return Ok(value);
        }
        let message = format!(
            "{}: expected at most {LARGEST_SI:e} in SI units, found {number:e} times {scale_factor:e}",
            self.place(at)
        );
        Err(mistake(message, "check `unit` and `scale` of the channel, or correct the record"))
    }

    fn place(&self, at: usize) -> String {
        format!("{}:{}: column `{}`", self.file, self.line(), self.header.get(at).unwrap_or(""))
    }

    /// Refuses a time that does not come after the last one, or that no log can hold.
    fn follows(&self, t_s: f64, last_s: f64, start_s: f64) -> Result<(), Mistake> {
        let file = self.file;
        let line = self.line();
        if t_s <= last_s {
            let message = format!(
                "{file}:{line}: expected time to advance from row to row, found {t_s} s after {last_s} s"
            );
            return Err(mistake(
                message,
                "sort the rows by time, or split the record into segments by `rows`",
            ));
        }
        let help = "check `rate`, or `time-column` and `time-unit`";
        if t_s - last_s < SHORTEST_STEP_S {
            let step_s = t_s - last_s;
            let message = format!(
                "{file}:{line}: expected at least {SHORTEST_STEP_S} s from row to row, found {step_s:e} s"
            );
            return Err(mistake(message, help));
        }
        if t_s - start_s > LONGEST_S {
            let lasts_s = t_s - start_s;
            let message =
                format!("{file}:{line}: expected a segment of at most {LONGEST_S} s, found {lasts_s:e} s");
            return Err(mistake(message, help));
        }
        Ok(())
    }
}
