//! The legend: below the data, entries in rows as wide as the picture.

use procedures::trace::{Plot, Style};

use super::look::Look;
use super::text::text_width;
use super::{LEFT, RIGHT, draw, units};
use crate::markup::Markup;

/// Length of the sample of a line.
const SAMPLE: f64 = 26.0;
const ROW: f64 = 17.0;

#[derive(Debug)]
struct Entry {
    look: Option<Look>,
    errors: bool,
    text: String,
    x: f64,
    row: usize,
}

/// Entries with their places.
#[derive(Debug)]
pub(super) struct Legend {
    entries: Vec<Entry>,
    rows: usize,
}

impl Legend {
    /// Entries of all series, and one for limits if there are any.
    pub(super) fn new(plot: &Plot, looks: &[Look]) -> Self {
        let mut all: Vec<(Option<Look>, bool, String)> = plot
            .series
            .iter()
            .zip(looks)
            .filter(|(s, _)| !s.label.is_empty())
            .map(|(s, look)| (Some(*look), !s.u.is_empty() && s.style != Style::Band, s.label.clone()))
            .collect();
        if !plot.limits.is_empty() {
            all.push((None, false, if plot.limits.len() == 1 { "limit" } else { "limits" }.to_owned()));
        }
        let (mut x, mut row) = (LEFT, 0);
        let mut entries = Vec::with_capacity(all.len());
        for (look, errors, text) in all {
            let width = SAMPLE + 6.0 + text_width(&text) + 16.0;
            if x > LEFT && x + width > RIGHT {
                x = LEFT;
                row += 1;
            }
            entries.push(Entry { look, errors, text, x, row });
            x += width;
        }
        let rows = if entries.is_empty() { 0 } else { row + 1 };
        Self { entries, rows }
    }

    /// Height in units of the picture.
    pub(super) fn height(&self) -> f64 {
        if self.rows == 0 { 2.0 } else { self.rows as f64 * ROW + 4.0 }
    }

    /// Draws it below `top`.
    pub(super) fn draw(&self, m: &mut Markup, top: f64) {
        for entry in &self.entries {
            let y = top + entry.row as f64 * ROW + ROW / 2.0;
            let ends = [entry.x, entry.x + SAMPLE];
            match entry.look {
                Some(look) => draw::sample(m, &look, entry.errors, ends, y),
                None => draw::limit_line(m, ends, y),
            }
            let x = units(entry.x + SAMPLE + 6.0);
            m.element("text", &[("x", &x), ("y", &units(y + 3.8))], &entry.text);
        }
    }
}
