//! Controller parameter files.

use std::sync::LazyLock;

use controllers::parameter::{AXIS_PARAMETERS, PARAMETERS, VELOCITY_LAW};
use controllers::velocity::{LAWS, VelocityLaw};
use controllers::{AxisGains, DirectorGains};
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::quantity::QuantityKind;
use procedures::table::{Field, Need, Shape, TableReader, quoted, read_file};

use super::settings::{self, Described};
use super::shipped::{self, Folder};
use crate::model::rig::Rig;

const HEAD: &[Field] = &[
    Field { key: "schema", shape: Shape::Integer, need: Need::Required, doc: "Version of the format: 1." },
    Field { key: "id", shape: Shape::Text, need: Need::Required, doc: "Name of the parameter set." },
];

static DESCRIBED: LazyLock<Vec<Described>> =
    LazyLock::new(|| PARAMETERS.iter().map(settings::of_gain).collect());
static OF_AXIS: LazyLock<Vec<Described>> =
    LazyLock::new(|| AXIS_PARAMETERS.iter().map(settings::of_gain).collect());
static FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| {
    let gain = |d: &Described| {
        let kind = settings::quantity_kind(d.quantity).unwrap_or(QuantityKind::Ratio);
        Field::required(d.key, Shape::Quantity(kind), d.doc)
    };
    let of_axis: &'static [Field] = Vec::leak(OF_AXIS.iter().map(gain).chain([*LAW]).collect());
    let section: &'static Shape = Box::leak(Box::new(Shape::Table(of_axis)));
    let doc = "Gains of further axes, `[axis.<name>]`: name of an axis of the rig, or the section that its \
               key `gains` names.";
    let head: Vec<Field> =
        HEAD.iter().copied().chain([Field::optional("axis", Shape::Map(section), doc)]).collect();
    let mut all = settings::fields(&head, &DESCRIBED).to_vec();
    for field in &mut all {
        if let Shape::Table(inside) = field.shape
            && director_sections().any(|section| section == field.key)
        {
            field.shape = Shape::Table(Vec::leak([inside, &[*LAW]].concat()));
        }
    }
    Vec::leak(all)
});

/// The law of a velocity loop: one of [`LAWS`].
static LAW: LazyLock<Field> = LazyLock::new(|| {
    let names: Vec<&str> = LAWS.iter().map(|law| law.name).collect();
    Field::default(VELOCITY_LAW, Shape::Choice(Vec::leak(names)), VelocityLaw::DEFAULT.name(), law_doc())
});

/// What the key of the law is for, and what each of the laws does.
pub fn law_doc() -> &'static str {
    let laws: Vec<String> = LAWS.iter().map(|law| format!("`{}`: {}", law.name, law.doc)).collect();
    String::leak(format!("Law of the velocity loop. {}", laws.join(" ")))
}

/// Keys of a parameter file.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

/// Every parameter with what is known of it.
pub fn described() -> &'static [Described] {
    &DESCRIBED
}

/// A parameter file as it was read.
struct Set {
    id: String,
    gains: DirectorGains,
    /// Sections `[axis.<name>]`.
    axes: Vec<(String, AxisGains)>,
}

impl Set {
    fn read(name: &str, beside: Option<&str>) -> Result<Self, Vec<Diagnostic>> {
        let source: SourceFile = shipped::find(Folder::Parameters, name, beside)?;
        read_file(&source, fields(), |t| {
            let schema = t.schema();
            let id = t.text("id");
            let mut gains = DirectorGains::default();
            let [mut az, mut el] = [VelocityLaw::DEFAULT; 2];
            let laws = |t: &mut TableReader<'_>, table: &'static str| match table {
                "az" => az = read_law(t),
                "el" => el = read_law(t),
                _ => {}
            };
            for (index, value_si) in settings::read_with(t, &DESCRIBED, laws) {
                (PARAMETERS[index].set)(&mut gains, value_si);
            }
            (gains.az.velocity_law, gains.el.velocity_law) = (az, el);
            let named = |t: &mut TableReader<'_>, name: &str, _| Some((name.to_owned(), read_axis(t)?));
            let axes = if t.has("axis") { t.named_tables("axis", named)? } else { Vec::new() };
            schema.and(Some(Self { id: id?, gains, axes }))
        })
    }

    /// Gains in a section for an axis: one of the director's own, or `[axis.<name>]`.
    fn section(&self, name: &str) -> Option<AxisGains> {
        if let Some((_, gains)) = self.axes.iter().find(|(own, _)| own == name) {
            return Some(*gains);
        }
        let place = director_sections().position(|section| section == name)?;
        [self.gains.az, self.gains.el].get(place).copied()
    }

    fn sections(&self) -> Vec<&str> {
        let mut all: Vec<&str> = director_sections().collect();
        all.extend(self.axes.iter().map(|(name, _)| name.as_str()));
        all
    }
}

/// Sections for axes that every parameter file has by its defaults: azimuth and elevation of the director.
fn director_sections() -> impl Iterator<Item = &'static str> {
    let first = OF_AXIS[0].key;
    PARAMETERS.iter().filter_map(move |p| p.key.split_once('.').filter(|(_, key)| *key == first)).map(|p| p.0)
}

fn read_law(t: &mut TableReader<'_>) -> VelocityLaw {
    t.text(VELOCITY_LAW).and_then(|name| VelocityLaw::named(&name)).unwrap_or_default()
}

fn read_axis(t: &mut TableReader<'_>) -> Option<AxisGains> {
    let mut gains = AxisGains { velocity_law: read_law(t), ..AxisGains::default() };
    let mut is_whole = true;
    for parameter in AXIS_PARAMETERS {
        let [least, most] = parameter.range_si;
        match t.quantity(parameter.key) {
            Some(value) if (least..=most).contains(&value) => {
                (parameter.set)(&mut gains, value);
            }
            Some(_) => {
                let message = format!("`{}` is out of range", parameter.key);
                let help = format!("SI values from {least} to {most}");
                t.mistake(parameter.key, message, Some(help));
                is_whole = false;
            }
            None => is_whole = false,
        }
    }
    is_whole.then_some(gains)
}

/// The parameter set of this name without a rig; `beside` is the file that names it, if one does.
///
/// # Errors
/// All mistakes of the parameter file at once.
pub fn named(name: &str, beside: Option<&str>) -> Result<(String, DirectorGains), Vec<Diagnostic>> {
    Set::read(name, beside).map(|set| (set.id, set.gains))
}

/// Gains of a rig's production controllers, with a section for each of its axes.
///
/// # Errors
/// All mistakes of the parameter file at once, or an axis whose section it lacks.
pub fn load(rig: &Rig) -> Result<DirectorGains, Vec<Diagnostic>> {
    load_named(&rig.parameters, Some(&rig.source.name), rig)
}

/// Gains of other parameters than a rig's own, with a section for each of its axes; `beside` is the file that names them, if
/// one does.
///
/// # Errors
/// As of [`load`].
pub fn load_named(
    parameters: &str,
    beside: Option<&str>,
    rig: &Rig,
) -> Result<DirectorGains, Vec<Diagnostic>> {
    let set = Set::read(parameters, beside)?;
    let mut gains = set.gains;
    let mut mistakes = Vec::new();
    for (axis, own) in rig.axes.iter().zip(&mut gains.axes) {
        match set.section(&axis.gains) {
            Some(section) => *own = section,
            None => {
                let message = format!(
                    "axis `{}` takes its gains from section `{}`, but parameters `{}` have no such section \
                     for an axis",
                    axis.name, axis.gains, set.id
                );
                let known = quoted(set.sections());
                let help = format!(
                    "add `[axis.{}]` to the parameters, or set `gains` in `[axis.{}]` of the rig to one of {known}",
                    axis.gains, axis.name
                );
                mistakes.push(Diagnostic::new(message).in_file(&rig.source).help(help));
            }
        }
    }
    if mistakes.is_empty() { Ok(gains) } else { Err(mistakes) }
}
