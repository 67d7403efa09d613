//! The points of a log, each beside the case of the plan that its events name.

use procedures::case::Case;
use procedures::log::{PointStatus, Window};
use procedures::measurement::PointResult;

/// A point that was found in the log.
pub(super) struct Found {
    /// What its analysis gave.
    pub(super) result: PointResult,
    /// How it ended.
    pub(super) status: PointStatus,
    /// Why it did not complete or gives no numbers.
    pub(super) reason: Option<String>,
}

/// What a log holds of each planned point.
pub(super) enum Place {
    /// Nothing, nor of any later one.
    Empty,
    /// Nothing, though there is a later one.
    Gap,
    /// One point.
    Once(Box<Found>),
    /// More than one: nobody can say which of them is true.
    Ambiguous,
}

/// All planned points, and what is wrong with what the log says of them.
pub(super) struct Points<'p> {
    cases: &'p [Case],
    places: Vec<Place>,
    last: Option<usize>,
    faults: Vec<String>,
}

impl<'p> Points<'p> {
    pub(super) fn new(cases: &'p [Case]) -> Self {
        let places = cases.iter().map(|_| Place::Empty).collect();
        Self { cases, places, last: None, faults: Vec::new() }
    }

    /// The case of the next window of the log, or `None` where the window is none of a planned point or its point was
    /// there before.
    pub(super) fn case_of(&mut self, window: &Window) -> Option<&'p Case> {
        let index = window.point;
        let Some(case) = self.cases.get(index) else {
            let planned = self.cases.len();
            self.faults.push(format!("point {index} is in the log, but only {planned} points were planned"));
            return None;
        };
        let name = &case.point;
        if !matches!(self.places[index], Place::Empty) {
            self.faults.push(format!("point {index} [{name}] is in the log more than once: none is judged"));
            self.places[index] = Place::Ambiguous;
            return None;
        }
        if let Some(last) = self.last.filter(|&last| last > index) {
            self.faults
                .push(format!("point {index} [{name}] comes after point {last}: expected the plan's order"));
        }
        self.last = Some(index);
        if let Some(fault) = segments_fault(case, window) {
            self.faults.push(format!("point {index} [{name}]: {fault}"));
        }
        Some(case)
    }

    /// Puts the analysis of a window into its place.
    pub(super) fn take(&mut self, index: usize, found: Found) {
        self.places[index] = Place::Once(Box::new(found));
    }

    /// The places in the plan's order, and the faults; a point that is missing before others is one.
    pub(super) fn finish(mut self) -> (Vec<Place>, Vec<String>) {
        let end = self.places.iter().rposition(|p| !matches!(p, Place::Empty)).map_or(0, |last| last + 1);
        for (index, place) in self.places[..end].iter_mut().enumerate() {
            if matches!(place, Place::Empty) {
                let name = &self.cases[index].point;
                self.faults
                    .push(format!("point {index} [{name}] is missing, although later points are there"));
                *place = Place::Gap;
            }
        }
        (self.places, self.faults)
    }
}

/// A segment has its place by its index. They begin at 0 and follow each other; a point that completed has some.
fn segments_fault(case: &Case, window: &Window) -> Option<String> {
    let found: Vec<usize> = window.segments.iter().map(|s| s.segment).collect();
    if window.status == PointStatus::Completed && found.is_empty() && !case.segments.is_empty() {
        return Some("it completed, but the log has no events of its segments".to_owned());
    }
    let planned = case.segments.len();
    let in_order = found.iter().enumerate().all(|(place, &segment)| place == segment);
    (!in_order || found.len() > planned)
        .then(|| format!("expected events of its {planned} segments in order, found segments {found:?}"))
}
