//! Unit files: the true parameters of a simulated unit. Only the constructor of the simulated rig gets them.
//!
//! A file is for one world: the director, or a rotary table of one to four axes. Both worlds share the head of the file, the
//! layering over bases, and the keys that say what a planted defect must and may cause.

use std::ops::Range;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, SCHEMA_FIELD, Shape, TableReader};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::files::shipped::{self, Folder, sort};
use crate::site::unit::{Unit, World};

mod chain;
mod director;
mod drawn;
mod state;
mod structure;
mod table;
mod values;

pub use director::{described, fields};
pub use drawn::{DrawnFrom, DrawnSettings, METHODS, Method, read_drawn};
pub use state::{in_state, load_state, read_state};
pub use structure::tables as structure_tables;
pub use table::{described_axis, described_table, fields as table_fields};

/// Values of `must-trip`: `polarity` is the check of signs before motion, `bus` the interlock on the bus.
pub const TRIPS: &[&str] = &["polarity", "bus"];

/// Value of `world` for a rotary table; other uses of "table" in this file are TOML tables.
const TABLE: &str = "table";

const HEAD: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name of the unit."),
    Field::required("title", Shape::Text, "Heading."),
    Field::default(
        "world",
        Shape::Choice(&["director", TABLE]),
        "director",
        "What is simulated: the director, or a rotary table of one to four axes, each a table `[axis.<name>]`.",
    ),
    Field::optional("base", Shape::Text, "Base unit: its settings apply where this file gives none."),
    Field::optional("must-flip", Shape::Texts, "Requirements that this defect must make fail."),
    Field::optional("may-flip", Shape::Texts, "Requirements whose verdict it may change."),
    Field::optional(
        "must-trip",
        Shape::Choice(TRIPS),
        "What this defect must trip: the run then ends before a requirement is measured.",
    ),
    Field::optional("reason", Shape::Text, "Physical cause of the defect."),
    Field::optional("drawn", Shape::Table(drawn::FIELDS), "Where a unit that `bench draw` wrote comes from."),
];

/// One parsed file, before its settings are layered over those of its base.
struct Parsed {
    id: String,
    title: String,
    /// Name of the base, and where the file says it.
    base: Option<(String, Range<usize>)>,
    must_flip: Vec<String>,
    may_flip: Vec<String>,
    must_trip: Option<String>,
    reason: Option<String>,
    drawn: Option<DrawnFrom>,
    given: Given,
}

/// The settings that one file gives.
enum Given {
    Director(director::Given),
    Table(table::Given),
}

impl Given {
    fn is_of_table(&self) -> bool {
        matches!(self, Self::Table(_))
    }

    fn world(&self) -> &'static str {
        if self.is_of_table() { "a rotary table" } else { "the director" }
    }
}

/// Finds, parses and layers a unit over its bases.
///
/// # Errors
/// All mistakes of the first file that has any. If none has, the mistakes in how the files fit each other.
pub fn load_unit(name: &str) -> Result<Unit, Vec<Diagnostic>> {
    load_unit_beside(name, None)
}

/// Finds a unit as [`load_unit`] does; a path lies beside the file that names the unit, if one does.
///
/// # Errors
/// As [`load_unit`].
pub(super) fn load_unit_beside(name: &str, beside: Option<&str>) -> Result<Unit, Vec<Diagnostic>> {
    let own = shipped::find(Folder::Units, name, beside)?;
    read_unit(sort::expect(own, Folder::Units)?)
}

/// Parses a unit file and layers the unit over its bases.
///
/// # Errors
/// As [`load_unit`].
pub fn read_unit(source: SourceFile) -> Result<Unit, Vec<Diagnostic>> {
    layered(chain::of(source)?)
}

/// The unit that a chain describes: the unit's own file is first, then its base, then the base of that.
///
/// Settings come from all files. Names, and what a defect must and may cause, come from the unit's own file alone.
fn layered(chain: Vec<(SourceFile, Parsed)>) -> Result<Unit, Vec<Diagnostic>> {
    let world = world(&chain)?;
    let (sources, parsed): (Vec<SourceFile>, Vec<Parsed>) = chain.into_iter().unzip();
    let own = parsed.into_iter().next().expect("the chain holds at least the unit itself");
    Ok(Unit {
        id: own.id,
        title: own.title,
        world,
        must_flip: own.must_flip,
        may_flip: own.may_flip,
        must_trip: own.must_trip,
        reason: own.reason,
        sources,
    })
}

/// The settings of all files of a chain, layered: those of a file replace those of its base.
fn world(chain: &[(SourceFile, Parsed)]) -> Result<World, Vec<Diagnostic>> {
    check_worlds(chain)?;
    let mut directors = Vec::new();
    let mut tables = Vec::new();
    for (source, parsed) in chain {
        match &parsed.given {
            Given::Director(given) => directors.push(director::Layer { source, given }),
            Given::Table(given) => tables.push(table::Layer { source, given }),
        }
    }
    if tables.is_empty() {
        return director::layered(&directors).map(|settings| World::Director(Box::new(settings)));
    }
    table::layered(&tables).map(World::Table)
}

/// Refuses a chain whose files are for different worlds. The mistake points at the `base` key of the upper file.
fn check_worlds(chain: &[(SourceFile, Parsed)]) -> Result<(), Vec<Diagnostic>> {
    for pair in chain.windows(2) {
        let [(source, above), (below_source, below)] = pair else { continue };
        if above.given.is_of_table() == below.given.is_of_table() {
            continue;
        }
        let own = above.given.world();
        let other = below.given.world();
        let message = format!(
            "`{}` is for {own}, but `{}`, on which it builds, is for {other}",
            source.name, below_source.name
        );
        let mistake = Diagnostic::new(message).help("give both the same `world`, or choose another base");
        return Err(vec![match &above.base {
            Some((_, span)) => mistake.at(source, span.clone()),
            None => mistake.in_file(source),
        }]);
    }
    Ok(())
}

/// Keys that a file may have. They depend on its `world`, so that key alone is looked up before the file is read.
fn fields_of(source: &SourceFile) -> &'static [Field] {
    let (root, _) = DeTable::parse_recoverable(&source.text);
    match root.get_ref().get("world").map(Spanned::get_ref) {
        Some(DeValue::String(word)) if word == TABLE => table::reading_fields(),
        _ => director::fields(),
    }
}

fn read(t: &mut TableReader<'_>) -> Option<Parsed> {
    let schema = t.schema();
    let id = t.text("id");
    let title = t.text("title");
    let world = t.text("world");
    let base = t.text("base").map(|base| (base, t.span("base")));
    let must_flip = t.texts("must-flip");
    let may_flip = t.texts("may-flip");
    let must_trip = t.text("must-trip");
    let reason = t.text("reason");
    let drawn = t.has("drawn").then(|| t.table("drawn", drawn::read)).flatten();
    let given = match world.as_deref() {
        Some(TABLE) => Given::Table(table::read(t)),
        _ => Given::Director(director::read(t)),
    };
    // Only now, after every key has been read: so all mistakes of the file are reported at once.
    schema?;
    Some(Parsed {
        id: id?,
        title: title?,
        base,
        must_flip: must_flip.unwrap_or_default(),
        may_flip: may_flip.unwrap_or_default(),
        must_trip,
        reason,
        drawn,
        given,
    })
}

#[cfg(test)]
mod tests;
