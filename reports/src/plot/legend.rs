//! The legend: below the data, entries in rows as wide as the picture.

use procedures::trace::Style;

use super::layout::{LEFT, Panel};
use super::look::Look;
use super::text::text_width;
use super::{RIGHT, draw, limit, mask, plane, span, units};
use crate::markup::Markup;
use crate::number;

/// Length of the sample of a line.
const SAMPLE: f64 = 26.0;
const ROW: f64 = 17.0;

/// What an entry explains.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sample {
    /// A series, with error bars or not.
    Series(Look, bool),
    Limit,
    Mask,
    /// A circle that is a limit, or a guide.
    Circle(bool),
    /// A shaded stretch.
    Span,
}

#[derive(Debug)]
struct Entry {
    sample: Sample,
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
    /// Entries of all series of all panels, those that look and read alike once, then those of limits.
    pub(super) fn new(panels: &[Panel<'_>]) -> Self {
        let mut x = LEFT;
        let mut row = 0;
        let all = samples(panels);
        let mut entries = Vec::with_capacity(all.len());
        for (sample, text) in all {
            let width = SAMPLE + 6.0 + text_width(&text) + 16.0;
            if x > LEFT && x + width > RIGHT {
                x = LEFT;
                row += 1;
            }
            entries.push(Entry { sample, text, x, row });
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
            match entry.sample {
                Sample::Series(look, errors) => draw::sample(m, &look, errors, ends, y),
                Sample::Limit => limit::line(m, ends, y),
                Sample::Mask => mask::sample(m, ends, y),
                Sample::Span => span::sample(m, ends, y),
                Sample::Circle(forbidden) => {
                    let middle = (ends[0] + ends[1]) / 2.0;
                    plane::outline(m, &plane::circle((middle, y), (6.0, 6.0)), forbidden);
                }
            }
            let x = units(entry.x + SAMPLE + 6.0);
            m.element("text", &[("x", &x), ("y", &units(y + 3.8))], &entry.text);
        }
    }
}

fn samples(panels: &[Panel<'_>]) -> Vec<(Sample, String)> {
    let mut all: Vec<(Sample, String)> = Vec::new();
    for panel in panels {
        let labelled = panel.plot.series.iter().zip(&panel.looks).filter(|(s, _)| !s.label.is_empty());
        for (s, look) in labelled {
            let area = matches!(s.style, Style::Band | Style::Histogram | Style::Circles);
            let entry = (Sample::Series(*look, !s.u.is_empty() && !area), s.label.clone());
            if !all.contains(&entry) {
                all.push(entry);
            }
        }
    }
    for span in panels.iter().flat_map(|p| &p.plot.spans).filter(|s| !s.label.is_empty()) {
        let entry = (Sample::Span, number::typeset(&span.label));
        if !all.contains(&entry) {
            all.push(entry);
        }
    }
    let circles = panels.iter().flat_map(|p| &p.plot.circles).filter(|c| !c.label.is_empty());
    all.extend(circles.map(|c| (Sample::Circle(c.forbidden), number::typeset(&c.label))));
    let limits = panels.iter().map(|p| p.plot.limits.len()).sum::<usize>();
    if limits > 0 {
        all.push((Sample::Limit, if limits == 1 { "limit" } else { "limits" }.to_owned()));
    }
    if panels.iter().any(|p| !p.plot.masks.is_empty()) {
        all.push((Sample::Mask, "limit, forbidden side hatched".to_owned()));
    }
    all
}
