//! Current loop, latency, velocity loop, coarse track loop.

use super::{ELEVATIONS_DEG, Expected, Subject, row, servo};
use crate::linear::{CoarseCamera, Margins, coarse_open_loop, jitter_s, margins};

/// Where a velocity loop is searched for crossings, Hz.
pub const VELOCITY_HZ: [f64; 2] = [0.6, 110.0];
/// Where a track loop is searched for crossings, Hz.
pub const TRACK_HZ: [f64; 2] = [0.3, 40.0];
/// Period of the coarse track law, s (director.md 4.5: 2 kHz).
pub const TRACK_PERIOD_S: f64 = 0.5e-3;

/// A first-order fit over a decade at 40 dB (row 7 for a real pole), and the hold that is taken off.
const CURRENT_U: f64 = 0.02;
/// Row 12: step onset ± 0.3 of a period of 250 µs.
const LATENCY_U_S: f64 = 75e-6;
/// Row 9: margins at 40 dB.
const BANDWIDTH_U: f64 = 3e-3;
const PHASE_U_DEG: f64 = 0.5;
/// A line of 1 % (0.09 dB), k = 2: the crossing lies on the flank of a mode that is narrower than the local fit, so no
/// neighbours help.
const GAIN_U_DB: f64 = 0.18;
/// Track loop: an excitation near 1 Hz on top of half a pixel of camera noise (director.md, section 8: 0.02 Hz).
const TRACK_U_HZ: f64 = 0.02;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let mut rows = Vec::new();
    for axis in 0..2 {
        let settings = subject.axis(axis);
        let bandwidth_hz = settings.current_bandwidth_hz;
        rows.push(row("CUR-BW", axis, "bandwidth", "", bandwidth_hz, CURRENT_U * bandwidth_hz));
        let tick_s = 1.0 / servo::LOOP_RATE_HZ;
        let [jitter_s, _] = jitter_s(settings, subject.unit.step_rate_hz);
        let round_s = settings.command_delay_s + jitter_s + tick_s + settings.sensor_delay_s;
        rows.push(row("LAT-RT", axis, "round-trip", "", round_s, LATENCY_U_S));
        for elevation_deg in ELEVATIONS_DEG {
            let condition = format!("elevation {elevation_deg} deg");
            rows.extend(velocity(subject, axis, elevation_deg, &condition));
            let track = track(subject, axis, elevation_deg).map_or(0.0, |m| m.bandwidth_hz);
            rows.push(row("TRK-BW", axis, "bandwidth", condition, track, TRACK_U_HZ));
        }
    }
    rows
}

fn velocity(subject: &Subject<'_>, axis: usize, elevation_deg: f64, condition: &str) -> [Expected; 3] {
    let velocity = servo::velocity(subject, axis, elevation_deg);
    let [from_hz, to_hz] = VELOCITY_HZ;
    let none = Margins { bandwidth_hz: 0.0, phase_margin_deg: 0.0, gain_margin_db: 0.0, gain_margin_hz: 0.0 };
    let found = margins(|hz| velocity.open(hz), from_hz, to_hz).unwrap_or(none);
    let bandwidth_u = BANDWIDTH_U * found.bandwidth_hz;
    [
        row("VEL-BW", axis, "bandwidth", condition, found.bandwidth_hz, bandwidth_u),
        row("VEL-GM", axis, "gain-margin", condition, found.gain_margin_db, GAIN_U_DB),
        row("VEL-PM", axis, "phase-margin", condition, found.phase_margin_deg.to_radians(), {
            PHASE_U_DEG.to_radians()
        }),
    ]
}

/// The coarse track loop; dropped frames make those that come stand longer.
fn track(subject: &Subject<'_>, axis: usize, elevation_deg: f64) -> Option<Margins> {
    let velocity = servo::velocity(subject, axis, elevation_deg);
    let mut coarse = CoarseCamera::new(subject.unit, &velocity, &subject.gains.track, TRACK_PERIOD_S);
    coarse.frame_period_s /= (1.0 - subject.unit.trackers.coarse.dropped_ratio).max(1e-3);
    let [from_hz, to_hz] = TRACK_HZ;
    margins(|hz| coarse_open_loop(&velocity, &coarse, hz), from_hz, to_hz)
}
