//! Where a drawn unit comes from: the table `[drawn]` of its file.

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, Shape, TableReader};
use sim_devices::unit::{CURVES, PARAMETERS};

use super::{Given, chain};

/// How the units of a population are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Each unit on its own.
    Independent,
    /// Latin hypercubes, each randomised on its own.
    LatinHypercube,
    /// Scrambled Sobol points, each set randomised on its own.
    Sobol,
}

/// Methods by their names in files and options.
pub const METHODS: [(&str, Method); 3] = [
    ("independent", Method::Independent),
    ("latin-hypercube", Method::LatinHypercube),
    ("sobol", Method::Sobol),
];

impl Method {
    /// Name in files and options.
    pub fn name(self) -> &'static str {
        METHODS.iter().find(|(_, method)| *method == self).map_or("independent", |(name, _)| name)
    }
}

/// What a unit was drawn from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawnFrom {
    /// Id of the family.
    pub family: String,
    /// SHA-256 of the family file, lower-case hexadecimal.
    pub family_sha256: String,
    /// How.
    pub method: Method,
    /// Seed of the population.
    pub seed: i64,
    /// Number of the unit in the population, from 1.
    pub number: u32,
    /// Units of the population; `None` for independent draws, which do not depend on it.
    pub units: Option<u32>,
    /// Sets of points that were randomised on their own, each of equally many units; likewise.
    pub randomisations: Option<u32>,
}

impl DrawnFrom {
    /// The set of points that the unit belongs to, from 0 on; 0 for independent draws.
    pub fn randomisation(&self) -> u32 {
        match (self.units, self.randomisations) {
            (Some(units), Some(sets)) if sets > 0 && units >= sets => (self.number - 1) / (units / sets),
            _ => 0,
        }
    }
}

/// Keys of `[drawn]`.
pub(super) const FIELDS: &[Field] = &[
    Field::required("family", Shape::Text, "Id of the family."),
    Field::required("family-sha256", Shape::Text, "SHA-256 of the family file."),
    Field::required(
        "method",
        Shape::Choice(&["independent", "latin-hypercube", "sobol"]),
        "How the units of the population were chosen.",
    ),
    Field::required("seed", Shape::Integer, "Seed of the population."),
    Field::required("number", Shape::Integer, "Number of the unit in the population, from 1."),
    Field::optional("units", Shape::Integer, "Units of the population, where the draw depends on it."),
    Field::optional(
        "randomisations",
        Shape::Integer,
        "Sets of points that were randomised on their own, each of equally many units.",
    ),
];

pub(super) fn read(t: &mut TableReader<'_>) -> Option<DrawnFrom> {
    let family = t.text("family");
    let family_sha256 = t.text("family-sha256");
    let method = t.text("method");
    let method = METHODS.iter().find(|(name, _)| Some(*name) == method.as_deref()).map(|(_, method)| *method);
    let seed = t.integer("seed", 0);
    let number = t.count("number", 1);
    let mut count = |key| t.has(key).then(|| t.count(key, 1)).flatten();
    let [units, randomisations] = ["units", "randomisations"].map(&mut count);
    Some(DrawnFrom {
        family: family?,
        family_sha256: family_sha256?,
        method: method?,
        seed: seed?,
        number: number?,
        units,
        randomisations,
    })
}

/// A drawn unit by its own file alone.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnSettings {
    /// Id of the unit.
    pub id: String,
    /// Where it comes from.
    pub from: DrawnFrom,
    /// Keys of the settings that its file gives, with SI values; of a curve, its first value.
    pub values_si: Vec<(String, f64)>,
}

/// Reads where a drawn unit comes from and what its own file sets, without its base; `None` for a unit that was not drawn.
///
/// # Errors
/// All mistakes of the file.
pub fn read_drawn(source: SourceFile) -> Result<Option<DrawnSettings>, Vec<Diagnostic>> {
    let (_, parsed) = chain::parsed(source)?;
    let (Some(from), Given::Director(given)) = (parsed.drawn, parsed.given) else { return Ok(None) };
    let scalars = given.values.iter().map(|(place, value_si)| (PARAMETERS[*place].key.to_owned(), *value_si));
    let curves = given.curves.iter().filter_map(|curve| {
        let described = &CURVES[curve.index];
        Some((format!("{}.{}", described.table, described.key), *curve.values.first()?))
    });
    Ok(Some(DrawnSettings { id: parsed.id, from, values_si: scalars.chain(curves).collect() }))
}
