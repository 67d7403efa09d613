//! Curves over elevation: the tables `[az-structure]` and `[el-structure]` of a unit file.
//!
//! One array is checked where it stands. What only shows once a unit lies over its bases (lengths, modes that are
//! not whole) is checked afterwards and points into the file that brought it about.

use std::ops::Range;

use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::quantity::QuantityKind;
use procedures::table::{Field, Need, Shape, TableReader};
use sim_devices::unit::{CURVES, Curve, UnitSettings};

use crate::files::settings::{in_unit, quantity_kind};

/// A curve as one file gives it.
#[derive(Clone, Debug)]
pub(super) struct GivenCurve {
    /// Which of [`CURVES`].
    pub(super) index: usize,
    pub(super) values: Vec<f64>,
    span: Range<usize>,
}

/// The required travel of elevation, which the nodes must cover (study 2.1.4), with room for rounding.
const TRAVEL_DEG: [f64; 2] = [-10.0, 90.0];
const ROUNDING_DEG: f64 = 1e-9;

/// The tables that the curves name, each once, in their order.
pub fn tables() -> Vec<&'static str> {
    let mut names: Vec<&'static str> = CURVES.iter().map(|c| c.table).collect();
    names.dedup();
    names
}

/// One field per table, with the arrays inside it.
pub(super) fn fields() -> Vec<Field> {
    let inside = |table: &str| -> Vec<Field> {
        let of_table = CURVES.iter().filter(|c| c.table == table);
        of_table
            .map(|c| Field {
                key: c.key.as_str(),
                shape: Shape::Quantities(kind(c)),
                need: Need::Optional,
                doc: c.doc,
            })
            .collect()
    };
    let doc = "Structure of one axis: arrays with one value per elevation node.";
    tables()
        .into_iter()
        .map(|key| Field { key, shape: Shape::Table(Vec::leak(inside(key))), need: Need::Optional, doc })
        .collect()
}

fn kind(curve: &Curve) -> QuantityKind {
    quantity_kind(curve.quantity).unwrap_or(QuantityKind::Ratio)
}

/// Reads the curves that the file gives, each entry checked for its range and nodes for their order.
pub(super) fn read(t: &mut TableReader<'_>) -> Vec<GivenCurve> {
    let mut all = Vec::new();
    for table in tables() {
        let given = t.table(table, |t| {
            let of_table = CURVES.iter().enumerate().filter(|(_, curve)| curve.table == table);
            Some(of_table.filter_map(|(index, curve)| read_curve(t, index, curve)).collect::<Vec<_>>())
        });
        all.extend(given.unwrap_or_default());
    }
    all
}

fn read_curve(t: &mut TableReader<'_>, index: usize, curve: &'static Curve) -> Option<GivenCurve> {
    let given = t.spanned_quantities(&curve.key)?;
    let found = t.mistakes();
    for (value, span) in &given {
        if !(curve.range_si[0]..=curve.range_si[1]).contains(value) {
            t.mistake_at(span.clone(), out_of_range(curve, *value), Some(curve.doc.to_owned()));
        }
    }
    let values: Vec<f64> = given.iter().map(|(value, _)| *value).collect();
    if curve.ascending {
        check_order(t, curve, &given);
        check_ends(t, curve, &values);
    }
    (t.mistakes() == found).then(|| GivenCurve { index, values, span: t.span(&curve.key) })
}

fn shown(curve: &Curve, value: f64) -> String {
    let kind = kind(curve);
    // Ratios of structures are plain numbers in every text about them: ζ 0.03, not 3 %.
    let unit = if kind == QuantityKind::Ratio { "" } else { kind.display_unit() };
    in_unit(curve.quantity, unit, value)
}

fn out_of_range(curve: &Curve, value: f64) -> String {
    let [least, most] = curve.range_si.map(|end| shown(curve, end));
    format!("`{}` must be {least} to {most}, found {}", curve.key, shown(curve, value))
}

fn check_order(t: &mut TableReader<'_>, curve: &Curve, given: &[(f64, Range<usize>)]) {
    for pair in given.windows(2) {
        let [(before, _), (after, span)] = pair else { continue };
        if after <= before {
            let after = shown(curve, *after);
            let before = shown(curve, *before);
            let message = format!("`{}` does not ascend: {after} after {before}", curve.key);
            t.mistake_at(span.clone(), message, Some("sort the nodes in ascending order".to_owned()));
        }
    }
}

fn check_ends(t: &mut TableReader<'_>, curve: &Curve, values: &[f64]) {
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min).to_degrees();
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max).to_degrees();
    let [from, to] = TRAVEL_DEG;
    let mut missing = |end: f64, message: String| {
        let help = format!("the nodes must cover the travel, {from} deg to {to} deg: add `\"{end} deg\"`");
        t.mistake(&curve.key, message, Some(help));
    };
    if lowest > from + ROUNDING_DEG {
        let first = shown(curve, lowest.to_radians());
        missing(from, format!("`{}` has no node at {from} deg: it begins at {first}", curve.key));
    }
    if highest < to - ROUNDING_DEG {
        let last = shown(curve, highest.to_radians());
        missing(to, format!("`{}` has no node at {to} deg: it ends at {last}", curve.key));
    }
}

/// Curves of a unit over its bases, and which file gave each.
pub(super) struct Layers<'a> {
    files: Vec<(&'a SourceFile, &'a [GivenCurve])>,
}

/// The file that a curve comes from, counted from the unit itself; none if from the nominal unit built in.
type Origin<'a> = Option<(usize, &'a GivenCurve)>;

impl<'a> Layers<'a> {
    /// The unit first, its last base last.
    pub(super) fn new(files: Vec<(&'a SourceFile, &'a [GivenCurve])>) -> Self {
        Self { files }
    }

    /// Puts the curves into the settings and checks them against each other.
    pub(super) fn apply(&self, settings: &mut UnitSettings) -> Vec<Diagnostic> {
        for (_, curves) in self.files.iter().rev() {
            for given in *curves {
                CURVES[given.index].set(settings, given.values.clone());
            }
        }
        let mut found = Vec::new();
        for table in tables() {
            let of_table: Vec<usize> = (0..CURVES.len()).filter(|&k| CURVES[k].table == table).collect();
            self.check_lengths(settings, &of_table, &mut found);
            self.check_modes(settings, &of_table, &mut found);
        }
        found
    }

    fn origin(&self, index: usize) -> Origin<'a> {
        let in_file =
            |&(_, curves): &(&SourceFile, &'a [GivenCurve])| curves.iter().find(|c| c.index == index);
        self.files.iter().enumerate().find_map(|(layer, file)| Some((layer, in_file(file)?)))
    }

    fn mistake(&self, (layer, given): (usize, &GivenCurve), message: String, help: String) -> Diagnostic {
        Diagnostic::new(message).help(help).at(self.files[layer].0, given.span.clone())
    }

    /// Every array has one value per node. Of an array and the nodes the one written later over the other is wrong.
    fn check_lengths(&self, settings: &UnitSettings, of_table: &[usize], found: &mut Vec<Diagnostic>) {
        let Some(&nodes) = of_table.iter().find(|&&k| CURVES[k].ascending) else { return };
        let count = CURVES[nodes].get(settings).len();
        let mut left_behind = Vec::new();
        for &k in of_table {
            let length = CURVES[k].get(settings).len();
            if length == 0 || length == count {
                continue;
            }
            match (self.origin(k), self.origin(nodes)) {
                (Some(array), Some((layer, _))) if array.0 > layer => left_behind.push(k),
                (Some(array), _) => {
                    let message = format!("`{}`: expected {count} values, found {length}", CURVES[k].key);
                    found.push(self.mistake(
                        array,
                        message,
                        format!("give one value per node of `{}`", CURVES[nodes].key),
                    ));
                }
                (None, _) => left_behind.push(k),
            }
        }
        if let (Some(given), false) = (self.origin(nodes), left_behind.is_empty()) {
            let keys: Vec<String> = left_behind.iter().map(|&k| format!("`{}`", CURVES[k].key)).collect();
            let length = CURVES[left_behind[0]].get(settings).len();
            let message =
                format!("{count} elevation nodes, but the base's {} have {length} values", keys.join(", "));
            found.push(self.mistake(
                given,
                message,
                "give these arrays here too, or keep the base's nodes".to_owned(),
            ));
        }
    }

    /// A mode has all its arrays or none.
    fn check_modes(&self, settings: &UnitSettings, of_table: &[usize], found: &mut Vec<Diagnostic>) {
        let mode = |k: usize| CURVES[k].key.strip_prefix("mode-").and_then(|rest| rest.split('-').next());
        let mut modes: Vec<&str> = of_table.iter().filter_map(|&k| mode(k)).collect();
        modes.dedup();
        for name in modes {
            let arrays = of_table.iter().copied().filter(|&k| mode(k) == Some(name));
            let (given, missing): (Vec<usize>, Vec<usize>) =
                arrays.partition(|&k| !CURVES[k].get(settings).is_empty());
            let place = given.iter().filter_map(|&k| self.origin(k)).min_by_key(|(layer, _)| *layer);
            let (false, Some(place)) = (missing.is_empty(), place) else { continue };
            let keys: Vec<String> = missing.iter().map(|&k| format!("`{}`", CURVES[k].key)).collect();
            let message = format!("mode {name} is incomplete: {} missing", keys.join(", "));
            found.push(self.mistake(
                place,
                message,
                "give frequency, damping, gyro and encoder for each mode".to_owned(),
            ));
        }
    }
}
