//! Torque over time: its peak, and its root mean square as motor and drive feel it (I²t).

use procedures::stimulus::Stimulus;

use super::course::{Instant, Stretch};
use crate::model::axis::RigAxis;

/// Parts of a torque ramp.
const RAMP_PARTS: u32 = 32;

/// What motor and drive have to bear, point after point without a pause.
#[derive(Debug)]
pub(super) struct Load<'a> {
    axis: &'a RigAxis,
    /// Duration, torque squared, point.
    pieces: Vec<(f64, f64, usize)>,
    points: usize,
    peak_nm: f64,
}

impl<'a> Load<'a> {
    pub(super) fn new(axis: &'a RigAxis) -> Self {
        Self { axis, pieces: Vec::new(), points: 0, peak_nm: 0.0 }
    }

    pub(super) fn next_point(&mut self) {
        self.points += 1;
        self.peak_nm = 0.0;
    }

    /// Largest torque of the point so far.
    pub(super) fn peak_of_point(&self) -> f64 {
        self.peak_nm
    }

    pub(super) fn take(&mut self, stretch: &Stretch<'_>) {
        match stretch {
            Stretch::Stroke { instants, repeats } => {
                let from = self.pieces.len();
                for instant in instants {
                    self.peak_nm = self.peak_nm.max(self.torque_nm(instant).abs());
                    self.push(instant.for_s, self.heating_nm(instant));
                }
                let to = self.pieces.len();
                for _ in 1..*repeats {
                    self.pieces.extend_from_within(from..to);
                }
            }
            Stretch::Torque { segment, .. } => self.commanded(&segment.stimulus, segment.at_most_s),
        }
    }

    fn push(&mut self, for_s: f64, torque_nm: f64) {
        self.peak_nm = self.peak_nm.max(torque_nm.abs());
        self.pieces.push((for_s, torque_nm * torque_nm, self.points - 1));
    }

    /// Root mean square of what the motor has to give about an instant.
    fn heating_nm(&self, at: &Instant) -> f64 {
        let [peak, rms] = at.swing_rad_per_s2;
        let acceleration_rad_per_s2 = at.acceleration_rad_per_s2 - peak;
        let steady_nm = self.torque_nm(&Instant { acceleration_rad_per_s2, ..*at });
        steady_nm.hypot(self.axis.guard.stop.inertia_kg_m2 * rms)
    }

    /// What the motor has to give: inertia, friction and what the loads pull. Friction is as expected where that is
    /// worse, and the least where the motor brakes and friction helps. At rest the motor is counted with all of the load.
    fn torque_nm(&self, at: &Instant) -> f64 {
        let stop = &self.axis.guard.stop;
        let limits = &self.axis.limits;
        let rate = at.rate_rad_per_s;
        let others_nm = stop.inertia_kg_m2 * at.acceleration_rad_per_s2 - stop.loads.at(at.position_rad);
        let ahead = if rate != 0.0 { rate.signum() } else { at.acceleration_rad_per_s2.signum() };
        if rate == 0.0 && at.acceleration_rad_per_s2 == 0.0 {
            return others_nm;
        }
        let with = |friction_nm: f64| {
            (others_nm + ahead * friction_nm + stop.friction.viscous_nm_s_per_rad * rate).abs()
        };
        with(limits.expected_static_friction_nm).max(with(stop.friction.coulomb_nm))
    }

    fn commanded(&mut self, stimulus: &Stimulus, at_most_s: f64) {
        match stimulus {
            Stimulus::TorqueRamp { from_nm, rate_nm_per_s } => {
                let part_s = at_most_s / f64::from(RAMP_PARTS);
                for k in 0..RAMP_PARTS {
                    // The end of a part that grows is its worst.
                    let torque_nm = |k: u32| (from_nm + rate_nm_per_s * f64::from(k) * part_s).abs();
                    self.push(part_s, torque_nm(k).max(torque_nm(k + 1)));
                }
            }
            Stimulus::TorqueMultisine { offset_nm, lines, .. } => {
                let peak = offset_nm.abs() + lines.iter().map(|l| l.amplitude_nm.abs()).sum::<f64>();
                let half: f64 = lines.iter().map(|l| l.amplitude_nm * l.amplitude_nm / 2.0).sum();
                self.push(at_most_s, (offset_nm * offset_nm + half).sqrt());
                self.peak_nm = self.peak_nm.max(peak);
            }
            Stimulus::Hold { torque_nm } => self.push(at_most_s, *torque_nm),
            Stimulus::Move { .. }
            | Stimulus::Reversals { .. }
            | Stimulus::Cruise { .. }
            | Stimulus::Step { .. }
            | Stimulus::Sine { .. }
            | Stimulus::Trajectory { .. } => {}
        }
    }

    /// The largest root mean square, and the point that reaches it: the mean of first order with the thermal time as its
    /// time constant, which is what the interlock on I²t computes from the torque that it sees.
    pub(super) fn worst_rms(&self) -> (f64, usize) {
        let mut mean = 0.0;
        let mut worst = (0.0, 0);
        let mut kept = (f64::NAN, 0.0);
        for &(for_s, squared, point) in &self.pieces {
            // Most pieces last equally long.
            if kept.0 != for_s {
                kept = (for_s, -(-for_s / self.axis.guard.safety.thermal_time_s).exp_m1());
            }
            mean += (squared - mean) * kept.1;
            if mean > worst.0 {
                worst = (mean, point);
            }
        }
        (worst.0.sqrt(), worst.1)
    }
}
