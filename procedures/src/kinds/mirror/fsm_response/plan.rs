//! The points of a mirror response procedure: the gimbal holds, the mirror is excited.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::keys::{HarmonicsKeys, Keys, MultisineKeys, StrokeKeys};
use crate::axis::Axes;
use crate::case::{Case, MirrorChannel, Mode, Request, Segment};
use crate::diagnostic::Diagnostic;
use crate::excitation::{Excitation, Injection, Signal, Sine};
use crate::kinds::optics::frames::{self, MIRROR_AXES};
use crate::quantity::QuantityKind as Q;

/// Label of the rest before the excitation.
pub(super) const SETTLE: &str = "settle";
/// Label of the multisine.
pub(super) const MEASURE: &str = "measure";
/// Label of a position of the stroke.
pub(super) const POSITION: &str = "position";
/// Label of a single sine.
pub(super) const TONE: &str = "tone";

/// Rest before the excitation: the gimbal comes to rest.
const SETTLE_S: f64 = 0.25;
/// Time over which an excitation grows, where a period is longer.
const FADE_S: f64 = 0.1;

/// All points, or why the rig does not allow them.
pub(super) fn plan(keys: &Keys, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
    frames::check_axes("fsm-response", axis, axes)?;
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
pub(super) fn mirror_axis(case: &Case) -> Option<usize> {
    case.excitations.iter().find_map(|e| match e.into {
        Injection::MirrorAz => Some(0),
        Injection::MirrorEl => Some(1),
        Injection::Torque | Injection::Velocity => None,
    })
}

/// Name of the mirror axis that a case excites, for measurements; empty where it excites none.
pub(super) fn mirror_axis_name(case: &Case) -> &'static str {
    mirror_axis(case).map_or("", |axis| MIRROR_AXES[axis])
}

/// Whether a case has a segment of this label.
pub(super) fn has_segment(case: &Case, label: &str) -> bool {
    case.segments.iter().any(|s| s.label == label)
}

/// Word of a channel, in names of points.
pub(super) fn word(channel: MirrorChannel) -> &'static str {
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
pub(super) fn lines(keys: &MultisineKeys) -> Vec<Sine> {
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
            start_pose_rad: frames::poses(self.axes, [self.keys.azimuth_rad, self.keys.elevation_rad]),
            segments: [Segment::hold(SETTLE, Mode::Position, SETTLE_S)].into_iter().chain(excited).collect(),
            excitations: played.iter().map(|played| played.excitation.clone()).collect(),
            mirror_channel: Some(channel),
            logs_payload_fully: true,
            ..Case::default()
        }
    }
}
