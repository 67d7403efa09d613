//! How often a comparison of controllers calls planted changes rightly.
//!
//! For each change a pilot of eight units tells the scatter of the shifts; the number of units is the one that calls the
//! effect of the linear model rightly with a probability of 0.999, if the scatter is at its upper bound of 90 %. Then the comparison is
//! repeated on fresh units.
//!
//! `cargo run --release -p validation -- planted_changes [REPETITIONS] [NAME]`

use analysis::paired::{Plan, PlannedCall, scatter_at_most};
use procedures::regression::{Call, Look};
use validation::planted::{Bed, PLANTED, Planted, outcome};

const PILOT_UNITS: u32 = 8;
const POWER: f64 = 0.999;
/// First number of the units of repetitions; the pilot has those before.
const FIRST: u32 = 10_001;

pub(crate) fn study() {
    let mut arguments = crate::arguments();
    let repetitions: u32 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(100);
    let only = arguments.next();
    println!(
        "| change | measurand | effect by the model | margin | expected | scatter | units | power | right | blocks | mean shift |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for planted in
        PLANTED.iter().filter(|planted| only.as_deref().is_none_or(|only| planted.name.contains(only)))
    {
        row(planted, repetitions);
    }
}

fn row(planted: &Planted, repetitions: u32) {
    let effect = planted.effect();
    let scatter = scatter(planted);
    let (units, power) = units(planted, effect, scatter);
    let (right, blocks, mean) = repeat(planted, units, repetitions);
    let show = |si: f64| planted.kind.format(si);
    println!(
        "| {} | {} | {} | {} | {:?} | {} | {units} | {power:.4} | {right} of {repetitions} | {blocks} | {} |",
        planted.name,
        planted.measurand,
        show(effect),
        show(planted.margin),
        planted.expected,
        show(scatter),
        show(mean)
    );
}

/// Upper bound of the scatter from unit to unit, by the pilot.
fn scatter(planted: &Planted) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let bed = Bed::new(planted, folder.path(), 1, PILOT_UNITS).expect("files without a mistake");
    let arms = bed.run(planted, folder.path(), jobs());
    let found = outcome(planted, &arms, 0, PILOT_UNITS as usize);
    let scatter = found.scatter.unwrap_or(0.0);
    scatter_at_most(scatter, f64::from(PILOT_UNITS - 1), 0.9).unwrap_or(0.0)
}

/// Units of a comparison, and the probability of the right call.
fn units(planted: &Planted, effect: f64, scatter: f64) -> (u32, f64) {
    const FEWEST: u64 = 4;
    let call = match planted.expected {
        Call::Worse | Call::Better => PlannedCall::Worse,
        _ => PlannedCall::Equivalent,
    };
    let plan =
        Plan { call, effect: effect.abs(), margin: planted.margin, scatter, level: Look::Single.level() };
    if scatter == 0.0 {
        return (FEWEST as u32, 1.0);
    }
    let pairs = plan
        .pairs(POWER)
        .expect("an effect on its side of the margin: a test of this crate says so")
        .max(FEWEST);
    (u32::try_from(pairs).unwrap_or(u32::MAX), plan.probability(pairs))
}

/// Right calls, blocks, and the mean shift over all.
fn repeat(planted: &Planted, units: u32, repetitions: u32) -> (u32, u32, f64) {
    let mut right = 0;
    let mut blocks = 0;
    let mut sum = 0.0;
    for repetition in 0..repetitions {
        let folder = tempfile::tempdir().expect("a folder");
        let first = FIRST + repetition * units;
        let bed = Bed::new(planted, folder.path(), first, units).expect("files without a mistake");
        let arms = bed.run(planted, folder.path(), jobs());
        let found = outcome(planted, &arms, 0, units as usize);
        right += u32::from(found.call == planted.expected);
        blocks += u32::from(found.blocks);
        sum += found.shift.unwrap_or(f64::NAN);
    }
    (right, blocks, sum / f64::from(repetitions.max(1)))
}

fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
