//! Unit files: what the simulation obeys. Handed to nothing but the constructor of the simulated rig.

use std::ops::Range;
use std::sync::LazyLock;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, SCHEMA_FIELD, Shape, TableReader};
use sim_devices::unit::{PARAMETERS, UnitSettings};

use super::settings::{self, Described};

mod chain;
mod state;
mod structure;
mod values;

pub use state::BuildState;
pub use structure::tables as structure_tables;
use structure::{GivenCurve, Layers};
use values::Values;

/// A unit file with everything that its bases say.
#[derive(Clone, Debug)]
pub struct Unit {
    /// E.g. `nominal`, `azimuth-retainer`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What the simulation obeys.
    pub settings: UnitSettings,
    /// Requirements that this defect must turn to fail.
    pub must_flip: Vec<String>,
    /// Requirements that it may turn.
    pub may_flip: Vec<String>,
    /// The check before motion or the interlock that this defect must trip, so that nothing is measured.
    pub must_trip: Option<String>,
    /// The physical reason.
    pub reason: Option<String>,
    /// The files, from the unit itself to its last base.
    pub sources: Vec<SourceFile>,
}

/// What a defect can trip: the check of signs before motion, and the interlock on the bus.
pub const TRIPS: &[&str] = &["polarity", "bus"];

const HEAD: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name of the unit."),
    Field::required("title", Shape::Text, "Heading."),
    Field::optional("base", Shape::Text, "Unit whose settings hold where this file is silent."),
    Field::optional("must-flip", Shape::Texts, "Requirements that this defect must turn to fail."),
    Field::optional("may-flip", Shape::Texts, "Requirements that it may turn."),
    Field::optional(
        "must-trip",
        Shape::Choice(TRIPS),
        "What this defect must trip, so that the run rightly ends before a requirement is measured.",
    ),
    Field::optional("reason", Shape::Text, "The physical reason of the defect."),
];

static DESCRIBED: LazyLock<Vec<Described>> = LazyLock::new(|| {
    PARAMETERS
        .iter()
        .map(|p| Described {
            key: p.key,
            quantity: p.quantity,
            min_si: p.min_si,
            max_si: p.max_si,
            default: p.default,
            doc: p.doc,
            source: p.source,
        })
        .collect()
});
static FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| {
    let head: Vec<Field> = HEAD.iter().copied().chain(structure::fields()).collect();
    settings::fields(&head, &DESCRIBED)
});

/// Keys of a unit file.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

/// Every scalar setting with what is known of it, in the order of [`PARAMETERS`].
pub fn described() -> &'static [Described] {
    &DESCRIBED
}

/// One file, before it lies over its base.
struct Parsed {
    id: String,
    title: String,
    base: Option<(String, Range<usize>)>,
    must_flip: Vec<String>,
    may_flip: Vec<String>,
    must_trip: Option<String>,
    reason: Option<String>,
    values: Vec<(usize, f64)>,
    curves: Vec<GivenCurve>,
}

impl Unit {
    /// Whether something is planted in it: it claims to fail a requirement, or to end a run.
    pub fn is_defect(&self) -> bool {
        self.must_trip.is_some() || !self.must_flip.is_empty()
    }

    /// Finds, parses and layers a unit over its bases.
    ///
    /// # Errors
    /// All mistakes of the first file that has any, or of how the files fit each other.
    pub fn load(name: &str) -> Result<Self, Vec<Diagnostic>> {
        Self::layered(chain::of(name)?)
    }

    fn layered(chain: Vec<(SourceFile, Parsed)>) -> Result<Self, Vec<Diagnostic>> {
        let mut settings = UnitSettings::default();
        for (_, parsed) in chain.iter().rev() {
            for &(index, value_si) in &parsed.values {
                (PARAMETERS[index].set)(&mut settings, value_si);
            }
        }
        let layers = chain.iter().map(|(source, parsed)| (source, parsed.curves.as_slice())).collect();
        let mut mistakes = Layers::new(layers).apply(&mut settings);
        let values = chain.iter().map(|(source, parsed)| (source, parsed.values.as_slice())).collect();
        mistakes.extend(Values::new(values).check(&settings));
        if !mistakes.is_empty() {
            return Err(mistakes);
        }
        let (sources, parsed): (Vec<SourceFile>, Vec<Parsed>) = chain.into_iter().unzip();
        let own = parsed.into_iter().next().expect("the chain holds at least the unit itself");
        Ok(Self {
            id: own.id,
            title: own.title,
            settings,
            must_flip: own.must_flip,
            may_flip: own.may_flip,
            must_trip: own.must_trip,
            reason: own.reason,
            sources,
        })
    }
}

fn read(t: &mut TableReader<'_>) -> Option<Parsed> {
    let (schema, id, title) = (t.schema(), t.text("id"), t.text("title"));
    let base = t.text("base").map(|base| (base, t.span("base")));
    let (must_flip, may_flip) = (t.texts("must-flip"), t.texts("may-flip"));
    let (must_trip, reason) = (t.text("must-trip"), t.text("reason"));
    let values = settings::read(t, &DESCRIBED);
    let curves = structure::read(t);
    schema?;
    Some(Parsed {
        id: id?,
        title: title?,
        base,
        must_flip: must_flip.unwrap_or_default(),
        may_flip: may_flip.unwrap_or_default(),
        must_trip,
        reason,
        values,
        curves,
    })
}

#[cfg(test)]
mod tests;
