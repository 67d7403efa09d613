//! Expected results of units, from the model: `expected_results [--all] [UNIT…]`, default every shipped unit.
use std::process::ExitCode;

use bench::files::shipped::{self, Folder};
use bench::files::unit::load_unit;
use bench::site::unit::Unit;
use validation::expected::{Judge, Verified, flips, table, worst};

pub(crate) fn study() -> ExitCode {
    let (flags, names): (Vec<String>, Vec<String>) =
        crate::arguments().partition(|argument| argument.starts_with("--"));
    let all_rows = flags.iter().any(|flag| flag == "--all");
    let names = if names.is_empty() {
        shipped::all(Folder::Units).map(|unit| unit.stem().to_owned()).collect()
    } else {
        names
    };
    match print(&names, all_rows) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(mistake) => {
            println!("{mistake}");
            ExitCode::from(2)
        }
    }
}

fn print(names: &[String], all_rows: bool) -> Result<bool, String> {
    let told = |mistakes: Vec<procedures::diagnostic::Diagnostic>| format!("{mistakes:?}");
    let judge = Judge::shipped().map_err(told)?;
    let nominal = load_unit("nominal").map_err(told)?;
    let nominal = judge.verify(nominal.director().ok_or("`nominal` is no director")?);
    let mut holds = true;
    for name in names {
        let unit = load_unit(name).map_err(told)?;
        let Some(settings) = unit.director() else { continue };
        let rows = judge.verify(settings);
        println!("{}: {}", unit.id, unit.title);
        if names.len() == 1 || all_rows || unit.id == "nominal" || unit.id == "as-measured" {
            let shown: Vec<&Verified> = if all_rows { rows.iter().collect() } else { worst(&rows) };
            println!("{}", table(shown));
        }
        holds &= unit.id == "as-measured" || tell_flips(&unit, &rows, &nominal);
    }
    Ok(holds)
}

fn tell_flips(unit: &Unit, rows: &[Verified], nominal: &[Verified]) -> bool {
    let flips = flips(unit, rows, nominal);
    if let Some((what, why)) = &flips.trip {
        println!("  trips {what}: {why}");
    }
    for (id, verdict) in &flips.turned {
        let must = unit.must_flip.iter().any(|m| m == id);
        println!("  {id} turns to {verdict:?}{}", if must { " (must)" } else { "" });
    }
    for broken in &flips.broken {
        println!("  NOT AS CLAIMED: {broken}");
    }
    flips.broken.is_empty()
}
