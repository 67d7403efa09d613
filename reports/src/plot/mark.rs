//! Vertical marks with their labels above the frame.

use procedures::trace::Mark;

use super::axis::Axis;
use super::limit;
use super::text::text_width;
use super::{RIGHT, TOP, units};
use crate::markup::Markup;

const MARK: &str = "#4d4d4d";
/// Height of a row of labels.
pub(super) const ROW: f64 = 13.0;

/// Label of a vertical mark, above the frame.
#[derive(Debug)]
pub(super) struct MarkLabel<'a> {
    text: &'a str,
    at: f64,
    anchor: &'static str,
    row: usize,
}

impl MarkLabel<'_> {
    /// Base line of the text.
    fn base(&self) -> f64 {
        TOP - 4.0 - ROW * self.row as f64
    }
}

/// Labels of the marks in rows above the frame, each in the lowest row where it touches no other.
///
/// From right to left: the line of a mark then ends below the labels that reach over it from the left.
pub(super) fn labels<'a>(marks: &[&'a Mark], x: &Axis) -> Vec<MarkLabel<'a>> {
    let mut taken: Vec<(usize, f64, f64)> = Vec::new();
    let mut labels = Vec::new();
    let mut placed: Vec<(f64, &Mark)> =
        marks.iter().filter(|m| x.shows(m.x)).filter_map(|m| Some((x.place(m.x)?, *m))).collect();
    placed.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (at, mark) in placed {
        let width = text_width(&mark.label);
        let fits = at + width < RIGHT;
        let start = if fits { at } else { at - width };
        let touches =
            |row: usize| taken.iter().any(|(r, a, b)| *r == row && start < *b && start + width > *a);
        let row = (0..).find(|&row| !touches(row)).unwrap_or(0);
        taken.push((row, start - 6.0, start + width + 6.0));
        labels.push(MarkLabel { text: &mark.label, at, anchor: if fits { "start" } else { "end" }, row });
    }
    labels
}

/// Room that the labels of the marks need above the picture.
pub(super) fn rows(labels: &[MarkLabel<'_>]) -> usize {
    labels.iter().map(|l| l.row + 1).max().unwrap_or(0)
}

/// Vertical marks from their labels down to the foot of the last panel.
pub(super) fn draw(m: &mut Markup, labels: &[MarkLabel<'_>], foot: f64) {
    for label in labels {
        let d = format!("M{} {}V{}", units(label.at), units(label.base() + 2.0), units(foot));
        m.empty("path", &[("d", &d), ("stroke", MARK), ("stroke-width", "1"), ("stroke-dasharray", "2 2")]);
    }
    for label in labels {
        limit::halo(m, label.at, label.base(), label.anchor, MARK, label.text);
    }
}
