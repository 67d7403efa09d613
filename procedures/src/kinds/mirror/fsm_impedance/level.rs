//! Level of a sweep, from voltage and current that the analyser read at the terminals of the mirror.

use std::f64::consts::SQRT_2;

use analysis::frf::Line;

use crate::quantity::QuantityKind as Q;

/// Channels of the analyser, V and A RMS.
pub(super) const CHANNELS: [&str; 2] = ["level_v", "current_a"];
/// What a sweep without them cannot say.
pub(super) const UNKNOWN: &str = "level not known: voltage and current are not in the log";
/// Resistance of the analyser's source (E4990A), whose level is that of open terminals: the mirror takes the rest.
const SOURCE_OHM: f64 = 25.0;
/// Peak to peak of a sine over its RMS.
const PEAK_TO_PEAK: f64 = 2.0 * SQRT_2;
/// Voltage over current may depart from |Z| by this much: fixture compensation is in Z only.
const CONSISTENT_RATIO: f64 = 0.05;

/// Level of a sweep, V peak to peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// Least and largest of the source over the points: what stands at open terminals.
    source_v: [f64; 2],
    /// Least and largest voltage at the terminals over the points.
    terminals_v: [f64; 2],
    /// Largest departure of voltage over current from |Z|.
    inconsistent_ratio: f64,
}

impl Level {
    /// Of the impedances with the voltages and currents of the same points, RMS; `None` where these are no numbers.
    pub(super) fn new(lines: &[Line], voltage_v: &[f64], current_a: &[f64]) -> Option<Self> {
        let points = || lines.iter().zip(voltage_v).zip(current_a).map(|((l, v), i)| (l.value, *v, *i));
        let sound = |(_, v, i): (_, f64, f64)| v.is_finite() && i.is_finite() && v > 0.0 && i > 0.0;
        if points().count() != lines.len() || lines.is_empty() || !points().all(sound) {
            return None;
        }
        Some(Self {
            // The source drives Z and its own resistance with the same current.
            source_v: extremes(points().map(|(z, _, i)| PEAK_TO_PEAK * i * (z + SOURCE_OHM).norm())),
            terminals_v: extremes(points().map(|(_, v, _)| PEAK_TO_PEAK * v)),
            inconsistent_ratio: points().map(|(z, v, i)| (v / i / z.norm() - 1.0).abs()).fold(0.0, f64::max),
        })
    }

    /// Level of the source at the point where it is farthest from what was asked for.
    pub(super) fn source_v(&self, requested_v: f64) -> f64 {
        let [low, high] = self.source_v;
        if (low - requested_v).abs() > (high - requested_v).abs() { low } else { high }
    }

    /// What a reader must know of it.
    pub(super) fn flags(&self) -> Vec<String> {
        let [low, high] = self.terminals_v.map(|v| Q::Voltage.format(v));
        let mut all = vec![format!(
            "level of the source; behind its {SOURCE_OHM} ohm the terminals have {low} .. {high}"
        )];
        if self.inconsistent_ratio > CONSISTENT_RATIO {
            all.push(format!(
                "voltage over current departs from the impedance by up to {:.0} %",
                100.0 * self.inconsistent_ratio
            ));
        }
        all
    }
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}
