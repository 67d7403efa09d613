//! Piezo actuator: hysteresis and creep of the strain, and the electrical side of the stacks.
//!
//! Hysteresis is a Prandtl–Ishlinskii operator: a weighted sum of play operators (Krejčí & Kuhnen, *Inverse control
//! of systems with hysteresis and creep*, IEE Proc. Control Theory Appl. 148 (2001) 185). It is rate independent,
//! has return-point memory and closed, congruent minor loops. Creep is logarithmic in time (Jung & Gweon, *Creep
//! characteristics of piezoelectric actuators*, Rev. Sci. Instrum. 71 (2000) 1896), approximated by one relaxation
//! per decade of time.

mod circuit;
mod exponential;
#[cfg(test)]
mod tests;

pub use circuit::{Circuit, CircuitValues, Impedance};
pub(crate) use exponential::exponential;

/// Play operators of one actuator, in lanes: sums over a lane do not wait for each other.
const PLAYS: usize = ROWS * LANES;
const ROWS: usize = 3;
const LANES: usize = 4;

/// Prandtl–Ishlinskii hysteresis: equal weights, thresholds spread evenly over the full scale.
#[derive(Clone, Debug)]
pub struct Hysteresis {
    direct_gain: f64,
    weight: f64,
    thresholds: [[f64; LANES]; ROWS],
    plays: [[f64; LANES]; ROWS],
}

impl Hysteresis {
    /// A virgin actuator. `width_ratio` is the opening of the loop between ± `full_scale` at zero input over the
    /// whole travel of that loop (0 … 0.3); a loop between ± `unity_amplitude` has the secant gain 1.
    pub fn new(full_scale: f64, width_ratio: f64, unity_amplitude: f64) -> Self {
        let thresholds: [f64; PLAYS] =
            std::array::from_fn(|j| full_scale * (j + 1) as f64 / (PLAYS + 1) as f64);
        // With gain 1 at full scale: at zero input a play of threshold r stands 2·min(r, A − r) apart on the two
        // branches, and the output travels 2·A.
        let opening: f64 = thresholds.iter().map(|r| r.min(full_scale - r)).sum();
        let weight = width_ratio * full_scale / opening;
        let share = |amplitude: f64| -> f64 {
            thresholds.iter().map(|r| weight * (1.0 - r / amplitude).max(0.0)).sum()
        };
        let direct = 1.0 - share(full_scale);
        let scale = 1.0 / (direct + share(unity_amplitude));
        let in_lanes = |row: usize| std::array::from_fn(|lane| thresholds[row * LANES + lane]);
        Self {
            direct_gain: direct * scale,
            weight: weight * scale,
            thresholds: std::array::from_fn(in_lanes),
            plays: [[0.0; LANES]; ROWS],
        }
    }

    /// Strain at a new input, in units of the input; only its turning points matter, not the time between.
    #[inline]
    pub fn update(&mut self, input: f64) -> f64 {
        let mut sums = [0.0; LANES];
        for (plays, thresholds) in self.plays.iter_mut().zip(&self.thresholds) {
            for lane in 0..LANES {
                let low = input - thresholds[lane];
                let high = input + thresholds[lane];
                let raised = if plays[lane] < low { low } else { plays[lane] };
                plays[lane] = if raised > high { high } else { raised };
                sums[lane] += plays[lane];
            }
        }
        self.direct_gain * input + self.weight * ((sums[0] + sums[1]) + (sums[2] + sums[3]))
    }
}

/// Relaxation times of creep, one per decade.
const CREEP_TIMES_S: [f64; 4] = [0.1, 1.0, 10.0, 100.0];

/// Logarithmic creep: after a step the strain grows by a fixed share per decade of time, from 0.1 s to 100 s.
#[derive(Clone, Debug)]
pub struct Creep {
    share_per_decade: f64,
    relaxations: [f64; CREEP_TIMES_S.len()],
    /// 1 − exp(−Δt/τ): exact for an input that holds over a step.
    approaches: [f64; CREEP_TIMES_S.len()],
}

impl Creep {
    /// At rest at zero, stepped every `step_s`.
    pub fn new(share_per_decade: f64, step_s: f64) -> Self {
        Self {
            share_per_decade,
            relaxations: [0.0; CREEP_TIMES_S.len()],
            approaches: CREEP_TIMES_S.map(|time_s| -(-step_s / time_s).exp_m1()),
        }
    }

    /// One step at a strain; returns the strain with what had crept before it.
    #[inline]
    pub fn update(&mut self, strain: f64) -> f64 {
        let [a, b, c, d] = self.relaxations;
        for (relaxation, approach) in self.relaxations.iter_mut().zip(&self.approaches) {
            *relaxation += approach * (strain - *relaxation);
        }
        strain + self.share_per_decade * ((a + b) + (c + d))
    }
}
