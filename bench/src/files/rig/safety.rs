//! What a rig file says about stopping: the table `[axis.*.safety]`. None of it may be left out.
//!
//! One row of [`SAFETY_PARAMETERS`] is one key: reading, range check, the message where it is missing, schema and
//! `bench explain rig` come from there.

mod rows;

use std::ops::Range;

use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape, TableReader};

use crate::model::axis::SafeState;
use crate::model::stopping::{LeastFriction, Loads};

pub use rows::SAFETY_PARAMETERS;

/// What a key of the table holds, and where it goes.
#[derive(Clone, Copy)]
pub(super) enum Holds {
    /// One quantity.
    Quantity(K, fn(&mut Safety) -> &mut f64),
    /// A band.
    Band(K, fn(&mut Safety) -> &mut [f64; 2]),
    /// `hold` or `release`.
    SafeState,
    /// An angle that may be left out.
    Pose,
}

/// One safety parameter of an axis.
pub struct SafetyParameter {
    /// Key in the rig file.
    pub key: &'static str,
    pub(super) holds: Holds,
    /// What it is, one sentence.
    pub doc: &'static str,
    /// What to start from: a value, or a rule in words where every rig has its own.
    pub recommended: &'static str,
    /// Least value, as a person would write it; empty where there is none.
    pub least: &'static str,
    /// Largest value.
    pub most: &'static str,
    /// Why that value, and why that range.
    pub reason: &'static str,
}

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

/// The table of one axis.
#[derive(Clone, Debug)]
pub(super) struct Safety {
    pub(super) trip_velocity_rad_per_s: f64,
    pub(super) trip_acceleration_rad_per_s2: f64,
    pub(super) braking_deceleration_rad_per_s2: f64,
    pub(super) stop_jerk_rad_per_s3: f64,
    pub(super) continuous_torque_nm: f64,
    pub(super) thermal_time_s: f64,
    pub(super) max_following_error_rad: f64,
    pub(super) max_rate_disagreement_rad_per_s: f64,
    pub(super) max_heat_sink_degc: f64,
    pub(super) bus_voltage_v: [f64; 2],
    pub(super) watchdog_s: f64,
    pub(super) friction: LeastFriction,
    pub(super) loads: Loads,
    pub(super) brake_nm: f64,
    pub(super) end_stop_energy_j: f64,
    pub(super) polarity_torque_nm: f64,
    pub(super) zero_tolerance_rad: f64,
    pub(super) presliding_stiffness_nm_per_rad: f64,
    pub(super) safe_state: SafeState,
    pub(super) safe_pose_rad: Option<f64>,
    /// Where each key stands in the file, in the order of the rows.
    pub(super) places: Vec<Range<usize>>,
}

impl Safety {
    /// Every figure NaN: only [`read`] makes one of use.
    fn blank() -> Self {
        let nan = f64::NAN;
        Self {
            trip_velocity_rad_per_s: nan,
            trip_acceleration_rad_per_s2: nan,
            braking_deceleration_rad_per_s2: nan,
            stop_jerk_rad_per_s3: nan,
            continuous_torque_nm: nan,
            thermal_time_s: nan,
            max_following_error_rad: nan,
            max_rate_disagreement_rad_per_s: nan,
            max_heat_sink_degc: nan,
            bus_voltage_v: [nan; 2],
            watchdog_s: nan,
            friction: LeastFriction { static_nm: nan, coulomb_nm: nan, viscous_nm_s_per_rad: nan },
            loads: Loads { unbalance_nm: nan, spring_nm_per_rad: nan, spring_rest_rad: nan },
            brake_nm: nan,
            end_stop_energy_j: nan,
            polarity_torque_nm: nan,
            zero_tolerance_rad: nan,
            presliding_stiffness_nm_per_rad: nan,
            safe_state: SafeState::Hold,
            safe_pose_rad: None,
            places: Vec::new(),
        }
    }

    /// Where a key of the table stands.
    pub(super) fn place(&self, key: &str) -> Option<Range<usize>> {
        let index = SAFETY_PARAMETERS.iter().position(|p| p.key == key)?;
        self.places.get(index).cloned()
    }
}

/// Reads the table; every key that is missing or out of its range is told with its reason.
pub(super) fn read(t: &mut TableReader<'_>) -> Option<Safety> {
    let mut safety = Safety::blank();
    let mut whole = true;
    for parameter in SAFETY_PARAMETERS {
        safety.places.push(t.span(parameter.key));
        whole &= read_one(t, parameter, &mut safety).is_some();
    }
    whole.then_some(safety)
}

fn read_one(t: &mut TableReader<'_>, p: &'static SafetyParameter, safety: &mut Safety) -> Option<()> {
    if !t.has(p.key) {
        if matches!(p.holds, Holds::Pose) {
            return Some(());
        }
        let message = format!("`{}` is missing: recommended {}, because {}", p.key, p.recommended, p.reason);
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
    let help = format!("recommended {}, because {}", p.recommended, p.reason);
    t.mistake(p.key, message, Some(help));
    None
}
