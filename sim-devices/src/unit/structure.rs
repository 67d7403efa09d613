//! Structure over elevation: rigid-body gain and flexible modes, as curves over the elevation angle.
//!
//! Motor torque T to sensed rate: `ω/T = g/(J·s) + Σ c_n·s/(s² + 2ζ_n·ω_n·s + ω_n²)` with one c_n for the encoder
//! (collocated, never negative) and one for the frame that carries gyro and line of sight (any sign).

mod curve;
pub(super) mod nominal;

pub use curve::{CURVES, Curve};

/// One flexible mode; each curve has one value per node of [`StructureSettings::elevation_rad`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModeCurves {
    /// Natural frequency.
    pub frequency_hz: Vec<f64>,
    /// Damping ratio ζ.
    pub damping_ratio: Vec<f64>,
    /// Participation c in the rate of the frame, 1/(kg·m²).
    pub gyro_per_kg_m2: Vec<f64>,
    /// Participation c in the rate of the shaft, 1/(kg·m²).
    pub encoder_per_kg_m2: Vec<f64>,
}

/// Structure of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureSettings {
    /// Nodes, ascending.
    pub elevation_rad: Vec<f64>,
    /// Rigid gain g: the axis accelerates like one of inertia J/g.
    pub rigid_gain_ratio: Vec<f64>,
    /// Flexible modes; those without values are absent.
    pub modes: Vec<ModeCurves>,
}

/// Modes that a unit file can give, per axis.
const MODES_COUNT: usize = 8;

impl StructureSettings {
    /// A rigid axis.
    pub fn rigid() -> Self {
        Self { elevation_rad: vec![0.0], rigid_gain_ratio: vec![1.0], modes: Vec::new() }
    }

    /// The structure frozen as it is at one elevation.
    pub fn frozen_at(&self, elevation_rad: f64) -> Self {
        let at = |values: &[f64]| vec![self.interpolate(values, elevation_rad)];
        let modes = self.modes.iter().map(|mode| ModeCurves {
            frequency_hz: at(&mode.frequency_hz),
            damping_ratio: at(&mode.damping_ratio),
            gyro_per_kg_m2: at(&mode.gyro_per_kg_m2),
            encoder_per_kg_m2: at(&mode.encoder_per_kg_m2),
        });
        Self {
            elevation_rad: vec![elevation_rad],
            rigid_gain_ratio: at(&self.rigid_gain_ratio),
            modes: modes.collect(),
        }
    }

    /// A curve at an elevation: linear between nodes, constant outside; 0 for a curve without values.
    pub fn interpolate(&self, values: &[f64], elevation_rad: f64) -> f64 {
        let nodes = &self.elevation_rad;
        let above = nodes.partition_point(|&node| node <= elevation_rad);
        let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return 0.0 };
        if above == 0 || values.len() < nodes.len() {
            return first;
        }
        if above >= nodes.len() {
            return last;
        }
        let ratio = (elevation_rad - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
        values[above - 1] + ratio * (values[above] - values[above - 1])
    }
}
