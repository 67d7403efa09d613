//! Kind `fsm-response`: what the steering mirror makes of its commands, by channel, axis and level.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::axis::Axes;
use crate::case::{Case, MirrorChannel, Mode, Request, Segment};
use crate::device::MIRROR_AXES;
use crate::diagnostic::Diagnostic;
use crate::excitation::{Excitation, Injection, Signal, Sine};
use crate::kinds::mirror;
use crate::kinds::position::positioned;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod channels;
mod conclude;
mod keys;
mod periods;
mod point;
mod response;
pub(in crate::kinds) mod spectra;
#[cfg(test)]
mod tests;

use keys::{HarmonicsKeys, Keys, MultisineKeys, StrokeKeys};

const DOC: &str = "\
# What it finds
Closed-loop response of the steering mirror from command to tilt, for each axis of the mirror, level and command channel:
`mirror-bandwidth` (-3 dB of the command), `mirror-attenuation-100-hz`, how far analog and serial channel differ
(`channel-level-difference`, `channel-phase-difference`), `mirror-stroke` to the shorter side, the scale of the strain
gauge against the autocollimator (`gauge-scale-departure`), `harmonic-distortion` of single sines, a resonance of the
mirror's support (`reaction-resonance`), and the margins of its servo (`mirror-crossover`, `mirror-gain-margin`,
`mirror-phase-margin`, `mirror-modulus-margin`).

# How it excites
The gimbal holds its pose. A multisine is added to the tilt command: log-spaced lines, and every multiple of 1/period
where a support may resonate, Schroeder phases, scaled to the level peak to peak (1 V = 500 urad by default). Stroke:
positions in equal steps up to the reach on both sides, each ramped to from the middle and held. Harmonics: single
sines of the level. Stroke and harmonics use the first channel.

# How it computes
The input is what the driver really sent (`command_*_rad`), so the timing of the serial line is part of the input and not
of the response. A negative command is one character longer than a positive one and takes effect that much later, which is
part of the input as well. Complex amplitudes over whole periods; the ratio of the means with its variance from the
scatter of the periods. The hold from row to row and the known delay of the channel are removed; a serial command adds its
time on the line, 9 characters of 10 bits. Above about 1 kHz images of the hold fold back by some per cent. Bandwidth and
attenuation, by the autocollimator where there is one and else by the strain gauge (the flags say which): a parabola of dB
over ln f through the nearest 11 lines that count; u from the residuals of that fit (which include distortion that repeats
in every period), the scatter of the lines and the scale of the sensor. Channels: largest difference of the gauge up to
100 Hz by a smooth curve through all lines (ln of the ratio of gains by a constant, f² and f⁴, phase by f and f³), its
square is reduced by the contribution of noise; a line 6 standard deviations off the curve counts by itself. 80 % of the
lines must count in both channels, one of them in the highest third of an octave. Support: a resonance on top of a smooth
response that explains far more than chance would. It is sought in the autocollimator signal (which shows the mirror
itself), or without one in the gauge signal (which shows motion against the support); lines next to it do not count.
Stroke: mean of the last half of each rest; the farthest position reached, the shorter side. Lines do not count where
their mean is less than 20 dB above its scatter or above 0.4 of the row rate. Open loop: L = T/(1 - T) of the response T
by the gauge, line by line (the gauge is the sensor of the servo: its scale and its filter are in the loop and in T
alike); margins from local fits as in `frequency-response`; u includes the uncertainty of the known delay of the channel,
which is not part of the loop.

# Fails when
Rows are missing in half of the periods of a multisine (others are left out) or in a single sine; a period is no whole number of rows; the command was cut off (saturation); no line counts around the
requested frequency. Stroke without autocollimator is inconclusive unless `gauge-u` is stated: the servo follows its
gauge, so a wrong scale does not show.

# Source
director.md §2 (FSM-BW, FSM-STR, FSM-CH), §4.4, E7, §8; Pintelon & Schoukens, System Identification, 2nd ed., §2.4.
";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        response::BANDWIDTH,
        Q::Frequency,
        "First frequency at which the tilt falls 3 dB below the command.",
    ),
    Measurand::new(
        response::ATTENUATION,
        Q::Decibel,
        "Command over tilt at 100 Hz, in decibels; negative where the mirror moves more than commanded.",
    ),
    Measurand::new(
        channels::LEVEL_DIFFERENCE,
        Q::Decibel,
        "Largest gain difference between analog and serial channel for the same axis and level.",
    ),
    Measurand::new(
        channels::PHASE_DIFFERENCE,
        Q::Angle,
        "Largest phase difference between analog and serial channel, corrected for the known delays.",
    ),
    Measurand::new(conclude::STROKE, Q::Angle, "Largest tilt reached on the side that reaches less."),
    Measurand::new(
        conclude::GAUGE_SCALE,
        Q::Ratio,
        "Scale of the strain gauge over that of the autocollimator, less 1.",
    ),
    Measurand::new(
        response::DISTORTION,
        Q::Ratio,
        "Root of the summed squares of harmonics 2 to 5 of a sine over its fundamental.",
    ),
    Measurand::new(
        response::RESONANCE,
        Q::Frequency,
        "Resonance of the mirror's support, as seen in the response.",
    ),
    Measurand::new(
        response::CROSSOVER,
        Q::Frequency,
        "Lowest 0 dB crossing of the open loop of the mirror's servo.",
    ),
    Measurand::new(
        response::GAIN_MARGIN,
        Q::Decibel,
        "Smallest gain margin of all -180 deg crossings of the open loop of the mirror's servo.",
    ),
    Measurand::new(
        response::PHASE_MARGIN,
        Q::Angle,
        "Smallest phase margin of all 0 dB crossings of the open loop of the mirror's servo.",
    ),
    Measurand::new(
        response::MODULUS_MARGIN,
        Q::Ratio,
        "Smallest distance of the open loop of the mirror's servo from -1.",
    ),
];

pub(in crate::kinds) const KIND: Kind = Kind::new::<Keys>("fsm-response", DOC, keys::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let mut names = vec![response::BANDWIDTH, response::ATTENUATION, response::RESONANCE];
        names.extend(response::MARGINS.map(|(name, _)| name));
        if self.channels.len() > 1 {
            names.extend([channels::LEVEL_DIFFERENCE, channels::PHASE_DIFFERENCE]);
        }
        if self.stroke.is_some() {
            names.extend([conclude::STROKE, conclude::GAUGE_SCALE]);
        }
        if self.harmonics.is_some() {
            names.push(response::DISTORTION);
        }
        Some(names)
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, _axes: &Axes) -> PointResult {
        point::analyse(self, case, window)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        mirror::on_gimbal(conclude::conclude(self, cases, points), axes)
    }
}

/// Label of the rest before the excitation.
const SETTLE: &str = "settle";
/// Label of the multisine.
const MEASURE: &str = "measure";
/// Label of a position of the stroke.
const POSITION: &str = "position";
/// Label of a single sine.
const TONE: &str = "tone";

/// Rest before the excitation: the gimbal comes to rest.
const SETTLE_S: f64 = 0.25;
/// Time over which an excitation grows, where a period is longer.
const FADE_S: f64 = 0.1;

/// All points, or why the rig does not allow them.
fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    positioned::check_axes("fsm-response", axis, axes)?;
    let lines = lines(&keys.multisine);
    let mut cases = Vec::new();
    for &mirror_axis in &keys.mirror_axes {
        let planner = Planner { keys, axis, axes, mirror_axis };
        for &level_v in &keys.levels_v {
            cases.extend(keys.channels.iter().map(|&channel| planner.response(&lines, level_v, channel)));
        }
        if let Some(stroke) = &keys.stroke {
            cases.push(planner.stroke(stroke));
        }
        if let Some(harmonics) = &keys.harmonics {
            cases.extend(keys.levels_v.iter().map(|&level_v| planner.tones(harmonics, level_v)));
        }
    }
    Ok(cases)
}

/// Axis of the mirror that a case excites: its index, azimuth first.
fn mirror_axis(case: &Case) -> Option<usize> {
    case.excitations.iter().find_map(|e| match e.into {
        Injection::MirrorAz => Some(0),
        Injection::MirrorEl => Some(1),
        Injection::Torque | Injection::Velocity => None,
    })
}

/// Name of the mirror axis that a case excites, for measurements; empty where it excites none.
fn mirror_axis_name(case: &Case) -> &'static str {
    mirror_axis(case).map_or("", |axis| MIRROR_AXES[axis])
}

/// Whether a case has a segment of this label.
fn has_segment(case: &Case, label: &str) -> bool {
    case.segments.iter().any(|s| s.label == label)
}

/// Word of a channel, in names of points.
fn word(channel: MirrorChannel) -> &'static str {
    match channel {
        MirrorChannel::Analog => "analog",
        MirrorChannel::Serial => "serial",
    }
}

/// Lines of equal amplitude whose sum is 1 peak to peak.
///
/// Log-spaced over the range, and every multiple of 1/period where a resonance of the support is looked for. Phases
/// after Schroeder (*IEEE Trans. Inf. Theory* 16, 85, 1970): each line has its turn in a share of the period like its
/// share of the power, −dφ/dω = T·(power of the lines below), which keeps the peaks low.
fn lines(keys: &MultisineKeys) -> Vec<Sine> {
    let orders = orders(keys);
    let count = orders.len() as f64;
    let mut phase_rad = 0.0;
    let mut before = 0.0;
    let mut lines: Vec<Sine> = Vec::with_capacity(orders.len());
    for (k, &order) in orders.iter().enumerate() {
        phase_rad -= TAU * (f64::from(order) - before) * (k as f64 / count);
        before = f64::from(order);
        lines.push(Sine { frequency_hz: before / keys.period_s, amplitude: 1.0, phase_rad: phase_rad % TAU });
    }
    let span = span(&lines, keys.period_s);
    lines.iter_mut().for_each(|line| line.amplitude /= span);
    lines
}

fn orders(keys: &MultisineKeys) -> Vec<u32> {
    let order = |hz: f64| (hz * keys.period_s).round().max(1.0) as u32;
    let [low, high] = keys.range_hz;
    let steps = f64::from(keys.lines.max(2) - 1);
    let spaced = (0..keys.lines).map(|k| order(low * (high / low).powf(f64::from(k) / steps)));
    let every = order(keys.reaction_hz[0])..=order(keys.reaction_hz[1]);
    let mut orders: Vec<u32> = spaced.chain(every).collect();
    orders.sort_unstable();
    orders.dedup();
    orders
}

/// Largest less smallest value of a sum, on eight samples per period of its highest line: 0.5 % too small at most for
/// all but that line.
fn span(lines: &[Sine], period_s: f64) -> f64 {
    const PER_PERIOD: f64 = 8.0;
    let highest_hz = lines.last().map_or(1.0, |l| l.frequency_hz);
    let samples = (PER_PERIOD * highest_hz * period_s).ceil().min(1e5) as u32;
    let sum = |k: u32| -> f64 {
        let t_s = period_s * f64::from(k) / f64::from(samples);
        lines.iter().map(|l| (TAU * l.frequency_hz * t_s + l.phase_rad).cos()).sum()
    };
    let mut low = 0.0_f64;
    let mut high = 0.0_f64;
    for value in (0..samples).map(sum) {
        low = low.min(value);
        high = high.max(value);
    }
    high - low
}

/// An excitation and the segment that plays it.
struct Played {
    excitation: Excitation,
    label: &'static str,
    duration_s: f64,
}

struct Planner<'a> {
    keys: &'a Keys,
    axis: &'a str,
    axes: &'a Axes,
    mirror_axis: usize,
}

impl Planner<'_> {
    fn response(&self, unit: &[Sine], level_v: f64, channel: MirrorChannel) -> Case {
        let multisine = &self.keys.multisine;
        let level_rad = level_v * self.keys.scale_rad_per_v;
        let lines = unit.iter().map(|l| Sine { amplitude: l.amplitude * level_rad, ..*l }).collect();
        let signal = Signal::Multisine { period_s: multisine.period_s, lines };
        let duration_s = f64::from(multisine.periods) * multisine.period_s;
        let fade_s = FADE_S.min(0.5 * multisine.period_s);
        let played = Played { excitation: self.excitation(signal, fade_s), label: MEASURE, duration_s };
        self.case(format!("{} {}", self.level(level_v), word(channel)), Some(level_v), channel, &[played])
    }

    fn stroke(&self, stroke: &StrokeKeys) -> Case {
        let duration_s = stroke.ramp_s + stroke.rest_s;
        let position = |side: f64, k: u32| {
            let amplitude = side * stroke.reach_rad * f64::from(k) / f64::from(stroke.positions);
            let line = Sine { frequency_hz: 0.0, amplitude, phase_rad: 0.0 };
            let signal = Signal::Multisine { period_s: FADE_S, lines: vec![line] };
            Played { excitation: self.excitation(signal, stroke.ramp_s), label: POSITION, duration_s }
        };
        let mut played = Vec::new();
        for side in [1.0, -1.0] {
            played.extend((1..=stroke.positions).map(|k| position(side, k)));
        }
        let point = format!("{} stroke", MIRROR_AXES[self.mirror_axis]);
        self.case(point, None, self.keys.channels[0], &played)
    }

    fn tones(&self, harmonics: &HarmonicsKeys, level_v: f64) -> Case {
        let amplitude = 0.5 * level_v * self.keys.scale_rad_per_v;
        let tone = |&frequency_hz: &f64| {
            let lines = vec![Sine { frequency_hz, amplitude, phase_rad: -FRAC_PI_2 }];
            let signal = Signal::Multisine { period_s: 1.0 / frequency_hz, lines };
            let excitation = self.excitation(signal, FADE_S);
            Played { excitation, label: TONE, duration_s: harmonics.duration_s }
        };
        let played: Vec<_> = harmonics.frequencies_hz.iter().map(tone).collect();
        let point = format!("{} harmonics", self.level(level_v));
        self.case(point, Some(level_v), self.keys.channels[0], &played)
    }

    fn level(&self, level_v: f64) -> String {
        format!("{} {}", MIRROR_AXES[self.mirror_axis], Q::Voltage.format(level_v))
    }

    fn excitation(&self, signal: Signal, fade_s: f64) -> Excitation {
        let into = [Injection::MirrorAz, Injection::MirrorEl][self.mirror_axis];
        Excitation { into, signal, fade_s, every_ticks: 1 }
    }

    fn case(&self, point: String, level_v: Option<f64>, channel: MirrorChannel, played: &[Played]) -> Case {
        let request = |value| Request { name: "level".to_owned(), value, kind: Q::Voltage };
        let excited = played.iter().enumerate().map(|(index, played)| Segment {
            excited: Some(index),
            ..Segment::hold(played.label, Mode::Position, played.duration_s)
        });
        Case {
            point,
            axis: self.axis.to_owned(),
            requested: level_v.map(request).into_iter().collect(),
            start_pose_rad: positioned::poses(self.axes, [self.keys.azimuth_rad, self.keys.elevation_rad]),
            segments: [Segment::hold(SETTLE, Mode::Position, SETTLE_S)].into_iter().chain(excited).collect(),
            excitations: played.iter().map(|played| played.excitation.clone()).collect(),
            mirror_channel: Some(channel),
            logs_payload_fully: true,
            ..Case::default()
        }
    }
}
