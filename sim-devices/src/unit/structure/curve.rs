//! Curves of a structure as data: reading, checks, schema and documentation iterate this list.

use std::sync::LazyLock;

use super::{MODES_COUNT, ModeCurves, StructureSettings};
use crate::unit::UnitSettings;

/// Which array of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Elevation,
    RigidGain,
    Frequency(usize),
    Damping(usize),
    Gyro(usize),
    Encoder(usize),
}

/// One array over elevation.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Table in the file, e.g. `az-structure`.
    pub table: &'static str,
    /// Key in that table, e.g. `mode-1-frequency`.
    pub key: String,
    /// Name of the quantity kind.
    pub quantity: &'static str,
    /// Smallest and largest allowed SI value of each entry.
    pub range_si: [f64; 2],
    /// Whether the entries must ascend strictly: the nodes of the others.
    pub ascending: bool,
    /// One sentence.
    pub doc: &'static str,
    /// Where the figures come from.
    pub source: &'static str,
    axis: usize,
    part: Part,
}

/// Every curve of both axes.
pub static CURVES: LazyLock<Vec<Curve>> = LazyLock::new(|| (0..2).flat_map(of_axis).collect());

const FIT: &str = "fit to the study's tables 4.1 and 4.2, discrete loop";

fn of_axis(axis: usize) -> Vec<Curve> {
    let curve = |part, key: String, quantity, range_si, doc| Curve {
        table: ["az-structure", "el-structure"][axis],
        key,
        quantity,
        range_si,
        ascending: part == Part::Elevation,
        doc,
        source: FIT,
        axis,
        part,
    };
    let mut all = vec![
        curve(
            Part::Elevation,
            "elevation".to_owned(),
            "angle",
            [-1.0, 2.0],
            "Elevation nodes of the other curves.",
        ),
        curve(
            Part::RigidGain,
            "rigid-gain".to_owned(),
            "ratio",
            [0.1, 10.0],
            "Rigid gain: the axis accelerates as if its inertia were divided by this.",
        ),
    ];
    all.extend((0..MODES_COUNT).flat_map(|mode| {
        of_mode(mode).map(|(part, key, quantity, range_si, doc)| curve(part, key, quantity, range_si, doc))
    }));
    all
}

/// Part, key, quantity, range and sentence of the four curves of a mode.
fn of_mode(mode: usize) -> [(Part, String, &'static str, [f64; 2], &'static str); 4] {
    let key = |what: &str| format!("mode-{}-{what}", mode + 1);
    [
        (
            Part::Frequency(mode),
            key("frequency"),
            "frequency",
            [0.5, 2000.0],
            "Natural frequency of the mode.",
        ),
        (Part::Damping(mode), key("damping"), "ratio", [1e-4, 0.99], "Damping ratio of the mode, below 1."),
        (
            Part::Gyro(mode),
            key("gyro"),
            "inverse-inertia",
            [-1.0, 1.0],
            "Participation in the rate of the frame (gyro, line of sight); any sign.",
        ),
        (
            Part::Encoder(mode),
            key("encoder"),
            "inverse-inertia",
            [0.0, 1.0],
            "Participation in the rate of the shaft (encoder); never negative, because the motor acts there.",
        ),
    ]
}

impl Curve {
    /// The values; empty for a mode that the unit does not have.
    pub fn get<'a>(&self, unit: &'a UnitSettings) -> &'a [f64] {
        let structure = [&unit.az_structure, &unit.el_structure][self.axis];
        let mode =
            |k: usize, of: fn(&ModeCurves) -> &Vec<f64>| structure.modes.get(k).map_or(&[][..], |m| of(m));
        match self.part {
            Part::Elevation => &structure.elevation_rad,
            Part::RigidGain => &structure.rigid_gain_ratio,
            Part::Frequency(k) => mode(k, |m| &m.frequency_hz),
            Part::Damping(k) => mode(k, |m| &m.damping_ratio),
            Part::Gyro(k) => mode(k, |m| &m.gyro_per_kg_m2),
            Part::Encoder(k) => mode(k, |m| &m.encoder_per_kg_m2),
        }
    }

    /// Puts values in; a mode that was absent comes into being.
    pub fn set(&self, unit: &mut UnitSettings, values: Vec<f64>) {
        let structure: &mut StructureSettings = match self.axis {
            0 => &mut unit.az_structure,
            _ => &mut unit.el_structure,
        };
        let (Part::Frequency(k) | Part::Damping(k) | Part::Gyro(k) | Part::Encoder(k)) = self.part else {
            match self.part {
                Part::Elevation => structure.elevation_rad = values,
                _ => structure.rigid_gain_ratio = values,
            }
            return;
        };
        if structure.modes.len() <= k {
            structure.modes.resize(k + 1, ModeCurves::default());
        }
        let mode = &mut structure.modes[k];
        match self.part {
            Part::Frequency(_) => mode.frequency_hz = values,
            Part::Damping(_) => mode.damping_ratio = values,
            Part::Gyro(_) => mode.gyro_per_kg_m2 = values,
            _ => mode.encoder_per_kg_m2 = values,
        }
    }
}
