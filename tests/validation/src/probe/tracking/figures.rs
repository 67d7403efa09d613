//! Figures of a tracking record.

use controllers::DirectorGains;
use sim_devices::unit::UnitSettings;

use super::{ROW_RATE_HZ, Row};
use crate::budget::{IntegratorLoop, Rejection};
use crate::spectrum::{Spectrum, welch};

/// Tick of the control computer: a frame waits for the next one, its command leaves with the one after.
const TICK_S: f64 = 250e-6;
/// Longest window of a spectrum, in rows: 10 s.
const WINDOW: usize = 4096;
/// Resolution in time of the longest stretch, in rows: 0.1 s.
const STRETCH_ROWS: usize = (ROW_RATE_HZ / 10.0) as usize;

/// Rows from one time to another.
pub fn span(rows: &[Row], from_s: f64, to_s: f64) -> &[Row] {
    let first = rows.partition_point(|row| row.time_s < from_s);
    let last = rows.partition_point(|row| row.time_s < to_s);
    &rows[first..last]
}

/// 1σ: root mean square about the mean.
pub fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Largest size.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |top, value| top.max(value.abs()))
}

/// The fine track loop as the unit and its gains make it: from the centre of a shutter to the mirror's angle there are
/// the camera's latency, the wait for the tick, the tick until the command leaves and the analog channel. The mirror's
/// own loop adds 0.1 ms at 8 Hz, which is left out, and gain above 15 Hz, where little is left to reject.
pub fn fine_loop(unit: &UnitSettings, gains: &DirectorGains) -> IntegratorLoop {
    let camera = &unit.trackers.fine;
    let due_s = 0.5 * camera.shutter_s + camera.latency_s;
    let heard_s = (due_s / TICK_S - 1e-9).ceil() * TICK_S - 0.5 * camera.shutter_s;
    let delay_s = heard_s + TICK_S + unit.mirror.analog_delay_s;
    IntegratorLoop { gain_per_s: gains.fine.gain_per_s, delay_s, frame_s: 1.0 / camera.frame_rate_hz }
}

/// Fine error of one axis, found and to be expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FineTracking {
    /// 1σ of the record.
    pub found_rad: f64,
    /// From the rejection of the loop, the spectrum of its input and the noise of its camera.
    pub predicted_rad: f64,
}

impl FineTracking {
    /// Of these rows.
    pub fn of(rows: &[Row], axis: usize, unit: &UnitSettings, gains: &DirectorGains) -> Self {
        let camera = &unit.trackers.fine;
        let ifov_rad = if axis == 0 { camera.ifov_x_rad } else { camera.ifov_y_rad };
        let input = spectrum(rows, |row| row.fine_input_rad(axis));
        Self {
            found_rad: deviation(rows.iter().map(|row| row.fine_rad(axis))),
            predicted_rad: fine_loop(unit, gains).budget(&input, camera, ifov_rad).total_rad(),
        }
    }

    /// Found over predicted.
    pub fn ratio(&self) -> f64 {
        self.found_rad / self.predicted_rad
    }
}

fn spectrum(rows: &[Row], value: impl Fn(&Row) -> f64) -> Spectrum {
    let samples: Vec<f64> = rows.iter().map(value).collect();
    // At least three windows, half overlapping, where the record allows.
    let longest = (samples.len() / 2).max(2);
    let length = WINDOW.min(1 << longest.ilog2());
    welch(&samples, ROW_RATE_HZ, length)
}

/// Length of the longest stretch in which both cameras keep the target and the fine error's root mean square stays
/// within a limit on both axes, s.
pub fn longest_within(rows: &[Row], limit_rad: f64) -> f64 {
    let squares = |piece: &[Row], axis: usize| {
        let sum: f64 = piece.iter().map(|row| row.fine_rad(axis).powi(2)).sum();
        if piece.iter().all(|row| row.locked) { sum / piece.len() as f64 } else { f64::INFINITY }
    };
    let pieces: Vec<[f64; 2]> =
        rows.chunks_exact(STRETCH_ROWS).map(|piece| [0, 1].map(|axis| squares(piece, axis))).collect();
    let mut longest = 0;
    for first in 0..pieces.len() {
        let mut sums = [0.0; 2];
        for (count, piece) in (1_usize..).zip(&pieces[first..]) {
            sums = [sums[0] + piece[0], sums[1] + piece[1]];
            if sums.iter().all(|sum| *sum <= limit_rad * limit_rad * count as f64) {
                longest = longest.max(count);
            }
        }
    }
    longest as f64 * STRETCH_ROWS as f64 / ROW_RATE_HZ
}

/// ATM-REJ of one axis from the spectra with and without the mirror: ratios of powers within ± 15 % of a frequency, the
/// crossing and the largest one up to 40 Hz.
pub fn rejection(rows: &[Row], axis: usize) -> Rejection {
    let without = spectrum(rows, |row| row.fine_input_rad(axis));
    let with = spectrum(rows, |row| row.fine_rad(axis));
    let ratio_db = |hz: f64| {
        let bin = |hz: f64| (hz / with.width_hz).round() as usize;
        let power = |s: &Spectrum| s.psd[bin(0.85 * hz)..=bin(1.15 * hz)].iter().sum::<f64>();
        10.0 * (power(&with) / power(&without)).log10()
    };
    let grid = || (0..).map(|k| 1.02_f64.powi(k)).take_while(|hz| *hz < 40.0);
    Rejection {
        at_1_hz_db: ratio_db(1.0),
        at_3_hz_db: ratio_db(3.0),
        crossing_hz: grid().find(|hz| ratio_db(*hz) >= 0.0).unwrap_or(f64::INFINITY),
        amplification_db: grid().map(ratio_db).fold(f64::NEG_INFINITY, f64::max),
    }
}
