//! Steps of a current: where each leaves its rest.

use analysis::delay::{Onset, OnsetShape, Step, step_onset};
use analysis::uncertainty::mean_of_repeats;

/// Samples from which the time constant is fitted, about.
const ENOUGH: usize = 1500;
/// Most steps for that.
const MOST_STEPS: usize = 8;
/// The current is looked at until this long after half of its rise; later the loops around it answer.
const AFTER_S: f64 = 1.5e-3;
/// And for this many samples at the least.
const LEAST_AFTER: usize = 6;

/// Onsets of many steps.
pub(super) struct Onsets {
    pub(super) delay_s: f64,
    /// Standard uncertainty from the scatter of the steps.
    pub(super) u_s: f64,
    pub(super) time_constant_s: f64,
    /// Onset of each step alone.
    pub(super) each_s: Vec<f64>,
}

impl Onsets {
    /// Standard deviation between the steps.
    pub(super) fn jitter_s(&self) -> Option<f64> {
        let n = self.each_s.len() as f64;
        let mean = self.each_s.iter().sum::<f64>() / n;
        let sum: f64 = self.each_s.iter().map(|s| (s - mean).powi(2)).sum();
        (n > 1.0).then(|| (sum / (n - 1.0)).sqrt())
    }
}

/// A step from its rest until shortly after its rise; `None` if it has none.
pub(super) fn cut(step: Step) -> Option<Step> {
    let t = &step.since_command_s;
    let y = &step.value;
    let quiet = t.partition_point(|t| *t < 0.0);
    let tail = &y[y.len() - (y.len().saturating_sub(quiet)).div_ceil(5)..];
    if quiet == 0 || tail.is_empty() {
        return None;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let rest = mean(&y[..quiet]);
    let end = mean(tail);
    let half = |k: usize| (y[k] - rest) / (end - rest) > 0.5;
    let risen = (quiet..t.len() - 1).find(|&k| half(k) && half(k + 1))?;
    let last = t.partition_point(|at| *at <= t[risen] + AFTER_S).max(risen + LEAST_AFTER).min(t.len());
    Some(Step { since_command_s: t[..last].to_vec(), value: y[..last].to_vec() })
}

/// Standard deviation of a median over that of a mean, for normal scatter: √(π/2).
const MEDIAN_RATIO: f64 = 1.2533;

/// Fits onset and time constant to steps that are cut: each alone, because a delay that jitters would smear a fit to all.
pub(super) fn onsets(steps: &[Step]) -> Result<Onsets, String> {
    let longest = steps.iter().map(|s| s.value.len()).max().ok_or("there is no step in the record")?;
    let few = (ENOUGH / longest.max(1)).clamp(1, MOST_STEPS);
    let alone = |step: &Step, time_constant_s| {
        step_onset(std::slice::from_ref(step), OnsetShape::Exponential { time_constant_s })
            .map_err(|e| e.to_string())
    };
    let some = steps.iter().step_by(steps.len().div_ceil(few));
    let mut constants: Vec<f64> = some
        .map(|step| alone(step, None)?.time_constant_s.ok_or_else(|| "no time constant".to_owned()))
        .collect::<Result<_, _>>()?;
    constants.sort_by(f64::total_cmp);
    let time_constant_s = constants[constants.len() / 2];
    let found: Vec<Onset> =
        steps.iter().map(|step| alone(step, Some(time_constant_s))).collect::<Result<_, _>>()?;
    let each_s: Vec<f64> = found.iter().map(|onset| onset.delay_s).collect();
    // Delays jitter to one side, and a step that met noise is read far off: the median is what most of them are.
    let mut sorted_s = each_s.clone();
    sorted_s.sort_by(f64::total_cmp);
    let delay_s = sorted_s[sorted_s.len() / 2];
    let u_s = mean_of_repeats(&each_s).map_or(found[0].u_s, |(_, c)| MEDIAN_RATIO * c.u);
    Ok(Onsets { delay_s, u_s, time_constant_s, each_s })
}
