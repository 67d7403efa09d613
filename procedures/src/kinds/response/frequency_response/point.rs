//! One point: a record becomes responses, lines that say something are told from others and drawn, all points conclude.

use analysis::frf::{DB_PER_NEPER, Frf, Line, unwrapped_rad};
use analysis::margins::Margins;

use super::coupling::{self, Coupling};
use super::{Keys, Response, loops, plant};
use crate::axis::{Axes, AxisLimits};
use crate::case::Case;
use crate::kinds::response::excited::{self, Channel, ELEVATION, Measured, conditions};
use crate::kinds::response::{coherence_panel, phase_panel};
use crate::log::Window;
use crate::measurement::{Conclusion, Condition, Exclusion, Measurement, PointResult, Reduced};
use crate::quantity::QuantityKind as Q;
use crate::reason::{Reason, ResponseReason};
use crate::trace::{Circle, Plot, Scale, Series, Style};

/// Everything about a point that its measurements share.
pub(super) struct Point<'a> {
    pub(super) case: &'a Case,
    pub(super) limits: &'a AxisLimits,
    pub(super) measured: Measured,
    pub(super) conditions: Vec<Condition>,
    evidence: Vec<crate::measurement::Evidence>,
    /// Whether the plant differs from place to place of the strokes: that of a gimbal's inner axis follows its own angle.
    pub(super) varies: bool,
}

/// What a point hands on for what is said over several points.
#[derive(Default)]
pub(super) struct Kept {
    pub(super) coupling: Option<Coupling>,
    /// Lines of torque to rate, where points differ in the gains of the loop around it.
    pub(super) plant: Vec<Line>,
}

pub(super) fn analyse(keys: &Keys, case: &Case, window: &Window, axes: &Axes) -> PointResult {
    let mut result = PointResult::of(case);
    match read(keys, case, window, axes) {
        Ok(point) => {
            result.excluded = point.measured.excluded.clone();
            let mut kept = Kept::default();
            for response in &keys.responses {
                point.evaluate(*response, &mut result, &mut kept);
            }
            result.reduced = Reduced::to(kept);
        }
        Err(reason) => {
            result.measurements = keys
                .responses
                .iter()
                .flat_map(|r| r.measurands())
                .map(|name| without(name, case, &reason))
                .collect();
            result.inconclusive = Some(reason);
        }
    }
    result
}

/// A measurand of a point without a record that can be read.
fn without(name: &str, case: &Case, reason: &Reason) -> Measurement {
    let kind = super::MEASURANDS.iter().find(|m| m.name == name).map_or(Q::Ratio, |m| m.kind);
    Measurement {
        point: Some(case.point.clone()),
        conditions: conditions(case, None, None),
        ..Measurement::inconclusive(name, &case.axis, kind, "frequency-response/1", reason)
    }
}

fn read<'a>(keys: &Keys, case: &'a Case, window: &Window, axes: &'a Axes) -> Result<Point<'a>, Reason> {
    let reading = excited::read(&keys.excited, case, window, axes)?;
    let limits = axes.limits(&case.axis)?;
    let conditions = conditions(case, reading.elevation_rad, Some(&reading.measured));
    let varies = axes.gimbal_index(&case.axis) == Some(1);
    Ok(Point { case, limits, measured: reading.measured, conditions, evidence: reading.evidence, varies })
}

impl Point<'_> {
    fn evaluate(&self, response: Response, result: &mut PointResult, kept: &mut Kept) {
        match response {
            Response::VelocityLoop => loops::evaluate_velocity(self, result),
            Response::TrackLoop => loops::evaluate_track(self, result),
            Response::CrossAxis => kept.coupling = coupling::evaluate(self, result),
            Response::Plant => kept.plant = plant::evaluate_plant(self, result),
            Response::CurrentLoop => loops::evaluate_current(self, result),
            Response::Coaxiality => coupling::evaluate_coaxiality(self, result),
            Response::TorqueAngle => plant::evaluate_angle(self, result),
            Response::VelocityPosition => loops::evaluate_closed(self, result),
        }
    }

    /// A response with its lines judged.
    pub(super) fn response(&self, from: Channel, to: Channel) -> Result<Judged, Reason> {
        let lines = self.measured.response(from, to)?;
        Ok(judge(lines, &self.measured, self.limits))
    }

    /// A response with its lines judged, where friction has no part in it.
    pub(super) fn response_while_holding(&self, from: Channel, to: Channel) -> Result<Judged, Reason> {
        let lines = self.measured.response(from, to)?;
        Ok(judge_noise(lines))
    }

    /// The point's name, fit for an id.
    pub(super) fn slug(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '.') { c } else { '-' };
        self.case.point.chars().map(plain).collect()
    }

    /// A measurement of this point.
    pub(super) fn measurement(&self, measurement: Measurement) -> Measurement {
        let mut flags = measurement.flags.clone();
        let state = if self.measured.slides { "sliding" } else { "presliding" };
        flags.push(format!("{state}, {} windows", self.measured.windows));
        Measurement {
            point: Some(self.case.point.clone()),
            conditions: self.conditions.clone(),
            evidence: self.evidence.clone(),
            flags,
            ..measurement
        }
    }
}

/// Below this signal to noise of its mean a line says nothing.
const LEAST_SNR_DB: f64 = 20.0;
/// In presliding lines below this are those of the contact, not of the axis (director.md, 4.2), at least.
const PRESLIDING_HZ: f64 = 7.0;
/// Least frequency in presliding, as a multiple of the frequency at which inertia and bristles resonate.
const PRESLIDING_RATIO: f64 = 5.0;

/// Lines that count, and those that stay visible only.
#[derive(Clone, Debug, Default)]
pub(in crate::kinds) struct Judged {
    pub(in crate::kinds) lines: Frf,
    pub(in crate::kinds) hollow: Frf,
    pub(in crate::kinds) excluded: Vec<Exclusion>,
    /// Highest frequency that presliding spoils; none if the axis slid.
    pub(in crate::kinds) presliding_below_hz: Option<f64>,
}

/// Frequency below which a contact that sticks shows itself instead of the axis.
pub(super) fn presliding_hz(limits: &AxisLimits) -> f64 {
    let resonance = (limits.expected_presliding_stiffness_nm_per_rad / limits.inertia_kg_m2).sqrt();
    (PRESLIDING_RATIO * resonance / std::f64::consts::TAU).max(PRESLIDING_HZ)
}

/// Judges the lines of a response.
pub(super) fn judge(lines: Frf, measured: &Measured, limits: &AxisLimits) -> Judged {
    if measured.slides {
        return judge_noise(lines);
    }
    let corner_hz = presliding_hz(limits);
    let (sticking, others): (Frf, Frf) = lines.into_iter().partition(|l| l.frequency_hz < corner_hz);
    let mut judged = judge_noise(others);
    judged.presliding_below_hz = Some(corner_hz);
    if !sticking.is_empty() {
        let reason = presliding(measured, corner_hz).to_string();
        judged.excluded.insert(0, Exclusion { count: sticking.len(), of: "lines".to_owned(), reason });
        judged.hollow.splice(0..0, sticking);
    }
    judged
}

/// Judges lines by their noise alone.
pub(in crate::kinds) fn judge_noise(lines: Frf) -> Judged {
    let (lines, hollow): (Frf, Frf) = lines.into_iter().partition(|l| snr_db(l) >= LEAST_SNR_DB);
    let reason = format!("signal to noise below {LEAST_SNR_DB} dB");
    let noisy = Exclusion { count: hollow.len(), of: "lines".to_owned(), reason };
    let excluded = if hollow.is_empty() { Vec::new() } else { vec![noisy] };
    Judged { lines, hollow, excluded, presliding_below_hz: None }
}

/// Real degrees of freedom of a number that all lines have a part in: harmonic mean, few of them anywhere count.
pub(super) fn freedom(lines: &[Line]) -> f64 {
    2.0 * lines.len() as f64 / lines.iter().map(|l| 1.0 / l.dof.max(0.5)).sum::<f64>()
}

/// Why presliding lines do not count.
pub(super) fn presliding(measured: &Measured, corner_hz: f64) -> ResponseReason {
    ResponseReason::Presliding { mean_rad_per_s: measured.mean_rate_rad_per_s, corner_hz }
}

/// Signal to noise of a line's mean.
fn snr_db(line: &Line) -> f64 {
    -20.0 * (2.0_f64.sqrt() * line.relative_sd()).log10()
}

pub(super) fn conclude(keys: &Keys, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
    let mut measurements: Vec<Measurement> = points.iter().flat_map(|p| p.measurements.clone()).collect();
    let mut plots: Vec<Plot> = points.iter().flat_map(|p| p.plots.clone()).collect();
    let loops = [
        (Response::VelocityLoop, "velocity-bandwidth", "Bandwidth of the velocity loop over elevation"),
        (Response::VelocityLoop, "velocity-gain-margin", "Gain margin of the velocity loop over elevation"),
        (Response::VelocityLoop, "velocity-phase-margin", "Phase margin of the velocity loop over elevation"),
        (Response::TrackLoop, "track-bandwidth", "Bandwidth of the coarse track loop over elevation"),
        (Response::TrackLoop, "track-gain-margin", "Gain margin of the coarse track loop over elevation"),
        (Response::TrackLoop, "track-phase-margin", "Phase margin of the coarse track loop over elevation"),
    ];
    let asked = loops.into_iter().filter(|(response, ..)| keys.asks_for(*response));
    plots.extend(asked.filter_map(|(_, measurand, title)| plot_over_elevation(measurand, title, points)));
    if keys.asks_for(Response::CrossAxis) {
        plots.extend(coupling_plot(points));
        measurements.extend(coupling::conclude(cases, points));
    }
    if keys.asks_for(Response::Plant) && keys.excited.gain_ratios.len() > 1 {
        measurements.extend(plant::departures(cases, points));
        plots.extend(plant::gains_plots(cases, points));
    }
    let remarks =
        cases.first().map(|case| excited::notes(&keys.excited, &case.axis, axes)).unwrap_or_default();
    Conclusion { measurements, plots, remarks, ..Conclusion::default() }
}

/// Expanded uncertainty in pictures: k = 2.
const COVERAGE: f64 = 2.0;
/// A disk of a larger margin leaves the picture (at 2 it is half of the plane).
const LARGEST_DISK: f64 = 1.5;

fn frequency() -> Scale {
    Scale::logarithmic("frequency", "Hz")
}

fn of(lines: &[Line], value: impl Fn(&Line) -> f64) -> Vec<f64> {
    lines.iter().map(value).collect()
}

/// Gain with its band, phase and coherence as panels; lines that do not count stay visible as hollow markers.
pub(in crate::kinds) fn bode(id: &str, title: &str, unit: &str, judged: &Judged) -> Vec<Plot> {
    if judged.lines.is_empty() && judged.hollow.is_empty() {
        return Vec::new();
    }
    let hz = |l: &Line| l.frequency_hz;
    let lines = &judged.lines;
    let hollow = &judged.hollow;
    let degrees: Vec<f64> = unwrapped_rad(lines).iter().map(|p| p.to_degrees()).collect();
    let gain = Plot {
        series: curves(
            (of(lines, hz), of(lines, Line::gain_db)),
            of(lines, |l| COVERAGE * DB_PER_NEPER * l.relative_sd()),
            (of(hollow, hz), of(hollow, Line::gain_db)),
        ),
        ..Plot::new(id, title, frequency(), Scale::linear(format!("gain, dB re {unit}"), "dB"))
    };
    let phase = curves(
        (of(lines, hz), degrees),
        of(lines, |l| COVERAGE * l.relative_sd().to_degrees()),
        (of(hollow, hz), of(hollow, |l| l.phase_rad().to_degrees())),
    );
    let phase = phase_panel(&gain, phase);
    let share = |l: &Line| l.coherence.unwrap_or(1.0);
    let shares = curves((of(lines, hz), of(lines, share)), Vec::new(), (of(hollow, hz), of(hollow, share)));
    let coherence = coherence_panel(&gain, "coherence of one window", shares);
    vec![gain, phase, coherence]
}

type Points = (Vec<f64>, Vec<f64>);

fn curves(counted: Points, band: Vec<f64>, hollow: Points) -> Vec<Series> {
    let mut all = Vec::new();
    let (x, y) = counted;
    if !band.is_empty() {
        all.push(Series::new("U (k = 2)", Style::Band, x.clone(), y.clone()).with_u(band));
    }
    all.push(Series::new("measured", Style::Line, x, y));
    if !hollow.0.is_empty() {
        all.push(Series::new("does not count", Style::Excluded, hollow.0, hollow.1));
    }
    all
}

/// The open loop in the plane, its circles of 95 %, and the disk around −1 that it keeps out of.
pub(in crate::kinds) fn nyquist(id: &str, title: &str, judged: &Judged, margins: &Margins) -> Plot {
    let lines: Vec<Line> = judged.lines.iter().copied().filter(|l| l.value.norm() < 3.0).collect();
    let x = of(&lines, |l| l.value.re);
    let y = of(&lines, |l| l.value.im);
    let circles = of(&lines, |l| l.circle_radius(0.95));
    let mut plot = Plot {
        series: vec![
            Series::new("95 % circles", Style::Circles, x.clone(), y.clone()).with_u(circles),
            Series::new("measured", Style::Line, x, y),
        ],
        ..Plot::nyquist(id, title)
    };
    let label = format!("modulus margin {:.3}", margins.modulus.value);
    plot.circles.push(Circle::guide(&label, [-1.0, 0.0], margins.modulus.value));
    let alpha = margins.disk.alpha.value;
    if alpha < LARGEST_DISK {
        // Crosses the real axis at -1 over the gains that the loop bears: (2 + a)/(2 - a) either way.
        let gain = (2.0 + alpha) / (2.0 - alpha);
        let centre = -0.5 * (gain + 1.0 / gain);
        let radius = 0.5 * (gain - 1.0 / gain);
        plot.circles.push(Circle::guide(format!("disk margin {alpha:.3}"), [centre, 0.0], radius));
    }
    let hollow: Vec<Line> = judged.hollow.iter().copied().filter(|l| l.value.norm() < 3.0).collect();
    if !hollow.is_empty() {
        let x = of(&hollow, |l| l.value.re);
        let y = of(&hollow, |l| l.value.im);
        plot.series.push(Series::new("does not count", Style::Excluded, x, y));
    }
    plot
}

/// A measurand over elevation, with the limits of its requirement.
fn plot_over_elevation(measurand: &str, title: &str, points: &[PointResult]) -> Option<Plot> {
    let all: Vec<&Measurement> =
        points.iter().flat_map(|p| &p.measurements).filter(|m| m.measurand == measurand).collect();
    let kind = all.first()?.kind;
    let at = |m: &Measurement| {
        let elevation = m.conditions.iter().find(|c| c.name == ELEVATION)?;
        Some(Q::Angle.to_display(elevation.achieved.unwrap_or(elevation.requested)))
    };
    let found: Vec<(f64, f64, f64)> = all
        .iter()
        .filter_map(|m| Some((at(m)?, kind.to_display(m.value?), COVERAGE * kind.to_display(m.u))))
        .collect();
    if found.len() < 2 {
        return None;
    }
    let x = found.iter().map(|f| f.0).collect();
    let y = found.iter().map(|f| f.1).collect();
    let series = Series::new("measured, U (k = 2)", Style::Markers, x, y);
    Some(Plot {
        series: vec![series.with_u(found.iter().map(|f| f.2).collect())],
        limits_of: Some(measurand.to_owned()),
        ..Plot::new(
            format!("{measurand}-over-elevation"),
            title,
            Scale::linear("elevation", Q::Angle.display_unit()),
            Scale::linear(measurand, kind.display_unit()),
        )
    })
}

/// Coupling over frequency, all points.
fn coupling_plot(points: &[PointResult]) -> Option<Plot> {
    let series: Vec<Series> = points
        .iter()
        .filter_map(|point| {
            let coupling = coupling::of_point(point)?;
            let percent = coupling.ratio.iter().map(|r| 100.0 * r).collect();
            Some(Series::new(&point.point, Style::Line, coupling.frequency_hz.clone(), percent))
        })
        .collect();
    if series.is_empty() {
        return None;
    }
    let y = Scale::logarithmic("rate of the other axis over rate of this one", "%");
    Some(Plot { series, ..Plot::new("cross-axis", "Coupling between the axes", frequency(), y) })
}
