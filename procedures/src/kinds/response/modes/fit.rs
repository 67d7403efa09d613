//! Modes of a point: torque to the rates of frame and shaft, poles that both share, with the rigid axis and one delay.
//!
//! Fitted are both sensors; where a small mode shows in the gyro only, or one is missing, their difference and the
//! encoder instead. In the difference the rigid axis is
//! gone and with it what the contact does to it (bristles that lag behind a changing rate bend a response by some
//! 0.5 % around 10 Hz, as much as a small mode does); the encoder gives inertia and delay.

use std::f64::consts::{FRAC_PI_2, TAU};

use analysis::frf::{C64, Frf, Line};
use analysis::goodness::Goodness;
use analysis::modal::{Lower, Modal, Mode, Settings, Upper, modes};
use analysis::periodic::times_jw;

use super::assign::{Candidate, Expected, Wanted, assign};
use crate::kinds::response::excited::{Channel, Measured};
use crate::measurement::Exclusion;
use crate::reason::{Reason, ResponseReason};

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
pub(super) fn read(measured: &Measured, cogging_orders_per_rev: f64) -> Result<Responses, Reason> {
    if !measured.slides {
        return Err(ResponseReason::Sticking { mean_rad_per_s: measured.mean_rate_rad_per_s }.into());
    }
    let derived = |lines: &Frf, n: i32| times_jw(lines, n).map_err(Reason::from);
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
pub(super) fn judged(sensors: [Frf; 2], ratio: &Frf) -> Result<Responses, Reason> {
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
            return Err(ResponseReason::FewLines {
                sensor: SENSORS[k],
                lines: good.len(),
                least_db: LEAST_SNR_DB,
                least: LEAST_LINES,
            }
            .into());
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

/// Orders of the stabilisation diagram.
const MOST_ORDER: usize = 40;
/// More modes than that in the band of a director's axis are noise.
const MOST_MODES: usize = 8;
/// Lines at the low end that the first value of the delay comes from: there the axis is stiff.
const STIFF_LINES: usize = 5;
/// A mode is visible from this multiple of the standard uncertainty of its residue on.
const VISIBLE: f64 = 4.0;
/// Share of the gyro's participation below which the encoder's is none.
const UNSEEN: f64 = 0.25;

/// The fitted responses.
const DIFFERENCE: usize = 0;
const ENCODER: usize = 1;

/// Modes of a point, and which of them were expected.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) modal: Modal,
    /// How well the modes describe the lines.
    pub(super) goodness: Goodness,
    /// Whether the first response is the difference of the sensors: where a small mode shows in the gyro only.
    pub(super) apart: bool,
    /// Index into the modes for each expected one.
    pub(super) pairs: Vec<Option<usize>>,
    /// Indices of modes that are visible in a sensor.
    pub(super) visible: Vec<usize>,
}

/// Share of a mode in the rate of a sensor, over that of the rigid axis: c_n·J, with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Participation {
    pub(super) value: f64,
    pub(super) u: f64,
}

/// Fits and names the modes at an elevation.
pub(super) fn fit(
    responses: &Responses,
    expected: &[Expected],
    elevation_rad: f64,
) -> Result<Fitted, Reason> {
    let always_apart = expected.iter().any(|e| e.gyro_only);
    let together = if always_apart { None } else { Some(fit_as(responses, expected, elevation_rad, false)) };
    match together {
        Some(Ok(found)) if found.pairs.iter().all(Option::is_some) => Ok(found),
        None => fit_as(responses, expected, elevation_rad, true),
        Some(together) => {
            // What is missing in one view may stand in the other.
            let apart = fit_as(responses, expected, elevation_rad, true);
            let count = |f: &Result<Fitted, Reason>| {
                f.as_ref().map_or(0, |f| f.pairs.iter().filter(|pair| pair.is_some()).count())
            };
            if count(&apart) > count(&together) { apart } else { together }
        }
    }
}

fn fit_as(
    responses: &Responses,
    expected: &[Expected],
    elevation_rad: f64,
    apart: bool,
) -> Result<Fitted, Reason> {
    let settings = Settings {
        delay_s: first_delay_s(&responses.sensors[1]),
        fits_delay: true,
        lower: Lower::Viscous,
        upper: Upper::Affine,
        most_order: MOST_ORDER,
        most_modes: MOST_MODES,
        ..Settings::default()
    };
    let first = if apart { &responses.difference } else { &responses.sensors[0] };
    let fitted = [first.clone(), responses.sensors[1].clone()];
    let modal = modes(&fitted, &settings)?;
    let goodness = Goodness::of_lines(&fitted.concat(), modal.fit.misfit_ratio(), modal.fit.dof)
        .with_share(largest_share(&fitted, &modal));
    let visible: Vec<usize> = (0..modal.modes.len()).filter(|&k| is_visible(&modal.modes[k])).collect();
    let found: Vec<Candidate> = visible.iter().map(|&k| candidate(&modal, k, apart)).collect();
    let wanted: Vec<Wanted> = expected
        .iter()
        .map(|e| Wanted { range_hz: e.range_hz(elevation_rad), gyro_only: e.gyro_only })
        .collect();
    let pairs = assign(&wanted, &found).into_iter().map(|pair| pair.map(|k| visible[k])).collect();
    Ok(Fitted { modal, goodness, apart, pairs, visible })
}

/// Residuals over what was observed, rms, of the response that the modes describe worst: the larger response must not hide what is
/// left of the smaller one.
fn largest_share(responses: &[Frf], modal: &Modal) -> f64 {
    let share = |(k, lines): (usize, &Frf)| {
        let left = |l: &Line| (l.value - modal.fit.response_at(k, l.frequency_hz)).norm_sqr();
        let power = lines.iter().map(|l| l.value.norm_sqr()).sum::<f64>();
        (lines.iter().map(left).sum::<f64>() / power).sqrt()
    };
    responses.iter().enumerate().map(share).fold(0.0, f64::max)
}

/// What is left of the phase of jω·G at the low end, where the axis is one piece: median of −∠/ω. Only a start.
fn first_delay_s(lines: &[Line]) -> f64 {
    let late = |l: &Line| {
        let turned = l.value * C64::from_polar(1.0, FRAC_PI_2);
        -turned.arg() / (TAU * l.frequency_hz)
    };
    let mut all: Vec<f64> = lines.iter().take(STIFF_LINES).map(late).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0).max(0.0)
}

/// By what the mode adds to the responses: a delay that the lines leave open turns the residues of all modes, and hides none.
fn is_visible(mode: &Mode) -> bool {
    mode.residues.iter().zip(&mode.observed_u).any(|(r, u)| r.norm() > VISIBLE * u)
}

/// Participation of mode `k` in a sensor.
pub(super) fn participation(modal: &Modal, k: usize, sensor: usize, apart: bool) -> Participation {
    share(modal, k, sensor, apart, &modal.modes[k].residue_u)
}

/// The same with an uncertainty of the residues.
fn share(modal: &Modal, k: usize, sensor: usize, apart: bool, residue_u: &[f64]) -> Participation {
    let rigid = rigid(modal);
    let mode = &modal.modes[k];
    let of = |response: usize| (mode.residues[response], residue_u[response]);
    let (residue, u) = match (of(DIFFERENCE), of(ENCODER), sensor) {
        ((d, d_u), (e, e_u), 0) if apart => (d + e, d_u.hypot(e_u)),
        (gyro, _, 0) => gyro,
        (_, encoder, _) => encoder,
    };
    // R = c·p/(2jβ), p = −a/2 + jβ: its real part is c/2. Half of the variance of R belongs to it.
    Participation { value: 2.0 * residue.re / rigid, u: 2.0_f64.sqrt() * u / rigid.abs() }
}

/// 1/J: residue of the one real pole, which stands last, in the encoder.
pub(super) fn rigid(modal: &Modal) -> f64 {
    modal.fit.residues[ENCODER].last().map_or(f64::NAN, |r| r.re)
}

/// The fitted response of a sensor at a frequency in Hz.
pub(super) fn response(fitted: &Fitted, sensor: usize, hz: f64) -> C64 {
    let modal = &fitted.modal;
    let encoder = modal.fit.response_at(ENCODER, hz);
    match (sensor, fitted.apart) {
        (0, true) => modal.fit.response_at(DIFFERENCE, hz) + encoder,
        (0, false) => modal.fit.response_at(DIFFERENCE, hz),
        _ => encoder,
    }
}

fn candidate(modal: &Modal, k: usize, apart: bool) -> Candidate {
    let mode = &modal.modes[k];
    // Whether a sensor shows the mode at all does not depend on the delay.
    let [gyro, encoder] = [0, 1].map(|sensor| share(modal, k, sensor, apart, &mode.observed_u));
    let ratio = mode.damping.as_ref().map_or(1.0, |d| d.ratio.abs().max(f64::MIN_POSITIVE));
    let height = gyro.value.abs().max(encoder.value.abs()) / (2.0 * ratio);
    Candidate {
        frequency_hz: mode.frequency_hz,
        height: if height.is_finite() { height } else { 0.0 },
        gyro_only: encoder.value.abs() - 2.0 * encoder.u < UNSEEN * gyro.value.abs(),
    }
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
