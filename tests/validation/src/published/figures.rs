//! Figures of the study, by elevation in degrees.

/// Table 4.1: bandwidth Hz, phase margin °, gain margin dB.
pub(super) const ELEVATION_VELOCITY: [(f64, [f64; 3]); 11] = [
    (-10.0, [3.86, 46.70, 6.71]),
    (0.0, [3.75, 45.80, 6.93]),
    (10.0, [3.74, 45.60, 7.14]),
    (20.0, [3.84, 46.20, 7.27]),
    (30.0, [3.77, 45.90, 7.48]),
    (40.0, [3.85, 46.50, 7.41]),
    (50.0, [3.75, 45.80, 10.10]),
    (60.0, [3.77, 46.10, 9.81]),
    (70.0, [3.87, 46.90, 9.47]),
    (80.0, [3.79, 46.20, 11.60]),
    (90.0, [3.95, 47.50, 9.49]),
];

/// Table 4.2, likewise.
pub(super) const AZIMUTH_VELOCITY: [(f64, [f64; 3]); 11] = [
    (-10.0, [4.05, 49.70, 14.20]),
    (0.0, [4.15, 50.40, 11.70]),
    (10.0, [4.41, 51.90, 6.82]),
    (20.0, [4.11, 50.10, 6.02]),
    (30.0, [4.28, 50.50, 7.42]),
    (40.0, [3.69, 46.70, 7.25]),
    (50.0, [3.84, 47.80, 6.80]),
    (60.0, [3.60, 46.00, 7.15]),
    (70.0, [3.75, 47.10, 8.03]),
    (80.0, [3.48, 44.90, 9.95]),
    (90.0, [3.59, 46.10, 12.20]),
];

/// Table 4.3: rise s, settling s.
pub(super) const AZIMUTH_POSITION: [(f64, [f64; 2]); 10] = [
    (-10.0, [0.443, 0.839]),
    (10.0, [0.438, 0.828]),
    (20.0, [0.438, 0.829]),
    (30.0, [0.442, 0.838]),
    (40.0, [0.451, 0.857]),
    (50.0, [0.461, 0.882]),
    (60.0, [0.467, 0.899]),
    (70.0, [0.468, 0.901]),
    (80.0, [0.469, 0.904]),
    (90.0, [0.472, 0.953]),
];

/// Tables 4.4 and 4.5 are given as ranges over the elevation: their middles. Bandwidth 1.00 to 1.03 Hz, phase margin
/// 72.70°, gain margin 20.3 to 23.9 dB, of which 20 to 24 dB is to be met.
pub(super) const ELEVATION_TRACK: [f64; 3] = [1.015, 72.70, 22.0];

/// Bandwidth 1.02 to 1.05 Hz, phase margin 56.4° to 56.6°. The gain margins, 36 to 45 dB, do not fit a 1 Hz loop around
/// a 4 Hz velocity loop (erratum E21): they are no figures to meet.
pub(super) const AZIMUTH_TRACK: [f64; 2] = [1.035, 56.5];

/// Elevations of both tables.
pub(super) const TRACK_ELEVATIONS_DEG: [f64; 11] =
    [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0];
