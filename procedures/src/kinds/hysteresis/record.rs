//! What a point's window says of the axis: angle and effort, in torque or in current.

use std::f64::consts::PI;
use std::ops::Range;

use crate::axis::AxisLimits;
use crate::log::{Rows, Window};
use crate::measurement::Evidence;
use crate::quantity::QuantityKind as Q;

/// The axis' rows and where effort comes from.
pub(super) struct Record<'a> {
    rows: &'a Rows,
    pub(super) angle_rad: &'a [f64],
    source: &'a [f64],
    scale: f64,
    channels: [&'static str; 2],
    /// Torque, or current where no torque constant is known.
    pub(super) kind: Q,
    /// Relative standard uncertainty that the torque constant gives every effort.
    pub(super) scale_u_ratio: f64,
    /// Torque that one count of the drive is worth; 0 for currents.
    quantum_nm: f64,
}

impl<'a> Record<'a> {
    /// Effort is Kt·i where current and torque constant are there, else the torque channel, else plain current.
    pub(super) fn new(axis: &str, window: &'a Window, limits: &AxisLimits) -> Result<Self, String> {
        let topic = format!("/{axis}");
        let rows = window.rows(&topic).ok_or_else(|| format!("the log has no topic {topic}"))?;
        let column = |name: &str| rows.column(name);
        let angle_rad =
            column("position_rad").ok_or_else(|| format!("{topic} has no channel position_rad"))?;
        let (source, name, scale, kind) =
            match (column("current_a"), column("torque_nm"), limits.torque_constant_nm_per_a) {
                (Some(current), _, Some(constant)) => (current, "current_a", constant, Q::Torque),
                (_, Some(torque), _) => (torque, "torque_nm", 1.0, Q::Torque),
                (Some(current), None, None) => (current, "current_a", 1.0, Q::Current),
                (None, None, _) => return Err(format!("{topic} has neither current_a nor torque_nm")),
            };
        if angle_rad.iter().chain(source).any(|v| !v.is_finite()) {
            return Err(format!("{topic} has values that are no numbers in position_rad or {name}"));
        }
        let torque = kind == Q::Torque;
        Ok(Self {
            rows,
            angle_rad,
            source,
            scale,
            channels: ["position_rad", name],
            kind,
            scale_u_ratio: if torque { limits.torque_constant_u_ratio } else { 0.0 },
            quantum_nm: if torque { limits.torque_quantum_nm } else { 0.0 },
        })
    }

    /// Rows in a stretch of time.
    pub(super) fn range(&self, start_s: f64, end_s: f64) -> Range<usize> {
        self.rows.range(start_s, end_s)
    }

    /// Mean rate of the rows in a range; `None` if time does not advance or rows are missing (a gap above 1.5
    /// periods: α would be wrong around it).
    pub(super) fn sample_rate_hz(&self, range: &Range<usize>) -> Option<f64> {
        let time = self.rows.time_s.get(range.clone())?;
        let (first, last) = (time.first()?, time.last()?);
        let period = (last - first) / (time.len().max(2) - 1) as f64;
        let even = time.windows(2).all(|pair| pair[1] - pair[0] < 1.5 * period && pair[1] > pair[0]);
        (period > 0.0 && even).then(|| 1.0 / period)
    }

    /// Motor torque (or current) in a range, inertia not taken off yet.
    pub(super) fn motor(&self, range: Range<usize>) -> Vec<f64> {
        self.source[range].iter().map(|v| v * self.scale).collect()
    }

    /// Standard uncertainty that the drive's quantum q leaves in a mean over a range: q/√12, less what the noise σ
    /// dithers away, exp(−2π²·σ²/q²) (Widrow & Kollár, *Quantization Noise*, 2008, chapter 6). What is dithered
    /// scatters from sample to sample and is in the type A part already. σ comes from neighbouring samples.
    pub(super) fn quantum_u(&self, range: Range<usize>) -> f64 {
        let motor = self.motor(range);
        let pairs = motor.len().saturating_sub(1).max(1) as f64;
        let variance = motor.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / pairs / 2.0;
        let q = self.quantum_nm;
        if q > 0.0 { q / 12_f64.sqrt() * (-2.0 * (PI / q).powi(2) * variance).exp() } else { 0.0 }
    }

    /// Where the numbers of a range come from.
    pub(super) fn evidence(&self, range: &Range<usize>) -> Vec<Evidence> {
        let time = &self.rows.time_s;
        let (Some(t0), Some(t1)) = (time.get(range.start), time.get(range.end.saturating_sub(1))) else {
            return Vec::new();
        };
        let topic = &self.rows.topic.name;
        let channels = self.channels.iter().map(|name| format!("{topic} {name}")).collect();
        vec![Evidence { file: String::new(), channels, t0_s: *t0, t1_s: *t1 }]
    }
}
