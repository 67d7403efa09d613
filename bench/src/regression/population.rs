//! The units of a regression: files that somebody names, or draws from a family.

use procedures::diagnostic::Diagnostic;
use procedures::regression::Population;

use crate::files::family::{Family, load_family};
use crate::files::unit::load_unit;
use crate::record::journal::sha256;
use crate::site::unit::Unit;

/// Units by their numbers, from 1.
#[derive(Clone, Debug)]
pub enum Units {
    /// Units as their files say.
    Named(Vec<Unit>),
    /// The first units of a family.
    Drawn {
        /// Where they are drawn from.
        family: Box<Family>,
        /// Seed of the draws.
        seed: u64,
        /// How many.
        count: u32,
    },
}

impl Units {
    /// Units of these names or paths, in this order.
    ///
    /// # Errors
    /// All mistakes of their files; a unit that is named twice counts as one.
    pub fn named(names: &[String]) -> Result<Self, Vec<Diagnostic>> {
        let mut members: Vec<Unit> = Vec::new();
        let mut mistakes = Vec::new();
        for name in names {
            match load_unit(name) {
                // Whatever the files are called: one unit is one replicate.
                Ok(unit) if members.iter().any(|other| other.world == unit.world) => {
                    let message =
                        format!("unit `{name}` is named twice, or equals another one; name each unit once");
                    mistakes.push(Diagnostic::new(message));
                }
                Ok(unit) => members.push(unit),
                Err(found) => mistakes.extend(found),
            }
        }
        if mistakes.is_empty() { Ok(Self::Named(members)) } else { Err(mistakes) }
    }

    /// The first `count` units of a family, by its shipped name or path.
    ///
    /// # Errors
    /// All mistakes of its file.
    pub fn drawn(name: &str, seed: u64, count: u32) -> Result<Self, Vec<Diagnostic>> {
        Ok(Self::Drawn { family: Box::new(load_family(name)?), seed, count })
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        match self {
            Self::Named(members) => u32::try_from(members.len()).unwrap_or(u32::MAX),
            Self::Drawn { count, .. } => *count,
        }
    }

    /// The unit of a number, from 1.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub fn unit(&self, number: u32) -> Result<Unit, Vec<Diagnostic>> {
        match self {
            Self::Named(members) => {
                let place = usize::try_from(number).ok().and_then(|number| number.checked_sub(1));
                place.and_then(|place| members.get(place)).cloned().ok_or_else(|| {
                    let message =
                        format!("there is no unit {number}; the population has units 1 to {}", self.count());
                    vec![Diagnostic::new(message)]
                })
            }
            Self::Drawn { family, seed, .. } => family.unit(*seed, number).load(),
        }
    }

    /// Digest of the unit of a number. Of a drawn one it does not depend on where the family and its base lie.
    pub fn digest(&self, number: u32, unit: &Unit) -> String {
        match self {
            Self::Named(_) => digest(unit),
            Self::Drawn { family, seed, .. } => {
                let bases = unit.sources.iter().skip(1).map(|source| source.text.as_str());
                let own = [family.source.text.clone(), family.settings(*seed, number)];
                let texts: Vec<&str> = own.iter().map(String::as_str).chain(bases).collect();
                sha256(texts.join("\0").as_bytes())
            }
        }
    }

    /// What records say of the first `units` of them.
    pub fn described(&self, units: u32) -> Population {
        match self {
            Self::Named(members) => {
                let digests: Vec<String> = members.iter().map(digest).collect();
                let sha256 = sha256(digests.join("\n").as_bytes());
                Population { name: "files".to_owned(), sha256, units }
            }
            Self::Drawn { family, seed, .. } => Population {
                name: format!("{}, seed {seed}", family.id),
                sha256: sha256(family.source.text.as_bytes()),
                units,
            },
        }
    }
}

/// Digest of all files of a unit.
fn digest(unit: &Unit) -> String {
    let texts: Vec<&str> = unit.sources.iter().map(|source| source.text.as_str()).collect();
    sha256(texts.join("\0").as_bytes())
}
