//! What a procedure says, and the points: the axis rests under position control, torque is added.

use analysis::excitation::{Grid, Kind, Multisine, Offset, Phases, Selection, Spacing};

use crate::axis::{Axes, Axis, AxisLimits};
use crate::case::{Case, Mode, Request, Segment, Then};
use crate::device::Task;
use crate::diagnostic::Diagnostic;
use crate::excitation::{Excitation, Injection, Signal};
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{self, Elevation, limits_of};
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader, name_of, value_of};

pub(super) const FIELDS: &[Field] = &[
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation at which the axis rests."),
    Field::required(
        "points",
        Shape::Texts,
        "Points to run: `fit` (one point per level), `slow`, `onset`, `probe` (needs an oscilloscope), `echo`.",
    ),
    Field::required("level", Shape::Quantities(Q::Voltage), "Peak to peak of the multisines; 1 V is 1 A."),
    Field::default(
        "command-ticks",
        Shape::Integer,
        "4",
        "Ticks from command to command in `slow`: 4 at 4 kHz correspond to a computer at 1 kHz, 5 at 20 \
         kHz to one with 50 us x 5.",
    ),
    Field::default(
        "lines",
        Shape::Integer,
        "120",
        "Approximate number of log-spaced lines, 5 Hz to 1.5 kHz.",
    ),
    Field::default("windows", Shape::Integer, "6", "Windows of 1 s in each point with a multisine."),
    Field::default("step-level", Shape::Quantity(Q::Voltage), "2 V", "Height of the steps; 1 V is 1 A."),
    Field::default("steps", Shape::Integer, "40", "Number of steps in the point `onset`."),
    Field::default("captures", Shape::Integer, "8", "Number of oscilloscope records in the point `probe`."),
];

/// A way to measure, one point or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Fit,
    Slow,
    Onset,
    Probe,
    Echo,
}

const STAGES: [(&str, Stage); 5] = [
    ("fit", Stage::Fit),
    ("slow", Stage::Slow),
    ("onset", Stage::Onset),
    ("probe", Stage::Probe),
    ("echo", Stage::Echo),
];

impl Stage {
    /// Name of the stage, also the label of its segments.
    pub(super) fn name(self) -> &'static str {
        name_of(&STAGES, &self)
    }

    /// Stage of a planned point.
    pub(super) fn of(case: &Case) -> Option<Self> {
        value_of(&STAGES, &case.segments.last()?.label)
    }

    /// What the point itself yields; differences between points come later.
    pub(super) fn measurands(self) -> &'static [&'static str] {
        match self {
            Self::Fit => &[super::ROUND_TRIP, super::LAG, super::HOLD],
            Self::Slow => &[],
            Self::Onset => &[super::BY_ONSET, super::JITTER],
            Self::Probe => &[super::OUT],
            Self::Echo => &[super::ECHO],
        }
    }
}

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) elevation_rad: f64,
    pub(super) stages: Vec<Stage>,
    pub(super) levels_v: Vec<f64>,
    /// Ticks from one command of the slow computer to the next.
    pub(super) command_ticks: u32,
    pub(super) lines: u32,
    pub(super) windows: u32,
    pub(super) step_v: f64,
    pub(super) steps: u32,
    pub(super) captures: u32,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevation_rad = table.quantity("elevation");
        let stages = table.named_values("points", "point", &STAGES);
        let levels_v = table.quantities("level");
        let command_ticks = table.count("command-ticks", 2);
        let lines = table.count("lines", 10);
        let windows = table.count("windows", 3);
        let step_v = table.positive("step-level");
        let steps = table.count("steps", 4);
        let captures = table.count("captures", 1);
        let levels_v = levels_v?;
        let lines = lines?;
        let windows = windows?;
        table.check_steps("level", &[levels_v.len(), lines as usize]);
        if levels_v.iter().any(|level| *level <= 0.0) {
            table.mistake("level", "give a positive level", None);
        }
        Some(Self {
            elevation_rad: elevation_rad?,
            stages: stages?,
            levels_v,
            command_ticks: command_ticks?,
            lines,
            windows,
            step_v: step_v?,
            steps: steps?,
            captures: captures?,
        })
    }
}

impl Keys {
    pub(super) fn has(&self, stage: Stage) -> bool {
        self.stages.contains(&stage)
    }
}

/// Window of a multisine.
pub(super) const WINDOW_S: f64 = 1.0;
/// The loop has settled and the signal is at its full size after this.
pub(super) const SETTLE_S: f64 = 1.0;
/// Lines at the loop rate.
const BAND_HZ: [f64; 2] = [5.0, 1500.0];
/// Highest line, as a part of the rate of the commands.
const HIGHEST_RATIO: f64 = 0.4;
/// Time between two steps.
pub(super) const STEP_S: f64 = 0.05;
const FADE_S: f64 = 0.5;
const ECHO_S: f64 = 1.5;
const CAPTURE_RATE_HZ: f64 = 200e3;
const CAPTURE_S: f64 = 0.02;
/// An oscilloscope that has not triggered by then never will.
const CAPTURE_LIMIT_S: f64 = 5.0;
/// Condition of a point.
const LEVEL: &str = "level";

/// The points of an axis.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = limits_of(axis, axes)?;
    let Some(nm_per_a) = limits.torque_constant_nm_per_a.filter(|_| limits.loop_rate_hz > 0.0) else {
        let message = format!("axis `{axis}`: loop rate and torque constant must be known");
        return Err(vec![Diagnostic::new(message)]);
    };
    let elevation = Elevation::of(axis, axes).axis();
    let beyond = elevation.and_then(|own| positioned::beyond_travel("elevation", keys.elevation_rad, own));
    let mut mistakes: Vec<Diagnostic> = beyond.into_iter().collect();
    let mut cases = Vec::new();
    for stage in &keys.stages {
        let levels: &[f64] = match stage {
            Stage::Fit => &keys.levels_v,
            Stage::Slow => &keys.levels_v[keys.levels_v.len().saturating_sub(1)..],
            Stage::Onset | Stage::Probe | Stage::Echo => &[keys.step_v],
        };
        for &level_v in levels {
            match case(keys, *stage, axis, limits, [level_v, nm_per_a]) {
                Ok(case) => cases.push(rested(keys, case, axes)),
                Err(mistake) => mistakes.push(mistake),
            }
        }
    }
    if mistakes.is_empty() { Ok(cases) } else { Err(mistakes) }
}

/// The case with everything at rest at its elevation.
fn rested(keys: &Keys, case: Case, axes: &Axes) -> Case {
    let elevation = Elevation::of(&case.axis, axes).axis().map(|axis| axis.name.as_str());
    let pose = |own: &Axis| {
        let [low, high] = own.limits.soft_limits_rad;
        match elevation == Some(own.name.as_str()) {
            true => keys.elevation_rad.clamp(low.min(high), high),
            false => positioned::rest_rad(&own.limits),
        }
    };
    Case { start_pose_rad: axes.pose(pose), ..case }
}

fn case(
    keys: &Keys,
    stage: Stage,
    axis: &str,
    limits: &AxisLimits,
    [level_v, nm_per_a]: [f64; 2],
) -> Result<Case, Diagnostic> {
    let (excitations, mut segments) = match stage {
        Stage::Fit | Stage::Slow => {
            let every_ticks = if stage == Stage::Slow { keys.command_ticks } else { 1 };
            let signal = multisine(keys, limits.loop_rate_hz / f64::from(every_ticks), level_v * nm_per_a)?;
            let excitation = Excitation { every_ticks, fade_s: FADE_S, ..torque(signal) };
            let lasts_s = SETTLE_S + f64::from(keys.windows) * WINDOW_S;
            (vec![excitation], vec![excited(stage, lasts_s)])
        }
        Stage::Onset => {
            let lasts_s = f64::from(keys.steps + 1) * STEP_S;
            (vec![square(level_v * nm_per_a)], vec![excited(stage, lasts_s)])
        }
        Stage::Probe => {
            let task = Task::Capture {
                axis: axis.to_owned(),
                sample_rate_hz: CAPTURE_RATE_HZ,
                duration_s: CAPTURE_S,
            };
            let one = Segment { task: Some(task), ..excited(stage, CAPTURE_LIMIT_S) };
            (vec![square(level_v * nm_per_a)], vec![one; keys.captures as usize])
        }
        Stage::Echo => (Vec::new(), vec![Segment::hold(stage.name(), Mode::Position, ECHO_S)]),
    };
    if let Some(last) = segments.last_mut() {
        last.then = Then::Stop;
    }
    let requested = Request { name: LEVEL.to_owned(), value: level_v, kind: Q::Voltage };
    Ok(Case {
        point: match stage {
            Stage::Echo => stage.name().to_owned(),
            _ => format!("{}, level={}", stage.name(), Q::Voltage.format(level_v)),
        },
        axis: axis.to_owned(),
        requested: if stage == Stage::Echo { Vec::new() } else { vec![requested] },
        segments,
        excitations,
        logs_payload_fully: stage == Stage::Echo,
        ..Case::default()
    })
}

fn excited(stage: Stage, at_most_s: f64) -> Segment {
    Segment { excited: Some(0), ..Segment::hold(stage.name(), Mode::Position, at_most_s) }
}

fn torque(signal: Signal) -> Excitation {
    Excitation { into: Injection::Torque, signal, fade_s: 0.0, every_ticks: 1 }
}

fn square(amplitude: f64) -> Excitation {
    torque(Signal::Square { amplitude, period_s: 2.0 * STEP_S })
}

fn multisine(keys: &Keys, rate_hz: f64, peak_to_peak_nm: f64) -> Result<Signal, Diagnostic> {
    let wanted = Selection {
        band_hz: BAND_HZ[0]..=BAND_HZ[1].min(HIGHEST_RATIO * rate_hz),
        kind: Kind::Full,
        spacing: Spacing::Logarithmic(keys.lines as usize),
        forbidden_hz: Vec::new(),
    };
    let refused = |error: analysis::excitation::ExcitationError| Diagnostic::new(error.to_string());
    let grid = Grid::new(WINDOW_S, Offset::Zero, rate_hz, &wanted, &mut || 0.0).map_err(refused)?;
    let multisine = Multisine::new(&grid, &|_| 1.0, Phases::Schroeder)
        .and_then(|m| m.scaled_to(peak_to_peak_nm))
        .map_err(refused)?;
    Ok(Signal::Multisine { period_s: multisine.period_s, lines: multisine.lines })
}
