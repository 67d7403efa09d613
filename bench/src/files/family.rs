//! Families of units (`sim-devices/units/families/*.toml`): distributions of the settings of a simulated unit, and units drawn
//! from them.
//!
//! A drawn unit is a pure function of its family, a seed and a number. Its text is that of a unit file over the base of the
//! family, with values as a person would write them: what is read back is what the unit obeys.

use std::collections::BTreeSet;
use std::path::Path;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::population::copula::GaussianCopula;
use procedures::table::{TableReader, read_file};
use reports::printable::counted;
use sim_devices::unit::UnitSettings;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::files::shipped::{self, Folder, SHIPPED, sort};
use crate::files::unit::load_unit_beside;
use crate::record::journal::sha256;

mod correlation;
mod distribution;
mod draw;
mod fields;
mod population;
#[cfg(test)]
mod tests;
mod variable;

pub use draw::DrawnUnit;
pub use fields::FIELDS;
pub use population::{LEAST_RANDOMISATIONS, Population, PopulationError};

use correlation::Pair;
use variable::{Variable, What};

/// Distributions of the settings of a simulated unit about those of a base.
#[derive(Clone, Debug)]
pub struct Family {
    /// E.g. `production`; the ids of its units begin with it.
    pub id: String,
    /// Heading.
    pub title: String,
    /// The file.
    pub source: SourceFile,
    /// SHA-256 of the file, lower-case hexadecimal.
    sha256: String,
    /// Base as a drawn unit names it.
    base: String,
    /// Settings of the base: the nominal values.
    nominal: UnitSettings,
    /// What is drawn, in the order of the draws: settings as the file lists them, then factors of modes.
    variables: Vec<Variable>,
    coupled: Coupled,
}

/// Variables that are correlated.
#[derive(Clone, Debug, Default)]
struct Coupled {
    /// Places in the list of variables, ascending.
    places: Vec<usize>,
    /// Couples as many; `None` without correlations.
    copula: Option<GaussianCopula>,
}

impl Family {
    /// What the family draws, in one line.
    pub fn summary(&self) -> String {
        let factors =
            self.variables.iter().filter(|variable| matches!(variable.what, What::Curve(_))).count();
        format!(
            "family {}: {}, {} of modes, {} correlated; base {}",
            self.id,
            counted(self.variables.len() - factors, "setting"),
            counted(factors, "factor"),
            self.coupled.places.len(),
            self.base
        )
    }
}

/// Finds and reads a family by its shipped name or its path.
///
/// # Errors
/// All mistakes of the file, or of its base.
pub fn load_family(name: &str) -> Result<Family, Vec<Diagnostic>> {
    let source = shipped::find(Folder::Families, name, None)?;
    read_family(sort::expect(source, Folder::Families)?)
}

/// Reads a family file.
///
/// # Errors
/// All mistakes of the file, or of its base; also where a drawn unit would be no good unit file.
pub fn read_family(source: SourceFile) -> Result<Family, Vec<Diagnostic>> {
    let base = Base::of(&source)?;
    let family = read_file(&source, FIELDS, |t| read(t, base))?;
    // What a distribution cannot know, such as switches and settings in whole steps, shows in any unit.
    let impossible = |mistake: Diagnostic| Diagnostic {
        message: format!("a unit drawn from this family cannot be: {}", mistake.message),
        ..mistake
    };
    match family.unit(1, 1).load() {
        Ok(_) => Ok(family),
        Err(mistakes) => Err(mistakes.into_iter().map(impossible).collect()),
    }
}

/// The unit that the nominal values come from.
struct Base {
    name: String,
    settings: UnitSettings,
}

impl Base {
    /// Looks up `base` alone: the other keys can only be read with its settings.
    fn of(source: &SourceFile) -> Result<Self, Vec<Diagnostic>> {
        let (root, _) = DeTable::parse_recoverable(&source.text);
        let written = root.get_ref().get("base");
        let name = match written.map(Spanned::get_ref) {
            Some(DeValue::String(name)) => name.to_string(),
            _ => default_base().to_owned(),
        };
        let point = |mistake: Diagnostic| match (&mistake.file, written) {
            (None, Some(base)) => mistake.at(source, base.span()),
            _ => mistake,
        };
        let pointed = |all: Vec<Diagnostic>| all.into_iter().map(point).collect::<Vec<_>>();
        let unit = load_unit_beside(&name, Some(&source.name)).map_err(pointed)?;
        let Some(settings) = unit.director() else {
            let message = format!("base `{name}` is a rotary table; families are of units of the director");
            return Err(pointed(vec![Diagnostic::new(message).help("name a unit of the director")]));
        };
        // A drawn unit may lie in any folder: it finds a base that is not shipped by its whole path.
        let is_shipped = unit.sources.first().is_none_or(|own| own.name.starts_with(SHIPPED));
        let whole = |own: &SourceFile| std::path::absolute(Path::new(&own.name)).ok();
        let path = unit.sources.first().filter(|_| !is_shipped).and_then(whole);
        let name = path.map_or(name, |path| path.display().to_string());
        Ok(Self { name, settings: settings.clone() })
    }
}

/// What stands in the place of `base` where it is left out.
fn default_base() -> &'static str {
    let default = FIELDS.iter().find(|field| field.key == "base").map(|field| field.need);
    match default {
        Some(procedures::table::Need::Default(name)) => name,
        _ => "nominal",
    }
}

fn read(t: &mut TableReader<'_>, base: Base) -> Option<Family> {
    let schema = t.schema();
    let id = t.text("id");
    let title = t.text("title");
    t.text("base");
    let mut drawn = BTreeSet::new();
    let settings = t.tables("setting", |t| variable::settings(t, &base.settings, &mut drawn));
    let mut multiplied = Vec::new();
    let factors = t.tables("mode-factor", |t| variable::mode_factors(t, &base.settings, &mut multiplied));
    let mut variables: Vec<Variable> = settings.into_iter().flatten().flatten().collect();
    let mut factors: Vec<Variable> = factors.into_iter().flatten().flatten().collect();
    factors.sort_by_key(Variable::place);
    variables.append(&mut factors);
    if variables.is_empty() && t.mistakes() == 0 {
        let help = "add a table `[[setting]]`".to_owned();
        t.mistake("setting", "the family draws nothing: all its units would be the same", Some(help));
    }
    // Where a setting was misread, what names it would only be a second mistake.
    let is_whole = t.mistakes() == 0;
    let place = t.span("correlation");
    let mut pairs: Vec<Pair> = Vec::new();
    t.tables("correlation", |t| correlation::read(t, is_whole.then_some(variables.as_slice()), &mut pairs));
    let coupled = if t.mistakes() == 0 { correlation::coupled(t, place, &variables, &pairs) } else { None };
    schema?;
    Some(Family {
        id: id?,
        title: title?,
        sha256: sha256(t.source().text.as_bytes()),
        source: t.source().clone(),
        base: base.name,
        nominal: base.settings,
        variables,
        coupled: coupled?,
    })
}
