//! Signals of an excited axis in the log: which windows of them count, how large the excitation is, what repeats with the
//! strokes, and what stands at lines that are not excited.
//!
//! Each turn-round leaves the same transient in the windows that follow it, and strokes between the same ends meet the same
//! cogging. Neither knows of the excitation, but a few dozen windows at regular times do not average it away: it would stay in
//! the response as an error that no scatter shows. So amplitudes over the excitation, Z_w = G + D_c/R_w, are fitted with a
//! D_c for each class c of windows that lie at the same place of a stroke; R_w, the excitation seen from the window's start,
//! turns from window to window, which tells both apart.

use std::ops::Range;

use analysis::frf::C64;
use analysis::periodic::{self, Distortion, LineKind, Windows};

use super::Excited;
use super::course::Course;
use crate::axis::{Axes, AxisLimits, says_limited};
use crate::excitation::Excitation;
use crate::log::{Rows, Window};
use crate::measurement::{Evidence, Exclusion};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};

/// What is read beside the excitation itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::kinds) enum Channel {
    /// Command of the velocity loop less the rate that it was closed on, rad/s.
    Error,
    /// Rate that the velocity loop was closed on, rad/s.
    Rate,
    /// Torque that was sent, N·m.
    Torque,
    /// Torque that the drive shows, from its current, N·m.
    Shown,
    /// Angle of the shaft by the encoder, rad.
    Angle,
    /// Rate of the other axis, rad/s.
    OtherRate,
    /// What the track loop asks of the velocity loop, before the excitation is added, rad/s.
    Asked,
    /// Command of the velocity loop, with the excitation, rad/s.
    Commanded,
}

/// Columns of one point.
pub(in crate::kinds) struct Record<'a> {
    rows: &'a Rows,
    pub(super) time_s: &'a [f64],
    pub(super) excitation: &'a [f64],
    pub(in crate::kinds) angle_rad: &'a [f64],
    pub(in crate::kinds) rate: &'a [f64],
    pub(super) torque_nm: &'a [f64],
    command: &'a [f64],
    asked: Option<&'a [f64]>,
    current_a: &'a [f64],
    /// Status of the drive, where the log has it.
    statusword: Option<&'a [f64]>,
    other: Option<&'a [f64]>,
    torque_constant: f64,
}

impl<'a> Record<'a> {
    /// The columns, or which of them is missing or holds something that is no number.
    pub(in crate::kinds) fn new(axis: &str, window: &'a Window, axes: &Axes) -> Result<Self, Reason> {
        let limits = axes.limits(axis)?;
        let topic = format!("/{axis}");
        let rows = window.topic(&topic)?;
        let column = |name: &str| rows.finite_channel(name);
        let other = axes.gimbal().ok().and_then(|gimbal| gimbal.other(axis));
        let other = other.and_then(|name| window.rows(&format!("/{name}")));
        let other = other.and_then(|rows| rows.column("velocity_feedback_rad_per_s"));
        Ok(Self {
            rows,
            time_s: &rows.time_s,
            excitation: column("excitation")?,
            angle_rad: column("position_rad")?,
            rate: column("velocity_feedback_rad_per_s")?,
            torque_nm: column("torque_command_nm")?,
            command: column("velocity_command_rad_per_s")?,
            asked: rows.column("velocity_setpoint_rad_per_s").filter(|a| a.iter().all(|v| v.is_finite())),
            current_a: column("current_a")?,
            statusword: rows.column("statusword"),
            other: other.filter(|o| o.len() == rows.time_s.len() && o.iter().all(|v| v.is_finite())),
            torque_constant: limits.torque_constant_nm_per_a.unwrap_or(1.0),
        })
    }

    /// Values of a channel in a range of rows.
    pub(super) fn values(&self, channel: Channel, range: std::ops::Range<usize>) -> Option<Vec<f64>> {
        let part = |column: &[f64]| column[range.clone()].to_vec();
        Some(match channel {
            Channel::Error => range.clone().map(|row| self.command[row] - self.rate[row]).collect(),
            Channel::Rate => part(self.rate),
            Channel::Torque => part(self.torque_nm),
            Channel::Shown => part(self.current_a).iter().map(|a| a * self.torque_constant).collect(),
            Channel::Angle => part(self.angle_rad),
            Channel::OtherRate => part(self.other?),
            Channel::Asked => part(self.asked?),
            Channel::Commanded => part(self.command),
        })
    }

    /// Whether the drive was at a limit of its own in any of these rows.
    pub(super) fn is_limited(&self, range: std::ops::Range<usize>) -> bool {
        self.statusword.is_some_and(|words| says_limited(&words[range]))
    }

    /// First row at or after a time.
    pub(super) fn row_at(&self, t_s: f64) -> usize {
        self.rows.range(t_s, f64::INFINITY).start
    }

    /// Where the numbers of the point come from.
    pub(in crate::kinds) fn evidence(&self) -> Vec<Evidence> {
        let (Some(t0), Some(t1)) = (self.time_s.first(), self.time_s.last()) else { return Vec::new() };
        let topic = &self.rows.topic.name;
        let names =
            ["excitation", "velocity_command_rad_per_s", "velocity_feedback_rad_per_s", "torque_command_nm"];
        let channels = names.iter().map(|name| format!("{topic} {name}")).collect();
        vec![Evidence::new(channels, [*t0, *t1])]
    }
}

/// Where a window begins, in which realisation, and with which lines.
pub(super) struct Candidate {
    pub(super) start: usize,
    pub(super) realisation: usize,
    pub(super) lines_hz: Vec<f64>,
    pub(super) place: usize,
}

/// Drops windows with gaps, at the torque limit, or in which the axis turned round.
pub(super) fn usable(
    candidates: Vec<Candidate>,
    record: &Record<'_>,
    rests: bool,
    length: usize,
    limits: &AxisLimits,
    excluded: &mut Vec<Exclusion>,
) -> Vec<Candidate> {
    let mut gaps = 0;
    let mut limited = 0;
    let mut clipped = 0;
    let mut reversed = 0;
    let lasts_s = (length - 1) as f64 / limits.row_rate_hz();
    let kept = candidates.into_iter().filter(|c| {
        let rows = c.start..c.start + length;
        let took_s = record.time_s[rows.end - 1] - record.time_s[rows.start];
        let rate = &record.rate[rows.clone()];
        let turns = !rests && rate.iter().any(|r| r * rate[0] <= 0.0);
        if (took_s - lasts_s).abs() > 0.5 / limits.row_rate_hz() {
            gaps += 1;
        } else if record.is_limited(rows.clone()) {
            clipped += 1;
        } else if record.torque_nm[rows].iter().any(|t| limits.is_saturated(*t)) {
            limited += 1;
        } else if turns {
            reversed += 1;
        } else {
            return true;
        }
        false
    });
    let kept = kept.collect();
    for (count, reason) in [
        (gaps, "cycles were dropped in them"),
        (limited, "the torque was at its limit"),
        (clipped, "the drive was at a limit of its own (bit 11 of its statusword)"),
        (reversed, "the axis reversed, so the contact stuck"),
    ] {
        if count > 0 {
            excluded.push(Exclusion { count, of: "windows".to_owned(), reason: reason.to_owned() });
        }
    }
    kept
}

/// The windows in which the axis slid, where those are most of them; else all, and that it did not.
pub(super) fn sliding(
    kept: Vec<Candidate>,
    keys: &Excited,
    rate: &dyn Fn(&Candidate) -> f64,
    excluded: &mut Vec<Exclusion>,
) -> (Vec<Candidate>, bool) {
    let least = keys.background.sliding_from_rad_per_s;
    let slid = |c: &Candidate| keys.background.velocity_rad_per_s > 0.0 && rate(c) >= least;
    let slow = kept.iter().filter(|c| !slid(c)).count();
    if slow == 0 || 2 * slow > kept.len() || kept.len() < slow + 2 {
        return (kept, slow == 0);
    }
    let reason = format!("the axis slid slower than {}", Q::AngularVelocity.format(least));
    excluded.push(Exclusion { count: slow, of: "windows".to_owned(), reason });
    (kept.into_iter().filter(slid).collect(), true)
}

pub(super) fn why_none(excluded: &[Exclusion]) -> ResponseReason {
    match excluded {
        [] => ResponseReason::TooFewWindows,
        _ => ResponseReason::FewWindowsLeft { excluded: excluded.to_vec() },
    }
}

/// Size of an excitation over the planned one in these rows, by projection on what was planned; a row is the mean over its ticks.
pub(super) fn ratio(
    excitation: &Excitation,
    began_s: f64,
    record: &Record<'_>,
    limits: &AxisLimits,
    rows: Range<usize>,
) -> f64 {
    let ticks = (limits.loop_rate_hz / limits.row_rate_hz()).round().max(1.0);
    let planned = |row: usize| {
        let at =
            |back: u32| excitation.at(record.time_s[row] - began_s - f64::from(back) / limits.loop_rate_hz);
        (0..ticks as u32).map(at).sum::<f64>() / ticks
    };
    let mut both = 0.0;
    let mut own = 0.0;
    for row in rows {
        let planned = planned(row);
        both += planned * record.excitation[row];
        own += planned * planned;
    }
    both / own
}

/// Windows that a class needs.
const LEAST_WINDOWS: usize = 4;
/// Share of the windows' weight that must be left for the response.
const LEAST_LEFT: f64 = 0.3;

/// Windows at the same place of a stroke, by index.
pub(super) fn classes(places: &[usize]) -> Vec<Vec<usize>> {
    let mut names: Vec<usize> = places.to_vec();
    names.sort_unstable();
    names.dedup();
    let windows_of = |name: usize| (0..places.len()).filter(|&w| places[w] == name).collect::<Vec<_>>();
    names.into_iter().map(windows_of).filter(|class| class.len() >= LEAST_WINDOWS).collect()
}

/// Takes D_c/R_w off the amplitudes of a line; `inverse` is 1/R_w. Gives the share of the windows' weight that is left for
/// the response, if both could be told apart.
pub(super) fn take_out(z: &mut [C64], inverse: &[C64], classes: &[Vec<usize>]) -> Option<f64> {
    // Residuals of amplitudes and of a constant on 1/R_w, class by class; windows of no class stay as they are.
    let mut rest_z = z.to_vec();
    let mut rest_one = vec![C64::new(1.0, 0.0); z.len()];
    for class in classes {
        project(&mut rest_z, inverse, class);
        project(&mut rest_one, inverse, class);
    }
    let left: f64 = rest_one.iter().map(C64::norm_sqr).sum();
    if classes.is_empty() || left < LEAST_LEFT * z.len() as f64 {
        return None;
    }
    let response: C64 = rest_one.iter().zip(&rest_z).map(|(one, z)| one.conj() * z).sum::<C64>() / left;
    for class in classes {
        let mut top = C64::new(0.0, 0.0);
        let mut bottom = 0.0;
        for &w in class {
            top += inverse[w].conj() * (z[w] - response);
            bottom += inverse[w].norm_sqr();
        }
        for &w in class {
            z[w] -= inverse[w] * top / bottom;
        }
    }
    Some(left / z.len() as f64)
}

/// Takes off what lies along 1/R_w within a class.
fn project(values: &mut [C64], inverse: &[C64], class: &[usize]) {
    let mut top = C64::new(0.0, 0.0);
    let mut bottom = 0.0;
    for &w in class {
        top += inverse[w].conj() * values[w];
        bottom += inverse[w].norm_sqr();
    }
    for &w in class {
        values[w] -= inverse[w] * top / bottom;
    }
}

/// Fewer lines are no grid.
const FEWEST: usize = 5;

/// Odd and even distortion of torque to rate, where lines are odd multiples of 1/T_w and some are left out.
pub(super) fn distortion(
    windows: &Windows,
    excited_hz: &[f64],
    course: &Course,
    record: &Record<'_>,
    nuisance: &[&[f64]],
) -> Option<Distortion> {
    let orders: Vec<u32> = excited_hz.iter().map(|hz| (hz * course.window_s).round() as u32).collect();
    let odd =
        |(order, hz): (&u32, &f64)| order % 2 == 1 && (f64::from(*order) - hz * course.window_s).abs() < 1e-6;
    if orders.len() < FEWEST || !orders.iter().zip(excited_hz).all(odd) {
        return None;
    }
    let first = *orders.first()?;
    let last = *orders.last()?;
    let kind = |order: u32| match order {
        order if orders.contains(&order) => LineKind::Excited,
        order if order % 2 == 1 => LineKind::Odd,
        _ => LineKind::Even,
    };
    let lines: Vec<(f64, LineKind)> =
        (first..=last).map(|order| (f64::from(order) / course.window_s, kind(order))).collect();
    let grid: Vec<f64> = lines.iter().map(|(hz, _)| *hz).collect();
    let all = 0..record.time_s.len();
    let [torque, rate] = [Channel::Torque, Channel::Rate].map(|c| record.values(c, all.clone()));
    let torque = torque?;
    let rate = rate?;
    let channels = [
        periodic::Channel { name: "torque", samples: &torque },
        periodic::Channel { name: "rate", samples: &rate },
    ];
    let mut spectra: Vec<Vec<Vec<C64>>> = periodic::spectra(windows, &grid, &channels, nuisance).ok()?;
    let rate = spectra.pop()?;
    let torque = spectra.pop()?;
    periodic::fast(&lines, &torque, &rate).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_repeats_is_taken_out_and_the_response_stays() {
        let turn = |w: usize| C64::from_polar(2.0, 0.85 * (w * w) as f64);
        let response = C64::new(0.3, -0.7);
        let [up, down] = [C64::new(5.0, 1.0), C64::new(-4.0, 2.0)];
        let inverse: Vec<C64> = (0..24).map(|w| turn(w).inv()).collect();
        let d = |w: usize| if w.is_multiple_of(2) { up } else { down };
        let mut z: Vec<C64> = (0..24).map(|w| response + d(w) * inverse[w]).collect();
        let classes = classes(&(0..24).map(|w| w % 2).collect::<Vec<_>>());
        assert!(take_out(&mut z, &inverse, &classes).is_some_and(|left| left > 0.8));
        assert!(z.iter().all(|z| (z - response).norm() < 1e-12));
    }

    #[test]
    fn windows_that_all_meet_the_excitation_alike_are_left_alone() {
        let mut z = vec![C64::new(1.0, 0.0); 12];
        let before = z.clone();
        assert_eq!(take_out(&mut z, &[C64::new(0.5, 0.5); 12], &classes(&[0; 12])), None);
        assert_eq!(z, before);
    }

    #[test]
    fn places_with_too_few_windows_are_no_class() {
        assert_eq!(classes(&[0, 0, 0, 1, 1, 1, 1]), [vec![3, 4, 5, 6]]);
    }
}
