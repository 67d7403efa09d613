//! One row for settings that several like parts of a director have.

use super::UnitSettings;
use super::setting::{FieldOfPart, Setting};

/// A setting of the director, or the same setting of several like parts: of both axes, both cameras, each gyro.
///
/// `defaults`, `docs` and `sources` hold one text for each key, or a single one for all of them.
pub(super) struct Row {
    /// Dotted keys, one a part.
    pub(super) keys: &'static [&'static str],
    /// Name of the quantity kind.
    pub(super) quantity: &'static str,
    /// Smallest and largest allowed SI value.
    pub(super) range_si: [f64; 2],
    /// Defaults as a person would write them.
    pub(super) defaults: &'static [&'static str],
    /// One sentence each.
    pub(super) docs: &'static [&'static str],
    /// Where the figures come from.
    pub(super) sources: &'static [&'static str],
    /// Finds the value in the part of this index.
    pub(super) field: fn(&mut UnitSettings, usize) -> &mut f64,
}

impl Row {
    /// The settings of all parts.
    pub(super) fn settings(&self) -> impl Iterator<Item = Setting<FieldOfPart<UnitSettings>>> {
        (0..self.keys.len()).map(|part| self.setting(part))
    }

    /// The setting of one part.
    pub(super) fn setting(&self, part: usize) -> Setting<FieldOfPart<UnitSettings>> {
        let field = self.field;
        Setting {
            key: self.keys[part],
            quantity: self.quantity,
            range_si: self.range_si,
            default: of_part(self.defaults, part),
            doc: of_part(self.docs, part),
            source: of_part(self.sources, part),
            field: Box::new(move |unit| field(unit, part)),
        }
    }
}

/// The text of a part, which is the only one where all parts have the same.
fn of_part(texts: &[&'static str], part: usize) -> &'static str {
    if texts.len() == 1 { texts[0] } else { texts[part] }
}
