//! Controller parameter files.

use std::sync::LazyLock;

use controllers::DirectorGains;
use controllers::parameter::PARAMETERS;
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, Need, Shape, quoted, read_file};

use super::settings::{self, Described};
use super::shipped::{self, Folder};
use crate::model::rig::Rig;

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
            default: p.default,
            doc: p.doc,
            source: p.source,
        })
        .collect()
});
static FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| settings::fields(HEAD, &DESCRIBED));

/// Keys of a parameter file.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

/// Every parameter with what is known of it.
pub fn described() -> &'static [Described] {
    &DESCRIBED
}

/// The parameter set of this name; `beside` is the file that names it, if one does.
///
/// # Errors
/// All mistakes of the parameter file at once.
pub fn named(name: &str, beside: Option<&str>) -> Result<(String, DirectorGains), Vec<Diagnostic>> {
    let source: SourceFile = shipped::find(Folder::Parameters, name, beside)?;
    let (id, values) = read_file(&source, fields(), |t| {
        let (schema, id) = (t.schema(), t.text("id"));
        let values = settings::read(t, &DESCRIBED);
        schema.and(Some((id?, values)))
    })?;
    let mut gains = DirectorGains::default();
    for (index, value_si) in values {
        (PARAMETERS[index].set)(&mut gains, value_si);
    }
    Ok((id, gains))
}

/// Gains of a rig's production controllers, with a section for each of its axes.
///
/// # Errors
/// All mistakes of the parameter file at once, or an axis whose section it lacks.
pub fn load(rig: &Rig) -> Result<DirectorGains, Vec<Diagnostic>> {
    let (id, gains) = named(&rig.parameters, Some(&rig.source.name))?;
    let lacking = rig.axes.iter().filter(|axis| gains.axis(&axis.gains).is_none());
    let mistakes: Vec<Diagnostic> = lacking
        .map(|axis| {
            let message = format!(
                "axis `{}` takes its gains from section `{}`, and parameters `{id}` have no such section for an axis",
                axis.name, axis.gains
            );
            let known = quoted(DirectorGains::AXIS_SECTIONS);
            let help = format!("say `gains` in `[axis.{}]`: one of {known}", axis.name);
            Diagnostic::new(message).in_file(&rig.source).help(help)
        })
        .collect();
    if mistakes.is_empty() { Ok(gains) } else { Err(mistakes) }
}
