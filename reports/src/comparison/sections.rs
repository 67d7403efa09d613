//! A comparison as headings and tables, whatever they are written in.

use procedures::comparison::{Band, Call, CurvePair, LEVEL, Value, ValuePair, WorstPoint};
use procedures::verdict::coverage_factor;

use super::RunComparison;
use crate::number::{Shown, percent, short, significant};
use crate::section::Section;
use crate::words;

const VALUE_HEAD: [&str; 9] =
    ["procedure", "measurand", "axis", "under", "A", "B", "B − A", "apart / u", "p"];
const CURVE_HEAD: [&str; 6] = ["procedure", "picture", "curve", "inside the band", "farthest point", "p"];

/// What differs, and what is missing on one side.
pub(super) fn differing(compared: &RunComparison) -> Vec<Section> {
    let all = [
        facts(compared),
        values(compared, Call::Differs, "Values that differ"),
        curves(compared, Call::Differs, "Curves that differ"),
        values(compared, Call::Near, "Values that are near a difference"),
        curves(compared, Call::Near, "Curves that are near a difference"),
        values(compared, Call::OnlyInA, "Values of A alone"),
        values(compared, Call::OnlyInB, "Values of B alone"),
        verdicts(compared),
        curves(compared, Call::NotJudged, "Curves without uncertainty, not judged"),
    ];
    all.into_iter().filter(|section| !section.is_empty()).collect()
}

/// Values and curves that are the same.
pub(super) fn same(compared: &RunComparison) -> Vec<Section> {
    let all = [
        values(compared, Call::Same, "Values that are the same"),
        curves(compared, Call::Same, "Curves that are the same"),
        values(compared, Call::Identical, "Identical values"),
        curves(compared, Call::Identical, "Identical curves"),
    ];
    all.into_iter().filter(|section| !section.is_empty()).collect()
}

/// By which rules the words above were found.
pub(super) fn rules(compared: &RunComparison) -> Vec<String> {
    let tolerance = match compared.tolerance {
        Some(ratio) => {
            format!("Differences within {} of the larger value count as the same.", percent(ratio))
        }
        None => "No tolerance was given: only the uncertainty counts.".to_owned(),
    };
    let curves = &compared.findings.curves;
    let relative = curves.iter().find_map(|pair| match pair.band {
        Band::Relative(ratio) => Some(ratio),
        Band::Uncertainty => None,
    });
    let relative = relative.map(|ratio| {
        let judged = if compared.tolerance.is_some() { "" } else { ", and are not judged" };
        format!(
            "Curves without uncertainty have a band of {}: of the ordinate on a logarithmic scale or in decibels, of a radian for \
             a phase, else of the height of the curve{judged}.",
            percent(ratio)
        )
    });
    let mut all = vec![
        "A, B: value ± U with U = k·u and k = t(0.97725, ν); B − A ± U of the difference, whose u is the root of the sum of both \
         squared."
            .to_owned(),
        format!(
            "A difference is one where its tail p, adjusted for all {} values and {} curves (Holm), is at most {}; `near` is beyond \
             its own U only.",
            compared.findings.pairs(),
            curves.len(),
            percent(LEVEL)
        ),
        tolerance,
    ];
    if curves.iter().any(|pair| pair.band == Band::Uncertainty) {
        all.push(
            "Curves with uncertainty have the band U (k = 2) of the difference and differ where a tenth of their points does."
                .to_owned(),
        );
    }
    all.extend(relative);
    if compared.findings.without_value > 0 {
        all.push(format!(
            "Quantities that both looked for and neither has a value of: {}.",
            compared.findings.without_value
        ));
    }
    if compared.findings.curves_alone > 0 {
        all.push(format!("Curves in one of the two only: {}.", compared.findings.curves_alone));
    }
    all
}

fn facts(compared: &RunComparison) -> Section {
    let row = |fact: &super::Fact| {
        let mark = if fact.a == fact.b { "" } else { "differs" };
        vec![fact.what.clone(), fact.a.clone(), fact.b.clone(), mark.to_owned()]
    };
    let is_known = |fact: &&super::Fact| fact.a != "—" || fact.b != "—";
    let mut rows: Vec<Vec<String>> = compared.facts.iter().filter(is_known).map(row).collect();
    if let Some([a, b]) = compared.overall {
        let mark = if a == b { "" } else { "differs" };
        let [a, b] = [a, b].map(|overall| words::overall(overall).word.to_owned());
        rows.push(vec!["outcome".to_owned(), a, b, mark.to_owned()]);
    }
    Section::new("Title pages", &["", "A", "B", ""], rows)
}

fn verdicts(compared: &RunComparison) -> Section {
    let word = |verdict: Option<_>| verdict.map_or("not in this run", |v| words::verdict(v).word).to_owned();
    let row =
        |change: &super::VerdictChange| vec![change.requirement.clone(), word(change.a), word(change.b)];
    Section::new(
        "Verdicts that changed",
        &["requirement", "A", "B"],
        compared.verdicts.iter().map(row).collect(),
    )
}

fn values(compared: &RunComparison, call: Call, heading: &str) -> Section {
    let mut found: Vec<&ValuePair> =
        compared.findings.values.iter().filter(|pair| pair.call == call).collect();
    if matches!(call, Call::Differs | Call::Near) {
        let apart = |pair: &ValuePair| pair.difference.and_then(|d| d.apart_u).unwrap_or(f64::INFINITY);
        found.sort_by(|a, b| apart(b).total_cmp(&apart(a)));
    }
    let heading = format!("{heading}: {}", found.len());
    Section::new(heading, &VALUE_HEAD, found.into_iter().map(value_row).collect())
}

fn value_row(pair: &ValuePair) -> Vec<String> {
    let quantity = &pair.quantity;
    let sizes = [pair.a, pair.b].into_iter().flatten().map(|v| v.value.abs().max(v.u.abs()));
    let unit = Shown::of_size(quantity.kind, sizes.fold(0.0, f64::max));
    let with_u = |value: f64, expanded_u: f64| {
        let (value, u) = unit.pair(value, expanded_u);
        if expanded_u > 0.0 { unit.text(&format!("{value} ± {u}")) } else { unit.text(&value) }
    };
    let cell = |value: Option<Value>| match value {
        Some(v) => with_u(v.value, coverage_factor(v.dof) * v.u),
        None => "—".to_owned(),
    };
    let dash = || "—".to_owned();
    let missing = || pair.reason.clone().unwrap_or_else(dash);
    let under = quantity.point.clone().unwrap_or_default();
    let line = if quantity.measurand.starts_with("cogging-") { order(pair) } else { String::new() };
    let difference = pair.difference.as_ref();
    vec![
        quantity.procedure.clone(),
        quantity.measurand.clone(),
        quantity.axis.clone(),
        format!("{under}{line}"),
        if pair.a.is_none() { missing() } else { cell(pair.a) },
        if pair.b.is_none() { missing() } else { cell(pair.b) },
        difference.map_or_else(dash, |d| with_u(d.value, d.expanded_u)),
        difference.and_then(|d| d.apart_u).map_or_else(dash, |apart_u| short(apart_u, 2)),
        difference.map_or_else(dash, |d| tail(d.p_family)),
    ]
}

/// The order of a line of the cogging, which its point does not name.
fn order(pair: &ValuePair) -> String {
    let order = pair.quantity.conditions.iter().find(|c| c.name == "order");
    order.map_or_else(String::new, |c| format!(", order {}", short(c.requested, 4)))
}

fn curves(compared: &RunComparison, call: Call, heading: &str) -> Section {
    let found: Vec<&CurvePair> = compared.findings.curves.iter().filter(|pair| pair.call == call).collect();
    let heading = format!("{heading}: {}", found.len());
    Section::new(heading, &CURVE_HEAD, found.into_iter().map(curve_row).collect())
}

fn curve_row(pair: &CurvePair) -> Vec<String> {
    let share = if pair.points == 0 {
        "no point in common".to_owned()
    } else {
        format!("{} of {}", pair.inside, pair.points)
    };
    let alone =
        if pair.points_alone > 0 { format!(", {} in one only", pair.points_alone) } else { String::new() };
    vec![
        pair.procedure.clone(),
        pair.title.clone(),
        pair.curve.clone(),
        format!("{share}{alone}"),
        pair.worst.map_or_else(|| "—".to_owned(), |worst| farthest(pair, &worst)),
        pair.p_family.map_or_else(|| "—".to_owned(), tail),
    ]
}

/// `at 42.5 Hz: −3.1 and −2.7 dB, 0.4 apart, band 0.3`.
fn farthest(pair: &CurvePair, worst: &WorstPoint) -> String {
    let number = |value: f64| significant(value, 4);
    let unit = |symbol: &str| if matches!(symbol, "" | "1") { String::new() } else { format!(" {symbol}") };
    format!(
        "at {}{}: {} and {}{}, {} apart, band {}",
        number(worst.x),
        unit(&pair.x.unit),
        number(worst.a),
        number(worst.b),
        unit(&pair.y.unit),
        significant(worst.difference.abs(), 2),
        significant(worst.half_width, 2)
    )
}

fn tail(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".to_owned() } else { short(p, 2) }
}
