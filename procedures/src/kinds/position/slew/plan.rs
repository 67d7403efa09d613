//! What a procedure says, and the point: all cues, again and again.

use crate::axis::{Axes, AxisLimits};
use crate::case::{Case, Request, Segment};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned::{self, Elevation};
use crate::quantity::QuantityKind as Q;
use crate::stimulus::ProfileLimits;
use crate::table::{Field, Shape, TableReader};

pub(super) const FIELDS: &[Field] = &[
    Field::required(
        "moves",
        Shape::Choice(&["full", "gentle", "cue"]),
        "`full`: largest acceleration; `gentle`: the smallest acceleration that reaches the velocity; \
         `cue`: as given.",
    ),
    Field::default("elevation", Shape::Quantity(Q::Angle), "0 deg", "Elevation while azimuth moves."),
    Field::optional(
        "cues",
        Shape::Quantities(Q::Angle),
        "Positions to slew to in turn, then back to the first; default: both ends of the travel.",
    ),
    Field::default(
        "repeats",
        Shape::Integer,
        "2",
        "Number of times that all cues are visited; an overshoot is judged from five on.",
    ),
    Field::default("rest", Shape::Quantity(Q::Time), "3.5 s", "Rest at each cue."),
    Field::default("plateau", Shape::Quantity(Q::Time), "0.6 s", "Duration of the cruise in gentle moves."),
    Field::default(
        "acceleration",
        Shape::Quantity(Q::AngularAcceleration),
        "20 deg/s^2",
        "Acceleration of slews to cues.",
    ),
    Field::default(
        "jerk",
        Shape::Quantity(Q::AngularJerk),
        "1 deg/s^3",
        "Jerk of slews to cues; it determines the overshoot.",
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

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
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
                let help =
                    "give at least two positions; neighbours must differ, and so must the first and the last";
                table.mistake("cues", "a slew from a cue to the same cue", Some(help.to_owned()));
            }
        }
        let repeats = repeats?;
        let rest_s = rest_s?;
        let cues = cues_rad.iter().flatten().map(Vec::len).next().unwrap_or(2);
        table.check_steps("repeats", &[cues, repeats as usize, 2]);
        if rest_s < 1.0 {
            table.mistake("rest", "a move needs 1 s to settle", None);
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

/// Label of moves, with the number of the cue that they go to.
pub(super) const SLEW: &str = "slew to cue";
/// Label of rests, with the number of their cue.
pub(super) const REST: &str = "rest at cue";
/// Without cues the moves turn this far from the soft limits: a stop from a full move must still fit.
const ROOM_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Gentle moves accelerate by this much more than they must.
const MARGIN_RATIO: f64 = 1.02;

pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    let limits = positioned::limits_of(axis, axes)?;
    let [low, high] = limits.soft_limits_rad;
    let cues = keys.cues_rad.clone().unwrap_or_else(|| vec![low + ROOM_RAD, high - ROOM_RAD]);
    let mut mistakes: Vec<Diagnostic> =
        cues.iter().filter_map(|cue| positioned::outside("cue", *cue, axis, limits)).collect();
    mistakes.extend(Elevation::of(axis, axes).held_outside(keys.elevation_rad));
    let profile = match keys.moves {
        Moves::Full => Some(positioned::profile(limits, f64::INFINITY, f64::INFINITY)),
        Moves::Gentle => gentle(keys, &cues, limits),
        Moves::Cue => Some(ProfileLimits {
            jerk_rad_per_s3: keys.jerk_rad_per_s3.min(limits.max_jerk_rad_per_s3),
            ..positioned::profile(limits, f64::INFINITY, keys.acceleration_rad_per_s2)
        }),
    };
    mistakes.extend(profile.is_none().then(|| too_near(keys, limits)));
    let Some(profile) = profile.filter(|_| mistakes.is_empty()) else { return Err(mistakes) };
    let held = Elevation::of(axis, axes).held_request(keys.elevation_rad);
    let requested: Vec<Request> = held.into_iter().collect();
    let moves = match keys.moves {
        Moves::Full => "full",
        Moves::Gentle => "gentle",
        Moves::Cue => "cue",
    };
    let point = [moves.to_owned(), positioned::point_name(&requested)];
    Ok(vec![Case {
        point: point.join(" ").trim_end().to_owned(),
        axis: axis.to_owned(),
        requested,
        start_pose_rad: positioned::start_pose(axes, axis, cues[0], keys.elevation_rad),
        segments: segments(keys, &cues, profile),
        ..Case::default()
    }])
}

fn segments(keys: &Keys, cues: &[f64], profile: ProfileLimits) -> Vec<Segment> {
    let mut all = vec![positioned::stay("before", 1.0)];
    for _ in 0..keys.repeats {
        for k in 0..cues.len() {
            let next = (k + 1) % cues.len();
            all.push(positioned::move_to(&format!("{SLEW} {next}"), cues[k], cues[next], profile));
            all.push(positioned::stay(&format!("{REST} {next}"), keys.rest_s));
        }
    }
    positioned::ended(all)
}

/// The least acceleration with which the shortest of the moves reaches the velocity and cruises: the ramps of a jerk-limited
/// move take v²/a + v·a/j.
fn gentle(keys: &Keys, cues: &[f64], limits: &AxisLimits) -> Option<ProfileLimits> {
    let v = limits.max_velocity_rad_per_s;
    let j = limits.max_jerk_rad_per_s3;
    let ways = cues.iter().zip(cues.iter().skip(1).chain(&cues[..1])).map(|(a, b)| (a - b).abs());
    let ramps_rad = ways.fold(f64::INFINITY, f64::min) - v * keys.plateau_s;
    let square = ramps_rad * ramps_rad - 4.0 * v * v * v / j;
    if ramps_rad <= 0.0 || square < 0.0 {
        return None;
    }
    let acceleration = MARGIN_RATIO * (ramps_rad - square.sqrt()) * j / (2.0 * v);
    let allowed = acceleration <= limits.max_acceleration_rad_per_s2;
    allowed.then(|| positioned::profile(limits, v, acceleration))
}

fn too_near(keys: &Keys, limits: &AxisLimits) -> Diagnostic {
    let message = format!(
        "no move between these cues cruises for {} at {} within {}",
        Q::Time.format(keys.plateau_s),
        Q::AngularVelocity.format(limits.max_velocity_rad_per_s),
        Q::AngularAcceleration.format(limits.max_acceleration_rad_per_s2)
    );
    Diagnostic::new(message).help("set the cues farther apart, or use a shorter `plateau`")
}
