//! What kinds share that read a tracker: its frames, each once, beside the angles of the mirror.

use analysis::frf::{C64, Line};
use analysis::periodic::errors_in_variables;
use analysis::tones::{Samples, tones};

use crate::case::Case;
use crate::excitation::{Excitation, Injection, Signal, Sine};
use crate::log::Window;
use crate::quantity::QuantityKind as Q;
use crate::reason::{OpticsReason, Reason};
use crate::table::{Field, Shape, TableReader};
use crate::target::{Target, TargetCourse};

#[cfg(test)]
pub(in crate::kinds) mod tests;

/// Key of the azimuth at which the gimbal points at a target.
pub(in crate::kinds) const AZIMUTH: Field = Field::default(
    "azimuth",
    Shape::Quantity(Q::Angle),
    "0 deg",
    "Azimuth of the target, at which the axis holds.",
);
/// Key of the elevation at which the gimbal points at a target.
pub(in crate::kinds) const ELEVATION: Field =
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Elevation at which the axis holds.");

/// Azimuth and elevation at which the gimbal points at a target.
pub(in crate::kinds) fn pose_rad(table: &mut TableReader<'_>) -> Option<[f64; 2]> {
    let azimuth = table.quantity(AZIMUTH.key);
    let elevation = table.quantity(ELEVATION.key);
    Some([azimuth?, elevation?])
}

/// Topic of the mirror.
pub(in crate::kinds) const MIRROR_TOPIC: &str = "/fsm";
/// Topic of the fine tracker.
pub(in crate::kinds) const FINE_TOPIC: &str = "/fine";
/// Readings, in the order of [`MIRROR_AXES`](crate::device::MIRROR_AXES).
pub(in crate::kinds) const READINGS: [&str; 2] = ["cross_elevation_rad", "elevation_rad"];
/// Gate that signs of mirror and trackers open: track loops may be closed.
pub(in crate::kinds) const SIGHT_GATE: &str = "sight";
/// What a tracker says of its lock while it measures its target.
const TRACKING: f64 = 2.0;
/// Fewest frames that say anything.
const LEAST_FRAMES: usize = 20;
/// A camera that runs at another rate than it was asked for is set wrongly.
const RATE_RATIO: f64 = 0.02;

/// Frames that showed the target.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::kinds) struct Frames {
    /// Middle of each exposure, as the tracker states it, on the log's time axis.
    pub(in crate::kinds) exposure_s: Vec<f64>,
    /// Row in which each was first seen.
    pub(in crate::kinds) received_s: Vec<f64>,
    /// Target minus line of sight: cross-elevation, elevation.
    pub(in crate::kinds) error_rad: [Vec<f64>; 2],
    /// Frames that the tracker made, those that never came or that showed no target included.
    pub(in crate::kinds) made: usize,
    /// Frames per second, by counter and exposures.
    pub(in crate::kinds) rate_hz: f64,
    /// Standard uncertainty of the exposures on the log's time axis, as far as the arrivals make it that lay the tracker's
    /// clock onto that of the loop; root mean square.
    pub(in crate::kinds) placed_u_s: f64,
    /// Standard uncertainty of the delay from an exposure to its message that the rig file declares: of all exposures
    /// alike.
    pub(in crate::kinds) declared_u_s: f64,
    /// Rate of the tracker's clock over that of the loop, less 1, as the last frame has it.
    pub(in crate::kinds) clock_drift_ratio: f64,
}

impl Frames {
    /// Those that arrived between two times.
    ///
    /// # Errors
    /// No topic, no channel, too few frames with a target, exposures that do not advance.
    pub(in crate::kinds) fn read(
        window: &Window,
        topic: &str,
        from_s: f64,
        to_s: f64,
    ) -> Result<Self, Reason> {
        let rows = window.topic(topic)?;
        let column = |name: &str| rows.channel(name);
        let counter = column("counter")?;
        let age = column("age_s")?;
        let lock = column("lock")?;
        let readings = [column(READINGS[0])?, column(READINGS[1])?];
        let placed_u = column("exposure_u_s")?;
        let declared_u = column("message_delay_u_s")?;
        let drift = column("clock_drift_ratio")?;
        let range = rows.range(from_s, to_s);
        let new = range.filter(|&k| k > 0 && counter[k] != counter[k - 1]);
        let mut frames = Self::default();
        let mut first = None;
        let mut last = None;
        for k in new {
            let exposure_s = rows.time_s[k] - age[k];
            let stamp = (counter[k], exposure_s);
            if last.is_some_and(|(_, before_s)| exposure_s <= before_s) {
                return Err(
                    OpticsReason::ExposuresStand { topic: topic.to_owned(), at_s: rows.time_s[k] }.into()
                );
            }
            first.get_or_insert(stamp);
            last = Some(stamp);
            if lock[k] != TRACKING || !readings.iter().all(|r| r[k].is_finite()) {
                continue;
            }
            frames.exposure_s.push(exposure_s);
            frames.received_s.push(rows.time_s[k]);
            frames.placed_u_s += placed_u[k].powi(2);
            (frames.declared_u_s, frames.clock_drift_ratio) = (declared_u[k], drift[k]);
            frames.error_rad.iter_mut().zip(readings).for_each(|(errors, reading)| errors.push(reading[k]));
        }
        if frames.exposure_s.len() < LEAST_FRAMES {
            return Err(OpticsReason::TooFewSeen {
                found: frames.exposure_s.len(),
                within_s: to_s - from_s,
                least: LEAST_FRAMES,
            }
            .into());
        }
        frames.placed_u_s = (frames.placed_u_s / frames.exposure_s.len() as f64).sqrt();
        if let (Some(first), Some(last)) = (first, last) {
            frames.made = (last.0 - first.0).max(0.0) as usize + 1;
            frames.rate_hz = (last.0 - first.0) / (last.1 - first.1);
        }
        Ok(frames)
    }

    /// Whether the camera runs as it was asked to.
    ///
    /// # Errors
    /// The rate that was asked for, and the one that the counter of the camera shows.
    pub(in crate::kinds) fn check_rate(&self, asked_hz: f64) -> Result<(), Reason> {
        let found_hz = self.rate_hz;
        if (found_hz / asked_hz - 1.0).abs() <= RATE_RATIO {
            return Ok(());
        }
        Err(OpticsReason::OtherRate { found_hz, asked_hz }.into())
    }

    /// Part of the frames that did not come or showed no target.
    pub(in crate::kinds) fn lost_ratio(&self) -> f64 {
        1.0 - self.exposure_s.len() as f64 / self.made.max(1) as f64
    }
}

/// A channel over time.
#[derive(Clone, Copy, Debug)]
pub(in crate::kinds) struct Course<'a> {
    pub(in crate::kinds) time_s: &'a [f64],
    pub(in crate::kinds) values: &'a [f64],
}

impl<'a> Course<'a> {
    /// A channel of a topic.
    ///
    /// # Errors
    /// What the log lacks.
    pub(in crate::kinds) fn of(window: &'a Window, topic: &str, name: &str) -> Result<Self, Reason> {
        let rows = window.topic(topic)?;
        Ok(Self { time_s: &rows.time_s, values: rows.channel(name)? })
    }

    /// The rows between two times.
    pub(in crate::kinds) fn between(self, from_s: f64, to_s: f64) -> Self {
        let from = self.time_s.partition_point(|&t| t < from_s);
        let to = self.time_s.partition_point(|&t| t < to_s).max(from);
        Self { time_s: &self.time_s[from..to], values: &self.values[from..to] }
    }

    /// Mean over a stretch of the straight lines between the rows.
    pub(in crate::kinds) fn mean(self, from_s: f64, to_s: f64) -> Option<f64> {
        let inner = self.between(from_s, to_s);
        let ends = [(from_s, self.at(from_s)?), (to_s, self.at(to_s)?)];
        let inner = inner.time_s.iter().copied().zip(inner.values.iter().copied());
        let corners: Vec<(f64, f64)> = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect();
        let area = |pair: &[(f64, f64)]| 0.5 * (pair[1].1 + pair[0].1) * (pair[1].0 - pair[0].0);
        Some(corners.windows(2).map(area).sum::<f64>() / (to_s - from_s))
    }

    /// On the straight line between the rows around a time; the nearest row's value beyond the ends.
    pub(in crate::kinds) fn at(self, time_s: f64) -> Option<f64> {
        let first = self.values.first()?;
        let last = self.values.last()?;
        match self.time_s.partition_point(|&t| t <= time_s) {
            0 => Some(*first),
            after if after == self.time_s.len() => Some(*last),
            after => {
                let t = &self.time_s[after - 1..=after];
                let v = &self.values[after - 1..=after];
                Some(v[0] + (v[1] - v[0]) * (time_s - t[0]) / (t[1] - t[0]))
            }
        }
    }
}

/// A sine of the mirror, cut into blocks of whole periods.
#[derive(Clone, Copy, Debug)]
pub(in crate::kinds) struct Blocks {
    /// Where the first begins.
    pub(in crate::kinds) start_s: f64,
    /// Length of each, whole periods.
    pub(in crate::kinds) block_s: f64,
    pub(in crate::kinds) count: usize,
    pub(in crate::kinds) frequency_hz: f64,
}

/// What a tracker makes of a sine.
#[derive(Clone, Copy, Debug)]
pub(in crate::kinds) struct Sensed {
    /// Reading over what moved, for both readings; variance by the scatter of the blocks.
    pub(in crate::kinds) readings: [Line; 2],
    /// Amplitude of what moved.
    pub(in crate::kinds) amplitude: f64,
}

/// Readings over a course that moves as a sine: sine, cosine, offset and drift in each block by least squares, over
/// exposures and rows; ratio of the means of the blocks.
///
/// # Errors
/// A block with too few frames, nothing that moved.
pub(in crate::kinds) fn sensed(
    moved: Course<'_>,
    frames: &Frames,
    blocks: &Blocks,
) -> Result<Sensed, Reason> {
    let amplitude = |course: Course<'_>| {
        let samples = Samples { time_s: course.time_s, values: course.values };
        let found = tones(samples, &[blocks.frequency_hz], blocks.start_s);
        found.map(|tones| vec![tones.amplitudes[0]]).map_err(|e| Reason::from(OpticsReason::BlockOfSine(e)))
    };
    let each = |course: Course<'_>| -> Result<Vec<Vec<C64>>, Reason> {
        let from = |k: usize| blocks.start_s + k as f64 * blocks.block_s;
        (0..blocks.count).map(|k| amplitude(course.between(from(k), from(k + 1)))).collect()
    };
    let sent = each(moved)?;
    let line = |errors: &[f64]| -> Result<Line, Reason> {
        let seen = each(Course { time_s: &frames.exposure_s, values: errors })?;
        let lines = errors_in_variables(&[blocks.frequency_hz], &sent, &seen).ok();
        lines.and_then(|l| l.first().copied()).ok_or_else(|| OpticsReason::NothingMoved.into())
    };
    let readings = [line(&frames.error_rad[0])?, line(&frames.error_rad[1])?];
    Ok(Sensed { readings, amplitude: sent.iter().map(|s| s[0].norm()).sum::<f64>() / sent.len() as f64 })
}

/// Axis of the mirror that a case moves.
pub(in crate::kinds) fn moved_axis(case: &Case) -> Option<usize> {
    case.excitations.iter().find_map(|e| match e.into {
        Injection::MirrorAz => Some(0),
        Injection::MirrorEl => Some(1),
        Injection::Torque | Injection::Velocity => None,
    })
}

/// A sine of an axis of the mirror that grows within a time.
pub(in crate::kinds) fn mirror_sine(
    axis: usize,
    frequency_hz: f64,
    amplitude: f64,
    fade_s: f64,
) -> Excitation {
    let line = Sine { frequency_hz, amplitude, phase_rad: -std::f64::consts::FRAC_PI_2 };
    let signal = Signal::Multisine { period_s: 1.0 / frequency_hz, lines: vec![line] };
    let into = [Injection::MirrorAz, Injection::MirrorEl][axis];
    Excitation { into, signal, fade_s, every_ticks: 1 }
}

/// A light that stands where the axes do.
pub(in crate::kinds) fn star([azimuth_rad, elevation_rad]: [f64; 2]) -> Target {
    Target { course: TargetCourse::Star, azimuth_rad, elevation_rad, stands_s: 0.0 }
}
