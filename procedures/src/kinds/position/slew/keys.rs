//! What a procedure says.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "moves",
        Shape::Choice(&["full", "gentle", "cue"]),
        "`full`: largest acceleration; `gentle`: the least that reaches the velocity; `cue`: as stated.",
    ),
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation while azimuth moves."),
    Field::optional(
        "cues",
        Shape::Quantities(Q::Angle),
        "Places to slew to, one after the other and back to the first; both ends of the travel without it.",
    ),
    Field::default("repeats", Shape::Integer, "2", "How often all cues are visited."),
    Field::default("rest", Shape::Quantity(Q::Time), "3.5 s", "Time at each cue."),
    Field::default("plateau", Shape::Quantity(Q::Time), "0.6 s", "Cruise of gentle moves."),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "20 deg/s^2",
        "Of slews to cues.",
    ),
    Field::default(
        "jerk",
        Shape::Quantity(Q::AngularJerk),
        "1 deg/s^3",
        "Of slews to cues: it decides the overshoot.",
    ),
];

/// Which limit the moves go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moves {
    Full,
    Gentle,
    Cue,
}

/// The keys, read. SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    pub(super) moves: Moves,
    pub(super) elevation_rad: f64,
    pub(super) cues_rad: Option<Vec<f64>>,
    pub(super) repeats: u32,
    pub(super) rest_s: f64,
    pub(super) plateau_s: f64,
    pub(super) acceleration_rad_per_s2: f64,
    pub(super) jerk_rad_per_s3: f64,
}

impl Keys {
    /// Reads them; mistakes stay in the reader.
    pub(super) fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let moves = table.text("moves");
        let elevation_rad = table.quantity("elevation");
        let cues_rad = table.has("cues").then(|| table.quantities("cues"));
        let repeats = table.count("repeats", 1);
        let rest_s = table.positive("rest");
        let plateau_s = table.positive("plateau");
        let acceleration = table.positive("acceleration");
        let jerk = table.positive("jerk");
        if let Some(Some(cues)) = &cues_rad {
            let stays = cues.iter().zip(cues.iter().skip(1).chain(&cues[..1])).any(|(a, b)| a == b);
            if stays {
                let help = "give at least two places, each other than the one before it, the first other than the last";
                table.mistake("cues", "a slew from a cue to the same cue", Some(help.to_owned()));
            }
        }
        let repeats = repeats?;
        let rest_s = rest_s?;
        let cues = cues_rad.iter().flatten().map(Vec::len).next().unwrap_or(2);
        table.check_steps("repeats", &[cues, repeats as usize, 2]);
        if rest_s < 1.0 {
            table.mistake("rest", "a move needs 1 s to end", None);
        }
        Some(Self {
            moves: match moves?.as_str() {
                "full" => Moves::Full,
                "gentle" => Moves::Gentle,
                _ => Moves::Cue,
            },
            elevation_rad: elevation_rad?,
            cues_rad: match cues_rad {
                Some(cues) => Some(cues?),
                None => None,
            },
            repeats,
            rest_s,
            plateau_s: plateau_s?,
            acceleration_rad_per_s2: acceleration?,
            jerk_rad_per_s3: jerk?,
        })
    }
}
