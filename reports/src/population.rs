//! A population of units: pass probabilities, quantiles and what they depend on, as text, Markdown and JSON.
//!
//! [`PopulationReport`] is data; [`text`], [`markdown`] and [`json`] are pure functions of it.

use procedures::population::{Draws, Estimated, LEVEL, Quantile, Row, SHARES};
use serde::Serialize;

use crate::json::to_text;
use crate::number::{Shown, percent, short};
use crate::section::{Section, rules_markdown};
use crate::{markdown as md, printable, terminal};

#[cfg(test)]
mod tests;

/// Name and version of the structure of `population.json`.
const SCHEMA: &str = "population/1";

/// What the units of a population came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PopulationReport {
    /// Always `population/1`.
    schema: &'static str,
    /// Id of the family.
    pub family: String,
    /// SHA-256 of the family file, lower-case hexadecimal.
    pub family_sha256: String,
    /// How the units were chosen, e.g. `sobol`.
    pub method: String,
    /// Seed of the population.
    pub seed: i64,
    /// Id of the campaign.
    pub campaign: String,
    /// Units that were run.
    pub units: usize,
    /// Numbers of units of the population that are missing among the runs.
    pub missing: Vec<u32>,
    /// How the units were chosen, for statistics.
    pub draws: Draws,
    /// One for each requirement and measurand, in the order of the requirements.
    pub rows: Vec<Row>,
}

/// What the title of a report says of its population.
#[derive(Clone, Debug, PartialEq)]
pub struct Title {
    /// Id of the family.
    pub family: String,
    /// SHA-256 of the family file.
    pub family_sha256: String,
    /// Name of the method.
    pub method: String,
    /// Seed of the population.
    pub seed: i64,
    /// Id of the campaign.
    pub campaign: String,
}

impl PopulationReport {
    /// A report of evaluated rows; `missing` are numbers of units without a run.
    pub fn new(title: Title, units: usize, missing: Vec<u32>, draws: Draws, rows: Vec<Row>) -> Self {
        let Title { family, family_sha256, method, seed, campaign } = title;
        Self { schema: SCHEMA, family, family_sha256, method, seed, campaign, units, missing, draws, rows }
    }

    /// What was run, in a sentence without its full stop.
    pub fn headline(&self) -> String {
        let sets = match self.draws {
            Draws::Independent => String::new(),
            Draws::Randomised { sets } => format!(" in {sets} randomisations"),
        };
        let missing = match self.missing.as_slice() {
            [] => String::new(),
            numbers => {
                let first: Vec<String> = numbers.iter().take(10).map(u32::to_string).collect();
                let more = if numbers.len() > 10 { ", …" } else { "" };
                format!("; without a run: {}{more}", first.join(", "))
            }
        };
        format!(
            "{} of {} ({}, seed {}){sets} through {}{missing}",
            printable::counted(self.units, "unit"),
            self.family,
            self.method,
            self.seed,
            self.campaign
        )
    }
}

/// Everything that has a row.
fn sections(report: &PopulationReport) -> Vec<Section> {
    let quantiles = SHARES.map(|share| format!("{} quantile", percent(share)));
    let mut head = vec!["requirement", "measurand", "units", "passes", "inconclusive", "pass probability"];
    head.extend(quantiles.iter().map(String::as_str));
    let dependent = ["requirement", "measurand", "setting", "rank correlation", "p"];
    let all = [
        Section::new("Requirements", &head, report.rows.iter().map(requirement).collect()),
        Section::new(
            "Settings that values depend on",
            &dependent,
            report.rows.iter().flat_map(dependences).collect(),
        ),
    ];
    all.into_iter().filter(|section| !section.is_empty()).collect()
}

fn requirement(row: &Row) -> Vec<String> {
    let mut cells = vec![
        row.requirement.clone(),
        row.measurand.clone(),
        row.units.to_string(),
        row.passes.to_string(),
        row.inconclusive.to_string(),
        probability(&row.pass),
    ];
    let largest = row.quantiles.iter().map(|q| q.estimated.value.abs()).fold(0.0, f64::max);
    let unit = Shown::of_size(row.kind, largest);
    let of_share = |share: &f64| row.quantiles.iter().find(|q| q.share == *share);
    cells.extend(SHARES.iter().map(|share| of_share(share).map_or_else(dash, |q| quantile(&unit, q))));
    cells
}

fn probability(pass: &Estimated) -> String {
    let share = |ratio: f64| if ratio == 0.0 { "0 %".to_owned() } else { whole_percent(ratio) };
    match (pass.interval, pass.u) {
        (Some([low, high]), _) => {
            format!("{} ({} .. {})", share(pass.value), share(low.unwrap_or(0.0)), share(high.unwrap_or(1.0)))
        }
        (None, Some(u)) => format!("{}, u = {} %", share(pass.value), short(100.0 * u, 2)),
        (None, None) => share(pass.value),
    }
}

/// All of a sample is 100 %, however little that says of the population.
fn whole_percent(ratio: f64) -> String {
    if ratio == 1.0 { "100 %".to_owned() } else { percent(ratio) }
}

fn quantile(unit: &Shown, quantile: &Quantile) -> String {
    let number = |si: f64| short(unit.number(si), 4);
    let Estimated { value, interval, u } = quantile.estimated;
    match (interval, u) {
        (Some(ends), _) => {
            let [low, high] = ends.map(|end| end.map_or_else(|| "?".to_owned(), number));
            unit.text(&format!("{} ({low} .. {high})", number(value)))
        }
        (None, Some(u)) => {
            let (value, u) = unit.pair(value, u);
            unit.text(&format!("{value}, u = {u}"))
        }
        (None, None) => unit.text(&number(value)),
    }
}

fn dependences(row: &Row) -> Vec<Vec<String>> {
    let cells = |one: &procedures::population::Sensitivity| {
        let p = if one.p_family < 1e-4 { "< 0.0001".to_owned() } else { short(one.p_family, 2) };
        vec![
            row.requirement.clone(),
            row.measurand.clone(),
            one.setting.clone(),
            format!("{:.2}, u = {:.2}", one.coefficient, one.u),
            p,
        ]
    };
    row.sensitivities.iter().map(cells).collect()
}

fn dash() -> String {
    "—".to_owned()
}

/// By which rules the numbers above were found.
fn rules(report: &PopulationReport) -> Vec<String> {
    let first = match report.draws {
        Draws::Independent => format!(
            "Pass probability with its exact interval (Clopper and Pearson), quantiles with intervals of order statistics, {} each; \
             `?`: that end lies beyond the units that were run.",
            percent(LEVEL)
        ),
        Draws::Randomised { sets } => format!(
            "u: standard uncertainty from the scatter of {sets} randomisations. A pass probability for a statement of conformity \
             needs independent draws."
        ),
    };
    let tested = report.rows.iter().map(|row| row.settings_tested).max().unwrap_or(0);
    vec![
        first,
        "The value of a unit is that of the measurement which decides the requirement. An inconclusive verdict is no pass."
            .to_owned(),
        format!(
            "Rank correlation (Spearman) with each of {tested} settings; listed where its tail p, adjusted for all of them (Holm), \
             is at most 5 %."
        ),
    ]
}

/// The report for a terminal.
pub fn text(report: &PopulationReport) -> String {
    let mut out = format!("{}\n\n", report.headline());
    sections(report).iter().for_each(|section| section.text(&mut out, usize::MAX));
    out += &rules(report).join("\n");
    printable::text(&terminal::plain(&out))
}

/// The report as Markdown.
pub fn markdown(report: &PopulationReport) -> String {
    let mut out = format!("# Population\n\n{}\n\n", md::text(&report.headline()));
    sections(report).iter().for_each(|section| section.markdown(&mut out));
    rules_markdown(&mut out, &rules(report));
    out
}

/// The report as data.
pub fn json(report: &PopulationReport) -> String {
    to_text(report)
}
