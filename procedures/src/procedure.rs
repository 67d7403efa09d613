//! A procedure file: one experiment on one axis.

use std::ops::Range;

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::kinds::{Experiment, KINDS, Kind};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::{Limit, QuantityKind};
use crate::table::{Field, MOST_MISTAKES, SCHEMA_FIELD, Shape};

mod narrow;
mod place;
mod prompt;
mod reach;
mod read;
#[cfg(test)]
pub(crate) mod sample;
pub use narrow::Subset;
pub(crate) use prompt::{FIELDS as PROMPT_FIELDS, read as read_prompts};
pub use prompt::{Prompt, PromptClass};
pub(crate) use read::is_harmless;

#[cfg(test)]
mod tests;
mod valid;

/// A condition that the log must meet for a point to count.
#[derive(Clone, Debug, PartialEq)]
pub enum ValidIf {
    /// The achieved condition lies within this ratio of the requested one, e.g. `velocity = "within 5 % of requested"`.
    Near {
        /// Name of the condition.
        condition: String,
        /// Allowed relative deviation.
        ratio: f64,
    },
    /// `dropped-cycles = "< 0.1 %, longest < 5 ms"`.
    DroppedCycles {
        /// Largest share of missed periods.
        ratio: f64,
        /// Longest gap.
        longest_s: f64,
    },
}

/// What a gate may look at before motion, with the kind of its quantity.
pub const GATES: &[(&str, QuantityKind)] =
    &[("heat-sink", QuantityKind::Temperature), ("bus-voltage", QuantityKind::Voltage)];

/// Keys that every procedure file has; the kind adds its own (see [`Kind::fields`]).
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Unique name, e.g. `AZ-FRICTION`; also the name of the log."),
    Field::required("title", Shape::Text, "Heading in the report."),
    Field::required("kind", Shape::Text, "Kind of experiment, e.g. `hysteresis`."),
    Field::required("axis", Shape::Text, "Axis that it moves, e.g. `az`."),
    Field::optional(
        "log-rate",
        Shape::Quantity(QuantityKind::Frequency),
        "Rows per second in the log; default: the loop rate.",
    ),
    Field::optional(
        "gate",
        Shape::Map(&Shape::Text),
        "Conditions that must be met before motion: `heat-sink`, `bus-voltage`.",
    ),
    Field::optional(
        "cool-down",
        Shape::Quantity(QuantityKind::Time),
        "Longest wait before a point for the heat sinks to cool down to the gate `heat-sink`; the axes \
         stay as they were left.",
    ),
    Field::optional(
        "valid-if",
        Shape::Map(&Shape::Text),
        "Conditions that make a point valid: `velocity = \"within 5 % of requested\"`, `dropped-cycles`.",
    ),
    Field::optional(
        "prompt",
        Shape::Tables(prompt::FIELDS),
        "Questions to the operator before the first point, `[[prompt]]`.",
    ),
];

/// Rows of a log are means over whole ticks: a rate that does not divide the loop rate would silently be another one.
fn log_rate(asked_hz: f64, loop_rate_hz: f64) -> Option<Diagnostic> {
    let ticks = loop_rate_hz / asked_hz;
    if loop_rate_hz <= 0.0 || (ticks - ticks.round()).abs() <= 1e-9 * ticks && ticks >= 1.0 - 1e-9 {
        return None;
    }
    let rate = |hz: f64| QuantityKind::Frequency.format(hz);
    let message =
        format!("`log-rate` {} does not divide the loop rate {}", rate(asked_hz), rate(loop_rate_hz));
    let whole = |hz: &f64| hz.fract() == 0.0;
    let rates: Vec<f64> = (1..=loop_rate_hz as u64).map(|n| loop_rate_hz / n as f64).filter(whole).collect();
    let above = rates.iter().copied().rfind(|hz| *hz > asked_hz);
    let below = rates.iter().copied().find(|hz| *hz < asked_hz);
    let near: Vec<String> = [below, above].into_iter().flatten().map(rate).collect();
    Some(Diagnostic::new(message).help(format!(
        "each row is a mean over whole ticks; the nearest possible rates are {}",
        near.join(" and ")
    )))
}

/// A key of a procedure file that says where azimuth or elevation stands, and where it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
struct WrittenPose {
    key: &'static str,
    span: Range<usize>,
}

/// A procedure.
#[derive(Debug)]
pub struct Procedure {
    /// E.g. `AZ-FRICTION`; also the log's file name.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Name of its kind.
    pub kind: &'static str,
    /// Axis it moves.
    pub axis: String,
    /// Rows per second in the log; the loop rate if `None`.
    pub log_rate_hz: Option<f64>,
    /// What must hold before motion, by channel, e.g. heat-sink `< 60 degC`.
    pub gates: Vec<(String, Limit)>,
    /// Longest wait before a point while the gate `heat-sink` is closed, s; the point is refused at once if `None`.
    pub cool_down_s: Option<f64>,
    /// What must hold of a point.
    pub valid_if: Vec<ValidIf>,
    /// Questions to the operator before the first point.
    pub prompts: Vec<Prompt>,
    /// Names of the measurands that it yields.
    pub yields: Vec<&'static str>,
    /// The kind's own part.
    pub experiment: Box<dyn Experiment>,
    /// The file, kept verbatim for the log.
    pub source: SourceFile,
    /// Where the axis is named, for mistakes that only the rig shows.
    axis_span: Range<usize>,
    /// What the file says of azimuth and elevation, which not every rig has.
    poses: Vec<WrittenPose>,
}

impl Procedure {
    /// Parses a procedure file. `points` of a campaign (`{ velocity = ["10 deg/s"] }`) narrow a sweep: see
    /// [`crate::campaign`]; they are applied by [`Procedure::plan`].
    ///
    /// # Errors
    /// All mistakes at once.
    pub fn parse(source: SourceFile) -> Result<Self, Vec<Diagnostic>> {
        Self::parse_with(source, KINDS)
    }

    pub(crate) fn parse_with(source: SourceFile, kinds: &'static [Kind]) -> Result<Self, Vec<Diagnostic>> {
        read::procedure(source, kinds)
    }

    /// The points to run: the kind's plan, narrowed to `subsets`, each checked against the axis limits by its
    /// envelope (soft limits, velocity, acceleration, torque) with a diagnostic for each excess.
    ///
    /// # Errors
    /// What the axis cannot do, or a subset value that the sweep does not have (with the values it has).
    pub fn plan(&self, axes: &Axes, subsets: &[Subset]) -> Result<Vec<Case>, Vec<Diagnostic>> {
        if axes.get(&self.axis).is_none() {
            let unknown = Diagnostic::new(format!("the rig has no axis `{}`", self.axis));
            let help = crate::table::suggestion(&self.axis, axes.names().collect::<Vec<_>>());
            return Err(vec![unknown.at(&self.source, self.axis_span.clone()).help(help)]);
        }
        let named = |mistake: Diagnostic| match mistake.file {
            None => place::found(mistake, &self.source),
            Some(_) => mistake,
        };
        let in_file = |all: Vec<Diagnostic>| all.into_iter().map(named).collect::<Vec<_>>();
        if let Some(refusal) =
            self.log_rate_hz.and_then(|hz| log_rate(hz, axes.get(&self.axis)?.loop_rate_hz))
        {
            return Err(in_file(vec![refusal]));
        }
        let axes = &axes.logged_at(self.log_rate_hz);
        let all = self.experiment.plan(&self.axis, axes).map_err(in_file)?;
        let nowhere = self.poses_nobody(axes);
        if !nowhere.is_empty() {
            return Err(nowhere);
        }
        let mut cases = narrow::narrow(all, subsets).map_err(in_file)?;
        cases.iter_mut().for_each(|case| case.cool_down_s = self.cool_down_s);
        if let Some(refusal) = reach::too_long(&cases) {
            return Err(in_file(vec![refusal]));
        }
        let excesses = cases.iter().flat_map(|case| reach::excesses(case, axes));
        let excesses: Vec<_> = excesses.take(MOST_MISTAKES).collect();
        if excesses.is_empty() { Ok(cases) } else { Err(in_file(excesses)) }
    }

    /// Mistakes of a file that says at which azimuth or elevation something is done on a rig of uncoupled axes.
    fn poses_nobody(&self, axes: &Axes) -> Vec<Diagnostic> {
        let Err(lacking) = axes.gimbal() else { return Vec::new() };
        let mistake = |pose: &WrittenPose| {
            let message = format!("`{}` has no meaning on this rig, which has {}", pose.key, lacking.axes);
            let help = format!("leave out `{}`, or set `carried-by` in the rig file", pose.key);
            Diagnostic::new(message).at(&self.source, pose.span.clone()).help(help)
        };
        self.poses.iter().map(mistake).collect()
    }

    /// Analyses one point and applies `valid-if`: measurements of a point whose window or achieved conditions break
    /// it become inconclusive with the reason and lose their value; so does everything of a point that did not
    /// complete. `loop_rate_hz` (of the log's plan) turns missed periods into time.
    pub fn analyse(&self, case: &Case, window: &Window, axes: &Axes, loop_rate_hz: f64) -> PointResult {
        let result = self.experiment.analyse(case, window, &axes.logged_at(self.log_rate_hz));
        if let Some(reason) = valid::broken_off(window) {
            return match self.experiment.reads_broken_off() {
                true => PointResult { inconclusive: result.inconclusive.or(Some(reason)), ..result },
                false => valid::without_numbers(result, reason),
            };
        }
        let breach = |v| valid::breach(v, case, &result, window, loop_rate_hz);
        match self.valid_if.iter().find_map(breach) {
            Some(reason) => {
                // The kind's own reason, if it has one, is nearer to the cause.
                let reason = result.inconclusive.clone().unwrap_or(reason);
                valid::without_numbers(result, reason)
            }
            None => result,
        }
    }
}
