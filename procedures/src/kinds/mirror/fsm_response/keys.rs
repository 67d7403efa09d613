//! What a mirror response procedure says, and how it is read.

use crate::case::MirrorChannel;
use crate::device::MIRROR_AXES;
use crate::diagnostic::nearest;
use crate::kinds::ReadKeys;
use crate::quantity::{Limit, QuantityKind as Q};
use crate::table::{Field, Shape, TableReader, quoted};

const CHANNELS: [&str; 2] = ["analog", "serial"];

/// The kind's own keys.
pub(super) const FIELDS: &[Field] = &[
    Field::default("mirror-axis", Shape::Texts, "az, el", "Axes of the mirror to measure."),
    Field::default("channel", Shape::Texts, "analog, serial", "Command channels to measure."),
    Field::default(
        "level",
        Shape::Quantities(Q::Voltage),
        "1 V, 2 V",
        "Levels of the command, peak to peak; `scale` converts them to angles.",
    ),
    Field::default(
        "scale",
        Shape::Quantity(Q::AngleScale),
        "500 urad/V",
        "Mirror angle per volt of a level.",
    ),
    Field::default(
        "place",
        Shape::Choice(&["table", "assembly"]),
        "table",
        "Support of the mirror: on the optical table, or in the assembly; reported only.",
    ),
    Field::default(
        "azimuth",
        Shape::Quantity(Q::Angle),
        "0 deg",
        "Azimuth at which the gimbal holds meanwhile.",
    ),
    Field::default("elevation", Shape::Quantity(Q::Angle), "40 deg", "Elevation at which the gimbal holds."),
    Field::default("multisine", Shape::Table(MULTISINE), "", "The excitation of the response."),
    Field::default("channels", Shape::Table(DELAYS), "", "Known data of the channels."),
    Field::optional("stroke", Shape::Table(STROKE), "Positions up to the end of the stroke."),
    Field::optional("harmonics", Shape::Table(HARMONICS), "Single sines for the sum of harmonics."),
    Field::optional(
        "gauge-u",
        Shape::Quantity(Q::Ratio),
        "Relative standard uncertainty of the strain gauges' scale, from a certificate; used where there \
         is no autocollimator.",
    ),
    Field::default(
        "reference-u",
        Shape::Quantity(Q::Ratio),
        "0.2 %",
        "Relative standard uncertainty of the autocollimator's scale.",
    ),
];

const MULTISINE: &[Field] = &[
    Field::default("range", Shape::Range(Q::Frequency), "2 Hz .. 1500 Hz", "Lowest and highest line."),
    Field::default("lines", Shape::Integer, "80", "Log-spaced lines, those of `reaction` not counted."),
    Field::default(
        "reaction",
        Shape::Range(Q::Frequency),
        "60 Hz .. 250 Hz",
        "Band in which a resonance of the support is sought; every multiple of 1/period is excited there.",
    ),
    Field::default("period", Shape::Quantity(Q::Time), "0.5 s", "Period of the excitation."),
    Field::default("periods", Shape::Integer, "12", "Periods, including those that are dropped."),
    Field::default("dropped", Shape::Integer, "2", "Periods at the start in which the response settles."),
    Field::default(
        "least-snr",
        Shape::Quantity(Q::Decibel),
        "20 dB",
        "Least ratio of the mean of a line to its scatter; other lines are left out.",
    ),
];

const DELAYS: &[Field] = &[
    Field::default("known-analog", Shape::Quantity(Q::Time), "50 us", "Delay inside the unit, analog input."),
    Field::default(
        "known-serial",
        Shape::Quantity(Q::Time),
        "150 us",
        "Delay inside the unit, serial command.",
    ),
    Field::default(
        "serial-bit-rate",
        Shape::Quantity(Q::Frequency),
        "937.5 kHz",
        "Bits per second on the serial line: a command takes 9 or 10 characters of 10 bits.",
    ),
    Field::default("delay-u", Shape::Quantity(Q::Time), "10 us", "Standard uncertainty of a known delay."),
    Field::default(
        "compared-to",
        Shape::Quantity(Q::Frequency),
        "100 Hz",
        "Highest frequency at which the channels are compared.",
    ),
];

const STROKE: &[Field] = &[
    Field::default("reach", Shape::Quantity(Q::Angle), "1.05 mrad", "Largest position that is commanded."),
    Field::default("positions", Shape::Integer, "4", "Number of positions on each side, equally spaced."),
    Field::default(
        "ramp",
        Shape::Quantity(Q::Time),
        "0.1 s",
        "Time of the ramp from the middle to a position.",
    ),
    Field::default("rest", Shape::Quantity(Q::Time), "0.2 s", "Time at the position; the last half counts."),
];

const HARMONICS: &[Field] = &[
    Field::default(
        "frequency",
        Shape::Quantities(Q::Frequency),
        "20 Hz, 50 Hz, 100 Hz",
        "Sines, each a whole number of rows long.",
    ),
    Field::default(
        "duration",
        Shape::Quantity(Q::Time),
        "1 s",
        "Duration of each sine; the last half counts.",
    ),
    Field::default(
        "criterion",
        Shape::Limit(Q::Ratio),
        "<= 5 %",
        "Criterion for the sum of harmonics 2 to 5; reported only.",
    ),
];

/// A mirror response procedure, SI units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// Indices into [`MIRROR_AXES`].
    pub(super) mirror_axes: Vec<usize>,
    pub(super) channels: Vec<MirrorChannel>,
    pub(super) levels_v: Vec<f64>,
    pub(super) scale_rad_per_v: f64,
    pub(super) place: String,
    pub(super) azimuth_rad: f64,
    pub(super) elevation_rad: f64,
    pub(super) multisine: MultisineKeys,
    pub(super) delays: DelayKeys,
    pub(super) stroke: Option<StrokeKeys>,
    pub(super) harmonics: Option<HarmonicsKeys>,
    pub(super) gauge_u_ratio: Option<f64>,
    pub(super) reference_u_ratio: f64,
}

/// The excitation of the response.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MultisineKeys {
    pub(super) range_hz: [f64; 2],
    pub(super) lines: u32,
    pub(super) reaction_hz: [f64; 2],
    pub(super) period_s: f64,
    pub(super) periods: u32,
    pub(super) dropped: u32,
    pub(super) least_snr_db: f64,
}

/// What is known of the channels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DelayKeys {
    pub(super) analog_s: f64,
    pub(super) serial_s: f64,
    pub(super) bit_rate_hz: f64,
    pub(super) u_s: f64,
    pub(super) compared_to_hz: f64,
}

/// Positions up to the end of the stroke.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StrokeKeys {
    pub(super) reach_rad: f64,
    pub(super) positions: u32,
    pub(super) ramp_s: f64,
    pub(super) rest_s: f64,
}

/// Single sines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HarmonicsKeys {
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) duration_s: f64,
    pub(super) criterion: Limit,
}

impl ReadKeys for Keys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let mirror_axes = words(table, "mirror-axis", &MIRROR_AXES);
        let channels = words(table, "channel", &CHANNELS);
        let levels_v = table.quantities("level");
        if levels_v.iter().flatten().any(|&v| v <= 0.0) {
            table.mistake("level", "every `level` must be greater than zero", None);
        }
        let scale_rad_per_v = table.positive("scale");
        let place = table.text("place");
        let azimuth_rad = table.quantity("azimuth");
        let elevation_rad = table.quantity("elevation");
        let multisine = table.table("multisine", MultisineKeys::read);
        let delays = table.table("channels", DelayKeys::read);
        let stroke = table.table("stroke", StrokeKeys::read);
        let harmonics = table.table("harmonics", HarmonicsKeys::read);
        let axes = mirror_axes.as_ref().map_or(0, Vec::len);
        let ways = channels.as_ref().map_or(0, Vec::len);
        table.check_steps("level", &[axes, ways + 1, levels_v.as_ref().map_or(0, Vec::len), LEVEL_STEPS]);
        let gauge_u_ratio = table.has("gauge-u").then(|| table.positive("gauge-u")).flatten();
        let reference_u_ratio = table.positive("reference-u");
        let channel = |k: &usize| [MirrorChannel::Analog, MirrorChannel::Serial][*k];
        Some(Self {
            mirror_axes: mirror_axes?,
            channels: channels?.iter().map(channel).collect(),
            levels_v: levels_v?,
            scale_rad_per_v: scale_rad_per_v?,
            place: place?,
            azimuth_rad: azimuth_rad?,
            elevation_rad: elevation_rad?,
            multisine: multisine?,
            delays: delays?,
            stroke,
            harmonics,
            gauge_u_ratio,
            reference_u_ratio: reference_u_ratio?,
        })
    }
}

impl Keys {
    /// Delay of a channel that its maker states, and the time of an order on the line, s; that of a sign not counted.
    pub(super) fn known_delay_s(&self, channel: MirrorChannel) -> f64 {
        /// Characters of an order without a sign: `Z0.12345E`.
        const CHARACTERS: f64 = 9.0;
        match channel {
            MirrorChannel::Analog => self.delays.analog_s,
            MirrorChannel::Serial => self.delays.serial_s + CHARACTERS * self.character_s(),
        }
    }

    /// By how much a negative command acts later than a positive one: the sign is a character, s.
    pub(super) fn sign_s(&self, channel: MirrorChannel) -> f64 {
        match channel {
            MirrorChannel::Analog => 0.0,
            MirrorChannel::Serial => self.character_s(),
        }
    }

    /// A character on the serial line, s.
    fn character_s(&self) -> f64 {
        /// Start, eight data, stop.
        const BITS: f64 = 10.0;
        BITS / self.delays.bit_rate_hz
    }
}

/// What a level counts for: every one of its points carries all lines.
const LEVEL_STEPS: usize = 20;

/// Words of a list, as indices into those that are known; each once.
fn words(table: &mut TableReader<'_>, key: &'static str, known: &[&str]) -> Option<Vec<usize>> {
    let given = table.spanned_texts(key)?;
    let mut all = Vec::new();
    for (word, span) in &given {
        match known.iter().position(|k| k == word) {
            Some(index) if !all.contains(&index) => all.push(index),
            Some(_) => table.mistake_at(span.clone(), format!("`{word}` is given twice"), None),
            None => {
                let near = nearest(word, known.iter().copied());
                let help = near.map_or_else(
                    || format!("one of {}", quoted(known.iter().copied())),
                    |n| format!("did you mean `{n}`?"),
                );
                table.mistake_at(span.clone(), format!("unknown word `{word}` in `{key}`"), Some(help));
            }
        }
    }
    if given.is_empty() {
        table.mistake(key, format!("`{key}` is an empty list"), None);
    }
    (!all.is_empty() && all.len() == given.len()).then_some(all)
}

/// Most lines of a multisine, and its highest one in multiples of 1/period: its span is searched on a grid.
const MOST_LINES: f64 = 2000.0;
const MOST_ORDER: f64 = 1e6;

impl MultisineKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let range_hz = table.range("range");
        let reaction_hz = table.range("reaction");
        let lines = table.count("lines", 10);
        let periods = table.count("periods", 6);
        let dropped = table.count("dropped", 1);
        let period_s = table.positive("period");
        let least_snr_db = table.quantity("least-snr");
        if let (Some([_, high_hz]), Some([from_hz, to_hz]), Some(period_s), Some(lines)) =
            (range_hz, reaction_hz, period_s, lines)
            && !((to_hz - from_hz) * period_s + f64::from(lines) <= MOST_LINES
                && high_hz * period_s <= MOST_ORDER)
        {
            let message = format!(
                "more than {MOST_LINES} lines, or one beyond {MOST_ORDER} periods in `period`: `reaction` \
                 excites every multiple of 1/`period`"
            );
            let help = "choose a shorter `period`, a narrower `reaction` or fewer `lines`".to_owned();
            table.mistake("period", message, Some(help));
            return None;
        }
        if let (Some([low_hz, _]), Some(period_s)) = (range_hz, period_s)
            && low_hz * period_s < 1.0 - 1e-9
        {
            table.mistake("range", "the lowest line must fit into one period", None);
        }
        if let (Some(range), Some(reaction)) = (range_hz, reaction_hz)
            && (reaction[0] < range[0] || reaction[1] > range[1])
        {
            table.mistake("reaction", "`reaction` must lie inside `range`", None);
        }
        if let (Some(periods), Some(dropped)) = (periods, dropped)
            && periods < dropped + 5
        {
            table.mistake("periods", "at least five periods must remain after the dropped ones", None);
        }
        Some(Self {
            range_hz: range_hz?,
            lines: lines?,
            reaction_hz: reaction_hz?,
            period_s: period_s?,
            periods: periods?,
            dropped: dropped?,
            least_snr_db: least_snr_db?,
        })
    }
}

impl DelayKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let analog_s = table.quantity("known-analog");
        let serial_s = table.quantity("known-serial");
        let bit_rate_hz = table.positive("serial-bit-rate");
        let u_s = table.positive("delay-u");
        let compared_to_hz = table.positive("compared-to");
        Some(Self {
            analog_s: analog_s?,
            serial_s: serial_s?,
            bit_rate_hz: bit_rate_hz?,
            u_s: u_s?,
            compared_to_hz: compared_to_hz?,
        })
    }
}

impl StrokeKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let reach_rad = table.positive("reach");
        let positions = table.count("positions", 2);
        let ramp_s = table.positive("ramp");
        let rest_s = table.positive("rest");
        Some(Self { reach_rad: reach_rad?, positions: positions?, ramp_s: ramp_s?, rest_s: rest_s? })
    }
}

impl HarmonicsKeys {
    fn read(table: &mut TableReader<'_>) -> Option<Self> {
        let frequencies_hz = table.quantities("frequency");
        let duration_s = table.positive("duration");
        let criterion = table.limit("criterion");
        if frequencies_hz.iter().flatten().any(|&f| f <= 0.0) {
            table.mistake("frequency", "every `frequency` must be greater than zero", None);
        }
        Some(Self { frequencies_hz: frequencies_hz?, duration_s: duration_s?, criterion: criterion? })
    }
}
