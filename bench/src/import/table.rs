//! CSV files row by row: one, or two side by side. No more than a row of each is in memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

use procedures::diagnostic::Diagnostic;

use super::map::{ImportMap, SegmentMap, TimeSource};

/// Largest table, bytes.
const MOST_BYTES: u64 = 256 << 20;
/// Longest line, bytes: room for a thousand columns.
const MOST_LINE_BYTES: usize = 64 << 10;

/// A mistake is rare and large: boxed, so that a good cell costs nothing.
pub(super) type Mistake = Box<Diagnostic>;

/// A CSV file being read.
struct Stream {
    file: String,
    size_bytes: u64,
    header: csv::StringRecord,
    reader: csv::Reader<Lines<File>>,
    /// Rows read so far.
    rows: u64,
}

/// The table of a segment, with the one beside it.
pub(super) struct Table {
    first: Stream,
    beside: Option<Stream>,
    /// Names of all columns.
    pub(super) header: csv::StringRecord,
    /// The row that was read last.
    pub(super) record: csv::StringRecord,
    other: csv::StringRecord,
    /// Where the time stands in both tables, where both have it.
    time: Option<[usize; 2]>,
    /// Lines of the first file, counted before it is read.
    pub(super) lines: usize,
}

impl Table {
    /// Opens the files of a segment and reads their headers.
    pub(super) fn open(map: &ImportMap, segment: &SegmentMap) -> Result<Self, Mistake> {
        let folder = Path::new(&map.source.name).parent().unwrap_or(Path::new(""));
        let (first, lines) = Stream::open(&folder.join(&segment.file))?;
        let beside = match &segment.beside {
            None => None,
            Some(beside) => Some(Stream::open(&folder.join(beside))?.0),
        };
        let place = |stream: &Stream, column: &str| stream.header.iter().position(|h| h == column);
        let time = match (&map.time, &beside) {
            // A second table without that column is taken as it is.
            (TimeSource::Column { column, .. }, Some(beside)) => {
                place(&first, column).zip(place(beside, column))
            }
            _ => None,
        };
        let mut header = first.header.clone();
        header.extend(beside.iter().flat_map(|stream| stream.header.iter()));
        let record = csv::StringRecord::new();
        let other = csv::StringRecord::new();
        let time = time.map(<[usize; 2]>::from);
        Ok(Self { first, beside, header, record, other, time, lines })
    }

    /// Name of the first file, for messages.
    pub(super) fn file(&self) -> &str {
        &self.first.file
    }

    /// Both files with their sizes in bytes.
    pub(super) fn files(&self) -> impl Iterator<Item = (&str, u64)> {
        [Some(&self.first), self.beside.as_ref()]
            .into_iter()
            .flatten()
            .map(|s| (s.file.as_str(), s.size_bytes))
    }

    /// Rows read so far.
    pub(super) fn rows(&self) -> u64 {
        self.first.rows
    }

    /// Reads the next row into `record`; whether there is one.
    pub(super) fn next_row(&mut self) -> Result<bool, Mistake> {
        let found = self.first.next_row(&mut self.record)?;
        let Some(beside) = &mut self.beside else { return Ok(found) };
        if beside.next_row(&mut self.other)? != found {
            let expected = self.first.count_rest(&mut self.record)?;
            let rows = beside.count_rest(&mut self.other)?;
            let here = &self.first.file;
            let there = &beside.file;
            let message = format!("{there}: expected {expected} rows as in {here}, found {rows}");
            return Err(mistake(message, "each row of one table must belong to the same row of the other"));
        }
        if let Some(at) = self.time.filter(|_| found) {
            self.same_time(at)?;
        }
        self.record.extend(&self.other);
        Ok(found)
    }

    /// Refuses rows of different times.
    fn same_time(&self, [here, there]: [usize; 2]) -> Result<(), Mistake> {
        let expected = self.record.get(here).unwrap_or("");
        let found = self.other.get(there).unwrap_or("");
        let number = |text: &str| text.parse::<f64>().ok();
        if number(expected) == number(found) {
            return Ok(());
        }
        let first = &self.first.file;
        let second = self.beside.as_ref().map_or("", |beside| &beside.file);
        let line = self.other.position().map_or(0, csv::Position::line);
        let message = format!("{second}:{line}: expected the time {expected} as in {first}, found {found}");
        Err(mistake(message, "each row of one table must belong to the same row of the other"))
    }
}

impl Stream {
    /// Opens a file and reads its header; gives its number of lines, too.
    fn open(path: &Path) -> Result<(Self, usize), Mistake> {
        let file = path.display().to_string();
        let cannot = |e: Error| Box::new(Diagnostic::new(format!("{file}: cannot be read: {e}")));
        let source = File::open(path).map_err(cannot)?;
        let size_bytes = source.metadata().map_err(cannot)?.len();
        if size_bytes > MOST_BYTES {
            let message = format!("{file}: the table has {size_bytes} bytes; expected at most {MOST_BYTES}");
            return Err(mistake(message, "split the record into several tables and import them one by one"));
        }
        let lines = count_lines(File::open(path).map_err(cannot)?.take(MOST_BYTES)).map_err(cannot)?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(Lines::new(source));
        let header = reader.headers().map_err(|e| ragged(&file, &e))?.clone();
        Ok((Self { file, size_bytes, header, reader, rows: 0 }, lines))
    }

    fn next_row(&mut self, record: &mut csv::StringRecord) -> Result<bool, Mistake> {
        let found = self.reader.read_record(record).map_err(|e| ragged(&self.file, &e))?;
        self.rows += u64::from(found);
        Ok(found)
    }

    /// All rows, those not read yet among them.
    fn count_rest(&mut self, record: &mut csv::StringRecord) -> Result<u64, Mistake> {
        while self.next_row(record)? {}
        Ok(self.rows)
    }
}

fn count_lines(mut source: impl Read) -> std::io::Result<usize> {
    let mut piece = vec![0; MOST_LINE_BYTES];
    let mut lines = 0;
    loop {
        match source.read(&mut piece)? {
            0 => return Ok(lines),
            count => lines += piece[..count].iter().filter(|&&b| ends_line(b)).count(),
        }
    }
}

fn ends_line(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Refuses a line that is too long, before a reader of records has gathered it.
struct Lines<R> {
    source: R,
    /// Number of the line that is being read, and its bytes so far.
    line: u64,
    bytes: usize,
}

impl<R> Lines<R> {
    fn new(source: R) -> Self {
        Self { source, line: 1, bytes: 0 }
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let most = into.len().min(MOST_LINE_BYTES);
        let count = self.source.read(&mut into[..most])?;
        let mut ends = into[..count].iter().enumerate().filter(|(_, b)| ends_line(**b)).map(|(at, _)| at);
        let first = self.bytes + ends.next().unwrap_or(count);
        if first > MOST_LINE_BYTES {
            let message = format!(
                "line {} has more than {MOST_LINE_BYTES} bytes: this is not a table of numbers",
                self.line
            );
            return Err(Error::new(ErrorKind::InvalidData, message));
        }
        let breaks = into[..count].iter().filter(|b| **b == b'\n').count() as u64;
        self.line += breaks;
        self.bytes = match into[..count].iter().rposition(|b| ends_line(*b)) {
            Some(last) => count - last - 1,
            None => first,
        };
        Ok(count)
    }
}

fn ragged(file: &str, error: &csv::Error) -> Mistake {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            let message =
                format!("{file}:{line}: expected {expected_len} cells as in the header, found {len}");
            mistake(message, "write one cell for each column in every row")
        }
        _ => Box::new(Diagnostic::new(format!("{file}: {error}"))),
    }
}

pub(super) fn mistake(message: String, help: &str) -> Mistake {
    Box::new(Diagnostic::new(message).help(help))
}
