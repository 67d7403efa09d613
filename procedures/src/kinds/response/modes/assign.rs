//! Which mode that was found is which mode that was expected, by a frequency over elevation or a band.

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
    Field::optional("frequency", Shape::Quantities(Q::Frequency), "Calculated frequency at each elevation."),
    Field::optional(
        "band",
        Shape::Range(Q::Frequency),
        "Band in which the frequency must lie, instead of `elevation` and `frequency`.",
    ),
    Field::default(
        "seen-by",
        Shape::Choice(&["both", "gyro"]),
        "both",
        "Sensors that show the mode: `gyro` for one that moves the frame but not the shaft.",
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

    /// Whether it may be there: a curve does not say how far off a mode may lie.
    pub(super) fn allows(&self, frequency_hz: f64) -> bool {
        match &self.place {
            Place::Curve(_) => true,
            Place::Band([low, high]) => (*low..=*high).contains(&frequency_hz),
        }
    }

    /// Whether a mode that was taken for `other` could as well be this one: both lie on curves within 35 % of it. Bands tell modes apart.
    pub(super) fn could_be(&self, other: &Self, frequency_hz: f64, elevation_rad: f64) -> bool {
        let [expected_hz, _] = self.range_hz(elevation_rad);
        let is_near = (frequency_hz / expected_hz).ln().abs() < ANOTHER;
        self.curve().is_some() && other.curve().is_some() && self.gyro_only == other.gyro_only && is_near
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
        t.mistake("mode", format!("mode {mode} is out of range"), Some(format!("1 to {MOST}")));
        return None;
    }
    let place = if t.has("band") { band(t) } else { curve(t) };
    Some(Expected { mode, place: place?, gyro_only })
}

fn band(t: &mut TableReader<'_>) -> Option<Place> {
    for key in ["elevation", "frequency"] {
        if t.has(key) {
            t.mistake(key, format!("`band` and `{key}` cannot be given together"), None);
        }
    }
    let band = t.range("band")?;
    if band[0] <= 0.0 {
        t.mistake("band", "give a positive frequency", None);
        return None;
    }
    Some(Place::Band(band))
}

fn curve(t: &mut TableReader<'_>) -> Option<Place> {
    if !t.has("elevation") || !t.has("frequency") {
        let help = "`elevation` with `frequency`, or `band`".to_owned();
        t.mistake("mode", "the expected frequency of the mode is missing", Some(help));
        return None;
    }
    let elevations = t.quantities("elevation")?;
    let frequencies = t.quantities("frequency")?;
    if elevations.len() != frequencies.len() {
        let message = format!("{} frequencies at {} elevations", frequencies.len(), elevations.len());
        t.mistake("frequency", message, Some("give one frequency for each elevation".to_owned()));
        return None;
    }
    if elevations.windows(2).any(|pair| pair[0] >= pair[1]) {
        t.mistake("elevation", "list the elevations in ascending order", None);
        return None;
    }
    if frequencies.iter().any(|f| *f <= 0.0) {
        t.mistake("frequency", "give a positive frequency", None);
        return None;
    }
    Some(Place::Curve(elevations.into_iter().zip(frequencies).collect()))
}

/// Refuses none, one twice, and modes that do not ascend.
pub(super) fn checked(t: &mut TableReader<'_>, expected: Vec<Expected>) -> Option<Vec<Expected>> {
    if expected.is_empty() {
        t.mistake(
            "expected",
            "no mode is expected",
            Some("add at least one `[[expected]]` table".to_owned()),
        );
        return None;
    }
    if expected.windows(2).any(|pair| pair[0].mode >= pair[1].mode) {
        let help = "use each number once".to_owned();
        t.mistake("expected", "list the modes in ascending order of their numbers", Some(help));
        return None;
    }
    Some(expected)
}

/// ln of the ratio of frequencies from which on a mode is another one: a structure 35 % softer or stiffer than its
/// calculation in frequency has another shape.
const ANOTHER: f64 = 0.30;
/// Cost of a sensor that shows what it should not.
const WRONG_SENSOR: f64 = 0.20;
/// Most that leaving a mode out costs that stands out from the rigid axis: otherwise a speck of noise that happens to
/// lie nearer would take its place.
const LEFT_OUT: f64 = 0.10;
/// Inside a band the middle is hardly better than the ends.
const IN_BAND: f64 = 0.02;
/// A resonance so many times as high as a candidate is no bystander: where nobody else is it, it may be the mode that was
/// expected, and the candidate a speck that happens to lie nearer.
const TALLER: f64 = 10.0;

/// What is known of an expected mode at one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Lowest and highest frequency, Hz.
    pub(super) range_hz: [f64; 2],
    /// Whether the encoder must not show it.
    pub(super) gyro_only: bool,
}

/// What is known of a mode that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) frequency_hz: f64,
    /// Height of its resonance over the rigid axis.
    pub(super) height: f64,
    /// Whether the gyro alone shows it.
    pub(super) gyro_only: bool,
}

/// Index of the mode found for each mode expected; both ascend in frequency, and so do the pairs. Least total of
/// |ln f/f₀| (outside of a band: from its nearer end), the wrong sensors, and resonances that are left out; no mode is a
/// speck beside a resonance that would be left over and could be it.
pub(super) fn assign(wanted: &[Wanted], found: &[Candidate]) -> Vec<Option<usize>> {
    let mut refused = vec![vec![false; found.len()]; wanted.len()];
    loop {
        let pairs = cheapest(wanted, found, &refused);
        match speck(wanted, found, &pairs) {
            // Every round refuses one pair more, so there are no more rounds than pairs.
            Some((i, k)) => refused[i][k] = true,
            None => return pairs,
        }
    }
}

/// A pair whose candidate has a much taller one beside it that nobody else is, as near as the same mode may be and shown
/// by the sensors no worse.
fn speck(wanted: &[Wanted], found: &[Candidate], pairs: &[Option<usize>]) -> Option<(usize, usize)> {
    let named = |(i, pair): (usize, &Option<usize>)| {
        let k = (*pair)?;
        let mode = &wanted[i];
        let chosen = &found[k];
        let fits = |c: &Candidate| c.gyro_only == mode.gyro_only;
        let could_be = |(j, c): (usize, &Candidate)| {
            !pairs.contains(&Some(j))
                && c.height >= TALLER * chosen.height
                && (fits(c) || !fits(chosen))
                && distance(mode, c).is_finite()
        };
        found.iter().enumerate().any(could_be).then_some((i, k))
    };
    pairs.iter().enumerate().find_map(named)
}

/// The pairs of least cost without those that are refused.
fn cheapest(wanted: &[Wanted], found: &[Candidate], refused: &[Vec<bool>]) -> Vec<Option<usize>> {
    let n = wanted.len();
    let m = found.len();
    let left_out = |c: &Candidate| LEFT_OUT * c.height.min(1.0);
    let paired = |i: usize, k: usize| {
        if refused[i][k] { f64::INFINITY } else { distance(&wanted[i], &found[k]) }
    };
    // least[i][k]: cheapest for the first i expected and the first k found.
    let mut least = vec![vec![0.0; m + 1]; n + 1];
    for i in 0..=n {
        for k in 0..=m {
            if i + k == 0 {
                continue;
            }
            let mut cost = f64::INFINITY;
            if i > 0 {
                cost = least[i - 1][k] + ANOTHER;
            }
            if k > 0 {
                cost = cost.min(least[i][k - 1] + left_out(&found[k - 1]));
            }
            if i > 0 && k > 0 {
                cost = cost.min(least[i - 1][k - 1] + paired(i - 1, k - 1));
            }
            least[i][k] = cost;
        }
    }
    let mut pairs = vec![None; n];
    let mut i = n;
    let mut k = m;
    while i > 0 && k > 0 {
        if least[i][k] == least[i - 1][k - 1] + paired(i - 1, k - 1) {
            (i, k) = (i - 1, k - 1);
            pairs[i] = Some(k);
        } else if least[i][k] == least[i][k - 1] + left_out(&found[k - 1]) {
            k -= 1;
        } else {
            i -= 1;
        }
    }
    pairs
}

/// How far a mode is from what was expected; infinite if it is another one.
fn distance(wanted: &Wanted, found: &Candidate) -> f64 {
    let [low, high] = wanted.range_hz;
    let f = found.frequency_hz;
    let outside = (low / f).ln().max((f / high).ln()).max(0.0);
    if outside >= ANOTHER {
        return f64::INFINITY;
    }
    let off_centre = IN_BAND * (f / (low * high).sqrt()).ln().abs();
    outside + off_centre + if wanted.gyro_only == found.gyro_only { 0.0 } else { WRONG_SENSOR }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(frequency_hz: f64, gyro_only: bool) -> Wanted {
        Wanted { range_hz: [frequency_hz; 2], gyro_only }
    }

    fn found(frequency_hz: f64, height: f64, gyro_only: bool) -> Candidate {
        Candidate { frequency_hz, height, gyro_only }
    }

    fn elevation() -> Vec<Wanted> {
        vec![wanted(10.0, true), wanted(16.6, false), wanted(17.4, false)]
    }

    #[test]
    fn modes_near_their_calculation_are_taken_in_order() {
        let seen = [found(10.1, 0.05, true), found(17.25, 2.0, false), found(18.0, 1.5, false)];
        assert_eq!(assign(&elevation(), &seen), [Some(0), Some(1), Some(2)]);
    }

    #[test]
    fn a_bending_mode_that_is_not_seen_is_not_replaced_by_a_torsional_one_that_came_down() {
        let seen = [found(13.2, 2.0, false), found(18.0, 1.5, false)];
        assert_eq!(assign(&elevation(), &seen), [None, Some(0), Some(1)]);
    }

    #[test]
    fn a_speck_nearer_to_the_calculation_does_not_take_the_place_of_a_resonance() {
        let seen = [found(16.6, 0.001, false), found(17.25, 2.0, false), found(18.0, 1.5, false)];
        assert_eq!(assign(&elevation(), &seen), [None, Some(1), Some(2)]);
    }

    fn azimuth() -> Vec<Wanted> {
        [[34.0, 43.0], [44.0, 57.0]].map(|range_hz| Wanted { range_hz, gyro_only: false }).into()
    }

    #[test]
    fn a_speck_inside_the_band_does_not_take_the_place_of_a_resonance_far_below_it() {
        // Leaving the resonance out costs 0.10, being 14 % below the band 0.142: the speck is cheaper, and is not the mode.
        let seen = [found(29.5, 3.0, false), found(36.0, 0.05, false), found(50.0, 2.0, false)];
        assert_eq!(assign(&azimuth(), &seen), [Some(0), Some(2)]);
        // The same where both came up: 14 % above its band is still the first one.
        let seen = [found(36.0, 0.05, false), found(49.0, 3.0, false), found(52.0, 2.0, false)];
        assert_eq!(assign(&azimuth(), &seen), [Some(1), Some(2)]);
    }

    #[test]
    fn a_small_mode_of_the_gyro_alone_is_no_speck_beside_a_resonance_that_both_show() {
        let seen = [
            found(10.1, 0.05, true),
            found(12.0, 2.0, false),
            found(17.25, 2.0, false),
            found(18.0, 1.5, false),
        ];
        assert_eq!(assign(&elevation(), &seen), [Some(0), Some(2), Some(3)]);
    }

    #[test]
    fn modes_far_away_are_left_out() {
        let seen = [found(4.0, 2.0, false), found(47.0, 1.0, false)];
        assert_eq!(assign(&elevation(), &seen), [None; 3]);
        assert_eq!(assign(&elevation(), &[]), [None; 3]);
    }

    #[test]
    fn anywhere_in_a_band_is_as_good() {
        let bands = azimuth();
        let seen = [found(42.9, 3.0, false), found(44.2, 1.0, false)];
        assert_eq!(assign(&bands, &seen), [Some(0), Some(1)]);
        // 15 % below its band it is still the same mode, and to be judged as such.
        assert_eq!(assign(&bands, &[found(29.5, 3.0, false)]), [Some(0), None]);
    }
}
