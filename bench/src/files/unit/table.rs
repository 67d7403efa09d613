//! Unit files of a rotary table: settings of the whole, and a table `[axis.<name>]` per axis, in the order written.

use std::ops::Range;
use std::sync::LazyLock;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, Need, Shape, TableReader};
use sim_devices::unit::{AXIS_PARAMETERS, MOST_AXES, Setting, TABLE_PARAMETERS, TableAxis, TableSettings};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::HEAD;
use super::values::{self, Values};
use crate::files::settings::{self, Described};

static DESCRIBED: LazyLock<Vec<Described>> =
    LazyLock::new(|| TABLE_PARAMETERS.iter().map(Setting::described).collect());
static DESCRIBED_AXIS: LazyLock<Vec<Described>> =
    LazyLock::new(|| AXIS_PARAMETERS.iter().map(Setting::described).collect());
static AXIS_FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| settings::fields(&[], &DESCRIBED_AXIS));
static FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| {
    let one: &'static Shape = Box::leak(Box::new(Shape::Table(*AXIS_FIELDS)));
    with_axis(Shape::Map(one))
});
/// What [`TableReader`] can read: the names of the axes become known once the file is open.
static READING: LazyLock<&'static [Field]> = LazyLock::new(|| with_axis(Shape::Table(&[])));

fn with_axis(shape: Shape) -> &'static [Field] {
    let doc = "The axes, 1 to 4 tables `[axis.<name>]` in the order of their stations on the bus.";
    let axis = Field { key: "axis", shape, need: Need::Optional, doc };
    let head: Vec<Field> = HEAD.iter().copied().chain([axis]).collect();
    settings::fields(&head, &DESCRIBED)
}

/// Keys of a unit file of a table.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

pub(super) fn reading_fields() -> &'static [Field] {
    *READING
}

/// Every setting of the whole table with what is known of it, in the order of [`TABLE_PARAMETERS`].
pub fn described_table() -> &'static [Described] {
    &DESCRIBED
}

/// Every setting of one axis with what is known of it, in the order of [`AXIS_PARAMETERS`].
pub fn described_axis() -> &'static [Described] {
    &DESCRIBED_AXIS
}

/// What one file gives.
pub(super) struct Given {
    /// Places in [`TABLE_PARAMETERS`] with their values.
    values: Vec<(usize, f64)>,
    axes: Vec<GivenAxis>,
}

/// What one file gives for an axis.
struct GivenAxis {
    name: String,
    span: Range<usize>,
    /// Places in [`AXIS_PARAMETERS`] with their values.
    values: Vec<(usize, f64)>,
}

/// A file of a chain.
pub(super) struct Layer<'a> {
    pub(super) source: &'a SourceFile,
    pub(super) given: &'a Given,
}

pub(super) fn read(t: &mut TableReader<'_>) -> Given {
    let axes = if t.has("axis") { read_axes(t) } else { Vec::new() };
    Given { values: settings::read(t, &DESCRIBED), axes }
}

/// Name of an axis and where it stands.
struct Name {
    text: String,
    span: Range<usize>,
}

fn read_axes(t: &mut TableReader<'_>) -> Vec<GivenAxis> {
    let names = names(t.source());
    if names.len() > MOST_AXES {
        let message = format!("a table has 1 to {MOST_AXES} axes, found {}", names.len());
        t.mistake_at(names[MOST_AXES].span.clone(), message, Some("remove this axis".to_owned()));
    }
    for name in names.iter().filter(|name| !is_kebab_case(&name.text)) {
        let help = "lower-case letters, digits and `-`, a letter first, e.g. `table`".to_owned();
        let message = format!("`{}` cannot be the name of an axis", name.text);
        t.mistake_at(name.span.clone(), message, Some(help));
    }
    let axes = t.table("axis", |t| {
        t.accept_any_key();
        Some(names.into_iter().take(MOST_AXES).filter_map(|name| read_axis(t, name)).collect())
    });
    axes.unwrap_or_default()
}

/// The field of a name that only the file knows is kept for the life of the program: four short texts a file.
fn read_axis(t: &mut TableReader<'_>, name: Name) -> Option<GivenAxis> {
    let key: &'static str = String::leak(name.text.clone());
    let doc = "One axis of the table.";
    let field = Field { key, shape: Shape::Table(*AXIS_FIELDS), need: Need::Optional, doc };
    t.extend(Vec::leak(vec![field]));
    let values = t.table(key, |t| Some(settings::read(t, &DESCRIBED_AXIS)))?;
    Some(GivenAxis { name: name.text, span: name.span, values })
}

/// Names of the tables `[axis.<name>]` in the order written.
fn names(source: &SourceFile) -> Vec<Name> {
    let (root, _) = DeTable::parse_recoverable(&source.text);
    let Some(DeValue::Table(axes)) = root.get_ref().get("axis").map(Spanned::get_ref) else {
        return Vec::new();
    };
    let mut names: Vec<Name> =
        axes.iter().map(|(name, _)| Name { text: name.get_ref().to_string(), span: name.span() }).collect();
    names.sort_by_key(|name| name.span.start);
    names
}

/// Whether a name can stand in rig, procedures and topics of a log.
fn is_kebab_case(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(allowed) && !name.ends_with('-')
}

/// The settings of all files, the unit first, its last base last. Axes of a base come before those that a file adds.
///
/// # Errors
/// Where they do not fit each other, or there are too few axes or too many.
pub(super) fn layered(layers: &[Layer<'_>]) -> Result<TableSettings, Vec<Diagnostic>> {
    let mut settings = TableSettings::without_axes();
    for layer in layers.iter().rev() {
        for &(index, value_si) in &layer.given.values {
            TABLE_PARAMETERS[index].set(&mut settings, value_si);
        }
        for axis in &layer.given.axes {
            lay(&mut settings.axes, axis);
            if settings.axes.len() > MOST_AXES {
                let message = format!("a table has 1 to {MOST_AXES} axes, `{}` is one more", axis.name);
                let help = "axes of the bases count as well";
                return Err(vec![Diagnostic::new(message).help(help).at(layer.source, axis.span.clone())]);
            }
        }
    }
    if settings.axes.is_empty() {
        let source = layers.first().map(|layer| layer.source);
        let mistake = Diagnostic::new(format!("a table has 1 to {MOST_AXES} axes, found none"))
            .help("each is a table `[axis.<name>]`");
        return Err(vec![source.map_or_else(|| mistake.clone(), |source| mistake.clone().in_file(source))]);
    }
    let whole = Values {
        described: &DESCRIBED,
        values_si: TABLE_PARAMETERS.iter().map(|p| p.get(&settings)).collect(),
        files: layers.iter().map(|layer| (layer.source, layer.given.values.as_slice())).collect(),
        within: Vec::new(),
        step_rate_hz: settings.step_rate_hz,
    };
    let mut mistakes = whole.check(&values::OF_TABLE);
    for axis in &settings.axes {
        mistakes.extend(of_axis(layers, axis, settings.step_rate_hz).check(&values::OF_TABLE_AXIS));
    }
    let mistakes = values::in_order(mistakes);
    if mistakes.is_empty() { Ok(settings) } else { Err(mistakes) }
}

/// Lays what a file gives for an axis over what its bases say of it.
fn lay(axes: &mut Vec<TableAxis>, given: &GivenAxis) {
    let place = axes.iter().position(|axis| axis.name == given.name).unwrap_or_else(|| {
        axes.push(TableAxis::new(&given.name));
        axes.len() - 1
    });
    for &(index, value_si) in &given.values {
        AXIS_PARAMETERS[index].set(&mut axes[place].settings, value_si);
    }
}

/// The scalar settings of an axis and the files that they come from.
fn of_axis<'a>(layers: &[Layer<'a>], axis: &'a TableAxis, step_rate_hz: f64) -> Values<'a> {
    let given = |layer: &Layer<'a>| {
        let own = layer.given.axes.iter().find(|given| given.name == axis.name);
        (layer.source, own.map_or(&[][..], |given| given.values.as_slice()))
    };
    Values {
        described: &DESCRIBED_AXIS,
        values_si: AXIS_PARAMETERS.iter().map(|p| p.get(&axis.settings)).collect(),
        files: layers.iter().map(given).collect(),
        within: vec!["axis", &axis.name],
        step_rate_hz,
    }
}
