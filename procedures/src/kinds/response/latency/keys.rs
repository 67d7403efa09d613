//! What a procedure says.

use crate::case::Case;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader, suggestion};

pub(super) const FIELDS: &[Field] = &[
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation at which the axis rests."),
    Field::required(
        "points",
        Shape::Texts,
        "What is run: `fit` (a point for each level), `slow`, `onset`, `probe` (needs an oscilloscope), `echo`.",
    ),
    Field::required("level", Shape::Quantities(Q::Voltage), "Peak to peak of the multisines; 1 V is 1 A."),
    Field::default(
        "command-ticks",
        Shape::Integer,
        "4",
        "Ticks from command to command in `slow`: 4 at 4 kHz are a computer of 1 kHz, 5 at 20 kHz one of 50 us x 5.",
    ),
    Field::default("lines", Shape::Integer, "120", "About so many lines in equal ratios, 5 Hz to 1.5 kHz."),
    Field::default("windows", Shape::Integer, "6", "Windows of 1 s in each point with a multisine."),
    Field::default("step-level", Shape::Quantity(Q::Voltage), "2 V", "Height of the steps; 1 V is 1 A."),
    Field::default("steps", Shape::Integer, "40", "Steps of the point `onset`."),
    Field::default("captures", Shape::Integer, "8", "Records of the oscilloscope in the point `probe`."),
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
        STAGES.iter().find(|(_, stage)| *stage == self).map_or("", |(name, _)| name)
    }

    /// Stage of a planned point.
    pub(super) fn of(case: &Case) -> Option<Self> {
        let label = &case.segments.last()?.label;
        STAGES.iter().find(|(name, _)| name == label).map(|(_, stage)| *stage)
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

impl Keys {
    /// Reads them; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let elevation_rad = table.quantity("elevation");
        let stages = stages(table);
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
            table.mistake("level", "a level is positive", None);
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

    pub(super) fn has(&self, stage: Stage) -> bool {
        self.stages.contains(&stage)
    }
}

fn stages(table: &mut TableReader<'_>) -> Option<Vec<Stage>> {
    let mut stages = Vec::new();
    for (name, span) in table.spanned_texts("points")? {
        match STAGES.iter().find(|(known, _)| *known == name) {
            Some((_, stage)) => stages.push(*stage),
            None => {
                let help = suggestion(&name, STAGES.iter().map(|(known, _)| *known));
                table.mistake_at(span, format!("unknown point `{name}`"), Some(help));
            }
        }
    }
    Some(stages)
}
