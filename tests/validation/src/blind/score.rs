//! How far findings are from the truth, over all units.

use std::collections::BTreeMap;

use analysis::family_wise::holm;
use analysis::proportion::probability_of_at_most;
use procedures::verdict::{Verdict, coverage_factor};
use serde::{Deserialize, Serialize};

/// A finding beside its truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// Number of the unit.
    pub unit: u32,
    /// Id of the procedure.
    pub procedure: String,
    /// Measurand.
    pub measurand: String,
    /// Axis.
    pub axis: String,
    /// Point; empty for what rests on several.
    pub point: String,
    /// What was found, SI.
    pub value: f64,
    /// Its standard uncertainty, SI.
    pub u: f64,
    /// Its degrees of freedom; `None`: infinite.
    pub dof: Option<f64>,
    /// What is true, SI.
    pub truth: f64,
    /// Verdict on what was found; none where no requirement judges it.
    pub verdict: Verdict,
    /// Verdict on the truth by the same limit.
    pub on_truth: Verdict,
    /// Probability that the printed value is outside its limit.
    pub probability_outside: Option<f64>,
    /// The requirement whose limit the truth is on; `None` where it is elsewhere.
    pub on_limit: Option<OnLimit>,
    /// By how many expanded uncertainties the truth is outside of its limit; 0 inside, or without one.
    #[serde(default)]
    pub outside_in_u: f64,
}

/// A requirement whose limit a truth is on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnLimit {
    /// Its id.
    pub requirement: String,
    /// Whether a guard band lies between acceptance and limit.
    pub is_guarded: bool,
    /// Verdict by simple acceptance.
    pub by_simple: Verdict,
}

/// Coverage that is promised less what 60 units cannot tell: below it a measurand is wrong.
const LEAST_COVERAGE: f64 = 0.93;
/// Level of the test over the whole table.
const LEVEL: f64 = 0.05;

impl Scored {
    /// Expanded uncertainty, SI.
    pub fn expanded_u(&self) -> f64 {
        coverage_factor(self.dof) * self.u
    }

    /// Error in expanded uncertainties.
    pub fn error_in_u(&self) -> f64 {
        (self.value - self.truth) / self.expanded_u()
    }

    /// Whether the interval holds the truth.
    pub fn is_covered(&self) -> bool {
        self.error_in_u().abs() <= 1.0
    }

    /// Whether it passed, with or without condition.
    pub fn is_pass(&self) -> bool {
        matches!(self.verdict, Verdict::Pass | Verdict::ConditionalPass)
    }

    /// Whether it passed or failed.
    pub fn is_decided(&self) -> bool {
        self.is_pass() || matches!(self.verdict, Verdict::Fail | Verdict::ConditionalFail)
    }

    /// Passed, though the truth is outside of the limit.
    pub fn is_false_pass(&self) -> bool {
        self.is_pass() && self.on_truth == Verdict::Fail
    }

    /// Failed, though the truth is inside of the limit.
    pub fn is_false_fail(&self) -> bool {
        self.verdict == Verdict::Fail && self.on_truth == Verdict::Pass
    }

    /// One line for a person.
    pub fn text(&self) -> String {
        format!(
            "unit {}, {} {} {} {}: {:.6e} ± {:.2e}, true {:.6e}: {:+.1} U",
            self.unit,
            self.procedure,
            self.measurand,
            self.axis,
            self.point,
            self.value,
            self.expanded_u(),
            self.truth,
            self.error_in_u()
        )
    }
}

/// What all findings of one measurand on one axis come to.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Measurand and axis.
    pub name: String,
    /// Findings.
    pub findings: usize,
    /// Units.
    pub units: usize,
    /// Findings whose interval holds the truth.
    pub covered: usize,
    /// Mean error in expanded uncertainties.
    pub mean_in_u: f64,
    /// Largest error in expanded uncertainties.
    pub largest_in_u: f64,
    /// Findings that lie beyond their truth by more than U: they would pass a lower, or an upper, limit that the truth is on.
    pub passes_on_limit: [usize; 2],
    /// Standard uncertainty over the root mean square of the errors: 1 is honest, 2 twice too careful.
    pub u_over_rms: f64,
    /// Probability of so few covered units if 93 % of all were: one finding of each unit, the first.
    pub p: f64,
    /// Whether that is too small, by Holm over the table.
    pub is_wrong: bool,
}

/// What is counted, not measured: findings without uncertainty, by measurand and axis.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Findings.
    pub findings: usize,
    /// Of these equal to the truth, but for rounding.
    pub equal: usize,
}

/// Rounding of a number that is counted, as a ratio.
const ROUNDING: f64 = 1e-9;

/// Findings without uncertainty.
pub fn counts(all: &[Scored]) -> BTreeMap<String, Count> {
    let mut counts: BTreeMap<String, Count> = BTreeMap::new();
    for one in all.iter().filter(|one| one.u <= 0.0) {
        let count = counts.entry(format!("{} {}", one.measurand, one.axis)).or_default();
        count.findings += 1;
        count.equal += usize::from((one.value - one.truth).abs() <= ROUNDING * one.truth.abs());
    }
    counts
}

/// A line for each measurand and axis, of findings with an uncertainty.
pub fn lines(all: &[Scored]) -> Vec<Line> {
    let mut groups: BTreeMap<String, Vec<&Scored>> = BTreeMap::new();
    for one in all.iter().filter(|one| one.u > 0.0) {
        groups.entry(format!("{} {}", one.measurand, one.axis)).or_default().push(one);
    }
    let mut lines: Vec<Line> = groups.into_iter().map(|(name, group)| line(name, &group)).collect();
    let p_values: Vec<f64> = lines.iter().map(|line| line.p).collect();
    for (line, adjusted_p) in lines.iter_mut().zip(holm(&p_values)) {
        line.is_wrong = adjusted_p <= LEVEL;
    }
    lines
}

fn line(name: String, group: &[&Scored]) -> Line {
    let errors = || group.iter().map(|one| one.error_in_u());
    let n = group.len() as f64;
    let mean_square = |of: &dyn Fn(&Scored) -> f64| group.iter().map(|one| of(one).powi(2)).sum::<f64>() / n;
    let mut first: BTreeMap<u32, &Scored> = BTreeMap::new();
    for one in group {
        first.entry(one.unit).or_insert(one);
    }
    let covered_units = first.values().filter(|one| one.is_covered()).count() as u64;
    let p = probability_of_at_most(covered_units, first.len() as u64, LEAST_COVERAGE).unwrap_or(1.0);
    Line {
        name,
        findings: group.len(),
        units: first.len(),
        covered: group.iter().filter(|one| one.is_covered()).count(),
        mean_in_u: errors().sum::<f64>() / n,
        largest_in_u: errors().map(f64::abs).fold(0.0, f64::max),
        passes_on_limit: [errors().filter(|e| *e >= 1.0).count(), errors().filter(|e| *e <= -1.0).count()],
        u_over_rms: (mean_square(&|one| one.u) / mean_square(&|one| one.value - one.truth)).sqrt(),
        p,
        is_wrong: false,
    }
}

/// The table of these lines.
pub fn table(lines: &[Line]) -> String {
    let mut text = "| finding | n | units | within U | mean, U | largest, U | passes on ≥ / ≤ limit | u / rms error | p | |\n\
                    | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n"
        .to_owned();
    for line in lines {
        let share = 100.0 * line.covered as f64 / line.findings as f64;
        text += &format!(
            "| {} | {} | {} | {share:.1} % | {:+.2} | {:.1} | {} / {} | {:.2} | {:.2e} | {} |\n",
            line.name,
            line.findings,
            line.units,
            line.mean_in_u,
            line.largest_in_u,
            line.passes_on_limit[0],
            line.passes_on_limit[1],
            line.u_over_rms,
            line.p,
            if line.is_wrong { "**wrong**" } else { "" }
        );
    }
    text
}

/// Most events of 99 % of all series, if each happens with its probability (the sum of unlike Bernoulli variables).
pub fn most_events(probabilities: &[f64]) -> usize {
    let mut law = vec![1.0];
    for p in probabilities {
        law.push(0.0);
        for k in (0..law.len()).rev() {
            law[k] = (1.0 - p) * law[k] + if k > 0 { p * law[k - 1] } else { 0.0 };
        }
    }
    let mut sum = 0.0;
    law.iter()
        .position(|p| {
            sum += p;
            sum >= MOST_EVENTS
        })
        .unwrap_or(probabilities.len())
}

/// Quantile up to which as many false verdicts are chance.
const MOST_EVENTS: f64 = 0.99;

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(unit: u32, error: f64) -> Scored {
        Scored {
            unit,
            procedure: "AZ-FRICTION".to_owned(),
            measurand: "friction-torque".to_owned(),
            axis: "az".to_owned(),
            point: String::new(),
            value: 219.0 + error,
            u: 0.5,
            dof: None,
            truth: 219.0,
            verdict: Verdict::Pass,
            on_truth: Verdict::Pass,
            probability_outside: None,
            on_limit: None,
            outside_in_u: 0.0,
        }
    }

    #[test]
    fn a_finding_that_misses_its_truth_on_every_unit_is_wrong_and_an_honest_one_is_not() {
        let off: Vec<Scored> = (0..12).map(|unit| scored(unit, 1.5)).collect();
        let found = lines(&off);
        assert!(found[0].is_wrong && found[0].covered == 0, "{found:?}");
        let honest: Vec<Scored> =
            (0..12).map(|unit| scored(unit, if unit % 2 == 0 { 0.5 } else { -0.5 })).collect();
        let found = lines(&honest);
        assert!(
            !found[0].is_wrong && found[0].covered == 12 && found[0].mean_in_u.abs() < 1e-12,
            "{found:?}"
        );
        assert!((found[0].u_over_rms - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_uncertainty_is_counted_and_not_scored() {
        let count = |value| Scored { value, u: 0.0, ..scored(1, 0.0) };
        let all = [count(219.0), count(220.0), scored(2, 0.1)];
        let found = counts(&all);
        assert_eq!(found["friction-torque az"], Count { findings: 2, equal: 1 });
        assert_eq!(lines(&all)[0].findings, 1);
    }

    #[test]
    fn as_many_events_are_chance_as_their_probabilities_allow() {
        // Binomial, n = 100, p = 0.02: P(X ≤ 5) = 0.9845, P(X ≤ 6) = 0.9959.
        assert_eq!(most_events(&[0.02; 100]), 6);
        assert_eq!((most_events(&[]), most_events(&[0.001; 3]), most_events(&[1.0; 4])), (0, 0, 4));
    }

    #[test]
    fn a_pass_is_false_where_the_truth_fails() {
        let wrong = Scored { on_truth: Verdict::Fail, ..scored(1, 0.0) };
        assert!(wrong.is_false_pass() && !wrong.is_false_fail());
        let wrong = Scored { verdict: Verdict::Fail, ..scored(1, 0.0) };
        assert!(wrong.is_false_fail() && !wrong.is_false_pass());
    }
}
