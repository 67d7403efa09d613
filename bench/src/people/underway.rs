//! The points that run now, for whoever shows how far a run is.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use procedures::case::Case;

use crate::cycle::progress::{Progress, Seen};

/// A point that runs.
#[derive(Debug)]
struct Point {
    procedure: String,
    name: String,
    number: usize,
    of: usize,
    planned_s: f64,
    segments: Vec<String>,
    progress: Arc<Progress>,
}

/// The points that run now; clones share them.
#[derive(Clone, Debug, Default)]
pub struct Underway(Arc<Mutex<Vec<Point>>>);

/// How far a point is.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Procedure id.
    pub procedure: String,
    /// Name of the point.
    pub point: String,
    /// Number of the point in its procedure, from 1.
    pub number: usize,
    /// Points of the procedure.
    pub of: usize,
    /// Planned duration of the point, s.
    pub planned_s: f64,
    /// Number of the segment, from 1, the count of segments, and its label; `None` before the first.
    pub segment: Option<Segment>,
    /// Where its loop is.
    pub seen: Seen,
}

/// A segment of a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its number, from 1.
    pub number: usize,
    /// Segments of the point.
    pub of: usize,
    /// Its label.
    pub label: String,
}

impl Underway {
    /// A point begins: `number` from 1, `of` so many in its procedure.
    pub fn begin(&self, procedure: &str, case: &Case, number: usize, of: usize) {
        let point = Point {
            procedure: procedure.to_owned(),
            name: case.point.clone(),
            number,
            of,
            planned_s: case.planned_s(),
            segments: case.segments.iter().map(|segment| segment.label.clone()).collect(),
            progress: Arc::default(),
        };
        let mut points = self.lock();
        points.retain(|other| other.procedure != procedure);
        points.push(point);
    }

    /// The point of a procedure is over, however it ended.
    pub fn end(&self, procedure: &str) {
        self.lock().retain(|point| point.procedure != procedure);
    }

    /// Where the loop of a procedure's point notes how far it is.
    pub fn progress(&self, procedure: &str) -> Arc<Progress> {
        let points = self.lock();
        points
            .iter()
            .find(|p| p.procedure == procedure)
            .map_or_else(Arc::default, |p| Arc::clone(&p.progress))
    }

    /// All points that run, in the order in which they began.
    pub fn standing(&self) -> Vec<Standing> {
        self.lock().iter().map(Point::standing).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Point>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Point {
    fn standing(&self) -> Standing {
        let seen = self.progress.seen();
        let segment = seen.segment.and_then(|index| {
            let label = self.segments.get(index)?.clone();
            Some(Segment { number: index + 1, of: self.segments.len(), label })
        });
        Standing {
            procedure: self.procedure.clone(),
            point: self.name.clone(),
            number: self.number,
            of: self.of,
            planned_s: self.planned_s,
            segment,
            seen,
        }
    }
}
