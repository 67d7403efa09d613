//! What a mirror impedance procedure says, and the points: the gimbal holds, the analyser sweeps one axis of the mirror.

use crate::axis::Axes;
use crate::case::{Case, Mode, Request, Segment};
use crate::device::{MIRROR_AXES, Task};
use crate::diagnostic::Diagnostic;
use crate::kinds::ReadKeys;
use crate::kinds::position::positioned;
use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader, suggestion};

/// Axes of the mirror, with the modes that are expected by default (director.md E6).
const MODES_HZ: [f64; 2] = [322.0, 350.0];

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default("mirror-axis", Shape::Texts, "az, el", "Axes of the mirror to measure."),
    Field::default("level", Shape::Quantity(Q::Voltage), "1 V", "Level of the sine, peak to peak."),
    Field::default("range", Shape::Range(Q::Frequency), "20 Hz .. 2 kHz", "First and last frequency."),
    Field::default("points", Shape::Integer, "401", "Points, spaced logarithmically."),
    Field::default(
        "at-most",
        Shape::Quantity(Q::Time),
        "120 s",
        "Time limit of a sweep; it ends earlier when the analyser is done.",
    ),
    Field::optional(
        "expected-mode",
        Shape::Map(&Shape::Quantity(Q::Frequency)),
        "Expected mode by axis, e.g. `{ az = \"322 Hz\", el = \"350 Hz\" }`, which is the default.",
    ),
    Field::default(
        "azimuth",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Azimuth at which the gimbal holds meanwhile.",
    ),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Elevation at which the gimbal holds."),
];

/// A mirror impedance procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// Names with expected modes, Hz.
    pub(super) mirror_axes: Vec<(String, f64)>,
    pub(super) level_v: f64,
    pub(super) range_hz: [f64; 2],
    pub(super) points: u32,
    pub(super) at_most_s: f64,
    pub(super) azimuth_rad: f64,
    pub(super) elevation_rad: f64,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let modes = expected_modes(table);
        let mirror_axes = mirror_axes(table, &modes);
        let level_v = table.positive("level");
        let range_hz = table.range("range");
        // Three numbers a point would be enough for six unknowns; a resonance of 4 % width needs more.
        let points = table.count("points", 60);
        let at_most_s = table.positive("at-most");
        let azimuth_rad = table.quantity("azimuth");
        let elevation_rad = table.quantity("elevation");
        if range_hz.is_some_and(|[low_hz, _]| low_hz <= 0.0) {
            table.mistake("range", "the first frequency must be above zero", None);
        }
        Some(Self {
            mirror_axes: mirror_axes?,
            level_v: level_v?,
            range_hz: range_hz?,
            points: points?,
            at_most_s: at_most_s?,
            azimuth_rad: azimuth_rad?,
            elevation_rad: elevation_rad?,
        })
    }
}

fn expected_modes(table: &mut TableReader<'_>) -> Vec<(String, f64)> {
    let mut modes: Vec<(String, f64)> = Vec::new();
    for (axis, text, span) in table.map("expected-mode").unwrap_or_default() {
        if !MIRROR_AXES.contains(&axis.as_str()) {
            let help = suggestion(&axis, MIRROR_AXES);
            table.mistake_at(span, format!("the mirror has no axis `{axis}`"), Some(help));
            continue;
        }
        match Q::Frequency.parse(&text) {
            Ok(hz) if hz > 0.0 => modes.push((axis, hz)),
            Ok(_) => table.mistake_at(span, format!("`{axis}` must be above zero"), None),
            Err(error) => table.mistake_at(span, format!("`{axis}`: {error}"), error.help()),
        }
    }
    modes
}

fn mirror_axes(table: &mut TableReader<'_>, modes: &[(String, f64)]) -> Option<Vec<(String, f64)>> {
    let given = table.spanned_texts("mirror-axis")?;
    let mut all: Vec<(String, f64)> = Vec::new();
    for (axis, span) in &given {
        let known = MIRROR_AXES.iter().zip(MODES_HZ);
        let Some((name, default_hz)) = known.into_iter().find(|(name, _)| *name == axis) else {
            let help = suggestion(axis, MIRROR_AXES);
            table.mistake_at(span.clone(), format!("the mirror has no axis `{axis}`"), Some(help));
            continue;
        };
        if all.iter().any(|(other, _)| other == name) {
            table.mistake_at(span.clone(), format!("`{name}` is given twice"), None);
        }
        let expected_hz = modes.iter().find(|(of, _)| of == name).map_or(default_hz, |(_, hz)| *hz);
        all.push(((*name).to_owned(), expected_hz));
    }
    if given.is_empty() {
        table.mistake("mirror-axis", "`mirror-axis` is an empty list", None);
    }
    (!all.is_empty() && all.len() == given.len()).then_some(all)
}

/// Label of the sweep.
const SWEEP: &str = "sweep";
/// Condition of a point.
pub(super) const LEVEL: &str = "level";
/// Label of the rest before it.
const SETTLE: &str = "settle";
const SETTLE_S: f64 = 0.25;

/// One point an axis of the mirror.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    positioned::check_axes("fsm-impedance", axis, axes)?;
    let case = |mirror_axis: &str| {
        let task = Task::Impedance {
            axis: mirror_axis.to_owned(),
            level_v_ptp: keys.level_v,
            from_hz: keys.range_hz[0],
            to_hz: keys.range_hz[1],
            points: keys.points,
        };
        let sweep = Segment { task: Some(task), ..Segment::hold(SWEEP, Mode::Position, keys.at_most_s) };
        Case {
            point: format!("{mirror_axis} impedance"),
            axis: axis.to_owned(),
            requested: vec![Request { name: LEVEL.to_owned(), value: keys.level_v, kind: Q::Voltage }],
            start_pose_rad: positioned::poses(axes, [keys.azimuth_rad, keys.elevation_rad]),
            segments: vec![Segment::hold(SETTLE, Mode::Position, SETTLE_S), sweep],
            ..Case::default()
        }
    };
    Ok(keys.mirror_axes.iter().map(|(name, _)| case(name)).collect())
}

/// Axis of the mirror that a case sweeps.
pub(super) fn mirror_axis(case: &Case) -> &str {
    let tasks = case.segments.iter().filter_map(|s| s.task.as_ref());
    tasks
        .filter_map(|task| if let Task::Impedance { axis, .. } = task { Some(axis.as_str()) } else { None })
        .next()
        .unwrap_or("")
}
