//! Both trackers of the unit `nominal`.

use super::CameraSettings;

/// Infrared camera along the line of sight of the frame.
pub(super) const COARSE: CameraSettings = CameraSettings {
    frame_rate_hz: 50.0,
    latency_s: 40.0 * 1e-3,
    latency_spread_s: 0.0,
    clock_offset_s: 5000.0,
    clock_drift_ratio: 12.0 * 1e-6,
    shutter_s: 1.0 * 1e-3,
    ifov_x_rad: 27.27 * 1e-6,
    ifov_y_rad: 36.36 * 1e-6,
    width_px: 640.0,
    height_px: 480.0,
    jitter_px: 0.5,
    centroid_step_px: 0.0625,
    x_of_cross_elevation_ratio: 0.0,
    x_of_elevation_ratio: 1.0,
    y_of_cross_elevation_ratio: 1.0,
    y_of_elevation_ratio: 0.0,
    scale_ratio: 1.06,
    dropped_ratio: 0.0,
    drop_period_count: 0.0,
    blank_period_count: 0.0,
    reacquisition_s: 200.0 * 1e-3,
};

/// CCD behind the mirror.
pub(super) const FINE: CameraSettings = CameraSettings {
    frame_rate_hz: 200.0,
    latency_s: 7.5 * 1e-3,
    clock_offset_s: 812.5,
    clock_drift_ratio: -8.0 * 1e-6,
    shutter_s: 100.0 * 1e-6,
    ifov_x_rad: 2.045 * 1e-6,
    ifov_y_rad: 2.045 * 1e-6,
    x_of_cross_elevation_ratio: 1.0,
    x_of_elevation_ratio: 0.0,
    y_of_cross_elevation_ratio: 0.0,
    y_of_elevation_ratio: 1.0,
    scale_ratio: 1.0,
    reacquisition_s: 50.0 * 1e-3,
    ..COARSE
};
