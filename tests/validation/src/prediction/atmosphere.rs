//! Fine track loop: rejection of tip-tilt, and what it leaves of a spectrum.

use sim_devices::atmosphere::tilt_psd_rad2_per_hz;

use super::mirror::Mirror;
use super::{Expected, Subject, row};
use crate::budget::IntegratorLoop;
use crate::spectrum::Spectrum;

/// Amplitudes of the fine loop's mirror.
const SMALL_RAD: f64 = 50e-6;
/// From the message to the tick that takes it, and from that to the mirror's channel: a period of the fastest loop each.
const TICKS_S: f64 = 2.0 * 250e-6;

/// PSD ratios of ten-minute records (estimators 1.1: random error of 200 averages), in bands.
const REJECTION_U_DB: f64 = 0.4;
const CROSSING_U_HZ: f64 = 0.2;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let mut rows = Vec::new();
    for axis in 0..2 {
        let figures = fine_loop(subject, axis).map(|design| design.figures());
        let of = |quantity, value: Option<f64>, u| {
            row("ATM-REJ", axis, quantity, "", value.unwrap_or(f64::NAN), u)
        };
        rows.extend([
            of("rejection-1-hz", figures.map(|f| f.at_1_hz_db), REJECTION_U_DB),
            of("rejection-3-hz", figures.map(|f| f.at_3_hz_db), REJECTION_U_DB),
            of("crossing", figures.map(|f| f.crossing_hz), CROSSING_U_HZ),
            of("amplification", figures.map(|f| f.amplification_db), REJECTION_U_DB),
        ]);
    }
    rows
}

/// The loop of an axis; `None` where the mirror swings, or the loop would feed its error. Lost frames leave out steps of the integrator.
pub(super) fn fine_loop(subject: &Subject<'_>, axis: usize) -> Option<IntegratorLoop> {
    let camera = &subject.unit.trackers.fine;
    let settings = &subject.unit.mirror;
    let mirror = Mirror::new(subject.unit, axis, SMALL_RAD);
    let trackers = &subject.unit.trackers;
    let real = [trackers.optical_gain_cross_elevation_ratio, trackers.optical_gain_elevation_ratio][axis];
    if !mirror.is_stable() || real <= 0.0 {
        return None;
    }
    let fine = &subject.gains.fine;
    let believed = [fine.az_optical_gain, fine.el_optical_gain][axis];
    let followed = mirror.closed(1.0).norm() * believed / real * camera.scale_ratio;
    Some(IntegratorLoop {
        gain_per_s: fine.gain_per_s * followed * (1.0 - camera.dropped_ratio),
        delay_s: camera.latency_s + TICKS_S + settings.serial_delay_s + mirror.delay_s(),
        frame_s: 1.0 / camera.frame_rate_hz,
    })
}

/// Fine error of an axis, 1σ, from the spectrum of the coarse error, the atmosphere and the camera's noise.
pub(super) fn fine_error_rad(subject: &Subject<'_>, axis: usize, coarse: &Spectrum) -> f64 {
    let Some(design) = fine_loop(subject, axis) else { return f64::NAN };
    let tilt = Spectrum {
        width_hz: coarse.width_hz,
        psd: (0..coarse.psd.len())
            .map(|k| {
                if k == 0 {
                    0.0
                } else {
                    tilt_psd_rad2_per_hz(&subject.unit.atmosphere, k as f64 * coarse.width_hz)
                }
            })
            .collect(),
    };
    let camera = &subject.unit.trackers.fine;
    let ifov_rad = [camera.ifov_x_rad, camera.ifov_y_rad][axis];
    let budget = design.budget(coarse, camera, ifov_rad);
    let atmosphere = design.budget(&tilt, camera, ifov_rad).input_rad;
    budget.total_rad().hypot(atmosphere)
}
