//! Unit files: what the simulation obeys. Handed to nothing but the constructor of the simulated rig.

use std::sync::LazyLock;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, Need, Shape, TableReader, read_file};
use sim_devices::unit::{PARAMETERS, UnitSettings};

use super::settings::{self, Described};
use super::shipped::{self, Folder};

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
    /// The physical reason.
    pub reason: Option<String>,
    /// The files, from the unit itself to its last base.
    pub sources: Vec<SourceFile>,
}

const HEAD: &[Field] = &[
    field("schema", Shape::Integer, Need::Required, "Version of the format: 1."),
    field("id", Shape::Text, Need::Required, "Name of the unit."),
    field("title", Shape::Text, Need::Required, "Heading."),
    field("base", Shape::Text, Need::Optional, "Unit whose settings hold where this file is silent."),
    field("must-flip", Shape::Texts, Need::Optional, "Requirements that this defect must turn to fail."),
    field("may-flip", Shape::Texts, Need::Optional, "Requirements that it may turn."),
    field("reason", Shape::Text, Need::Optional, "The physical reason of the defect."),
];

const fn field(key: &'static str, shape: Shape, need: Need, doc: &'static str) -> Field {
    Field { key, shape, need, doc }
}

static DESCRIBED: LazyLock<Vec<Described>> = LazyLock::new(|| {
    PARAMETERS
        .iter()
        .map(|p| Described {
            key: p.key,
            quantity: p.quantity,
            min_si: p.min_si,
            max_si: p.max_si,
            doc: p.doc,
        })
        .collect()
});
static FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| settings::fields(HEAD, &DESCRIBED));

/// Keys of a unit file.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

struct Parsed {
    id: String,
    title: String,
    base: Option<String>,
    must_flip: Vec<String>,
    may_flip: Vec<String>,
    reason: Option<String>,
    values: Vec<(usize, f64)>,
}

/// Longest chain of bases: a circle is longer than any sensible chain.
const MAX_BASES: usize = 8;

impl Unit {
    /// Finds, parses and layers a unit over its bases.
    ///
    /// # Errors
    /// All mistakes of the first file that has any.
    pub fn load(name: &str) -> Result<Self, Vec<Diagnostic>> {
        let mut chain = Vec::new();
        let mut next = Some((name.to_owned(), None));
        while let Some((wanted, beside)) = next.take() {
            let source = shipped::find(Folder::Units, &wanted, beside.as_deref())?;
            let parsed = read_file(&source, fields(), read)?;
            next = parsed.base.clone().map(|base| (base, Some(source.name.clone())));
            chain.push((source, parsed));
            if chain.len() > MAX_BASES {
                let message = format!("unit {name}: more than {MAX_BASES} bases in a row");
                return Err(vec![
                    Diagnostic::new(message).help("a base must not lead back to the unit itself"),
                ]);
            }
        }
        Ok(Self::layered(chain))
    }

    fn layered(chain: Vec<(SourceFile, Parsed)>) -> Self {
        let mut settings = UnitSettings::default();
        for (_, parsed) in chain.iter().rev() {
            for &(index, value_si) in &parsed.values {
                (PARAMETERS[index].set)(&mut settings, value_si);
            }
        }
        let (mut sources, mut own) = (Vec::new(), None);
        for (source, parsed) in chain {
            sources.push(source);
            own.get_or_insert(parsed);
        }
        let own = own.expect("the chain holds at least the unit itself");
        Self {
            id: own.id,
            title: own.title,
            settings,
            must_flip: own.must_flip,
            may_flip: own.may_flip,
            reason: own.reason,
            sources,
        }
    }
}

fn read(t: &mut TableReader<'_>) -> Option<Parsed> {
    let (id, title, base) = (t.text("id"), t.text("title"), t.text("base"));
    let (must_flip, may_flip) = (t.texts("must-flip"), t.texts("may-flip"));
    let reason = t.text("reason");
    let values = settings::read(t, &DESCRIBED);
    Some(Parsed {
        id: id?,
        title: title?,
        base,
        must_flip: must_flip.unwrap_or_default(),
        may_flip: may_flip.unwrap_or_default(),
        reason,
        values,
    })
}
