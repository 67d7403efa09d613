//! What a family draws: settings, and factors of the frequencies and damping ratios of modes.

use std::collections::BTreeSet;
use std::ops::Range;

use procedures::quantity::QuantityKind;
use procedures::table::{TableReader, suggestion};
use sim_devices::unit::{CURVES, Curve, PARAMETERS, UnitSettings};

use super::distribution::{Distribution, Shape, Spread};
use crate::files::settings::quantity_kind;

/// One random number of a unit and what it becomes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variable {
    pub(super) what: What,
    pub(super) distribution: Distribution,
}

/// What a variable sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum What {
    /// A setting, by its place in [`PARAMETERS`].
    Setting(usize),
    /// A curve of a mode, by its place in [`CURVES`]: all of its values are multiplied.
    Curve(usize),
}

impl Variable {
    /// Its name in files, e.g. `az.inertia`, `az-structure.mode-1-frequency`.
    pub(super) fn key(&self) -> String {
        match self.what {
            What::Setting(place) => PARAMETERS[place].key.to_owned(),
            What::Curve(place) => key_of(&CURVES[place]),
        }
    }

    /// Where it stands among settings or curves.
    pub(super) fn place(&self) -> What {
        self.what
    }
}

fn key_of(curve: &Curve) -> String {
    format!("{}.{}", curve.table, curve.key)
}

/// The keys that one stands for: `*.inertia` is `az.inertia` and `el.inertia`, of structures `az-structure` and `el-structure`.
pub(super) fn spelled_out(key: &str) -> Vec<String> {
    match key.strip_prefix('*') {
        Some(own) if own.starts_with(['.', '-']) => vec![format!("az{own}"), format!("el{own}")],
        _ => vec![key.to_owned()],
    }
}

/// The settings of one `[[setting]]`; `drawn` are those of the tables before it.
pub(super) fn settings(
    t: &mut TableReader<'_>,
    nominal: &UnitSettings,
    drawn: &mut BTreeSet<usize>,
) -> Option<Vec<Variable>> {
    let keys = t.spanned_texts("keys");
    let shape = Shape::read(t);
    t.text("reason");
    let mut variables = Vec::new();
    for (key, span) in keys? {
        for key in spelled_out(&key) {
            let place = setting(t, &key, &span, drawn);
            let (Some(place), Some(shape)) = (place, &shape) else { continue };
            let setting = &PARAMETERS[place];
            let spread = Spread {
                key: &key,
                kind: quantity_kind(setting.quantity).unwrap_or(QuantityKind::Ratio),
                nominal_si: setting.get(nominal),
                range_si: setting.range_si,
            };
            let distribution = shape.of_setting(t, &spread);
            variables.extend(
                distribution.map(|distribution| Variable { what: What::Setting(place), distribution }),
            );
        }
    }
    Some(variables)
}

/// The place of a setting that is not drawn yet.
fn setting(
    t: &mut TableReader<'_>,
    key: &str,
    span: &Range<usize>,
    drawn: &mut BTreeSet<usize>,
) -> Option<usize> {
    let Some(place) = PARAMETERS.iter().position(|setting| setting.key == key) else {
        let help = suggestion_near(key, PARAMETERS.iter().map(|setting| setting.key));
        t.mistake_at(span.clone(), format!("unknown setting `{key}`"), Some(help));
        return None;
    };
    if !drawn.insert(place) {
        let help = "remove one of the two keys".to_owned();
        t.mistake_at(span.clone(), format!("`{key}` is drawn twice in this file"), Some(help));
        return None;
    }
    Some(place)
}

/// The nearest known key; the whole list would be too long.
pub(super) fn suggestion_near<'a>(key: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let help = suggestion(key, known);
    if help.starts_with("did you mean") {
        help
    } else {
        "`bench explain nominal` lists all settings".to_owned()
    }
}

/// The factors of one `[[mode-factor]]`, one for each mode that a unit file can give: modes that the base does not have are
/// drawn, too, so that the others do not depend on them.
pub(super) fn mode_factors(
    t: &mut TableReader<'_>,
    nominal: &UnitSettings,
    multiplied: &mut Vec<String>,
) -> Option<Vec<Variable>> {
    let of = t.text("of");
    let shape = Shape::read(t);
    t.text("reason");
    let (of, shape) = (of?, shape?);
    if multiplied.contains(&of) {
        let help = "remove one of the two tables".to_owned();
        t.mistake("of", format!("`{of}` has two factors in this file"), Some(help));
        return None;
    }
    multiplied.push(of.clone());
    let ending = format!("-{of}");
    let mut variables = Vec::new();
    for (place, curve) in CURVES.iter().enumerate().filter(|(_, curve)| curve.key.ends_with(&ending)) {
        let spread = Spread {
            key: &key_of(curve),
            kind: QuantityKind::Ratio,
            nominal_si: 1.0,
            range_si: factors_of(curve, curve.get(nominal)),
        };
        let distribution = shape.of_setting(t, &spread)?;
        variables.push(Variable { what: What::Curve(place), distribution });
    }
    Some(variables)
}

/// Factors by which all values of a curve can be multiplied and stay in their range.
fn factors_of(curve: &Curve, values: &[f64]) -> [f64; 2] {
    let positive = values.iter().copied().filter(|value| *value > 0.0);
    let [least, most] = curve.range_si;
    let narrow =
        |[low, high]: [f64; 2], value: f64| [f64::max(low, least / value), f64::min(high, most / value)];
    positive.fold([0.0, 1000.0], narrow)
}
