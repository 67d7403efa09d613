//! What a rig file says about stopping: the table `[axis.*.safety]`. None of it may be left out.
//!
//! One row of [`SAFETY_PARAMETERS`] is one key: reading, range check, the message where it is missing, schema and
//! `bench explain rig` come from there.

use std::ops::Range;

use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape, TableReader};

use crate::model::safety::{Holds, SAFETY_PARAMETERS, SafeState, Safety, SafetyParameter};

impl SafetyParameter {
    /// Kind of the parameter's quantity.
    pub fn kind(&self) -> Option<K> {
        match self.holds {
            Holds::Quantity(kind, _) | Holds::Band(kind, _) => Some(kind),
            Holds::Pose => Some(K::Angle),
            Holds::SafeState => None,
        }
    }

    /// Range of the parameter in words.
    pub fn range(&self) -> String {
        match self.holds {
            Holds::SafeState => "hold, release".to_owned(),
            _ => format!("{} .. {}", self.least, self.most),
        }
    }

    const fn field(&self) -> Field {
        let shape = match self.holds {
            Holds::Quantity(kind, _) => Shape::Quantity(kind),
            Holds::Band(kind, _) => Shape::Range(kind),
            Holds::SafeState => Shape::Choice(&["hold", "release"]),
            Holds::Pose => Shape::Quantity(K::Angle),
        };
        let need = match self.holds {
            Holds::Pose => Need::Optional,
            _ => Need::Required,
        };
        Field { key: self.key, shape, need, doc: self.doc }
    }
}

/// Keys of `[axis.<name>.safety]`.
pub const SAFETY_FIELDS: &[Field] = &fields();

const fn fields() -> [Field; SAFETY_PARAMETERS.len()] {
    let mut all = [SAFETY_PARAMETERS[0].field(); SAFETY_PARAMETERS.len()];
    let mut k = 0;
    while k < all.len() {
        all[k] = SAFETY_PARAMETERS[k].field();
        k += 1;
    }
    all
}

/// The table of one axis and where each of its keys stands.
pub(super) struct Written {
    pub(super) safety: Safety,
    /// In the order of the rows.
    places: Vec<Range<usize>>,
}

impl Written {
    /// Where a key of the table stands.
    pub(super) fn place(&self, key: &str) -> Option<Range<usize>> {
        let index = SAFETY_PARAMETERS.iter().position(|p| p.key == key)?;
        self.places.get(index).cloned()
    }
}

/// Reads the table; every key that is missing or out of its range is told with its reason.
pub(super) fn read(t: &mut TableReader<'_>) -> Option<Written> {
    let mut safety = Safety::blank();
    let mut places = Vec::new();
    let mut whole = true;
    for parameter in SAFETY_PARAMETERS {
        places.push(t.span(parameter.key));
        whole &= read_one(t, parameter, &mut safety).is_some();
    }
    whole.then_some(Written { safety, places })
}

fn read_one(t: &mut TableReader<'_>, p: &'static SafetyParameter, safety: &mut Safety) -> Option<()> {
    if !t.has(p.key) {
        if matches!(p.holds, Holds::Pose) {
            return Some(());
        }
        let message = format!("`{}` is missing; recommended {}: {}", p.key, p.recommended, p.reason);
        let help = format!("{} Range {}; `bench explain rig` lists every safety parameter", p.doc, p.range());
        t.mistake_at(t.place(), message, Some(help));
        return None;
    }
    match p.holds {
        Holds::Quantity(_, place) => {
            let value = t.quantity(p.key)?;
            *place(safety) = value;
            within(t, p, &[value])
        }
        Holds::Band(_, place) => {
            let band = t.range(p.key)?;
            *place(safety) = band;
            within(t, p, &band)
        }
        Holds::SafeState => {
            let word = t.text(p.key)?;
            safety.safe_state = if word == "release" { SafeState::Release } else { SafeState::Hold };
            Some(())
        }
        Holds::Pose => {
            let pose_rad = t.quantity(p.key)?;
            safety.safe_pose_rad = Some(pose_rad);
            within(t, p, &[pose_rad])
        }
    }
}

/// Nothing where all values are in the parameter's range; otherwise a mistake with range and reason.
fn within(t: &mut TableReader<'_>, p: &SafetyParameter, values: &[f64]) -> Option<()> {
    let kind = p.kind()?;
    let end = |text: &str| kind.parse(text).expect("a test parses the ends of every range");
    let least = end(p.least);
    let most = end(p.most);
    // A unit conversion may round: the ends themselves are allowed.
    let slack = 1e-12 * least.abs().max(most.abs());
    let outside = values.iter().find(|value| !(least - slack..=most + slack).contains(*value));
    let Some(outside) = outside else { return Some(()) };
    let message = format!("`{}` must lie in {}, found {}", p.key, p.range(), kind.format(*outside));
    let help = format!("recommended {}: {}", p.recommended, p.reason);
    t.mistake(p.key, message, Some(help));
    None
}
