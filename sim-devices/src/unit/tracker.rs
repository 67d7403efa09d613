//! Coarse and fine video tracker.

mod nominal;
mod rows;

use super::UnitSettings;
use super::setting::{Field, Setting};

/// A video tracker and its camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSettings {
    /// Frames per second.
    pub frame_rate_hz: f64,
    /// From the centre of the shutter to the message at the host.
    pub latency_s: f64,
    /// What a message may take beyond that: width of a uniform distribution.
    pub latency_spread_s: f64,
    /// What its own clock shows when the simulation begins.
    pub clock_offset_s: f64,
    /// Rate of its own clock over true time, less 1.
    pub clock_drift_ratio: f64,
    /// Time the shutter is open; its centre is when the frame is true.
    pub shutter_s: f64,
    /// Angle of one pixel along the rows of the image.
    pub ifov_x_rad: f64,
    /// Angle of one pixel along the columns of the image.
    pub ifov_y_rad: f64,
    /// Pixels along a row.
    pub width_px: f64,
    /// Pixels along a column.
    pub height_px: f64,
    /// Random error of a frame in pixels, uniform, peak to peak.
    pub jitter_px: f64,
    /// Resolution of the centroid in pixels; 0 is exact.
    pub centroid_step_px: f64,
    /// Motion along the rows per cross-elevation angle.
    pub x_of_cross_elevation_ratio: f64,
    /// Motion along the rows per elevation angle.
    pub x_of_elevation_ratio: f64,
    /// Motion along the columns per cross-elevation angle.
    pub y_of_cross_elevation_ratio: f64,
    /// Motion along the columns per elevation angle.
    pub y_of_elevation_ratio: f64,
    /// Pixels reported per true pixel.
    pub scale_ratio: f64,
    /// Share of the frames whose message is never sent.
    pub dropped_ratio: f64,
    /// Every so many-th frame is never sent; 0 for none.
    pub drop_period_count: f64,
    /// Every so many-th frame does not show the target; 0 for none.
    pub blank_period_count: f64,
    /// Time from seeing the target again to measuring it.
    pub reacquisition_s: f64,
}

impl CameraSettings {
    /// From the centre of the shutter to the message at the host, on average, s.
    pub fn mean_latency_s(&self) -> f64 {
        self.latency_s + 0.5 * self.latency_spread_s
    }
}

/// Coarse and fine video tracker.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackersSettings {
    /// Infrared, along the line of sight of the frame.
    pub coarse: CameraSettings,
    /// CCD, behind the mirror.
    pub fine: CameraSettings,
    /// Mirror angle per line-of-sight angle across the elevation axis, as the optics really have it.
    pub optical_gain_cross_elevation_ratio: f64,
    /// Mirror angle per line-of-sight angle in elevation, as the optics really have it.
    pub optical_gain_elevation_ratio: f64,
}

impl TrackersSettings {
    /// A tracker to be changed: 0 coarse, 1 fine.
    fn camera_mut(&mut self, camera: usize) -> &mut CameraSettings {
        if camera == 0 { &mut self.coarse } else { &mut self.fine }
    }
}

impl Default for TrackersSettings {
    /// The unit `nominal`.
    fn default() -> Self {
        Self {
            coarse: nominal::COARSE,
            fine: nominal::FINE,
            optical_gain_cross_elevation_ratio: 3.5355,
            optical_gain_elevation_ratio: 2.5,
        }
    }
}

pub(super) use rows::CAMERAS;

/// Optics in front of the fine camera.
pub(super) const OPTICS: &[Setting<Field<UnitSettings>>] = &[
    Setting {
        key: "trackers.optical-gain-cross-elevation",
        quantity: "ratio",
        range_si: [-10.0, 10.0],
        default: "3.5355",
        doc: "Mirror angle per line-of-sight angle, azimuth.",
        source: "study 4.3",
        field: |unit| &mut unit.trackers.optical_gain_cross_elevation_ratio,
    },
    Setting {
        key: "trackers.optical-gain-elevation",
        quantity: "ratio",
        range_si: [-10.0, 10.0],
        default: "2.5",
        doc: "Mirror angle per line-of-sight angle, elevation.",
        source: "study 4.3",
        field: |unit| &mut unit.trackers.optical_gain_elevation_ratio,
    },
];
