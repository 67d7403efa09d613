//! Build states: what differs in a unit that is not complete yet. A state is laid over whichever unit is chosen.

use procedures::diagnostic::{Diagnostic, SourceFile};

use super::{chain, layered};
use crate::files::shipped::{self, Folder};
use crate::site::unit::{BuildState, Unit};

/// Finds and reads a state by its shipped name or its path beside the campaign that names it.
///
/// # Errors
/// All mistakes of the file.
pub fn load_state(name: &str, beside: Option<&str>) -> Result<BuildState, Vec<Diagnostic>> {
    read_state(shipped::find(Folder::States, name, beside)?)
}

/// Reads a state file: keys of a unit file, without a base and without what belongs to a planted defect.
///
/// # Errors
/// All mistakes of the file.
pub fn read_state(source: SourceFile) -> Result<BuildState, Vec<Diagnostic>> {
    let (source, parsed) = chain::parsed(source)?;
    if let Some((base, span)) = &parsed.base {
        let message =
            format!("a build state is applied to the unit of the run, so it cannot have the base `{base}`");
        return Err(vec![Diagnostic::new(message).at(&source, span.clone()).help("remove `base`")]);
    }
    if let Some(drawn) = &parsed.drawn {
        let message = format!("build state `{}` was drawn from the family `{}`", parsed.id, drawn.family);
        return Err(vec![Diagnostic::new(message).in_file(&source).help("use the file as a unit")]);
    }
    if parsed.must_trip.is_some() || !parsed.must_flip.is_empty() || !parsed.may_flip.is_empty() {
        let message = format!("build state `{}` is marked as a planted defect", parsed.id);
        let help = "remove `must-flip`, `may-flip` and `must-trip`, or use the file as a unit";
        return Err(vec![Diagnostic::new(message).in_file(&source).help(help)]);
    }
    Ok(BuildState { id: parsed.id, title: parsed.title, source })
}

/// A unit in a build state: its own name, the settings of the state over its own.
///
/// # Errors
/// Where the settings do not fit each other.
pub fn in_state(unit: &Unit, state: &BuildState) -> Result<Unit, Vec<Diagnostic>> {
    let files = std::iter::once(&state.source).chain(&unit.sources);
    let chain = files.map(|source| chain::parsed(source.clone())).collect::<Result<Vec<_>, _>>()?;
    let laid = layered(chain)?;
    Ok(Unit { world: laid.world, sources: laid.sources, ..unit.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::unit::load_unit;

    fn state(more: &str) -> Result<BuildState, Vec<Diagnostic>> {
        let text = format!("schema = 1\nid = \"bare\"\ntitle = \"Bare\"\n{more}");
        read_state(SourceFile { name: "bare.toml".to_owned(), text })
    }

    #[test]
    fn every_shipped_state_lies_over_every_unit_and_changes_only_what_it_says() {
        for name in ["nominal", "as-measured", "azimuth-retainer"] {
            let unit = load_unit(name).expect("shipped");
            for file in shipped::all(Folder::States) {
                let state = load_state(file.stem(), None).expect("shipped");
                assert_eq!(state.id, file.stem());
                let built = in_state(&unit, &state).expect("they fit");
                assert_ne!(built.world, unit.world, "{} over {name}", state.id);
                let [built_damping, damping] = [&built, &unit]
                    .map(|unit| unit.director().expect("a director").az.viscous_damping_nm_s_per_rad);
                assert_eq!(built_damping, damping);
                assert_eq!((built.id.as_str(), built.sources.len()), (name, unit.sources.len() + 1));
            }
        }
    }

    #[test]
    fn a_state_has_no_base_and_plants_nothing() {
        for (more, expected) in [
            ("base = \"nominal\"\n", "it cannot have the base `nominal`"),
            (
                "must-flip = [\"FRC-AZ\"]\nreason = \"r\"\n",
                "build state `bare` is marked as a planted defect",
            ),
        ] {
            let found = state(more).expect_err("a mistake");
            assert!(found[0].message.contains(expected), "{}", found[0].message);
        }
        assert!(load_state("azimut-table", None).expect_err("unknown")[0].help.is_some());
    }

    #[test]
    fn a_state_of_the_director_does_not_lie_over_a_table() {
        let state = load_state("azimuth-table", None).expect("shipped");
        let found = in_state(&load_unit("table").expect("shipped"), &state).expect_err("another world");
        assert_eq!(
            found[0].message,
            "`shipped:azimuth-table.toml` is for the director, but `shipped:table.toml`, on which it \
             builds, is for a rotary table"
        );
    }

    #[test]
    fn a_state_that_does_not_fit_the_unit_is_pointed_at_in_its_own_file() {
        let broken = state("[az]\nstatic-torque = \"1 N*m\"\n").expect("right in itself");
        let found =
            in_state(&load_unit("nominal").expect("shipped"), &broken).expect_err("breakaway below sliding");
        assert_eq!(found[0].file.as_deref(), Some("bare.toml"));
    }
}
