//! Numbers that are not finite never reach a report: JSON cannot hold them, and `NaN` in a table convinces nobody.
//!
//! They become `None` with a flag; a verdict that rests on one becomes inconclusive.

use procedures::measurement::Measurement;
use procedures::trace::{Plot, Series};
use procedures::verdict::{Judgement, Overall, Verdict};

use super::{Findings, LimitFindings, Results, RunRecord, SafetyFindings};

const REASON: &str = "not a finite number";

impl Results {
    /// [`Findings::make_finite`] and the same for the durations of the record.
    pub fn make_finite(&mut self) {
        self.findings.make_finite();
        self.record.make_finite();
    }
}

impl RunRecord {
    fn make_finite(&mut self) {
        for duration in [&mut self.wall_s, &mut self.simulated_s, &mut self.cpu_s] {
            if !duration.is_finite() {
                *duration = 0.0;
            }
        }
        self.speed_factor = self.speed_factor.filter(|f| f.is_finite());
        for attempt in &mut self.attempts {
            attempt.planned_s = attempt.planned_s.filter(|s| s.is_finite());
            attempt.ran_s = attempt.ran_s.filter(|s| s.is_finite());
        }
    }
}

impl Findings {
    /// Makes every number finite: a value or uncertainty that is not becomes "no value" with a flag and a reason, a
    /// judgement that rests on one becomes inconclusive (and with it the outcome and the overall verdict), points of
    /// pictures are left out.
    pub fn make_finite(&mut self) {
        for requirement in &mut self.requirements {
            let judges = &mut requirement.judges;
            for limit in judges.iter_mut().flat_map(|j| [&mut j.limit, &mut j.goal]).flatten() {
                finite_limit(limit);
            }
        }
        let mut touched = false;
        for procedure in &mut self.procedures {
            let broken: Vec<bool> = procedure.measurements.iter_mut().map(finite_measurement).collect();
            for judgement in &mut procedure.judgements {
                let rests_on_broken = broken.get(judgement.measurement).copied().unwrap_or(false);
                touched |= finite_judgement(judgement, rests_on_broken, &mut procedure.verdict);
            }
            for row in &mut procedure.points {
                row.conditions.retain(|c| c.requested.is_finite());
                row.conditions.iter_mut().for_each(|c| c.achieved = c.achieved.filter(|v| v.is_finite()));
                let lost = row.measurements.iter().any(|&i| broken.get(i) == Some(&true));
                if lost && row.verdict != Verdict::None {
                    row.verdict = row.verdict.max(Verdict::Inconclusive);
                }
            }
            procedure.plots.iter_mut().for_each(finite_plot);
            procedure.safety.iter_mut().for_each(SafetyFindings::make_finite);
        }
        touched |= self.finite_outcomes();
        if touched && matches!(self.overall, Overall::Pass | Overall::ConditionalPass | Overall::Screening) {
            self.overall = Overall::Inconclusive;
        }
    }

    /// Outcomes repeat the judgement that decided them: they follow the procedures, which are finite by now.
    fn finite_outcomes(&mut self) -> bool {
        let procedures = &self.procedures;
        let is_broken = |id: &str, judgement: &Judgement| {
            let procedure = procedures.iter().find(|p| p.id == id);
            let measurement = procedure.and_then(|p| p.measurements.get(judgement.measurement));
            measurement.is_some_and(|m| m.flags.iter().any(|f| f.ends_with(REASON)))
        };
        let mut touched = false;
        for outcome in &mut self.outcomes {
            if let Some((id, judgement)) = &mut outcome.decided_by {
                let broken = is_broken(id, judgement);
                touched |= finite_judgement(judgement, broken, &mut outcome.verdict);
            }
            for one in &mut outcome.by_measurand {
                let (id, judgement) = &mut one.decided_by;
                let broken = is_broken(id, judgement);
                touched |= finite_judgement(judgement, broken, &mut one.verdict);
            }
        }
        touched
    }
}

fn finite_limit(limit: &mut LimitFindings) {
    limit.low = limit.low.filter(|v| v.is_finite());
    limit.high = limit.high.filter(|v| v.is_finite());
}

/// Whether the measurement lost its value.
fn finite_measurement(m: &mut Measurement) -> bool {
    let value_lost = m.value.is_some_and(|v| !v.is_finite());
    let u_lost = !m.u.is_finite();
    m.dof = m.dof.filter(|d| d.is_finite());
    m.evidence.retain(|e| e.t0_s.is_finite() && e.t1_s.is_finite());
    m.angles_rad = m.angles_rad.filter(|ends| ends.iter().all(|end| end.is_finite()));
    m.conditions.retain(|c| c.requested.is_finite());
    m.conditions.iter_mut().for_each(|c| c.achieved = c.achieved.filter(|v| v.is_finite()));
    if !value_lost && !u_lost {
        return false;
    }
    let what = if value_lost { "value" } else { "uncertainty" };
    m.value = None;
    m.u = 0.0;
    m.flags.push(format!("{what} {REASON}"));
    m.inconclusive.get_or_insert_with(|| format!("{what} is {REASON}"));
    true
}

/// Whether the judgement, and with it `verdict` that contains it, had to change.
fn finite_judgement(j: &mut Judgement, rests_on_broken: bool, verdict: &mut Verdict) -> bool {
    let mut broken = rests_on_broken;
    for number in [&mut j.k, &mut j.expanded_u, &mut j.guard_band] {
        if !number.is_finite() {
            *number = 0.0;
            broken = true;
        }
    }
    for limit in &mut j.acceptance {
        *limit = limit.filter(|v| v.is_finite());
    }
    j.margin = j.margin.filter(|v| v.is_finite() && !broken);
    j.probability_outside = j.probability_outside.filter(|v| v.is_finite() && !broken);
    if !broken || j.verdict == Verdict::None {
        return false;
    }
    j.goal_met = None;
    j.verdict = Verdict::Inconclusive;
    j.reason.get_or_insert_with(|| format!("the measurement or its uncertainty is {REASON}"));
    *verdict = (*verdict).max(Verdict::Inconclusive);
    true
}

fn finite_plot(plot: &mut Plot) {
    let pair = |[a, b]: &[f64; 2]| a.is_finite() && b.is_finite();
    plot.series.iter_mut().for_each(finite_series);
    plot.limits.retain(|l| l.y.is_finite());
    plot.limits.iter_mut().for_each(|l| l.x = l.x.filter(pair));
    plot.marks.retain(|m| m.x.is_finite());
    plot.masks.iter_mut().for_each(|m| m.points.retain(pair));
    plot.masks.retain(|m| !m.points.is_empty());
    plot.circles.retain(|c| pair(&c.centre) && c.radius.is_finite());
    plot.notes.retain(|n| pair(&n.at));
    plot.spans.retain(|s| pair(&s.x));
    plot.x_range = plot.x_range.filter(pair);
    plot.y_range = plot.y_range.filter(pair);
}

fn finite_series(series: &mut Series) {
    let length = series.x.len().min(series.y.len());
    let with_u = series.u.len() >= length;
    let kept: Vec<usize> = (0..length)
        .filter(|&i| series.x[i].is_finite() && series.y[i].is_finite())
        .filter(|&i| !with_u || series.u[i].is_finite())
        .collect();
    if kept.len() == series.x.len() && kept.len() == series.y.len() && (with_u || series.u.is_empty()) {
        return;
    }
    let pick = |values: &[f64]| kept.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    series.x = pick(&series.x);
    series.y = pick(&series.y);
    series.u = if with_u { pick(&series.u) } else { Vec::new() };
}
