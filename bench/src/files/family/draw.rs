//! Units drawn from a family.

use std::fmt::Write as _;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::quantity::QuantityKind;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use sim_devices::unit::{CURVES, PARAMETERS};

use super::variable::{Variable, What};
use super::{Family, Population};
use crate::files::settings::quantity_kind;
use crate::files::unit::{Method, read_unit};
use crate::site::unit::Unit;

/// Key of the random stream of unit 0 of every family. Results of the blind test are published for units drawn with it.
const FIRST_KEY: u64 = 0x00b1_1d00;

/// The unit file of a drawn unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawnUnit {
    /// E.g. `production-7-12`: family, seed, number. Of a design, `production-sobol-7-12-of-640`.
    pub id: String,
    /// Text of the unit file.
    pub text: String,
}

impl DrawnUnit {
    /// The unit as the program reads it from a file of this text, without writing one.
    ///
    /// # Errors
    /// Where the drawn settings do not fit each other, such as static friction below sliding friction.
    pub fn load(&self) -> Result<Unit, Vec<Diagnostic>> {
        read_unit(SourceFile::new(format!("{}.toml", self.id), self.text.clone()))
    }
}

impl Family {
    /// A unit of independent draws: a pure function of the family, the seed and the number, from 1.
    ///
    /// Units of other seeds and numbers have random streams of their own, so a population may grow without a change of the units
    /// that it has.
    pub fn unit(&self, seed: u64, number: u32) -> DrawnUnit {
        let population = Population { method: Method::Independent, seed, units: number, randomisations: 1 };
        self.file(&population, number, &self.settings(seed, number))
    }

    /// The unit file of this number of a population with these settings.
    pub(super) fn file(&self, population: &Population, number: u32, settings: &str) -> DrawnUnit {
        let Population { method, seed, units, randomisations } = population;
        let (way, size, size_lines) = match method {
            Method::Independent => (String::new(), String::new(), String::new()),
            _ => (
                format!("-{}", method.name()),
                format!("-of-{units}"),
                format!("units = {units}\nrandomisations = {randomisations}\n"),
            ),
        };
        let id = format!("{}{way}-{seed}-{number}{size}", self.id);
        let title = format!("Unit {number} of {} with seed {seed}", self.id);
        let [family, base, title, quoted_id] =
            [&self.id, &self.base, &title, &id].map(|text| toml::Value::from(text.as_str()).to_string());
        let head = format!("schema = 1\nid = {quoted_id}\ntitle = {title}\nbase = {base}\n");
        let from = format!(
            "family = {family}\nfamily-sha256 = \"{}\"\nmethod = \"{}\"\nseed = {seed}\nnumber = {number}\n{size_lines}",
            self.sha256,
            method.name()
        );
        // Settings that belong to no table must stand before the first one.
        let (top, tables) = settings.split_at(settings.find("\n[").unwrap_or(settings.len()));
        DrawnUnit { text: format!("{head}{top}\n[drawn]\n{from}{tables}"), id }
    }

    /// The settings of a unit of independent draws, as they stand in its file: first those that belong to no table.
    pub fn settings(&self, seed: u64, number: u32) -> String {
        let mut random = ChaCha8Rng::seed_from_u64(FIRST_KEY + u64::from(number));
        random.set_stream(seed);
        let shares = self.variables.iter().map(|variable| share(variable, random.next_u64()));
        self.settings_at(shares.collect())
    }

    /// The settings of the unit at a point of the unit cube: one share for each variable, in their order.
    pub(super) fn settings_at(&self, mut shares: Vec<f64>) -> String {
        if let Some(copula) = &self.coupled.copula {
            let independent: Vec<f64> = self.coupled.places.iter().map(|&place| shares[place]).collect();
            let coupled = copula.couple(&independent);
            self.coupled.places.iter().zip(coupled).for_each(|(&place, share)| shares[place] = share);
        }
        let mut tables: Vec<(&'static str, Vec<String>)> = Vec::new();
        for (variable, share) in self.variables.iter().zip(shares) {
            let Some((table, line)) = self.line(variable, variable.distribution.quantile_si(share)) else {
                continue;
            };
            match tables.iter_mut().find(|(name, _)| *name == table) {
                Some((_, lines)) => lines.push(line),
                None => tables.push((table, vec![line])),
            }
        }
        let (top, tables): (Vec<_>, Vec<_>) = tables.into_iter().partition(|(table, _)| table.is_empty());
        let mut text: String =
            top.iter().flat_map(|(_, lines)| lines).map(|line| format!("{line}\n")).collect();
        for (table, lines) in tables {
            let _ = write!(text, "\n[{table}]\n{}\n", lines.join("\n"));
        }
        text
    }

    /// The line of a unit file that sets a variable, and the table it stands in; none for a mode that the base does not have.
    fn line(&self, variable: &Variable, value_si: f64) -> Option<(&'static str, String)> {
        match variable.what {
            What::Setting(place) => {
                let setting = &PARAMETERS[place];
                let (table, key) = setting.table_and_key();
                let [least_si, most_si] = setting.range_si;
                let value = written(setting.quantity, value_si.clamp(least_si, most_si));
                Some((table, format!("{key} = \"{value}\"")))
            }
            What::Curve(place) => {
                let curve = &CURVES[place];
                let nominal = curve.get(&self.nominal);
                if nominal.is_empty() || nominal.iter().any(|value| *value <= 0.0) {
                    return None;
                }
                let values: Vec<String> = nominal
                    .iter()
                    .map(|value| format!("\"{}\"", written(curve.quantity, value_si * value)))
                    .collect();
                Some((curve.table, format!("{} = [{}]", curve.key, values.join(", "))))
            }
        }
    }
}

/// A value as a person would write it, to six digits.
fn written(quantity: &str, value_si: f64) -> String {
    quantity_kind(quantity).unwrap_or(QuantityKind::Ratio).format(value_si)
}

/// The share of a distribution, 0 to 1, that 64 random bits stand for.
fn share(variable: &Variable, bits: u64) -> f64 {
    match variable.distribution.steps_count() {
        // The middle of one of so many equal slices.
        Some(count) => ((bits % count) as f64 + 0.5) / count as f64,
        None => (bits >> 11) as f64 / (1_u64 << 53) as f64,
    }
}
