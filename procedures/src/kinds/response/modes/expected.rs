//! What was calculated: a frequency over elevation, or a band.

use crate::quantity::QuantityKind as Q;
use crate::table::{Field, Shape, TableReader};

/// Keys of a table `[[expected]]`.
pub(super) const EXPECTED: &[Field] = &[
    Field::required("mode", Shape::Integer, "Number of the mode in the calculation, 1 to 4."),
    Field::optional(
        "elevation",
        Shape::Quantities(Q::Angle),
        "Elevations of the calculation, ascending; between them its frequencies are interpolated.",
    ),
    Field::optional("frequency", Shape::Quantities(Q::Frequency), "Calculated frequency at each of them."),
    Field::optional("band", Shape::Range(Q::Frequency), "Instead of both: where the frequency must lie."),
    Field::default(
        "seen-by",
        Shape::Choice(&["both", "gyro"]),
        "both",
        "Sensors that show it: `gyro` for a mode that moves the frame but not the shaft.",
    ),
];

const DEPARTURES: [&str; MOST] =
    ["mode-1-departure", "mode-2-departure", "mode-3-departure", "mode-4-departure"];
const FREQUENCIES: [&str; MOST] =
    ["first-mode-frequency", "second-mode-frequency", "third-mode-frequency", "fourth-mode-frequency"];
/// Modes that have a name.
const MOST: usize = 4;

/// Where a mode is expected.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Place {
    /// (elevation rad, frequency Hz), elevations ascending.
    Curve(Vec<(f64, f64)>),
    /// Lowest and highest frequency, Hz.
    Band([f64; 2]),
}

/// An expected mode.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Expected {
    /// Number in the calculation, 1…4.
    pub(super) mode: usize,
    pub(super) place: Place,
    /// Whether the encoder must not show it.
    pub(super) gyro_only: bool,
}

impl Expected {
    /// Name of what it yields.
    pub(super) fn measurand(&self) -> &'static str {
        match self.place {
            Place::Curve(_) => DEPARTURES[self.mode - 1],
            Place::Band(_) => FREQUENCIES[self.mode - 1],
        }
    }

    /// Kind of quantity of what it yields.
    pub(super) fn kind(&self) -> Q {
        if self.curve().is_some() { Q::Ratio } else { Q::Frequency }
    }

    fn curve(&self) -> Option<&[(f64, f64)]> {
        match &self.place {
            Place::Curve(curve) => Some(curve),
            Place::Band(_) => None,
        }
    }

    /// Lowest and highest frequency that are expected at an elevation, Hz; equal for a curve.
    pub(super) fn range_hz(&self, elevation_rad: f64) -> [f64; 2] {
        match &self.place {
            Place::Curve(curve) => [interpolated(curve, elevation_rad); 2],
            Place::Band(band) => *band,
        }
    }
}

/// Linear between the nodes, constant outside.
fn interpolated(curve: &[(f64, f64)], x: f64) -> f64 {
    let after = curve.partition_point(|(at, _)| *at < x);
    match (after.checked_sub(1).map(|k| curve[k]), curve.get(after)) {
        (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
        (Some((_, y)), None) => y,
        (None, Some(&(_, y))) => y,
        (None, None) => f64::NAN,
    }
}

/// Reads one table.
pub(super) fn read(t: &mut TableReader<'_>) -> Option<Expected> {
    let mode = t.count("mode", 1)? as usize;
    let gyro_only = t.text("seen-by")? == "gyro";
    if mode > MOST {
        t.mistake("mode", format!("mode {mode} has no name"), Some(format!("1 to {MOST}")));
        return None;
    }
    let place = if t.has("band") { band(t) } else { curve(t) };
    Some(Expected { mode, place: place?, gyro_only })
}

fn band(t: &mut TableReader<'_>) -> Option<Place> {
    for key in ["elevation", "frequency"] {
        if t.has(key) {
            t.mistake(key, format!("`band` and `{key}` exclude each other"), None);
        }
    }
    let band = t.range("band")?;
    if band[0] <= 0.0 {
        t.mistake("band", "a frequency is positive", None);
        return None;
    }
    Some(Place::Band(band))
}

fn curve(t: &mut TableReader<'_>) -> Option<Place> {
    if !t.has("elevation") || !t.has("frequency") {
        let help = "`elevation` with `frequency`, or `band`".to_owned();
        t.mistake("mode", "nothing says where the mode is expected", Some(help));
        return None;
    }
    let elevations = t.quantities("elevation")?;
    let frequencies = t.quantities("frequency")?;
    if elevations.len() != frequencies.len() {
        let message = format!("{} frequencies at {} elevations", frequencies.len(), elevations.len());
        t.mistake("frequency", message, Some("one frequency for each elevation".to_owned()));
        return None;
    }
    if elevations.windows(2).any(|pair| pair[0] >= pair[1]) {
        t.mistake("elevation", "elevations of a calculation ascend", None);
        return None;
    }
    if frequencies.iter().any(|f| *f <= 0.0) {
        t.mistake("frequency", "a frequency is positive", None);
        return None;
    }
    Some(Place::Curve(elevations.into_iter().zip(frequencies).collect()))
}

/// Refuses none, one twice, and modes that do not ascend.
pub(super) fn checked(t: &mut TableReader<'_>, expected: Vec<Expected>) -> Option<Vec<Expected>> {
    if expected.is_empty() {
        t.mistake("expected", "no mode is expected", Some("one `[[expected]]` table or more".to_owned()));
        return None;
    }
    if expected.windows(2).any(|pair| pair[0].mode >= pair[1].mode) {
        let help = "each number once".to_owned();
        t.mistake("expected", "modes stand in ascending order of their numbers", Some(help));
        return None;
    }
    Some(expected)
}
