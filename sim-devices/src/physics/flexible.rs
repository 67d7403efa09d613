//! Flexible modes of the structure, discretised exactly.
//!
//! `q̈ + 2ζω·q̇ + ω²·q = T` per mode, driven by the torque T at the shaft that is constant over a step; angle and rate
//! of the shaft gain `c_e·q`, `c_e·q̇`, those of the frame `c_g·q`, `c_g·q̇`. The step is the matrix exponential, so the
//! response is exact at any step width (Franklin, Powell & Workman, *Digital Control of Dynamic Systems*, §4.3).

use crate::unit::StructureSettings;

/// Width of the grid on which the curves are evaluated.
const GRID_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Below this rate at frame and shaft a mode of an axis that stands has died away: far under any sensor's noise.
const DEAD_RAD_PER_S: f64 = 1e-10;

/// What all modes together add at frame or shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deflection {
    /// Angle.
    pub angle_rad: f64,
    /// Rate.
    pub rate_rad_per_s: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mode {
    q: f64,
    q_rate: f64,
    /// What is left of (q, q̇) after a step, and what a unit torque adds.
    from_q: [f64; 2],
    from_rate: [f64; 2],
    from_torque: [f64; 2],
    frame: f64,
    shaft: f64,
    stiffness: f64,
    damping: f64,
}

/// All modes of one axis.
#[derive(Clone, Debug)]
pub struct Modes {
    structure: StructureSettings,
    step_s: f64,
    modes: Vec<Mode>,
    grid_index: i64,
    rigid_gain_ratio: f64,
    shaft_per_torque: f64,
    free_turn_rad: f64,
    frame: Deflection,
}

impl Modes {
    /// The modes at rest, as they are at an elevation, for steps of `step_s`.
    pub fn new(structure: &StructureSettings, elevation_rad: f64, step_s: f64) -> Self {
        let mut modes = Self {
            structure: structure.clone(),
            step_s,
            modes: vec![Mode::default(); structure.modes.len()],
            grid_index: 0,
            rigid_gain_ratio: 1.0,
            shaft_per_torque: 0.0,
            free_turn_rad: 0.0,
            frame: Deflection::default(),
        };
        modes.tune(grid_index(elevation_rad));
        modes
    }

    /// Follows the elevation; true if anything changed.
    #[inline]
    pub fn follow(&mut self, elevation_rad: f64) -> bool {
        let index = grid_index(elevation_rad);
        let moved = index != self.grid_index && self.structure.elevation_rad.len() > 1;
        if moved {
            self.tune(index);
        }
        moved
    }

    #[cold]
    fn tune(&mut self, index: i64) {
        self.grid_index = index;
        let structure = &self.structure;
        let step_s = self.step_s;
        let elevation_rad = index as f64 * GRID_RAD;
        let at = |curve: &[f64]| structure.interpolate(curve, elevation_rad);
        self.rigid_gain_ratio = at(&structure.rigid_gain_ratio);
        for (mode, curves) in self.modes.iter_mut().zip(&structure.modes) {
            let omega = std::f64::consts::TAU * at(&curves.frequency_hz);
            mode.discretise(omega, at(&curves.damping_ratio), step_s);
            mode.frame = at(&curves.gyro_per_kg_m2);
            mode.shaft = at(&curves.encoder_per_kg_m2);
        }
        let turn = |m: &Mode| m.shaft * ((m.from_q[0] - 1.0) * m.q + m.from_rate[0] * m.q_rate);
        self.free_turn_rad = self.modes.iter().map(turn).sum();
        self.frame = Deflection {
            angle_rad: self.modes.iter().map(|mode| mode.frame * mode.q).sum(),
            rate_rad_per_s: self.modes.iter().map(|mode| mode.frame * mode.q_rate).sum(),
        };
        self.shaft_per_torque = self.modes.iter().map(|mode| mode.shaft * mode.from_torque[0]).sum();
    }

    /// Rigid gain at the present elevation.
    pub fn rigid_gain_ratio(&self) -> f64 {
        self.rigid_gain_ratio
    }

    /// By how much the shaft turns in the coming step per N·m, beyond the rigid body.
    pub fn shaft_per_torque(&self) -> f64 {
        self.shaft_per_torque
    }

    /// By how much the shaft turns in the coming step without any torque, beyond the rigid body.
    #[inline]
    pub fn free_turn_rad(&self) -> f64 {
        self.free_turn_rad
    }

    /// One step under a torque at the shaft; what the modes add at the shaft then.
    #[inline]
    pub fn step(&mut self, torque_nm: f64) -> Deflection {
        let mut shaft = Deflection::default();
        let mut frame = Deflection::default();
        let mut free_turn_rad = 0.0;
        for mode in &mut self.modes {
            let q = mode.q;
            let rate = mode.q_rate;
            mode.q = mode.from_q[0] * q + mode.from_rate[0] * rate + mode.from_torque[0] * torque_nm;
            mode.q_rate = mode.from_q[1] * q + mode.from_rate[1] * rate + mode.from_torque[1] * torque_nm;
            shaft.angle_rad += mode.shaft * mode.q;
            shaft.rate_rad_per_s += mode.shaft * mode.q_rate;
            frame.angle_rad += mode.frame * mode.q;
            frame.rate_rad_per_s += mode.frame * mode.q_rate;
            free_turn_rad += mode.shaft * ((mode.from_q[0] - 1.0) * mode.q + mode.from_rate[0] * mode.q_rate);
        }
        self.free_turn_rad = free_turn_rad;
        self.frame = frame;
        shaft
    }

    /// Whether all modes rest; called while the axis stands, it also ends what is too small to be felt.
    pub fn come_to_rest(&mut self) -> bool {
        let felt = |mode: &Mode| {
            let amplitude = mode.q_rate.abs() + mode.stiffness.sqrt() * mode.q.abs();
            amplitude * mode.frame.abs().max(mode.shaft) > DEAD_RAD_PER_S
        };
        if self.modes.iter().any(felt) {
            return false;
        }
        self.modes.iter_mut().for_each(|mode| (mode.q, mode.q_rate) = (0.0, 0.0));
        self.free_turn_rad = 0.0;
        self.frame = Deflection::default();
        true
    }

    /// What the modes add at the frame.
    #[inline]
    pub fn frame(&self) -> Deflection {
        self.frame
    }

    /// What the modes add to the acceleration of the frame under this torque.
    #[inline]
    pub fn frame_rad_per_s2(&self, torque_nm: f64) -> f64 {
        let of = |m: &Mode| m.frame * (torque_nm - m.damping * m.q_rate - m.stiffness * m.q);
        self.modes.iter().map(of).sum()
    }

    /// Kinetic and elastic energy that the shaft gave to the modes, J: `½·c_e·(q̇² + ω²·q²)` each.
    pub fn energy_j(&self) -> f64 {
        let of = |m: &Mode| 0.5 * m.shaft * (m.q_rate * m.q_rate + m.stiffness * m.q * m.q);
        self.modes.iter().map(of).sum()
    }
}

fn grid_index(elevation_rad: f64) -> i64 {
    (elevation_rad / GRID_RAD).round() as i64
}

impl Mode {
    /// Matrix exponential of an underdamped mode (ζ < 1).
    fn discretise(&mut self, omega: f64, damping_ratio: f64, step_s: f64) {
        let decay_rate = damping_ratio * omega;
        let damped = omega * (1.0 - damping_ratio * damping_ratio).sqrt();
        let decay = (-decay_rate * step_s).exp();
        let (sin, cos) = (damped * step_s).sin_cos();
        let sine = decay * sin / damped;
        let cosine = decay * cos;
        let square = omega * omega;
        self.from_q = [cosine + decay_rate * sine, -square * sine];
        self.from_rate = [sine, cosine - decay_rate * sine];
        self.from_torque = [(1.0 - self.from_q[0]) / square, sine];
        self.stiffness = square;
        self.damping = 2.0 * decay_rate;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;

    /// Sine torque (held each step) against `Σ c·s/(s² + 2ζωs + ω²)` with the hold's exact response.
    #[test]
    fn every_mode_answers_as_its_transfer_function() {
        let unit = UnitSettings::default();
        let step_s = 1.0 / unit.step_rate_hz;
        for (structure, elevation_rad) in [(&unit.az_structure, 0.3), (&unit.el_structure, 1.2)] {
            for frequency_hz in [3.0_f64, 16.0, 17.5, 22.0, 37.0, 51.0, 90.0, 200.0] {
                let mut modes = Modes::new(structure, elevation_rad, step_s);
                let omega = std::f64::consts::TAU * frequency_hz;
                let periods = (12.0 * frequency_hz).round();
                let steps = (periods / frequency_hz / step_s).round() as u32;
                let mut re = 0.0;
                let mut im = 0.0;
                let last = (frequency_hz.ceil() / frequency_hz / step_s).round() as u32;
                for k in 0..steps {
                    let phase = omega * step_s * f64::from(k);
                    if k >= steps - last {
                        // Fourier sum over whole seconds' worth of periods at the end, transients gone.
                        let rate = modes.frame().rate_rad_per_s;
                        re += rate * phase.cos();
                        im -= rate * phase.sin();
                    }
                    modes.step(phase.cos());
                }
                let re = 2.0 * re / f64::from(last);
                let im = 2.0 * im / f64::from(last);
                let expected = frame_response(structure, modes.grid_index as f64 * GRID_RAD, omega, step_s);
                let error = ((re - expected.0).powi(2) + (im - expected.1).powi(2)).sqrt();
                let size = (expected.0.powi(2) + expected.1.powi(2)).sqrt();
                // 0.1 dB is 1.2 %, 0.5 degrees 0.9 %: demanded is ten times less.
                assert!(error < 1e-3 * size, "{frequency_hz} Hz: {re:e} {im:e} against {expected:?}");
            }
        }
    }

    /// `(1 − e^{−jωh})/(jωh)·Σ c·jω/(ω_n² − ω² + 2jζω_nω)`.
    fn frame_response(structure: &StructureSettings, elevation_rad: f64, omega: f64, h: f64) -> (f64, f64) {
        let at = |curve: &[f64]| structure.interpolate(curve, elevation_rad);
        let mut re = 0.0;
        let mut im = 0.0;
        for mode in &structure.modes {
            let own = std::f64::consts::TAU * at(&mode.frequency_hz);
            let a = own * own - omega * omega;
            let b = 2.0 * at(&mode.damping_ratio) * own * omega;
            let scale = at(&mode.gyro_per_kg_m2) * omega / (a * a + b * b);
            re += scale * b;
            im += scale * a;
        }
        let size = (omega * h / 2.0).sin() / (omega * h / 2.0);
        let turn = -omega * h / 2.0;
        let (sin, cos) = turn.sin_cos();
        (size * (re * cos - im * sin), size * (re * sin + im * cos))
    }

    #[test]
    fn undriven_modes_lose_energy_only_by_their_damping() {
        let mut structure = UnitSettings::default().az_structure;
        structure.modes.iter_mut().for_each(|mode| mode.damping_ratio.fill(0.0));
        let mut modes = Modes::new(&structure, 0.0, 50e-6);
        for _ in 0..100 {
            modes.step(1000.0);
        }
        let before = modes.energy_j();
        for _ in 0..1_200_000 {
            modes.step(0.0);
        }
        assert!((modes.energy_j() / before - 1.0).abs() < 1e-9, "{}", modes.energy_j() / before);
    }

    #[test]
    fn a_standing_axis_ends_what_cannot_be_felt_and_nothing_else() {
        let structure = UnitSettings::default().el_structure;
        let mut modes = Modes::new(&structure, 0.5, 50e-6);
        modes.step(100.0);
        assert!(!modes.come_to_rest());
        for _ in 0..400_000 {
            modes.step(0.0);
        }
        assert!(modes.come_to_rest());
        assert_eq!(modes.frame(), Deflection::default());
    }
}
