//! Controller parameter files.

use std::sync::LazyLock;

use controllers::parameter::PARAMETERS;
use controllers::{AxisGains, DirectorGains};
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, Need, Shape, read_file};

use super::rig::Rig;
use super::settings::{self, Described};
use super::shipped::{self, Folder};

const HEAD: &[Field] = &[
    Field { key: "schema", shape: Shape::Integer, need: Need::Required, doc: "Version of the format: 1." },
    Field { key: "id", shape: Shape::Text, need: Need::Required, doc: "Name of the parameter set." },
];

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

/// Keys of a parameter file.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

/// Gains of every axis of a rig, in its order.
///
/// # Errors
/// All mistakes of the parameter file at once.
pub fn load(rig: &Rig) -> Result<Vec<AxisGains>, Vec<Diagnostic>> {
    let source: SourceFile = shipped::find(Folder::Parameters, &rig.parameters, Some(&rig.source.name))?;
    let values = read_file(&source, fields(), |t| {
        let _ = t.text("id");
        Some(settings::read(t, &DESCRIBED))
    })?;
    let mut gains = DirectorGains::default();
    for (index, value_si) in values {
        (PARAMETERS[index].set)(&mut gains, value_si);
    }
    Ok(rig.axes.iter().map(|axis| if axis.name == "az" { gains.az } else { gains.el }).collect())
}
