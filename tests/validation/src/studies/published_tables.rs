//! The study's reference results (tables 4.1 to 4.5) beside the linear model and the simulated plant, for a unit.
//!
//! `cargo run --release -p validation -- published_tables [UNIT]`; the unit is `as-measured` where none is named.
use bench::files::parameters;
use bench::files::unit::load_unit;
use procedures::diagnostic::Diagnostic;
use validation::published;

pub(crate) fn study() -> std::process::ExitCode {
    let name = crate::arguments().next().unwrap_or_else(|| "as-measured".to_owned());
    match table(&name) {
        Ok((text, holds)) => {
            println!("unit {name}\n{text}");
            if holds { std::process::ExitCode::SUCCESS } else { std::process::ExitCode::FAILURE }
        }
        Err(mistakes) => {
            mistakes.iter().for_each(|mistake| eprintln!("{mistake}"));
            std::process::ExitCode::from(bench::exit::USAGE)
        }
    }
}

/// The table, and whether every row is within its tolerance.
fn table(name: &str) -> Result<(String, bool), Vec<Diagnostic>> {
    let unit = load_unit(name)?;
    let (_, gains) = parameters::named("director", None)?;
    let no_director = || vec![Diagnostic::new(format!("unit `{name}` is no director"))];
    let settings = unit.director().ok_or_else(no_director)?;
    let rows = published::rows(settings, &gains);
    Ok((published::table(&rows), rows.iter().all(published::Row::holds)))
}
