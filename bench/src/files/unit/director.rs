//! Unit files of the director: scalar settings, and curves over elevation.

use std::sync::LazyLock;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{Field, TableReader};
use sim_devices::unit::{PARAMETERS, Setting, UnitSettings};

use super::HEAD;
use super::structure::{self, GivenCurve, Layers};
use super::values::{self, Values};
use crate::files::settings::{self, Described};

static DESCRIBED: LazyLock<Vec<Described>> =
    LazyLock::new(|| PARAMETERS.iter().map(Setting::described).collect());
static FIELDS: LazyLock<&'static [Field]> = LazyLock::new(|| {
    let head: Vec<Field> = HEAD.iter().copied().chain(structure::fields()).collect();
    settings::fields(&head, &DESCRIBED)
});

/// Keys of a unit file of the director.
pub fn fields() -> &'static [Field] {
    *FIELDS
}

/// Every scalar setting with what is known of it, in the order of [`PARAMETERS`].
pub fn described() -> &'static [Described] {
    &DESCRIBED
}

/// What one file gives.
pub(super) struct Given {
    /// Places in [`PARAMETERS`] with their values.
    pub(super) values: Vec<(usize, f64)>,
    pub(super) curves: Vec<GivenCurve>,
}

/// A file of a chain.
pub(super) struct Layer<'a> {
    pub(super) source: &'a SourceFile,
    pub(super) given: &'a Given,
}

pub(super) fn read(t: &mut TableReader<'_>) -> Given {
    Given { values: settings::read(t, &DESCRIBED), curves: structure::read(t) }
}

/// The settings of all files, the unit first, its last base last.
///
/// # Errors
/// Where they do not fit each other.
pub(super) fn layered(layers: &[Layer<'_>]) -> Result<UnitSettings, Vec<Diagnostic>> {
    let mut settings = UnitSettings::default();
    for layer in layers.iter().rev() {
        for &(index, value_si) in &layer.given.values {
            PARAMETERS[index].set(&mut settings, value_si);
        }
    }
    let curves = layers.iter().map(|layer| (layer.source, layer.given.curves.as_slice())).collect();
    let mut mistakes = Layers::new(curves).apply(&mut settings);
    let scalars = Values {
        described: &DESCRIBED,
        values_si: PARAMETERS.iter().map(|p| p.get(&settings)).collect(),
        files: layers.iter().map(|layer| (layer.source, layer.given.values.as_slice())).collect(),
        within: Vec::new(),
        step_rate_hz: settings.step_rate_hz,
    };
    mistakes.extend(values::in_order(scalars.check(&values::OF_DIRECTOR)));
    if mistakes.is_empty() { Ok(settings) } else { Err(mistakes) }
}
