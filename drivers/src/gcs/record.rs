//! Tables of the data recorder: a header of lines `# KEY = value`, then rows of numbers.
//!
//! Every line but the last ends with a space and a line feed. A header that ends without the space has no data behind it.

use crate::answer::FormatError;

/// Longest part of a wrong line that an error quotes.
const QUOTED_CHARACTERS: usize = 40;

/// What `DRR?` brought back.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Names of the columns, as the controller gives them.
    pub names: Vec<String>,
    /// Time between two rows, s.
    pub sample_time_s: f64,
    /// Columns in the units of the controller, one a table, all of the same length.
    pub columns: Vec<Vec<f64>>,
}

impl Record {
    /// Reads a whole reply.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn read(text: &str) -> Result<Self, FormatError> {
        let mut lines = text.lines().map(str::trim);
        let mut header = Header::default();
        loop {
            let line = lines.next().ok_or_else(|| wrong("# END_HEADER", "the end of the reply"))?;
            let entry = line.strip_prefix('#').ok_or_else(|| wrong("a header line `# KEY = value`", line))?;
            if entry.trim().eq_ignore_ascii_case("END_HEADER") {
                break;
            }
            header.take(entry)?;
        }
        let columns_count = header.columns_count.ok_or_else(|| wrong("DIM in the header", "none"))?;
        let mut columns = vec![Vec::new(); columns_count];
        for line in lines.filter(|line| !line.is_empty()) {
            let values = line.split_whitespace();
            let mut found = 0;
            for value in values {
                let number = value.parse().map_err(|_| wrong("a number", value))?;
                if let Some(column) = columns.get_mut(found) {
                    column.push(number);
                }
                found += 1;
            }
            if found != columns_count {
                return Err(FormatError::Count { expected: columns_count, found });
            }
        }
        let rows_count = columns.first().map_or(0, Vec::len);
        if let Some(expected) = header.rows_count.filter(|expected| *expected != rows_count) {
            return Err(FormatError::Count { expected, found: rows_count });
        }
        let sample_time_s = header.sample_time_s.ok_or_else(|| wrong("SAMPLE_TIME in the header", "none"))?;
        header.names.resize(columns_count, String::new());
        Ok(Self { names: header.names, sample_time_s, columns })
    }
}

/// Most columns that a header may announce.
const MOST_COLUMNS: usize = 64;

/// What the header says.
#[derive(Default)]
struct Header {
    columns_count: Option<usize>,
    rows_count: Option<usize>,
    sample_time_s: Option<f64>,
    names: Vec<String>,
}

impl Header {
    /// Takes an entry; lines without `=` and keys that are not needed are comments.
    fn take(&mut self, entry: &str) -> Result<(), FormatError> {
        let Some((key, value)) = entry.split_once('=') else { return Ok(()) };
        let value = value.trim();
        match key.trim() {
            "DIM" => {
                let count = value.parse().ok().filter(|count| (1..=MOST_COLUMNS).contains(count));
                self.columns_count = Some(count.ok_or_else(|| wrong("DIM of 1 to 64", value))?);
            }
            "NDATA" => self.rows_count = Some(value.parse().map_err(|_| wrong("NDATA as a number", value))?),
            "SAMPLE_TIME" => {
                let time_s = value.parse().ok().filter(|time_s: &f64| time_s.is_finite() && *time_s > 0.0);
                self.sample_time_s = Some(time_s.ok_or_else(|| wrong("SAMPLE_TIME above 0", value))?);
            }
            "SEPARATOR" if value != "32" => return Err(wrong("SEPARATOR = 32, a space", value)),
            name => {
                if let Some(place) = name.strip_prefix("NAME").and_then(|place| place.parse::<usize>().ok())
                    && place < MOST_COLUMNS
                {
                    self.names.resize(self.names.len().max(place + 1), String::new());
                    value.clone_into(&mut self.names[place]);
                }
            }
        }
        Ok(())
    }
}

fn wrong(expected: &'static str, found: &str) -> FormatError {
    FormatError::Text { expected, found: found.chars().take(QUOTED_CHARACTERS).collect() }
}
