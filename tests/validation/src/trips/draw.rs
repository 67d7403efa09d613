//! What a seed stands for: unit, axis, place, motion, cause, instant.

use std::collections::BTreeMap;

use bench::model::rig::Rig;
use procedures::case::{Case, Mode, Segment, Then};
use procedures::stimulus::{Profile, ProfileLimits, Stimulus};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::cause::CAUSES;
use super::variation::Variation;

/// A plan keeps this far from the soft limits.
const CLEARANCE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Longest cruise.
const CRUISE_S: f64 = 2.5;

/// A planned trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The seed that it follows from.
    pub seed: u64,
    /// Index into [`super::UNITS`].
    pub unit: usize,
    /// The axis that moves: 0 azimuth, 1 elevation.
    pub axis: usize,
    /// Where both axes begin.
    pub from_rad: [f64; 2],
    /// Where the axis is sent.
    pub to_rad: f64,
    /// How.
    pub limits: ProfileLimits,
    /// Index into [`CAUSES`].
    pub cause: usize,
    /// Time from the beginning of the motion to the cause.
    pub after_s: f64,
    /// What differs from the shipped rig and unit.
    pub variation: Variation,
}

/// Uniform numbers in the order in which they are drawn.
pub(super) struct Random(ChaCha8Rng);

impl Random {
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    pub(super) fn one_of(&mut self, count: usize) -> usize {
        (self.0.next_u64() % count as u64) as usize
    }
}

impl Plan {
    /// The plan of a seed. Causes take turns, so that each is tried equally often.
    pub(super) fn draw(seed: u64, rig: &Rig) -> Self {
        let mut random = Random(ChaCha8Rng::seed_from_u64(seed));
        let unit = random.one_of(super::UNITS.len());
        let axis = random.one_of(2);
        let inside = |axis: usize| {
            let [low, high] = rig.axes[axis].guard.stop.soft_limits_rad;
            [low + CLEARANCE_RAD, high - CLEARANCE_RAD]
        };
        let from_rad = [0, 1].map(|axis| {
            let [low, high] = inside(axis);
            random.between(low, high)
        });
        let limits = ProfileLimits {
            velocity_rad_per_s: random.between(1.0, 60.0).to_radians(),
            acceleration_rad_per_s2: random.between(5.0, 90.0).to_radians(),
            jerk_rad_per_s3: rig.axes[axis].limits.max_jerk_rad_per_s3,
        };
        let ramps_s = limits.velocity_rad_per_s / limits.acceleration_rad_per_s2;
        let way_rad = limits.velocity_rad_per_s * (ramps_s + random.between(0.0, CRUISE_S));
        let [low, high] = inside(axis);
        let ahead = if random.one_of(2) == 0 { 1.0 } else { -1.0 };
        let end = |ahead: f64| (from_rad[axis] + ahead * way_rad).clamp(low, high);
        // A way that a limit cuts short is taken in the other direction where that one is longer.
        let cut = (end(ahead) - from_rad[axis]).abs() < 0.3 * way_rad;
        let longer = (end(-ahead) - from_rad[axis]).abs() > (end(ahead) - from_rad[axis]).abs();
        let to_rad = if cut && longer { end(-ahead) } else { end(ahead) };
        let lasts_s = Profile::new(to_rad - from_rad[axis], &limits).duration_s();
        let after_s = random.between(0.0, lasts_s);
        Self {
            seed,
            unit,
            axis,
            from_rad,
            to_rad,
            limits,
            cause: (seed % CAUSES.len() as u64) as usize,
            after_s,
            variation: Variation::draw(&mut random, rig),
        }
    }

    /// The case that the loop runs.
    pub(super) fn case(&self, rig: &Rig) -> Case {
        let names = rig.axis_names();
        let stimulus = Stimulus::Move { target_rad: self.to_rad, limits: self.limits };
        let segment = Segment {
            label: "move".to_owned(),
            mode: Mode::Position,
            stimulus,
            until: None,
            at_most_s: 60.0,
            then: Then::Next,
            dithered: false,
            ..Segment::default()
        };
        // It rests there until the cause has set in, whenever that is.
        let hold = Segment { stimulus: Stimulus::Hold { torque_nm: 0.0 }, at_most_s: 6.0, ..segment.clone() };
        Case {
            point: "trial".to_owned(),
            axis: names[self.axis].clone(),
            start_pose_rad: BTreeMap::from([0, 1].map(|axis| (names[axis].clone(), self.from_rad[axis]))),
            segments: vec![segment, hold],
            ..Case::default()
        }
    }
}
