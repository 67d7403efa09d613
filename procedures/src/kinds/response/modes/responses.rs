//! Torque to the rate of the frame (gyro) and of the shaft (encoder), and to their difference, from one record.

use std::f64::consts::TAU;

use analysis::frf::{C64, Frf, Line};
use analysis::periodic::times_jw;

use crate::kinds::response::excited::{Channel, Measured};
use crate::measurement::Exclusion;

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// Fewer lines are no response.
const LEAST_LINES: usize = 20;

/// Orders of cogging that are left out although the excitation holds lines there (it keeps away from the first four): a
/// torque that is no part of the response would stand on one line and pass for a mode.
const COGGING_ORDERS: std::ops::RangeInclusive<u32> = 5..=8;
/// How far from them.
const COGGING_ROOM_HZ: f64 = 0.3;

/// Names of the sensors, in the order of the responses.
pub(super) const SENSORS: [&str; 2] = ["gyro", "encoder"];

/// Responses, rad/s over N·m.
#[derive(Clone, Debug)]
pub(super) struct Responses {
    /// Of each sensor, lines that count.
    pub(super) sensors: [Frf; 2],
    /// Gyro less encoder at all lines of the gyro that count: only structure is left. What the contact does to the
    /// shaft, and noise of friction, is common to both sensors and cancels.
    pub(super) difference: Frf,
    /// Lines that do not count.
    pub(super) hollow: [Frf; 2],
    pub(super) excluded: Vec<Exclusion>,
}

/// The responses of a record of an axis with so many periods of cogging in a revolution, or why modes cannot be read
/// from it.
pub(super) fn read(measured: &Measured, cogging_orders_per_rev: f64) -> Result<Responses, String> {
    if !measured.slides {
        return Err(format!(
            "presliding: the axis did not slide all the time (mean rate {:.3} rad/s), the contact adds a spring to the structure",
            measured.mean_rate_rad_per_s
        ));
    }
    let derived = |lines: &Frf, n: i32| times_jw(lines, n).map_err(|e| e.to_string());
    let gyro = measured.response(Channel::Torque, Channel::Rate)?;
    let encoder = derived(&measured.response(Channel::Torque, Channel::Angle)?, 1)?;
    let ratio = derived(&measured.response(Channel::Angle, Channel::Rate)?, -1)?;
    let first_hz = cogging_orders_per_rev * measured.mean_rate_rad_per_s / TAU;
    let count = gyro.len();
    let sensors = [gyro, encoder].map(|lines| without_cogging(lines, first_hz));
    let left_out = count - sensors[0].len();
    let mut responses = judged(sensors, &ratio)?;
    if left_out > 0 {
        let first = COGGING_ORDERS.start();
        let last = COGGING_ORDERS.end();
        let reason = format!("within {COGGING_ROOM_HZ} Hz of orders {first} to {last} of cogging");
        responses.excluded.push(Exclusion { count: left_out, of: "lines".to_owned(), reason });
    }
    Ok(responses)
}

/// The lines that are none of cogging, whose first order lies at `first_hz`.
fn without_cogging(mut lines: Frf, first_hz: f64) -> Frf {
    let near =
        |hz: f64| COGGING_ORDERS.into_iter().any(|n| (hz - f64::from(n) * first_hz).abs() <= COGGING_ROOM_HZ);
    lines.retain(|line| !near(line.frequency_hz));
    lines
}

/// Keeps the lines that say something; `ratio` is gyro over encoder.
pub(super) fn judged(sensors: [Frf; 2], ratio: &Frf) -> Result<Responses, String> {
    let all = difference(&sensors[1], ratio);
    let mut excluded = Vec::new();
    let mut kept = [const { Vec::new() }; 2];
    let mut hollow = [const { Vec::new() }; 2];
    for (k, lines) in sensors.into_iter().enumerate() {
        let (good, noisy): (Frf, Frf) = lines.into_iter().partition(|l| snr_db(l) >= LEAST_SNR_DB);
        if !noisy.is_empty() {
            let reason = format!("{}: signal to noise below {LEAST_SNR_DB} dB", SENSORS[k]);
            excluded.push(Exclusion { count: noisy.len(), of: "lines".to_owned(), reason });
        }
        if good.len() < LEAST_LINES {
            return Err(format!(
                "the {} has {} lines with a signal to noise above {LEAST_SNR_DB} dB: expected at least {LEAST_LINES}; raise `level` or `duration`",
                SENSORS[k],
                good.len()
            ));
        }
        (kept[k], hollow[k]) = (good, noisy);
    }
    let counts = |l: &Line| kept[0].iter().any(|g| g.frequency_hz == l.frequency_hz);
    let difference = all.into_iter().filter(counts).collect();
    Ok(Responses { sensors: kept, difference, hollow, excluded })
}

/// E·(Q − 1), Q the ratio of the sensors on the same record: its variance is without what both share, which makes the
/// difference far quieter than either. Lines that only one of them has are left out.
fn difference(encoder: &Frf, ratio: &Frf) -> Frf {
    let difference = |(e, q): (&Line, &Line)| {
        let less_one = q.value - C64::new(1.0, 0.0);
        let variance = e.value.norm_sqr() * q.variance + less_one.norm_sqr() * e.variance;
        Line { value: e.value * less_one, variance, dof: e.dof.min(q.dof), coherence: None, ..*e }
    };
    let same = |e: &&Line| ratio.iter().find(|q| q.frequency_hz == e.frequency_hz);
    encoder.iter().filter_map(|e| Some(difference((e, same(&e)?)))).collect()
}

/// Signal to noise of a line's mean.
fn snr_db(line: &Line) -> f64 {
    -20.0 * (2.0_f64.sqrt() * line.relative_sd()).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_on_the_fifth_and_sixth_order_of_cogging_are_left_out_and_their_neighbours_stay() {
        // 144 periods at 0.30 rad/s: 6.875 Hz; the fifth and sixth lie in the band of azimuth's first mode.
        let lines = (60..=100).map(|k| Line::exact(0.5 * f64::from(k), C64::new(1.0, 0.0))).collect();
        let left: Vec<f64> =
            without_cogging(lines, 144.0 * 0.30 / TAU).iter().map(|l| l.frequency_hz).collect();
        assert!([34.0, 35.0, 40.5, 42.0].iter().all(|hz| left.contains(hz)), "{left:?}");
        assert!(![34.5, 41.0, 41.5, 48.0].iter().any(|hz| left.contains(hz)), "{left:?}");
        assert_eq!(left.len(), 41 - 4);
    }
}
