//! What kinds that read the inertial unit share: its samples, each once, beside the angles of the encoders.

pub(in crate::kinds) mod allan;
pub(in crate::kinds) mod imu_consistency;

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::ops::Range;

use crate::axis::Axes;
use crate::log::{Rows, Window};
use crate::measurement::{Evidence, Exclusion};
use crate::reason::{InertialReason, Reason};

#[cfg(test)]
pub(in crate::kinds) mod tests;

pub(in crate::kinds) const TOPIC: &str = "/imu";
/// Gyros, in the order of their channels.
pub(in crate::kinds) const GYROS: [&str; 3] = ["x", "y", "z"];
/// The counter of messages is a byte less its upper bit.
const COUNTER_MODULUS: f64 = 128.0;
/// Two samples that are further apart than this many periods have a gap between them.
const GAP_RATIO: f64 = 1.5;
/// A record in which more messages than this are missing is none.
const MOST_LOST_RATIO: f64 = 0.01;
/// Fewest samples that have a period.
const LEAST_SAMPLES: usize = 16;

/// Samples of the gyros, the longest stretch without gap.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::kinds) struct Samples {
    /// When each row was written, on the log's time axis; a sample is the mean since the row before.
    pub(in crate::kinds) time_s: Vec<f64>,
    /// Rates about X, Y, Z.
    pub(in crate::kinds) rate_rad_per_s: [Vec<f64>; 3],
    /// Angle of azimuth and elevation by their encoders.
    pub(in crate::kinds) angle_rad: [Vec<f64>; 2],
    /// How far azimuth and elevation have turned at the time of each row, by the counters of their encoders.
    turned_rad: [Vec<f64>; 2],
    /// Names of azimuth and elevation.
    axes: [String; 2],
    /// Messages that came since the sample before.
    messages: Vec<f64>,
    /// Time between two samples.
    pub(in crate::kinds) period_s: f64,
    /// Temperature of the unit, first and last.
    pub(in crate::kinds) temperature_degc: [f64; 2],
    /// What should be known of them.
    pub(in crate::kinds) flags: Vec<String>,
    /// What was left out.
    pub(in crate::kinds) excluded: Vec<Exclusion>,
}

impl Samples {
    /// First and last angle that azimuth (0) or elevation (1) passed.
    pub(in crate::kinds) fn passed_rad(&self, axis: usize) -> [f64; 2] {
        let angles = || self.angle_rad[axis].iter().copied();
        [angles().fold(f64::INFINITY, f64::min), angles().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Those of the rows between two times.
    ///
    /// A row whose message counter is that of the row before repeats its sample and is left out; so is what lies beyond a
    /// gap on the shorter side.
    ///
    /// # Errors
    /// No topic, no channel, too few samples, more than 1 % of the messages missing.
    pub(in crate::kinds) fn read(
        window: &Window,
        axes: &Axes,
        from_s: f64,
        to_s: f64,
    ) -> Result<Self, Reason> {
        let imu = window.topic(TOPIC)?;
        let rows = imu.range(from_s, to_s);
        let counter = column(imu, "sequence", &rows)?;
        let new: Vec<usize> = (1..rows.len()).filter(|&k| step(counter, k) > 0.0).collect();
        if new.len() < LEAST_SAMPLES {
            return Err(InertialReason::TooFewSamples { samples: new.len(), least: LEAST_SAMPLES }.into());
        }
        let time = &imu.time_s[rows.clone()];
        let period_s = middle(new.windows(2).map(|k| time[k[1]] - time[k[0]]).collect());
        let messages = middle(new.iter().map(|&k| step(counter, k)).collect());
        let longest = longest(&new, time, period_s);
        let kept = &new[longest];
        if kept.len() < LEAST_SAMPLES {
            return Err(InertialReason::Gaps.into());
        }
        let lost: f64 = kept.iter().map(|&k| (messages - step(counter, k)).rem_euclid(COUNTER_MODULUS)).sum();
        let expected = messages * kept.len() as f64;
        // A row with a message more than usual belongs to one with a message less.
        let lost = lost.min(kept.iter().map(|&k| (step(counter, k) - messages).abs()).sum());
        if lost > MOST_LOST_RATIO * expected {
            return Err(InertialReason::MessagesMissing { lost, expected }.into());
        }
        let pick = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&k| values[k]).collect() };
        let mut rate_rad_per_s: [Vec<f64>; 3] = Default::default();
        for (rates, gyro) in rate_rad_per_s.iter_mut().zip(GYROS) {
            *rates = pick(column(imu, &format!("rate_{gyro}_rad_per_s"), &rows)?);
            if let Some(k) = rates.iter().position(|r| !r.is_finite()) {
                return Err(InertialReason::NotANumber { gyro, sample: k }.into());
            }
        }
        let temperature =
            column(imu, "temperature_degc", &rows).map(|t| [t[kept[0]], t[kept[kept.len() - 1]]]);
        let time_s = pick(time);
        let names = axes.gimbal()?.names();
        let az = Turned::read(window, axes, names[0], &time_s)?;
        let el = Turned::read(window, axes, names[1], &time_s)?;
        let angle_rad = [az.angle_rad, el.angle_rad];
        let turned_rad = [az.turned_rad, el.turned_rad];
        let (flags, excluded) = notes(&new, kept, rows.len(), lost);
        let temperature_degc = temperature.unwrap_or([0.0; 2]);
        Ok(Self {
            time_s,
            rate_rad_per_s,
            angle_rad,
            turned_rad,
            messages: kept.iter().map(|&k| step(counter, k)).collect(),
            axes: names.map(str::to_owned),
            period_s,
            temperature_degc,
            flags,
            excluded,
        })
    }

    /// Number of samples.
    pub(in crate::kinds) fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Number of messages that most samples are the mean of.
    pub(in crate::kinds) fn messages_in_most(&self) -> f64 {
        middle(self.messages.clone())
    }

    /// Rates of a gyro where a sample is the mean of so many messages.
    pub(in crate::kinds) fn rates_of_messages(&self, index: usize, messages: f64) -> Vec<f64> {
        let pairs = self.rate_rad_per_s[index].iter().zip(&self.messages);
        pairs.filter(|(_, own)| **own == messages).map(|(rate, _)| *rate).collect()
    }

    /// Mean rates of the axes over each sample but the first, by the encoders: azimuth, elevation.
    pub(in crate::kinds) fn axis_rates(&self) -> [Vec<f64>; 2] {
        let rate = |angle: &[f64]| -> Vec<f64> {
            let time = self.time_s.windows(2);
            angle.windows(2).zip(time).map(|(a, t)| (a[1] - a[0]) / (t[1] - t[0])).collect()
        };
        [rate(&self.turned_rad[0]), rate(&self.turned_rad[1])]
    }

    /// Mean elevation over each sample but the first.
    pub(in crate::kinds) fn elevation_rad(&self) -> Vec<f64> {
        self.angle_rad[1].windows(2).map(|a| 0.5 * (a[0] + a[1])).collect()
    }

    /// Where the numbers come from.
    pub(in crate::kinds) fn evidence(&self) -> Vec<Evidence> {
        let gyros = GYROS.iter().map(|g| format!("{TOPIC} rate_{g}_rad_per_s"));
        let angles = self.axes.iter().map(|a| format!("/{a} position_counts"));
        let t0_s = self.time_s[0];
        let t1_s = self.time_s[self.len() - 1];
        vec![Evidence::new(gyros.chain(angles).collect(), [t0_s, t1_s])]
    }
}

/// Rates of X, Y, Z when the axes turn so and nothing else does (director.md §6: the transpose of the matrix there, whose
/// elevation rate is that of falling elevation).
pub(in crate::kinds) fn body_rates(az_rad_per_s: f64, el_rad_per_s: f64, elevation_rad: f64) -> [f64; 3] {
    let (sin, cos) = elevation_rad.sin_cos();
    let up = FRAC_1_SQRT_2 * cos * az_rad_per_s;
    let left = FRAC_1_SQRT_2 * el_rad_per_s;
    [up - left, up + left, sin * az_rad_per_s]
}

/// Rate of the Earth against the stars, about X, Y, Z (IERS Conventions 2010): site latitude, heading of azimuth zero
/// clockwise from north; azimuth grows counter-clockwise seen from above, X and Y stand at 45° about the line of sight.
pub(in crate::kinds) fn earth_rates(
    latitude_rad: f64,
    heading_of_zero_rad: f64,
    azimuth_rad: f64,
    elevation_rad: f64,
) -> [f64; 3] {
    const EARTH_RAD_PER_S: f64 = 7.292_115e-5;
    let heading = heading_of_zero_rad - azimuth_rad;
    let vertical = EARTH_RAD_PER_S * latitude_rad.sin();
    let north = EARTH_RAD_PER_S * latitude_rad.cos();
    let (sin, cos) = elevation_rad.sin_cos();
    // Along the line of sight, left of it, up from it.
    let ahead = north * cos * heading.cos() + vertical * sin;
    let left = north * heading.sin();
    let up = vertical * cos - north * sin * heading.cos();
    [FRAC_1_SQRT_2 * (up + left), FRAC_1_SQRT_2 * (up - left), ahead]
}

/// An axis by its encoder at the time of each sample: its angle as logged (a mean over the row where rows are slower than
/// the loop), and the angle it has turned by the counter of its encoder (of the last tick of the row, where a sample ends).
struct Turned {
    angle_rad: Vec<f64>,
    turned_rad: Vec<f64>,
}

impl Turned {
    fn read(window: &Window, axes: &Axes, axis: &str, time_s: &[f64]) -> Result<Self, Reason> {
        let topic = format!("/{axis}");
        let limits = axes.limits(axis)?;
        let rows = window.topic_with_rows(&topic)?;
        let column = |name: &str| rows.channel(name);
        let angle = column("position_rad")?;
        let counts = column("position_counts")?;
        let row = |t: &f64| rows.time_s.partition_point(|own| own <= t).saturating_sub(1);
        let at: Vec<usize> = time_s.iter().map(row).collect();
        let angle_rad: Vec<f64> = at.iter().map(|&k| angle[k]).collect();
        let steps: Vec<f64> =
            at.windows(2).map(|k| nearest(counts[k[1]] - counts[k[0]], limits.encoder_quantum_rad)).collect();
        // The encoder may count against the axis.
        let same: f64 = angle_rad.windows(2).zip(&steps).map(|(a, step)| (a[1] - a[0]) * step).sum();
        let count_rad = limits.encoder_quantum_rad.copysign(same);
        let mut turned_rad = Vec::with_capacity(at.len());
        let mut counted = 0.0;
        turned_rad.push(0.0);
        for step in steps {
            counted += step;
            turned_rad.push(count_rad * counted);
        }
        Ok(Self { angle_rad, turned_rad })
    }
}

/// A difference of counters that begin again after a full turn.
pub(in crate::kinds) fn nearest(difference: f64, count_rad: f64) -> f64 {
    let turn = (TAU / count_rad).round();
    difference - turn * (difference / turn).round()
}

fn column<'a>(imu: &'a Rows, name: &str, rows: &Range<usize>) -> Result<&'a [f64], Reason> {
    let column = imu.channel(name)?;
    Ok(&column[rows.clone()])
}

/// Messages since the row before.
fn step(counter: &[f64], k: usize) -> f64 {
    (counter[k] - counter[k - 1]).rem_euclid(COUNTER_MODULUS)
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// The longest stretch of new samples without gap, as indices of `new`.
fn longest(new: &[usize], time_s: &[f64], period_s: f64) -> Range<usize> {
    let gap = |k: &usize| time_s[new[*k]] - time_s[new[*k - 1]] > GAP_RATIO * period_s;
    let mut longest = 0..0;
    let mut from = 0;
    for to in (1..new.len()).filter(gap).chain([new.len()]) {
        if to - from > longest.len() {
            longest = from..to;
        }
        from = to;
    }
    longest
}

fn notes(new: &[usize], kept: &[usize], rows: usize, lost: f64) -> (Vec<String>, Vec<Exclusion>) {
    let mut flags = Vec::new();
    let mut excluded = Vec::new();
    let mut leave = |count: usize, of: &str, reason: &str| {
        if count > 0 {
            excluded.push(Exclusion { count, of: of.to_owned(), reason: reason.to_owned() });
        }
    };
    leave(rows.saturating_sub(new.len() + 1), "rows", "the counter shows the sample of the row before");
    leave(new.len() - kept.len(), "samples", "beyond a gap of the message counter");
    if kept.len() < new.len() {
        flags.push(format!("gap: the longest stretch holds {} of {} samples", kept.len(), new.len()));
    }
    if lost > 0.0 {
        flags.push(format!("{lost:.0} messages missing"));
    }
    (flags, excluded)
}
