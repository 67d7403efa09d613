//! The study's tracking cases.

use sim_devices::unit::UnitSettings;

use super::{ROW_RATE_HZ, Row, span};

/// What is tracked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenario {
    /// The cart on its rails, at the height of the director.
    Rail,
    /// The drone, 85 m high at 85 m distance.
    Drone,
    /// A fixed light.
    Star,
}

impl Scenario {
    /// A unit that points at it.
    pub fn unit(self, unit: &UnitSettings) -> UnitSettings {
        let mut unit = unit.clone();
        let (kind, elevation_deg) = match self {
            Self::Rail => (1.0, 0.0),
            Self::Drone => (2.0, 45.0_f64),
            Self::Star => (0.0, 30.0),
        };
        (unit.target.kind_count, unit.target.elevation_rad) = (kind, elevation_deg.to_radians());
        unit
    }
}

/// One axis on one target, with what the study found: 1σ (director.md §5).
#[derive(Clone, Copy, Debug)]
pub struct TrackingCase {
    /// Axis and target.
    pub name: &'static str,
    /// What is tracked.
    pub scenario: Scenario,
    /// 0 azimuth, 1 elevation.
    pub axis: usize,
    /// Coarse error.
    pub coarse_rad: f64,
    /// Fine error.
    pub fine_rad: f64,
    /// Whether the coarse figure is that of the part at constant velocity, without reversals and jumps.
    pub without_jumps: bool,
}

/// The four published cases.
pub const CASES: [TrackingCase; 4] = [
    TrackingCase {
        name: "elevation rail",
        scenario: Scenario::Rail,
        axis: 1,
        coarse_rad: 26.56e-6,
        fine_rad: 1.09e-6,
        without_jumps: false,
    },
    TrackingCase {
        name: "elevation drone",
        scenario: Scenario::Drone,
        axis: 1,
        coarse_rad: 97.57e-6,
        fine_rad: 1.98e-6,
        without_jumps: false,
    },
    TrackingCase {
        name: "azimuth rail",
        scenario: Scenario::Rail,
        axis: 0,
        coarse_rad: 48.58e-6,
        fine_rad: 2e-6,
        without_jumps: true,
    },
    TrackingCase {
        name: "azimuth drone",
        scenario: Scenario::Drone,
        axis: 0,
        coarse_rad: 73.05e-6,
        fine_rad: 2.57e-6,
        without_jumps: true,
    },
];

/// Departure and settling are over.
const SETTLED_S: f64 = 9.0;

impl TrackingCase {
    /// Rows that the coarse figure is taken over.
    pub fn coarse_window<'a>(&self, rows: &'a [Row]) -> &'a [Row] {
        if self.without_jumps { self.fine_window(rows) } else { span(rows, SETTLED_S, f64::INFINITY) }
    }

    /// Rows without reversals and jumps, where the mirror has stroke left: until the rail's first reversal at 47 s; of
    /// the drone's descent, between its velocity steps at 13.1 s and 33.1 s.
    pub fn fine_window<'a>(&self, rows: &'a [Row]) -> &'a [Row] {
        match self.scenario {
            Scenario::Rail => span(rows, SETTLED_S, 46.9),
            Scenario::Drone => span(rows, 15.0, 32.9),
            Scenario::Star => span(rows, SETTLED_S, f64::INFINITY),
        }
    }
}

/// TRK-RMS-C: acceleration of the target above which a window is opened, azimuth and elevation. In azimuth reversals
/// reach 26 mrad/s² and the drone's velocity steps 200 mrad/s², all else stays below 5 mrad/s². In elevation joints and
/// steps reach 35 mrad/s²; they count.
const THRESHOLD_RAD_PER_S2: [f64; 2] = [0.02, 0.06];
/// The window: this long before and after.
const BEFORE_S: f64 = 0.55;
const AFTER_S: f64 = 0.8;

/// Coarse errors of an axis outside the windows opened by the target's acceleration, and the share of the record that
/// lies inside; the record is taken from where it has settled.
pub fn quiet(rows: &[Row], axis: usize) -> (Vec<f64>, f64) {
    let rows = span(rows, SETTLED_S, f64::INFINITY);
    let mut inside = vec![false; rows.len()];
    for (k, pair) in rows.windows(2).enumerate() {
        let change = pair[1].truth.target_rad_per_s[axis] - pair[0].truth.target_rad_per_s[axis];
        if change.abs() * ROW_RATE_HZ > THRESHOLD_RAD_PER_S2[axis] {
            let [before, after] = [BEFORE_S, AFTER_S].map(|time_s| (time_s * ROW_RATE_HZ) as usize);
            let last = (k + after).min(rows.len() - 1);
            inside[k.saturating_sub(before)..=last].fill(true);
        }
    }
    let quiet = rows.iter().zip(&inside).filter(|(_, inside)| !**inside);
    let errors: Vec<f64> = quiet.map(|(row, _)| row.coarse_rad(axis)).collect();
    let excluded = 1.0 - errors.len() as f64 / rows.len() as f64;
    (errors, excluded)
}
