//! One setting of a whole unit, and how it is reached through the part that it belongs to.

use super::{AxisSettings, SupplySettings};
use drivers::parameter::Parameter;

/// One setting of a unit `U`; the value is SI.
pub struct Setting<U: 'static> {
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
    /// Where in the unit it is.
    reach: Reach<U>,
}

/// Where in a unit a setting is.
enum Reach<U: 'static> {
    /// In the unit itself.
    Unit(Access<U>),
    /// In one of its axes.
    Axis(Lens<U, AxisSettings>, Access<AxisSettings>),
    /// In its supply.
    Supply(Lens<U, SupplySettings>, Access<SupplySettings>),
}

/// How a value is put and read back.
struct Access<S: 'static> {
    set: fn(&mut S, f64),
    get: fn(&S) -> f64,
}

/// How a part of a unit is found.
pub(super) struct Lens<U: 'static, P: 'static> {
    pub(super) part: fn(&U) -> &P,
    pub(super) part_mut: fn(&mut U) -> &mut P,
}

impl<U> Setting<U> {
    /// Puts a value into the unit.
    pub fn set(&self, unit: &mut U, value_si: f64) {
        match &self.reach {
            Reach::Unit(access) => (access.set)(unit, value_si),
            Reach::Axis(lens, access) => (access.set)((lens.part_mut)(unit), value_si),
            Reach::Supply(lens, access) => (access.set)((lens.part_mut)(unit), value_si),
        }
    }

    /// Reads the value back.
    pub fn get(&self, unit: &U) -> f64 {
        match &self.reach {
            Reach::Unit(access) => (access.get)(unit),
            Reach::Axis(lens, access) => (access.get)((lens.part)(unit)),
            Reach::Supply(lens, access) => (access.get)((lens.part)(unit)),
        }
    }

    /// A setting in the unit itself.
    pub(super) const fn of_unit(parameter: &Parameter<U>) -> Self {
        Self::described(parameter, Reach::Unit(Access { set: parameter.set, get: parameter.get }))
    }

    /// A setting of the supply.
    pub(super) const fn of_supply(
        parameter: &Parameter<SupplySettings>,
        lens: Lens<U, SupplySettings>,
    ) -> Self {
        Self::described(parameter, Reach::Supply(lens, Access { set: parameter.set, get: parameter.get }))
    }

    /// A setting of an axis.
    pub(super) const fn of_axis(parameter: &Parameter<AxisSettings>, lens: Lens<U, AxisSettings>) -> Self {
        Self::described(parameter, Reach::Axis(lens, Access { set: parameter.set, get: parameter.get }))
    }

    const fn described<S>(parameter: &Parameter<S>, reach: Reach<U>) -> Self {
        Self {
            key: parameter.key,
            quantity: parameter.quantity,
            min_si: parameter.min_si,
            max_si: parameter.max_si,
            default: parameter.default,
            doc: parameter.doc,
            source: parameter.source,
            reach,
        }
    }
}
