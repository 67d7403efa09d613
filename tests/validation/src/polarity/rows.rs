//! The rows of the table: units, and what the check must say of them.

use std::collections::BTreeMap;

use sim_devices::unit::{AxisSettings, UnitSettings};

use super::trial::Trial;
use crate::shipped;

/// Largest motion and rate that any of them may cause (safety.md §2, layer 3).
const MOST_DEG: f64 = 1.0;
const MOST_DEG_PER_S: f64 = 2.0;

/// A unit and the beginning of the sentence that must name its fault; none where there is no fault.
pub struct Row {
    /// For the table.
    pub name: String,
    /// The unit.
    pub unit: UnitSettings,
    /// How the first sentence begins.
    pub sentence: Option<&'static str>,
    /// Seeds of the whole table.
    pub seeds: u64,
}

fn axes_of(unit: &mut UnitSettings) -> [&mut AxisSettings; 2] {
    [&mut unit.az, &mut unit.el]
}

/// A fault that each axis may have: name, beginning of its sentence, what it does to the axis.
type Spoiled = (&'static str, &'static str, fn(&mut AxisSettings));

/// Every row.
pub fn rows() -> Vec<Row> {
    let mut all = Vec::new();
    let each: [Spoiled; 5] = [
        ("encoder sign", "encoder sign of ", |axis| axis.encoder_sign_factor = -1.0),
        ("torque sign", "torque sign of ", |axis| axis.motor_sign_factor = -1.0),
        ("torque x 10", "torque scale of ", |axis| axis.torque_constant_nm_per_a *= 10.0),
        ("torque / 10", "torque scale of ", |axis| axis.torque_constant_nm_per_a /= 10.0),
        ("encoder modulus / 2", "encoder modulus of ", |axis| axis.encoder_modulus_ratio = 0.5),
    ];
    for (name, sentence, spoil) in each {
        for (k, axis) in ["az", "el"].into_iter().enumerate() {
            let mut unit = UnitSettings::default();
            spoil(axes_of(&mut unit)[k]);
            all.push(Row { name: format!("{name} {axis}"), unit, sentence: Some(sentence), seeds: 100 });
        }
    }
    for (name, unit, sentence) in
        [("gyro sign", "gyro-sign", "gyro sign of "), ("axes swapped", "axes-swapped", "axes swapped: ")]
    {
        all.push(Row {
            name: name.to_owned(),
            unit: shipped::director(unit),
            sentence: Some(sentence),
            seeds: 100,
        });
    }
    for (name, seeds) in [
        ("nominal", 200),
        ("as-measured", 50),
        ("friction-az", 50),
        ("azimuth-retainer", 50),
        ("friction-el", 50),
        ("torque-scale", 50),
    ] {
        all.push(Row { name: name.to_owned(), unit: shipped::director(name), sentence: None, seeds });
    }
    all.push(Row { name: "elevation under load".to_owned(), unit: under_load(), sentence: None, seeds: 300 });
    all
}

/// A soft contact that bears half of its static friction, as elevation of drawn unit 910: it sags by more than 1.5 z_ss.
fn under_load() -> UnitSettings {
    let mut unit = UnitSettings::default();
    unit.el.coulomb_torque_nm = 31.8;
    unit.el.static_torque_nm = 39.9;
    unit.el.bristle_stiffness_nm_per_rad = 42_600.0;
    unit.el.bristle_damping_nm_s_per_rad = 8670.0;
    unit.el.unbalance_nm = 20.0;
    unit
}

/// A pose within the allowed band, azimuth and elevation in degrees: 30° from the soft limits, and elevation where
/// friction holds the load of every unit of the table.
pub fn pose_deg(seed: u64) -> [f64; 2] {
    // Two irrational strides fill the band evenly.
    let share = |stride: f64| (seed as f64 * stride).fract();
    [-129.0 + 258.0 * share(0.618_033_988_75), 32.0 + 20.0 * share(0.754_877_666_25)]
}

/// What the seeds of a row gave.
#[derive(Debug, Default)]
pub struct Found {
    right: u64,
    most_rad: f64,
    most_rad_per_s: f64,
    sentences: BTreeMap<String, u64>,
    numbers: BTreeMap<(&'static str, &'static str), [f64; 2]>,
    wrong: Vec<String>,
}

impl Found {
    /// Takes a trial in.
    pub fn take(&mut self, row: &Row, seed: u64, trial: &Trial) {
        let first = trial.faults().first();
        let right = match (row.sentence, first) {
            (Some(sentence), Some(fault)) => fault.starts_with(sentence),
            (None, None) => true,
            _ => false,
        };
        self.right += u64::from(right);
        self.most_rad = self.most_rad.max(trial.most_rad);
        self.most_rad_per_s = self.most_rad_per_s.max(trial.most_rad_per_s);
        let told = first.map_or("none", |fault| fault.split([':', '(']).next().unwrap_or(fault));
        *self.sentences.entry(told.trim().to_owned()).or_default() += 1;
        if !right {
            let [az, el] = pose_deg(seed);
            self.wrong.push(format!(
                "seed {seed} at {az:.0}, {el:.0}: {:?} {:?}",
                trial.faults(),
                trial.ended
            ));
        }
        for measurand in ["presliding-ratio", "gyro-encoder-ratio", "torque-scale-ratio"] {
            for axis in ["az", "el"] {
                if let Some(value) = trial.value(measurand, axis) {
                    let range = self.numbers.entry((measurand, axis)).or_insert([value, value]);
                    *range = [range[0].min(value), range[1].max(value)];
                }
            }
        }
    }

    /// Whether every seed was right and nothing moved too far or too fast.
    pub fn holds(&self, row: &Row, seeds: u64) -> bool {
        self.right == seeds && self.is_gentle() && (row.sentence.is_some() || self.wrong.is_empty())
    }

    fn is_gentle(&self) -> bool {
        self.most_rad.to_degrees() <= MOST_DEG && self.most_rad_per_s.to_degrees() <= MOST_DEG_PER_S
    }

    /// The row of the table, with the numbers' ranges below it and what was wrong.
    pub fn line(&self, row: &Row, seeds: u64) -> String {
        let told: Vec<String> = self.sentences.iter().map(|(s, n)| format!("{s} ({n})")).collect();
        let mut text = format!(
            "{:<26} {:>4}/{:<4} {:>11.3} {:>11.3}  {}{}",
            row.name,
            self.right,
            seeds,
            self.most_rad.to_degrees(),
            self.most_rad_per_s.to_degrees(),
            told.join(", "),
            if self.holds(row, seeds) { "" } else { "  DOES NOT HOLD" }
        );
        for ((measurand, axis), [low, high]) in &self.numbers {
            text += &format!("\n    {measurand} {axis}: {low:.3} … {high:.3}");
        }
        for wrong in self.wrong.iter().take(3) {
            text += &format!("\n    {wrong}");
        }
        text
    }
}
