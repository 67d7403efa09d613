//! One setting of a whole unit, whatever part of it it belongs to.

use drivers::parameter::Parameter;

/// Puts an SI value where it belongs in a unit.
pub(super) type Put<U> = Box<dyn Fn(&mut U, f64) + Send + Sync>;
/// Reads an SI value from where it belongs in a unit.
pub(super) type Read<U> = Box<dyn Fn(&U) -> f64 + Send + Sync>;

/// One setting of a unit `U`; the value is SI.
pub struct Setting<U> {
    /// Dotted kebab-case key, e.g. `az.coulomb-torque`.
    pub key: &'static str,
    /// Name of the quantity kind, as in people's files, e.g. `torque`, `angle`, `ratio`, `count`.
    pub quantity: &'static str,
    /// Smallest allowed SI value.
    pub min_si: f64,
    /// Largest allowed SI value.
    pub max_si: f64,
    /// Default as a person would write it, e.g. `"167.75 N*m"`.
    pub default: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// Where the figure comes from.
    pub source: &'static str,
    pub(super) put: Put<U>,
    pub(super) read: Read<U>,
}

/// How a part of a unit is found.
pub(super) struct Part<U, P> {
    pub(super) part: fn(&U) -> &P,
    pub(super) part_mut: fn(&mut U) -> &mut P,
}

impl<U: 'static> Setting<U> {
    /// Puts a value into the unit.
    pub fn set(&self, unit: &mut U, value_si: f64) {
        (self.put)(unit, value_si);
    }

    /// Reads the value back.
    pub fn get(&self, unit: &U) -> f64 {
        (self.read)(unit)
    }

    /// A setting of the unit itself.
    pub(super) fn of_unit(parameter: &Parameter<U>) -> Self {
        Self::of_part(parameter, &Part { part: |unit| unit, part_mut: |unit| unit })
    }

    /// A setting of a part of the unit.
    pub(super) fn of_part<P: 'static>(parameter: &Parameter<P>, part: &Part<U, P>) -> Self {
        let &Part { part, part_mut } = part;
        let &Parameter { key, quantity, min_si, max_si, default, doc, source, set, get } = parameter;
        Self {
            key,
            quantity,
            min_si,
            max_si,
            default,
            doc,
            source,
            put: Box::new(move |unit, value_si| set(part_mut(unit), value_si)),
            read: Box::new(move |unit| get(part(unit))),
        }
    }
}
