//! What differs between two findings of the same logs, and by how much.

use procedures::measurement::Measurement;
use reports::record::{Findings, ProcedureFindings};
use reports::terminal;

use crate::record::journal::sha256;

/// Findings beside those of before.
pub(super) struct Compared {
    same: bool,
    /// Whether both were judged by the same requirements.
    same_requirements: bool,
    pub(super) text: String,
}

impl Compared {
    pub(super) fn new(before: &Findings, now: &Findings) -> Self {
        Self {
            same: before == now,
            same_requirements: before.campaign.requirements_sha256 == now.campaign.requirements_sha256,
            text: differences(before, now),
        }
    }

    /// Other limits give other findings; the same ones must not.
    pub(super) fn is_unexplained(&self) -> bool {
        !self.same && self.same_requirements
    }
}

/// Whether the bytes are the same; else by how much the numbers differ, and the first line that does.
fn differences(before: &Findings, now: &Findings) -> String {
    let texts = [before, now].map(reports::json::findings);
    if texts[0] == texts[1] {
        return format!("findings are identical byte for byte (sha256 {})", sha256(texts[1].as_bytes()));
    }
    let mut lines = numbers(&before.procedures, &now.procedures);
    lines.push(changed_verdicts(before, now));
    let mut pairs = texts[0].lines().zip(texts[1].lines()).enumerate();
    lines.push(match pairs.find(|(_, (a, b))| a != b) {
        Some((line, (a, b))) => format!(
            "first at line {}:\n    before: {}\n    now:    {}",
            line + 1,
            around(a.trim(), b.trim()),
            around(b.trim(), a.trim())
        ),
        None => "one of the two ends earlier".to_owned(),
    });
    format!("findings differ: {}", lines.join("\n  "))
}

/// A measurement of both findings.
struct Pair<'a> {
    procedure: &'a str,
    before: &'a Measurement,
    now: &'a Measurement,
}

impl Pair<'_> {
    /// Change of the value in standard uncertainties of before; a value that came or went is infinitely far.
    fn apart_u(&self) -> f64 {
        match (self.before.value, self.now.value) {
            (None, None) => 0.0,
            (Some(before), Some(now)) if before.to_bits() == now.to_bits() => 0.0,
            (Some(before), Some(now)) => (now - before).abs() / self.before.u,
            _ => f64::INFINITY,
        }
    }

    /// Relative change of the uncertainty.
    fn u_ratio(&self) -> f64 {
        if self.before.u.to_bits() == self.now.u.to_bits() {
            0.0
        } else {
            (self.now.u / self.before.u - 1.0).abs()
        }
    }

    fn name(&self) -> String {
        let point = self.before.point.as_ref().map_or(String::new(), |point| format!(", {point}"));
        format!("{} of {}{point}", self.before.measurand, self.procedure)
    }

    /// Both values, or both uncertainties, with all digits that tell them apart.
    fn change(&self, of: impl Fn(&Measurement) -> Option<f64>) -> String {
        let text = |m: &Measurement| of(m).map_or("none".to_owned(), |value| format!("{value:e}"));
        format!("{} -> {} SI", text(self.before), text(self.now))
    }
}

/// How many measurements differ, and by how much at the most.
fn numbers(before: &[ProcedureFindings], now: &[ProcedureFindings]) -> Vec<String> {
    let mut all = Vec::new();
    let mut alone = 0;
    for procedure in now {
        let earlier = before.iter().find(|earlier| earlier.id == procedure.id);
        let earlier = earlier.map_or(&[][..], |earlier| &earlier.measurements);
        alone += earlier.len().abs_diff(procedure.measurements.len());
        let pairs = earlier.iter().zip(&procedure.measurements);
        all.extend(pairs.map(|(before, now)| Pair { procedure: &procedure.id, before, now }));
    }
    let differ = all.iter().filter(|pair| pair.before != pair.now).count();
    let mut lines = vec![format!("{differ} of {} measurements", all.len())];
    if alone > 0 {
        lines.push(format!("measurements in only one of the two: {alone}"));
    }
    let farthest = all.iter().max_by(|a, b| a.apart_u().total_cmp(&b.apart_u()));
    lines.push(match farthest.filter(|pair| pair.apart_u() != 0.0) {
        Some(pair) => format!(
            "values differ by at most {:.2e} of their standard uncertainty ({}: {})",
            pair.apart_u(),
            pair.name(),
            pair.change(|m| m.value)
        ),
        None => "values are the same".to_owned(),
    });
    let widest = all.iter().max_by(|a, b| a.u_ratio().total_cmp(&b.u_ratio()));
    lines.push(match widest.filter(|pair| pair.u_ratio() != 0.0) {
        Some(pair) => format!(
            "uncertainties differ by at most {:.2e} of their size ({}: {})",
            pair.u_ratio(),
            pair.name(),
            pair.change(|m| Some(m.u))
        ),
        None => "uncertainties are the same".to_owned(),
    });
    lines
}

/// Requirements whose verdict is another one now.
fn changed_verdicts(before: &Findings, now: &Findings) -> String {
    let changed = now.outcomes.iter().filter_map(|outcome| {
        let earlier = before.outcomes.iter().find(|earlier| earlier.requirement == outcome.requirement);
        let word = earlier.map_or("none", |earlier| terminal::word(earlier.verdict));
        let is_new = earlier.is_none_or(|earlier| earlier.verdict != outcome.verdict);
        is_new.then(|| format!("{} {word} -> {}", outcome.requirement, terminal::word(outcome.verdict)))
    });
    let changed: Vec<String> = changed.collect();
    if changed.is_empty() {
        "verdicts are the same".to_owned()
    } else {
        format!("verdicts: {}", changed.join(", "))
    }
}

/// What a person reads of a long line: where it begins to differ from another.
fn around(line: &str, other: &str) -> String {
    const BEFORE: usize = 40;
    const SHOWN: usize = 120;
    let same = line.chars().zip(other.chars()).take_while(|(a, b)| a == b).count();
    let from = if line.chars().count() <= SHOWN { 0 } else { same.saturating_sub(BEFORE) };
    let shown: String = line.chars().skip(from).take(SHOWN).collect();
    let cut = |cut: bool| if cut { "…" } else { "" };
    format!("{}{shown}{}", cut(from > 0), cut(line.chars().count() > from + SHOWN))
}

#[cfg(test)]
mod tests {
    use procedures::measurement::Estimate;
    use procedures::quantity::QuantityKind;

    use super::*;

    fn friction(value: f64, u: f64) -> ProcedureFindings {
        let estimate = Estimate { value, u, dof: 9.0, n: 10 };
        let measurement =
            Measurement::new("friction-torque", "az", QuantityKind::Torque, Some(estimate), "test/1");
        let at_point = Measurement { point: Some("velocity=2 deg/s".to_owned()), ..measurement };
        ProcedureFindings { id: "AZ-FRICTION".to_owned(), measurements: vec![at_point], ..Default::default() }
    }

    #[test]
    fn it_is_told_by_how_much_values_and_uncertainties_differ() {
        let told = numbers(&[friction(219.0, 0.5)], &[friction(219.001, 0.537)]).join("\n");
        insta::assert_snapshot!(told, @r"
        1 of 1 measurements
        values differ by at most 2.00e-3 of their standard uncertainty (friction-torque of AZ-FRICTION, velocity=2 deg/s: 2.19e2 -> 2.19001e2 SI)
        uncertainties differ by at most 7.40e-2 of their size (friction-torque of AZ-FRICTION, velocity=2 deg/s: 5e-1 -> 5.37e-1 SI)
        ");
        let same = numbers(&[friction(219.0, 0.5)], &[friction(219.0, 0.5)]);
        assert_eq!(same, ["0 of 1 measurements", "values are the same", "uncertainties are the same"]);
        let without = ProcedureFindings { measurements: Vec::new(), ..friction(0.0, 0.0) };
        let fewer = numbers(&[friction(219.0, 0.5)], &[without]);
        assert_eq!(fewer[1], "measurements in only one of the two: 1");
    }
}
