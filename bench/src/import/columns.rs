//! The columns of one segment, read from a CSV file and scaled to SI.

use std::path::Path;

use procedures::diagnostic::{Diagnostic, nearest};

use crate::files::import_map::{ImportMap, SegmentMap, TimeSource};

/// Time between the rows of a static map, which has none: only for the order of rows in the log.
const STATIC_STEP_S: f64 = 1e-3;

/// A mistake is rare and large: boxed, so that a good cell costs nothing.
pub(super) type Mistake = Box<Diagnostic>;

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
pub(super) fn read(map: &ImportMap, segment: &SegmentMap) -> Result<Columns, Mistake> {
    let Table { file, header, records } = table(map, segment)?;
    let find = |column: &str| place(&file, &header, column);
    let time_column = match &map.time {
        TimeSource::Column { column, scale_s } => Some((find(column)?, *scale_s)),
        TimeSource::Rate { .. } | TimeSource::None => None,
    };
    let places = map.channels.iter().map(|c| find(&c.column)).collect::<Result<Vec<_>, _>>()?;
    let mut columns = vec![Vec::new(); places.len()];
    let mut time_s = Vec::new();
    for (number, record) in records.into_iter().enumerate() {
        let row = number as u64 + 1;
        if segment.rows.is_some_and(|[first, last]| row < first || row > last) {
            continue;
        }
        let cell = Cell { file: &file, record: &record, row, header: &header };
        let t_s = match (&map.time, time_column) {
            (_, Some((at, scale_s))) => cell.number(at)? * scale_s,
            (TimeSource::Rate { rate_hz }, None) => time_s.len() as f64 / rate_hz,
            _ => time_s.len() as f64 * STATIC_STEP_S,
        };
        if segment.from_s.is_some_and(|from_s| t_s < from_s) {
            continue;
        }
        if time_s.last().is_some_and(|last| t_s <= *last) {
            return Err(cell.back_in_time(t_s, time_s.last().copied().unwrap_or(0.0)));
        }
        time_s.push(t_s);
        for ((column, &at), channel) in columns.iter_mut().zip(&places).zip(&map.channels) {
            column.push(cell.number(at)? * channel.scale_factor);
        }
    }
    if time_s.len() < 2 {
        let message =
            format!("{file}: {} rows in segment `{}`, expected at least 2", time_s.len(), segment.branch);
        return Err(mistake(message, "check `rows` and `from`"));
    }
    let start_s = time_s[0];
    time_s.iter_mut().for_each(|t| *t -= start_s);
    Ok(Columns { time_s, columns })
}

/// A CSV file, or two side by side.
struct Table {
    file: String,
    header: csv::StringRecord,
    records: Vec<csv::StringRecord>,
}

/// The table of a segment, with the one beside it.
fn table(map: &ImportMap, segment: &SegmentMap) -> Result<Table, Mistake> {
    let folder = Path::new(&map.source.name).parent().unwrap_or(Path::new(""));
    let mut first = open(&folder.join(&segment.file))?;
    let Some(beside) = &segment.beside else { return Ok(first) };
    let second = open(&folder.join(beside))?;
    if first.records.len() != second.records.len() {
        let (expected, found) = (first.records.len(), second.records.len());
        let message =
            format!("{}: expected {expected} rows as in {}, found {found}", second.file, first.file);
        return Err(mistake(message, "tables stand side by side row by row"));
    }
    if let TimeSource::Column { column, .. } = &map.time {
        same_time(&first, &second, column)?;
    }
    first.header.extend(&second.header);
    for (row, other) in first.records.iter_mut().zip(&second.records) {
        row.extend(other);
    }
    Ok(first)
}

/// Refuses tables whose rows are of different times; a second one without that column is taken as it is.
fn same_time(first: &Table, second: &Table, column: &str) -> Result<(), Mistake> {
    let at = |table: &Table| table.header.iter().position(|h| h == column);
    let (Some(here), Some(there)) = (at(first), at(second)) else { return Ok(()) };
    let time = |record: &csv::StringRecord, at: usize| record.get(at).and_then(|t| t.parse::<f64>().ok());
    let rows = first.records.iter().zip(&second.records);
    match rows.enumerate().find(|(_, (a, b))| time(a, here) != time(b, there)) {
        None => Ok(()),
        Some((row, (a, b))) => {
            let (expected, found) = (a.get(here).unwrap_or(""), b.get(there).unwrap_or(""));
            let message = format!(
                "{}:{}: expected the time {expected} as in {}, found {found}",
                second.file,
                row + 2,
                first.file
            );
            Err(mistake(message, "tables stand side by side row by row"))
        }
    }
}

fn open(path: &Path) -> Result<Table, Mistake> {
    let file = path.display().to_string();
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|e| Box::new(Diagnostic::new(format!("{file}: cannot be read: {e}"))))?;
    let header = reader
        .headers()
        .map_err(|e| Box::new(Diagnostic::new(format!("{file}: no header line: {e}"))))?
        .clone();
    let records = reader.records().collect::<Result<Vec<_>, _>>().map_err(|e| ragged(&file, &e))?;
    Ok(Table { file, header, records })
}

fn place(file: &str, header: &csv::StringRecord, column: &str) -> Result<usize, Mistake> {
    header.iter().position(|h| h == column).ok_or_else(|| {
        let message =
            format!("{file}: no column `{column}`, found {}", header.iter().collect::<Vec<_>>().join(", "));
        let near = nearest(column, header.iter()).map(|n| format!("did you mean `{n}`?"));
        Box::new(near.into_iter().fold(Diagnostic::new(message), Diagnostic::help))
    })
}

fn ragged(file: &str, error: &csv::Error) -> Mistake {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            let message =
                format!("{file}:{line}: expected {expected_len} cells as in the header, found {len}");
            mistake(message, "every row needs one cell for each column")
        }
        _ => Box::new(Diagnostic::new(format!("{file}: {error}"))),
    }
}

fn mistake(message: String, help: &str) -> Mistake {
    Box::new(Diagnostic::new(message).help(help))
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

    fn number(&self, at: usize) -> Result<f64, Mistake> {
        let text = self.record.get(at).unwrap_or("");
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                let column = self.header.get(at).unwrap_or("");
                let message = format!(
                    "{}:{}: column `{column}`: expected a number, found `{text}`",
                    self.file,
                    self.line()
                );
                Err(mistake(message, "leave such rows out with `rows` or `from`, or mend the record"))
            }
        }
    }

    fn back_in_time(&self, t_s: f64, last_s: f64) -> Mistake {
        let message = format!(
            "{}:{}: time goes back or stands still: {t_s} s after {last_s} s",
            self.file,
            self.line()
        );
        mistake(message, "rows must ascend in time; split the record into segments by `rows`")
    }
}
