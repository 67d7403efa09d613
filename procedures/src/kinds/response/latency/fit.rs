//! Transport by fit: the response of the current as a sampled loop, so that lag and hold come out apart; by a current probe
//! for the way out alone.

use std::ops::Range;

use analysis::delay::Step;
use analysis::estimate::Estimate;
use analysis::frf::{Frf, Line, unwrapped_rad};
use analysis::lag::{LagFit, Order, Settings, current_loop, sampled_response};
use analysis::periodic::{self, Channel, Windows};

use super::conclude::{evidence, measurement, us};
use super::onset::{cut, onsets};
use super::plan::{SETTLE_S, WINDOW_S};
use super::{HOLD, LAG, OUT, ROUND_TRIP, Value};
use crate::axis::{AxisLimits, says_limited};
use crate::case::Case;
use crate::excitation::Signal;
use crate::log::Window;
use crate::measurement::{Exclusion, Measurement, PointResult, Reduced};
use crate::reason::{Reason, ResponseReason};
use crate::trace::{MAX_POINTS, Plot, Scale, Series, Style};

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// Room for rounding between events and rows.
const ROUNDING_S: f64 = 1e-5;

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
    pub(super) fn new(axis: &str, window: &'a Window) -> Result<Self, Reason> {
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
) -> Result<Response, Reason> {
    let columns = Columns::new(&case.axis, window)?;
    let span = window.segments.first().ok_or(ResponseReason::NotBegun)?;
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
        return Err(ResponseReason::FewWholeWindows { windows: starts.len(), limited: limited.len() }.into());
    }
    let level_v = columns.level_v(starts.iter().map(|&start| rows(start)), limits);
    let windows = Windows { sample_rate_hz: rate_hz, length, starts };
    let shown: Vec<f64> = take(columns.current_a).iter().map(|a| a * nm_per_a).collect();
    let sent = take(columns.torque_nm);
    let channels = [Channel { name: "torque", samples: &sent }, Channel { name: "current", samples: &shown }];
    let grid = grid_hz(case);
    let z = periodic::transfer(&windows, &grid, &take(columns.excitation), &channels, &[]);
    let z = z?;
    let all = periodic::errors_in_variables(&grid, &z[0], &z[1])?;
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

/// No command answers later than this.
pub(super) const MOST_DELAY_S: f64 = 0.02;
/// Below this loop rate a corner around 1 kHz cannot be told from a delay.
const LEAST_LOOP_RATE_HZ: f64 = 4000.0;

/// What a point at the loop rate says of the loop.
pub(super) struct Loop {
    pub(super) transport_s: Value,
    pub(super) corner_hz: Value,
    /// Lag of the loop, s.
    pub(super) lag_s: f64,
    pub(super) described: Described,
}

/// Which lag describes the response of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Described {
    FirstOrder,
    SecondOrder,
    ByNeither,
}

/// The response to commands at a part of the loop rate.
pub(super) struct SlowResponse {
    pub(super) lines: Frf,
    /// Period of the commands.
    pub(super) period_s: f64,
}

/// A point at the loop rate.
pub(super) fn fit(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, Reason> {
    let rate_hz = limits.loop_rate_hz;
    if rate_hz < LEAST_LOOP_RATE_HZ {
        return Err(ResponseReason::SlowForLag { rate_hz, least_hz: LEAST_LOOP_RATE_HZ }.into());
    }
    let found = response(case, window, limits, 1)?;
    let (fit, flags, u_s) = loop_of(&found.lines, 1.0 / rate_hz)?;
    let n = found.lines.len();
    let estimate = |value, u| Estimate { value, u, dof: f64::INFINITY, n };
    let lag_u_s = fit.lag_s * fit.corner_u_hz / fit.corner_hz;
    let evidence =
        evidence(window, &format!("/{}", case.axis), &["excitation", "torque_command_nm", "current_a"]);
    let with = |name: &str, estimate: Estimate, flags: Vec<String>| Measurement {
        evidence: evidence.clone(),
        ..measurement(name, case, found.level_v, estimate, flags)
    };
    Ok(PointResult {
        point: case.point.clone(),
        measurements: vec![
            with(ROUND_TRIP, estimate(fit.transport_s, u_s), [totals(&fit, &found), flags].concat()),
            with(LAG, estimate(fit.lag_s, lag_u_s), vec![corner(&fit)]),
            with(HOLD, estimate(fit.hold_s, 0.0), vec!["half a period, exact".to_owned()]),
        ],
        plots: vec![fit_plot(case, &found.lines, &fit, 1.0 / rate_hz)],
        reduced: Reduced::to(Loop {
            transport_s: Value { value: fit.transport_s, u: u_s },
            corner_hz: Value { value: fit.corner_hz, u: fit.corner_u_hz },
            lag_s: fit.lag_s,
            described: match (fit.misfit, fit.damping) {
                (true, _) => Described::ByNeither,
                (false, Some(_)) => Described::SecondOrder,
                (false, None) => Described::FirstOrder,
            },
        }),
        excluded: excluded(&found),
        ..PointResult::default()
    })
}

/// The loop, remarks about it, and the standard uncertainty of its transport. A loop that is none of first order is taken
/// as one of second order where that is clearly better; elsewhere the two differ in the transport by its uncertainty.
fn loop_of(lines: &[Line], period_s: f64) -> Result<(LagFit, Vec<String>, f64), Reason> {
    let settings = Settings { period_s, order: Order::First, most_delay_s: MOST_DELAY_S };
    let first = current_loop(lines, &settings)?;
    if !first.misfit {
        return Ok((first, Vec::new(), first.transport_u_s));
    }
    let second = current_loop(lines, &Settings { order: Order::Second, ..settings });
    match second {
        Ok(second) if !second.misfit && second.is_clearly_better_than(&first) => {
            Ok((second, vec!["current loop of second order".to_owned()], second.transport_u_s))
        }
        other => {
            let apart_s = other.map_or(first.lag_s, |second| (second.transport_s - first.transport_s).abs());
            let residuals = first.goodness.flag().unwrap_or_default();
            let flag = format!("a first-order lag does not describe the loop: {residuals}");
            Ok((first, vec![flag], first.transport_u_s.hypot(apart_s)))
        }
    }
}

fn totals(fit: &LagFit, found: &Response) -> Vec<String> {
    let lagged_s = fit.transport_s + fit.lag_s;
    vec![
        format!("with lag {:.1} us, with lag and hold {:.1} us", us(lagged_s), us(lagged_s + fit.hold_s)),
        format!("correlation with the corner {:.2}", fit.correlation),
        format!("{} lines, {} windows", found.lines.len(), found.windows),
    ]
}

fn corner(fit: &LagFit) -> String {
    format!("corner {:.1} Hz, gain {:.4}", fit.corner_hz, fit.gain)
}

fn excluded(found: &Response) -> Vec<Exclusion> {
    let exclusion = |count: usize, of: &str, reason: String| Exclusion { count, of: of.to_owned(), reason };
    let all = [
        exclusion(found.noisy, "lines", "signal to noise below 20 dB".to_owned()),
        exclusion(found.limited, "windows", ResponseReason::Limited.to_string()),
    ];
    all.into_iter().filter(|e| e.count > 0).collect()
}

/// Phase over frequency, measured and fitted.
fn fit_plot(case: &Case, lines: &[Line], fit: &LagFit, period_s: f64) -> Plot {
    let hz: Vec<f64> = lines.iter().map(|l| l.frequency_hz).collect();
    let damping = fit.damping.map(|[zeta, _]| zeta);
    let model = |l: &Line| {
        let value = sampled_response(l.frequency_hz, period_s, fit.corner_hz, damping, fit.transport_s);
        Line::exact(l.frequency_hz, value)
    };
    let degrees = |lines: &[Line]| unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect::<Vec<_>>();
    let modelled: Vec<Line> = lines.iter().map(model).collect();
    let slug = case.point.replace([',', '=', ' '], "-");
    Plot {
        series: vec![
            Series::new("measured", Style::Markers, hz.clone(), degrees(lines)),
            Series::new("lag, hold and transport", Style::Fit, hz, degrees(&modelled)),
        ],
        ..Plot::new(
            format!("phase-{slug}"),
            format!("Current over torque command: phase, {}", case.point),
            Scale::logarithmic("frequency", "Hz"),
            Scale::linear("phase", "deg"),
        )
    }
}

/// A point with commands at a part of the loop rate: its lines, for when the corner is known.
pub(super) fn slow(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, Reason> {
    let every = case.excitations.first().map_or(1, |e| e.every_ticks.max(1));
    let found = response(case, window, limits, every as usize)?;
    let excluded = excluded(&found);
    let period_s = f64::from(every) / limits.loop_rate_hz;
    Ok(PointResult {
        reduced: Reduced::to(SlowResponse { lines: found.lines, period_s }),
        excluded,
        ..PointResult::of(case)
    })
}

const TOPIC: &str = "/scope";

/// Time from the command to the current, by a probe at the motor.
pub(super) struct WayOut {
    pub(super) delay_s: Value,
}

pub(super) fn probe(case: &Case, window: &Window, limits: &AxisLimits) -> Result<PointResult, Reason> {
    let level_v = level_v(case, window, limits)?;
    let rows = window.rows(TOPIC).filter(|rows| !rows.time_s.is_empty());
    let rows = rows.ok_or(ResponseReason::NoOscilloscope { topic: TOPIC })?;
    let column = |name: &str| rows.channel(name);
    let [time, current, sync] = [column("time_s")?, column("current_a")?, column("sync_v")?];
    let records = records(time);
    let steps: Vec<Step> = records
        .iter()
        .filter_map(|r| step(&time[r.clone()], &current[r.clone()], &sync[r.clone()]))
        .filter_map(cut)
        .collect();
    if steps.is_empty() {
        return Err(ResponseReason::NoEdges { records: records.len() }.into());
    }
    let found = onsets(&steps)?;
    // Edge and onset are known to a sample of the oscilloscope.
    let period_s = (time[records[0].end - 1] - time[records[0].start]) / (records[0].len() - 1) as f64;
    let u_s = found.u_s.hypot(period_s / 12.0_f64.sqrt());
    let estimate = Estimate { value: found.delay_s, u: u_s, dof: f64::INFINITY, n: steps.len() };
    let flags = vec![
        format!("time constant {:.1} us at the motor", us(found.time_constant_s)),
        "from the synchronisation signal on: exchange included, unless the signal takes the same one"
            .to_owned(),
    ];
    let mut out = measurement(OUT, case, level_v, estimate, flags);
    out.evidence = evidence(window, TOPIC, &["time_s", "current_a", "sync_v"]);
    Ok(PointResult {
        point: case.point.clone(),
        measurements: vec![out],
        plots: vec![step_plot(&steps[0])],
        reduced: Reduced::to(WayOut { delay_s: Value { value: found.delay_s, u: u_s } }),
        ..PointResult::default()
    })
}

/// Height of the steps that the loop sent while the oscilloscope was ready, V; `None` where the log does not hold them.
///
/// # Errors
/// The drive was at a limit meanwhile.
fn level_v(case: &Case, window: &Window, limits: &AxisLimits) -> Result<Option<f64>, Reason> {
    let Ok(columns) = Columns::new(&case.axis, window) else { return Ok(None) };
    let row = |at_s: f64| columns.time_s.partition_point(|t| *t < at_s);
    let spans: Vec<Range<usize>> =
        window.segments.iter().map(|s| row(s.start_s)..row(s.end_s).max(row(s.start_s))).collect();
    match spans.iter().any(|rows| columns.is_limited(rows.clone(), limits)) {
        true => Err(ResponseReason::Limited.into()),
        false => Ok(columns.level_v(spans.into_iter(), limits)),
    }
}

/// Records one after the other: time falls where the next one begins.
fn records(time_s: &[f64]) -> Vec<std::ops::Range<usize>> {
    let inner = (1..time_s.len()).filter(|&k| time_s[k] <= time_s[k - 1]);
    let bounds: Vec<usize> = std::iter::once(0).chain(inner).chain([time_s.len()]).collect();
    bounds.windows(2).map(|b| b[0]..b[1]).filter(|r| r.len() > 1).collect()
}

/// The current since the rising edge of the synchronisation signal.
fn step(time_s: &[f64], current_a: &[f64], sync_v: &[f64]) -> Option<Step> {
    let highest = sync_v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = sync_v.iter().copied().fold(f64::INFINITY, f64::min);
    let level = 0.5 * (highest + lowest);
    let high = (1..sync_v.len()).find(|&k| sync_v[k - 1] < level && sync_v[k] >= level)?;
    let edge_s = 0.5 * (time_s[high - 1] + time_s[high]);
    let since_command_s = time_s.iter().map(|t| t - edge_s).collect();
    Some(Step { since_command_s, value: current_a.to_vec() })
}

fn step_plot(step: &Step) -> Plot {
    let ms: Vec<f64> = step.since_command_s.iter().map(|t| 1e3 * t).collect();
    Plot {
        series: vec![Series::thinned("current probe", Style::Line, [&ms, &step.value], MAX_POINTS)],
        ..Plot::new(
            "probe-step",
            "Current at the motor after a step of the command",
            Scale::linear("time since the command", "ms"),
            Scale::linear("current", "A"),
        )
    }
}
