//! What tests put into a log: rows, windows, noise, a rig with azimuth and elevation.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::axis::{Axes, AxisLimits};
use crate::log::{Channel, EndedBy, Rows, SegmentSpan, Topic, Width};
use crate::procedure::sample::sample_axes;

/// Rows of a topic, columns by name.
pub(crate) fn rows(topic: &str, time_s: &[f64], columns: Vec<(&str, Vec<f64>)>) -> Rows {
    let channel = |name: &str| Channel { name: name.to_owned(), unit: "1".to_owned(), width: Width::F64 };
    let channels = columns.iter().map(|(name, _)| channel(name)).collect();
    Rows {
        topic: Topic { name: topic.to_owned(), message: "test".to_owned(), channels },
        time_s: time_s.to_vec(),
        columns: columns.into_iter().map(|(_, values)| values).collect(),
    }
}

impl Rows {
    /// Takes the rows of a stretch of time out, as a stalled computer does.
    pub(crate) fn cut(&mut self, start_s: f64, end_s: f64) {
        let range = self.range(start_s, end_s);
        self.columns.iter_mut().for_each(|column| drop(column.drain(range.clone())));
        self.time_s.drain(range);
    }
}

/// A segment that ran to its end.
pub(crate) fn span(segment: usize, start_s: f64, end_s: f64) -> SegmentSpan {
    SegmentSpan { segment, start_s, end_s, start_position_rad: 0.0, ended_by: EndedBy::Completed }
}

/// Azimuth that carries elevation (director.md §1, §2, §8).
pub(crate) fn azimuth_and_elevation() -> Axes {
    let az = sample_axes().all()[0].limits.clone();
    let el = AxisLimits {
        travel_rad: [-10_f64.to_radians(), 90_f64.to_radians()],
        soft_limits_rad: [-9.5_f64.to_radians(), 89.5_f64.to_radians()],
        ..az.clone()
    };
    Axes::stacked([("az".to_owned(), az), ("el".to_owned(), el)])
}

/// Random numbers from a seed.
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform between 0 and 1, neither included.
    pub(crate) fn uniform(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0
    }

    /// Standard normal (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}
