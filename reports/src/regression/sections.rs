//! A regression as tables, whatever they are written in.

use procedures::quantity::QuantityKind;
use procedures::regression::{Call, Look, Outcome, Scale, Worse};

use super::{Regression, Side};
use crate::number::{Shown, percent, short, significant, typeset};
use crate::printable::counted;
use crate::section::Section;

const OUTCOME_HEAD: [&str; 9] = [
    "call",
    "requirement",
    "measurand",
    "where",
    "baseline",
    "candidate",
    "shift, + worse",
    "margin",
    "−2δ … 2δ",
];

/// Everything that has a row.
pub(super) fn all(found: &Regression) -> Vec<Section> {
    let sections = [
        outcomes(found, "Blocking criteria", true),
        outcomes(found, "Criteria that are only reported", false),
        ends(found),
        lost(found),
    ];
    sections.into_iter().filter(|section| !section.is_empty()).collect()
}

/// What was compared, a line each.
pub(super) fn facts(found: &Regression) -> Vec<String> {
    let scenario = &found.scenario;
    let mut facts = vec![
        format!("baseline: {}", side(&found.baseline)),
        format!("candidate: {}", side(&found.candidate)),
        format!(
            "campaign `{}` ({}) on rig `{}` ({})",
            scenario.campaign,
            digest(&scenario.campaign_sha256),
            scenario.rig,
            digest(&scenario.rig_sha256)
        ),
        format!(
            "{} of `{}` ({}), {} each, from seed {}",
            counted(scenario.population.units as usize, "unit"),
            scenario.population.name,
            digest(&scenario.population.sha256),
            counted(scenario.seeds_per_unit as usize, "run"),
            scenario.seed
        ),
    ];
    if found.shard.parts > 1 {
        facts.push(format!("shard {} of {} alone", found.shard.number, found.shard.parts));
    }
    if found.baseline.program != found.candidate.program {
        facts.push("the arms were run by different builds of the program".to_owned());
    }
    facts
}

/// By which rules the calls were found.
pub(super) fn rules(found: &Regression) -> Vec<String> {
    let looks = match found.decision.look {
        Look::Single => String::new(),
        Look::Sequential { number } => {
            format!("; look {number} of a sequential comparison, p times the looks")
        }
    };
    vec![
        format!(
            "Shift: candidate less baseline, or logarithm of their ratio in per cent; mean over units ± interval of {}{looks}.",
            percent(found.decision.level)
        ),
        "Equivalent: the interval lies inside ± margin; worse, better: it lies above or below zero otherwise; a worse criterion blocks \
         where its p, adjusted for all blocking criteria (Holm), is below 5 %."
            .to_owned(),
        "Picture: interval ━ and mean ● of the shift, margins ┊, zero ┼.".to_owned(),
    ]
}

fn side(side: &Side) -> String {
    let controller = &side.controller;
    let states: String = controller.states.iter().map(|state| format!(", state {state}")).collect();
    let laws: String = controller.laws.iter().map(|law| format!(", law {law}")).collect();
    format!(
        "parameters `{}` ({}){states}{laws}, bench {} ({})",
        controller.parameters,
        digest(&controller.sha256),
        side.program.version,
        digest(&side.program.sha256)
    )
}

/// As much of a digest as tells two of them apart.
fn digest(sha256: &str) -> &str {
    sha256.get(..12).unwrap_or(sha256)
}

/// What is said of a criterion.
pub(super) fn word(outcome: &Outcome) -> &'static str {
    match outcome.call {
        _ if outcome.blocks => "WORSE",
        Call::Worse => "worse",
        Call::Inconclusive => "inconclusive",
        Call::Better => "better",
        Call::Equivalent if outcome.differs => "equivalent, differs",
        Call::Equivalent => "equivalent",
        Call::Identical => "identical",
    }
}

fn outcomes(found: &Regression, heading: &str, blocking: bool) -> Section {
    let own = found.worst_first().into_iter().filter(|outcome| outcome.criterion.blocking == blocking);
    let rows: Vec<Vec<String>> = own.map(outcome_row).collect();
    Section::new(format!("{heading}: {}", rows.len()), &OUTCOME_HEAD, rows)
}

fn outcome_row(outcome: &Outcome) -> Vec<String> {
    let criterion = &outcome.criterion;
    let arms = [outcome.baseline, outcome.candidate];
    let unit = Shown::of_size(
        criterion.kind,
        arms.into_iter().flatten().fold(0.0, |size, arm| arm.mean.abs().max(size)),
    );
    let mean = |arm: Option<procedures::regression::Arm>| {
        arm.map_or_else(|| "—".to_owned(), |arm| unit.text(&significant(unit.number(arm.mean), 4)))
    };
    vec![
        word(outcome).to_owned(),
        criterion.requirement.clone(),
        criterion.measurand.clone(),
        criterion.place.clone(),
        mean(outcome.baseline),
        mean(outcome.candidate),
        shift(outcome),
        margin(outcome),
        picture(outcome),
    ]
}

/// Unit in which shift and margin of a criterion are shown.
fn shown(outcome: &Outcome) -> Shown {
    match outcome.criterion.scale {
        Scale::Difference => Shown::of_size(outcome.criterion.kind, outcome.criterion.margin),
        Scale::LogRatio => Shown::of_kind(QuantityKind::Ratio),
    }
}

/// A shift as it is shown: a logarithm of a ratio as its per cent.
fn displayed(outcome: &Outcome, shift: f64) -> f64 {
    match outcome.criterion.scale {
        Scale::Difference => shift,
        Scale::LogRatio => shift.exp_m1(),
    }
}

/// `+0.21 Hz [+0.15, +0.27]`, or why there is none.
pub(super) fn shift(outcome: &Outcome) -> String {
    let unit = shown(outcome);
    let number = |shift: f64| {
        let value = unit.number(displayed(outcome, shift));
        let text = typeset(&significant(value, 2));
        if value > 0.0 { format!("+{text}") } else { text }
    };
    let mut text = match (outcome.shift, outcome.interval) {
        (Some(shift), Some([low, high])) => {
            format!("{} [{}, {}]", unit.text(&number(shift)), number(low), number(high))
        }
        (Some(shift), None) => unit.text(&number(shift)),
        (None, _) => "—".to_owned(),
    };
    if let Some(why) = &outcome.why {
        text += &format!("; {why}");
    }
    if let Some(needed) = outcome.units_needed {
        text += &format!("; about {needed} more units needed");
    }
    if outcome.left_out > 0 {
        text += &format!("; {} left out", counted(outcome.left_out, "sample"));
    }
    text
}

/// `0.1 Hz, lower is worse`.
fn margin(outcome: &Outcome) -> String {
    let unit = shown(outcome);
    let text = unit.text(&short(unit.number(displayed(outcome, outcome.criterion.margin)), 3));
    let worse = match outcome.criterion.worse {
        Worse::Higher => "higher",
        Worse::Lower => "lower",
    };
    format!("{text}, {worse} is worse")
}

/// Cells of the picture; odd, so that zero has one of its own.
const CELLS: i32 = 25;

/// Interval and mean of a shift between −2 and 2 margins; an arrow where they lie beyond.
fn picture(outcome: &Outcome) -> String {
    let (Some(shift), Some([low, high])) = (outcome.shift, outcome.interval) else { return String::new() };
    let half = CELLS / 2;
    let cell = |value: f64| {
        let place = value / outcome.criterion.margin * f64::from(half) / 2.0;
        half + place.round().clamp(f64::from(-half - 1), f64::from(half + 1)) as i32
    };
    let [low, mean, high] = [low, shift, high].map(cell);
    let margins = [half - half / 2, half + half / 2];
    let symbol = |place: i32| match place {
        _ if place == mean => '●',
        0 if mean < 0 => '◄',
        _ if place == CELLS - 1 && mean >= CELLS => '►',
        _ if (low..=high).contains(&place) => '━',
        _ if margins.contains(&place) => '┊',
        _ if place == half => '┼',
        _ => '┈',
    };
    (0..CELLS).map(symbol).collect()
}

fn ends(found: &Regression) -> Section {
    let text = |why: &Option<String>| why.clone().unwrap_or_else(|| "completed".to_owned());
    let row = |end: &procedures::regression::UnitEnd| {
        vec![end.unit.to_string(), end.seed.to_string(), text(&end.baseline), text(&end.candidate)]
    };
    Section::new(
        format!("Runs that ended early: {}", found.ends.len()),
        &["unit", "seed", "baseline", "candidate"],
        found.ends.iter().map(row).collect(),
    )
}

fn lost(found: &Regression) -> Section {
    let row = |outcome: &Outcome| {
        let units: Vec<String> = outcome.lost.iter().map(|lost| lost.unit.to_string()).collect();
        let criterion = &outcome.criterion;
        vec![
            criterion.requirement.clone(),
            criterion.measurand.clone(),
            criterion.place.clone(),
            units.join(", "),
        ]
    };
    let with = found.decision.outcomes.iter().filter(|outcome| !outcome.lost.is_empty());
    Section::new(
        "Units that pass with the baseline and not with the candidate",
        &["requirement", "measurand", "where", "units"],
        with.map(row).collect(),
    )
}
