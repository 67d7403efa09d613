//! Kind `fsm-response`: what the steering mirror makes of its commands, by channel, axis and level.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::optics::frames;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod conclude;
mod keys;
mod plan;
mod plots;
mod point;
mod response;
pub(in crate::kinds) mod spectra;
#[cfg(test)]
mod tests;

use keys::Keys;

const DOC: &str = "\
# What it finds
Closed-loop response of the steering mirror from command to tilt, for each axis of the mirror, level and command channel:
`mirror-bandwidth` (-3 dB of the command), `mirror-attenuation-100-hz`, how far analog and serial channel differ
(`channel-level-difference`, `channel-phase-difference`), `mirror-stroke` to the shorter side, the scale of the strain
gauge against the autocollimator (`gauge-scale-departure`), `harmonic-distortion` of single sines, a resonance of what the
mirror stands on (`reaction-resonance`), and the margins of its servo (`mirror-crossover`, `mirror-gain-margin`,
`mirror-phase-margin`, `mirror-modulus-margin`).

# How it excites
The gimbal holds its pose. A multisine is added to the tilt command: log-spaced lines, and every multiple of 1/period
where a support may resonate, Schroeder phases, scaled to the level peak to peak (1 V = 500 urad by default). Stroke:
positions in equal steps up to the reach on both sides, each ramped to from the middle and held. Harmonics: single
sines of the level. Stroke and harmonics use the first channel.

# How it computes
Input is what the driver really sent (`command_*_rad`), so that the turns of the serial line are in the input and not in
the response. Complex amplitudes over whole periods; the ratio of the means with its variance from the scatter of the
periods. The hold from row to row and the known delay of the channel are taken off; a serial order adds its time on the
line, 9.5 characters of 10 bits. Above about 1 kHz images of the hold fold back by some per cent. Bandwidth and
attenuation, by the autocollimator where there is one and else by the strain gauge (the flags say which): a parabola of dB
over ln f through the nearest 11 lines that count; u from what they leave (so the distortion that repeats in every period
is in it), their own scatter and the scale of the sensor. Channels: largest difference of the gauge over the lines up to
100 Hz, of which 80 % must count in both channels, one of them in the highest third of an octave. Support: a resonance on
top of a smooth response, if it explains far more than chance would, looked for in the autocollimator (which sees the
mirror itself) and else in the gauge (which sees its motion against the support); lines next to it do not count. Stroke:
mean of the last half of each rest; the farthest position reached, the shorter side. Lines do not count where their mean
is less than 20 dB above its scatter or above 0.4 of the row rate. Open loop: L = T/(1 - T) of the response T by the
gauge, line by line (the gauge is the sensor of the servo: its scale and its filter are in the loop and in T alike);
margins from local fits as in `frequency-response`; u holds what the known delay of the channel may be off by, which is no
part of the loop.

# Fails when
Rows are missing; a period is no whole number of rows; the command was cut off (saturation); no line counts around the
number that is asked for. Stroke without autocollimator is inconclusive unless `gauge-u` is stated: the servo follows its
gauge, so that a wrong scale does not show.

# Source
director.md §2 (FSM-BW, FSM-STR, FSM-CH), §4.4, E7, §8; Pintelon & Schoukens, System Identification, 2nd ed., §2.4.
";

const MEASURANDS: &[Measurand] = &[
    Measurand {
        name: response::BANDWIDTH,
        kind: Q::Frequency,
        doc: "First frequency at which the tilt falls 3 dB below the command.",
    },
    Measurand {
        name: response::ATTENUATION,
        kind: Q::Decibel,
        doc: "Command over tilt at 100 Hz; negative where the mirror moves more than commanded.",
    },
    Measurand {
        name: conclude::LEVEL_DIFFERENCE,
        kind: Q::Decibel,
        doc: "Largest difference in gain of analog and serial channel at equal axis and level.",
    },
    Measurand {
        name: conclude::PHASE_DIFFERENCE,
        kind: Q::Angle,
        doc: "Largest difference in phase of analog and serial channel, known delays taken off.",
    },
    Measurand {
        name: conclude::STROKE,
        kind: Q::Angle,
        doc: "Farthest tilt that is reached to either side, the smaller one.",
    },
    Measurand {
        name: conclude::GAUGE_SCALE,
        kind: Q::Ratio,
        doc: "Scale of the strain gauge over that of the autocollimator, less 1.",
    },
    Measurand {
        name: response::DISTORTION,
        kind: Q::Ratio,
        doc: "Root of the summed squares of harmonics 2 to 5 of a sine over its fundamental.",
    },
    Measurand {
        name: response::RESONANCE,
        kind: Q::Frequency,
        doc: "Resonance of what the mirror stands on, seen on the response.",
    },
    Measurand {
        name: response::CROSSOVER,
        kind: Q::Frequency,
        doc: "Lowest 0 dB crossing of the open loop of the mirror's servo.",
    },
    Measurand {
        name: response::GAIN_MARGIN,
        kind: Q::Decibel,
        doc: "Smallest gain margin of all -180 deg crossings of that loop.",
    },
    Measurand {
        name: response::PHASE_MARGIN,
        kind: Q::Angle,
        doc: "Smallest phase margin of all 0 dB crossings of that loop.",
    },
    Measurand { name: response::MODULUS_MARGIN, kind: Q::Ratio, doc: "Least distance of that loop from -1." },
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "fsm-response",
    doc: DOC,
    fields: keys::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        let mut names = vec![response::BANDWIDTH, response::ATTENUATION, response::RESONANCE];
        names.extend(response::MARGINS.map(|(name, _)| name));
        if self.channels.len() > 1 {
            names.extend([conclude::LEVEL_DIFFERENCE, conclude::PHASE_DIFFERENCE]);
        }
        if self.stroke.is_some() {
            names.extend([conclude::STROKE, conclude::GAUGE_SCALE]);
        }
        if self.harmonics.is_some() {
            names.push(response::DISTORTION);
        }
        names
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, _axes: &Axes) -> PointResult {
        point::analyse(self, case, window)
    }

    fn conclude(&self, cases: &[Case], points: &[PointResult], axes: &Axes) -> Conclusion {
        let mut conclusion = conclude::conclude(self, cases, points);
        frames::belong_to_gimbal(&mut conclusion.measurements, axes);
        conclusion
    }
}
