//! `bench draw`: unit files of the units of a family.

use std::path::{Path, PathBuf};

use reports::printable::counted;

use super::{folders, output};
use crate::exit;
use crate::files::family::{DrawnUnit, LEAST_RANDOMISATIONS, Population, load_family};
use crate::files::unit::Method;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Family of units: a shipped name (`bench list families`) or a path
    family: String,
    /// Number of units
    #[arg(long, value_name = "N")]
    units: u32,
    /// Seed of the population
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// How the units are chosen
    #[arg(long, value_enum, default_value_t = Way::Independent)]
    method: Way,
    /// Sets of points of a design that are randomised on their own, each of equally many units
    #[arg(long, value_name = "R", default_value_t = LEAST_RANDOMISATIONS)]
    randomisations: u32,
    /// Folder for the unit files
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Methods as the command line has them.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum Way {
    /// Each on its own: for pass probabilities
    Independent,
    /// Latin hypercubes: for quantiles and sensitivities
    LatinHypercube,
    /// Scrambled Sobol points: for quantiles and sensitivities
    Sobol,
}

pub(super) fn run(args: &Args) -> u8 {
    match draw(args) {
        Ok(code) | Err(code) => code,
    }
}

fn draw(args: &Args) -> Result<u8, u8> {
    let family = load_family(&args.family).map_err(|mistakes| output::mistakes(&mistakes))?;
    let method = match args.method {
        Way::Independent => Method::Independent,
        Way::LatinHypercube => Method::LatinHypercube,
        Way::Sobol => Method::Sobol,
    };
    let population =
        Population { method, seed: args.seed, units: args.units, randomisations: args.randomisations };
    let units = family
        .population(&population)
        .map_err(|error| output::mistake(&format!("{}: {error}", family.id)))?;
    for unit in &units {
        unit.load().map_err(|mistakes| output::mistakes(&mistakes))?;
    }
    let folder = args.out.display();
    folders::make(&args.out)?;
    write(&args.out, &units).map_err(|error| folders::unwritable(&args.out, &error))?;
    let first = units.first().map_or("", |unit| unit.id.as_str());
    output::say(&format!(
        "{folder}: {} of {} with seed {}; run one with `bench run --unit {folder}/{first}.toml`",
        counted(units.len(), "unit"),
        family.id,
        args.seed
    ));
    Ok(exit::PASS)
}

fn write(folder: &Path, units: &[DrawnUnit]) -> std::io::Result<()> {
    units.iter().try_for_each(|unit| std::fs::write(folder.join(format!("{}.toml", unit.id)), &unit.text))
}
