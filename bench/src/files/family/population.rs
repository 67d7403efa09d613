//! Populations: units that are drawn together.

use procedures::population::design::{DesignError, latin_hypercube, scrambled_sobol};

use super::{DrawnUnit, Family};
use crate::files::unit::Method;

/// Fewest randomisations of a design: from fewer the scatter is not told well enough.
pub const LEAST_RANDOMISATIONS: u32 = 10;
/// More units than anybody runs.
const MOST_UNITS: u32 = 10_000;

/// Which units are drawn. They are a pure function of the family and of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Population {
    /// How.
    pub method: Method,
    /// Seed.
    pub seed: u64,
    /// Number of units.
    pub units: u32,
    /// Sets of points that are randomised on their own, each of equally many units. Independent draws have one.
    pub randomisations: u32,
}

/// Why a population cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PopulationError {
    /// No unit, or too many.
    #[error("{units} units; expected 1 to {MOST_UNITS}")]
    Units {
        /// Units that were asked for.
        units: u32,
    },
    /// A seed that a unit file cannot hold.
    #[error("seed {seed}; expected at most {}", i64::MAX)]
    Seed {
        /// The seed.
        seed: u64,
    },
    /// Sets of too few points, or of different numbers of points.
    #[error(
        "{units} units in {randomisations} randomisations; expected at least {LEAST_RANDOMISATIONS} randomisations of equally \
         many units, at least two each: ask for {} units",
        suggested(*.units, *.randomisations)
    )]
    Randomisations {
        /// Units that were asked for.
        units: u32,
        /// Randomisations that were asked for.
        randomisations: u32,
    },
    /// The design has no such points.
    #[error("{0}: use the method `latin-hypercube`")]
    Design(#[from] DesignError),
}

/// A number of units that can be divided, at least as many as were asked for.
fn suggested(units: u32, randomisations: u32) -> u64 {
    let randomisations = u64::from(randomisations.max(LEAST_RANDOMISATIONS));
    (u64::from(units).div_ceil(randomisations)).max(2) * randomisations
}

impl Population {
    /// Refuses what cannot be drawn.
    fn check(&self) -> Result<(), PopulationError> {
        let &Self { method, seed, units, randomisations } = self;
        if !(1..=MOST_UNITS).contains(&units) {
            return Err(PopulationError::Units { units });
        }
        if i64::try_from(seed).is_err() {
            return Err(PopulationError::Seed { seed });
        }
        let is_divided = randomisations >= LEAST_RANDOMISATIONS
            && units.is_multiple_of(randomisations)
            && units / randomisations >= 2;
        if method != Method::Independent && !is_divided {
            return Err(PopulationError::Randomisations { units, randomisations });
        }
        Ok(())
    }
}

impl Family {
    /// The units of a population in the order of their numbers.
    ///
    /// # Errors
    /// What cannot be drawn: no units, sets of different sizes, more dimensions than Sobol points have.
    pub fn population(&self, population: &Population) -> Result<Vec<DrawnUnit>, PopulationError> {
        population.check()?;
        if population.method == Method::Independent {
            return Ok((1..=population.units).map(|number| self.unit(population.seed, number)).collect());
        }
        let mut drawn = Vec::new();
        for set in 0..population.randomisations {
            for point in self.points(population, u64::from(set))? {
                let number = 1 + drawn.len() as u32;
                drawn.push(self.file(population, number, &self.settings_at(point)));
            }
        }
        Ok(drawn)
    }

    /// One randomisation of a design.
    fn points(&self, population: &Population, set: u64) -> Result<Vec<Vec<f64>>, DesignError> {
        let points = (population.units / population.randomisations) as usize;
        let dimensions = self.variables.len();
        match population.method {
            Method::Sobol => scrambled_sobol(points, dimensions, population.seed, set),
            _ => Ok(latin_hypercube(points, dimensions, population.seed, set)),
        }
    }
}
