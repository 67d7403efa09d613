//! From rows to the response of the current to the torque command.

use std::ops::Range;

use analysis::frf::{Frf, Line};
use analysis::periodic::{self, Channel, Windows};

use super::plan::{SETTLE_S, WINDOW_S};
use crate::axis::{AxisLimits, says_limited};
use crate::case::Case;
use crate::excitation::Signal;
use crate::log::Window;

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// Room for rounding between events and rows.
const ROUNDING_S: f64 = 1e-5;

/// Why a stretch is left out.
pub(super) const LIMITED: &str = "saturation: torque at its limit, or an internal limit of the drive active";

/// Columns of an axis.
pub(super) struct Columns<'a> {
    pub(super) time_s: &'a [f64],
    pub(super) excitation: &'a [f64],
    pub(super) torque_nm: &'a [f64],
    pub(super) current_a: &'a [f64],
    /// Where it is logged.
    statusword: Option<&'a [f64]>,
}

impl<'a> Columns<'a> {
    /// Those of the point, or which is missing or holds what is no number.
    pub(super) fn new(axis: &str, window: &'a Window) -> Result<Self, String> {
        let topic = format!("/{axis}");
        let rows = window.topic(&topic)?;
        let column = |name: &str| rows.finite_channel(name);
        Ok(Self {
            time_s: &rows.time_s,
            excitation: column("excitation")?,
            torque_nm: column("torque_command_nm")?,
            current_a: column("current_a")?,
            statusword: rows.column("statusword"),
        })
    }

    /// Whether the drive could not do what it was told somewhere in these rows: what it shows then is its limit.
    pub(super) fn is_limited(&self, rows: Range<usize>, limits: &AxisLimits) -> bool {
        let told = self.statusword.is_some_and(|words| says_limited(&words[rows.clone()]));
        told || self.torque_nm[rows].iter().any(|torque| limits.is_saturated(*torque))
    }

    /// What was added in these rows, peak to peak in A, which are the volts of a level.
    pub(super) fn level_v(
        &self,
        rows: impl Iterator<Item = Range<usize>>,
        limits: &AxisLimits,
    ) -> Option<f64> {
        let nm_per_a = limits.torque_constant_nm_per_a?;
        let added = rows.flat_map(|rows| self.excitation[rows].iter().copied());
        let (low, high) = added.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        (high >= low).then(|| (high - low) / nm_per_a)
    }
}

/// Lines that count, and how many do not.
pub(super) struct Response {
    pub(super) lines: Frf,
    pub(super) noisy: usize,
    pub(super) windows: usize,
    /// Windows that are left out because the drive was at a limit.
    pub(super) limited: usize,
    /// Peak to peak of what was added in the windows, V.
    pub(super) level_v: Option<f64>,
}

/// Response of current × torque constant to the torque that was sent, from every `every`-th row: those in which a
/// computer of that rate commands.
pub(super) fn response(
    case: &Case,
    window: &Window,
    limits: &AxisLimits,
    every: usize,
) -> Result<Response, String> {
    let columns = Columns::new(&case.axis, window)?;
    let span = window.segments.first().ok_or("the excitation did not begin")?;
    let first = columns.time_s.partition_point(|t| *t < span.start_s - ROUNDING_S);
    let last = columns.time_s.partition_point(|t| *t < span.end_s - ROUNDING_S);
    let first = first + phase(&columns.excitation[first..last.max(first)], every);
    let take = |column: &[f64]| -> Vec<f64> {
        column[first..last.max(first)].iter().step_by(every).copied().collect()
    };
    let rate_hz = limits.loop_rate_hz / every as f64;
    let nm_per_a = limits.torque_constant_nm_per_a.unwrap_or(1.0);
    let length = (WINDOW_S * rate_hz).round() as usize;
    // All rows of a window, those between two commands too.
    let rows = |start: usize| first + start * every..(first + (start + length) * every).min(last);
    let (limited, starts): (Vec<usize>, Vec<usize>) = whole(&take(columns.time_s), rate_hz)
        .into_iter()
        .partition(|&start| columns.is_limited(rows(start), limits));
    if starts.len() < 2 {
        let lost = match limited.len() {
            0 => String::new(),
            n => format!(", and {n} that are left out ({LIMITED})"),
        };
        return Err(format!("the record holds {} whole windows{lost}, at least 2 are needed", starts.len()));
    }
    let level_v = columns.level_v(starts.iter().map(|&start| rows(start)), limits);
    let windows = Windows { sample_rate_hz: rate_hz, length, starts };
    let shown: Vec<f64> = take(columns.current_a).iter().map(|a| a * nm_per_a).collect();
    let sent = take(columns.torque_nm);
    let channels = [Channel { name: "torque", samples: &sent }, Channel { name: "current", samples: &shown }];
    let grid = grid_hz(case);
    let z = periodic::transfer(&windows, &grid, &take(columns.excitation), &channels, &[]);
    let z = z.map_err(|e| e.to_string())?;
    let all = periodic::errors_in_variables(&grid, &z[0], &z[1]).map_err(|e| e.to_string())?;
    let (lines, noisy): (Frf, Frf) = all.into_iter().partition(|l| snr_db(l) >= LEAST_SNR_DB);
    let noisy = noisy.len();
    let limited = limited.len();
    Ok(Response { lines, noisy, windows: windows.starts.len(), limited, level_v })
}

/// Offset of the rows in which the command changes, among `every`; 0 if it never does.
fn phase(excitation: &[f64], every: usize) -> usize {
    let mut changes = vec![0_usize; every.max(1)];
    for k in 1..excitation.len() {
        changes[k % every] += usize::from(excitation[k] != excitation[k - 1]);
    }
    let most = changes.iter().copied().max().unwrap_or(0);
    changes.iter().position(|c| *c == most).unwrap_or(0)
}

/// Starts of the windows without a missing row.
fn whole(time_s: &[f64], rate_hz: f64) -> Vec<usize> {
    let length = (WINDOW_S * rate_hz).round() as usize;
    let first = (SETTLE_S * rate_hz).round() as usize;
    let lasts_s = (length - 1) as f64 / rate_hz;
    (first..time_s.len())
        .step_by(length)
        .filter(|start| start + length <= time_s.len())
        .filter(|start| (time_s[start + length - 1] - time_s[*start] - lasts_s).abs() < 0.5 / rate_hz)
        .collect()
}

fn grid_hz(case: &Case) -> Vec<f64> {
    match case.excitations.first().map(|e| &e.signal) {
        Some(Signal::Multisine { lines, .. }) => lines.iter().map(|l| l.frequency_hz).collect(),
        _ => Vec::new(),
    }
}

/// Signal to noise of a line's mean.
fn snr_db(line: &Line) -> f64 {
    -20.0 * (2.0_f64.sqrt() * line.relative_sd()).log10()
}
