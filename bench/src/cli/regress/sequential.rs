//! Looks at a growing number of units, until all is decided.

use std::path::Path;

use procedures::regression::{ArmRecord, Call, Look};
use reports::regression::Regression;

use super::{Args, BaselineArm, Prepared, both, decided, finish, kept};
use crate::cli::output;
use crate::exit;
use crate::regression::population::Units;
use crate::regression::{Asked, Course, Records, store};

/// Compares at each look of the criteria; the last one that was needed decides.
pub(super) fn compare(args: &Args, prepared: &Prepared, asked: &Asked<'_>, folder: &Path) -> Result<u8, u8> {
    let (Some(criteria), Some(candidate)) = (&prepared.criteria, &prepared.candidate) else {
        return Err(exit::USAGE);
    };
    let BaselineArm::ToRun(_) = prepared.baseline else {
        output::error(
            "--sequential runs both arms look by look; give the baseline's parameters instead of a record",
        );
        return Err(exit::USAGE);
    };
    let last = criteria.looks.last().copied().unwrap_or(0);
    // A family has as many units as are asked for.
    if matches!(prepared.units, Units::Named(_)) && prepared.units.count() < last {
        output::error(&format!(
            "--sequential looks at up to {last} units, and there are {}; name more, or set `looks` in the criteria file",
            prepared.units.count()
        ));
        return Err(exit::USAGE);
    }
    let mut all: Option<Records> = None;
    let mut from = 1;
    for (number, &units) in (1..).zip(&criteria.looks) {
        let found = both(asked, &prepared.baseline, candidate, Course { from, to: units })?;
        let found = match all {
            Some(before) => Records {
                baseline: joined(before.baseline, found.baseline),
                candidate: joined(before.candidate, found.candidate),
            },
            None => found,
        };
        let regression = decided(criteria, &found, Look::Sequential { number })?;
        output::note(&format!("look {number}, {units} units: {}", regression.headline()));
        if is_decided(&regression) || units == last {
            if !args.keep {
                let _ = std::fs::remove_dir(&asked.folder);
            }
            kept(store::write_records(folder, &looked(found, number), criteria))?;
            return finish(folder, &regression, args.json);
        }
        all = Some(found);
        from = units + 1;
    }
    Err(exit::USAGE)
}

/// The records with the look that decided.
fn looked(found: Records, number: usize) -> Records {
    let with = |arm: ArmRecord| ArmRecord { look: Some(number), ..arm };
    Records { baseline: with(found.baseline), candidate: with(found.candidate) }
}

fn is_decided(regression: &Regression) -> bool {
    regression.call() != Call::Inconclusive
}

/// The runs of both, with the number of units of the later one.
fn joined(before: ArmRecord, mut later: ArmRecord) -> ArmRecord {
    let mut replicates = before.replicates;
    replicates.append(&mut later.replicates);
    ArmRecord { replicates, ..later }
}
