//! The units of a regression: files that somebody names, or draws from a family.

use procedures::diagnostic::Diagnostic;
use procedures::regression::Population;

use crate::files::unit::load_unit;
use crate::record::journal::sha256;
use crate::site::unit::Unit;

/// Units by their numbers, from 1.
#[derive(Clone, Debug)]
pub struct Units {
    members: Vec<Unit>,
}

impl Units {
    /// Units of these names or paths, in this order.
    ///
    /// # Errors
    /// All mistakes of their files; a unit that is named twice counts as one.
    pub fn named(names: &[String]) -> Result<Self, Vec<Diagnostic>> {
        let mut members = Vec::new();
        let mut mistakes = Vec::new();
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                let message = format!("unit `{name}` is named twice; a unit is one replicate, name it once");
                mistakes.push(Diagnostic::new(message));
                continue;
            }
            match load_unit(name) {
                Ok(unit) => members.push(unit),
                Err(found) => mistakes.extend(found),
            }
        }
        if mistakes.is_empty() { Ok(Self { members }) } else { Err(mistakes) }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        u32::try_from(self.members.len()).unwrap_or(u32::MAX)
    }

    /// The unit of a number, from 1.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub fn unit(&self, number: u32) -> Result<Unit, Vec<Diagnostic>> {
        let found = usize::try_from(number).ok().and_then(|number| self.members.get(number.checked_sub(1)?));
        found.cloned().ok_or_else(|| {
            let message =
                format!("there is no unit {number}; the population has units 1 to {}", self.count());
            vec![Diagnostic::new(message)]
        })
    }

    /// What records say of the first `units` of them.
    pub fn described(&self, units: u32) -> Population {
        let digests: Vec<String> = self.members.iter().map(digest).collect();
        Population { name: "files".to_owned(), sha256: sha256(digests.join("\n").as_bytes()), units }
    }
}

/// Digest of all files of a unit.
pub(super) fn digest(unit: &Unit) -> String {
    let texts: Vec<&str> = unit.sources.iter().map(|source| source.text.as_str()).collect();
    sha256(texts.join("\0").as_bytes())
}
