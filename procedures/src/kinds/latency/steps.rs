//! Steps of a current: where each leaves its rest.

use crate::analysis::delay::{OnsetShape, Step, step_onset};

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
    let (t, y) = (&step.since_command_s, &step.value);
    let quiet = t.partition_point(|t| *t < 0.0);
    let tail = &y[y.len() - (y.len().saturating_sub(quiet)).div_ceil(5)..];
    if quiet == 0 || tail.is_empty() {
        return None;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (rest, end) = (mean(&y[..quiet]), mean(tail));
    let half = |k: usize| (y[k] - rest) / (end - rest) > 0.5;
    let risen = (quiet..t.len() - 1).find(|&k| half(k) && half(k + 1))?;
    let last = t.partition_point(|at| *at <= t[risen] + AFTER_S).max(risen + LEAST_AFTER).min(t.len());
    Some(Step { since_command_s: t[..last].to_vec(), value: y[..last].to_vec() })
}

/// Fits onset and time constant to steps that are cut.
pub(super) fn onsets(steps: &[Step]) -> Result<Onsets, String> {
    let longest = steps.iter().map(|s| s.value.len()).max().ok_or("there is no step in the record")?;
    let few = (ENOUGH / longest.max(1)).clamp(1, MOST_STEPS);
    let some: Vec<Step> = steps.iter().step_by(steps.len().div_ceil(few)).cloned().collect();
    let free = step_onset(&some, OnsetShape::Exponential { time_constant_s: None });
    let time_constant_s = free.map_err(|e| e.to_string())?.time_constant_s.ok_or("no time constant")?;
    let shape = OnsetShape::Exponential { time_constant_s: Some(time_constant_s) };
    let all = step_onset(steps, shape).map_err(|e| e.to_string())?;
    let each: Result<Vec<f64>, _> =
        steps.iter().map(|s| step_onset(std::slice::from_ref(s), shape).map(|o| o.delay_s)).collect();
    Ok(Onsets {
        delay_s: all.delay_s,
        u_s: all.u_s,
        time_constant_s,
        each_s: each.map_err(|e| e.to_string())?,
    })
}
