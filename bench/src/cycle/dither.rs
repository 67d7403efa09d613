//! Dither of slow torque ramps: ± ½ quantum, so that the drive's rounding does not become a staircase.

use procedures::log::Plan;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use sha2::{Digest, Sha256};

/// A uniform dither addressed by (seed, procedure, point, tick): the value of a tick does not depend on how often it
/// was asked before.
#[derive(Clone, Debug)]
pub struct Dither {
    random: ChaCha8Rng,
    quantum_nm: f64,
}

impl Dither {
    /// The dither of one point; `quantum_nm` is the torque of one drive count.
    pub fn new(plan: &Plan, point: &str, quantum_nm: f64) -> Self {
        let mut key = Sha256::new();
        for part in [plan.procedure.as_str(), point, "dither"] {
            key.update((part.len() as u64).to_le_bytes());
            key.update(part.as_bytes());
        }
        key.update(plan.seed.to_le_bytes());
        Self { random: ChaCha8Rng::from_seed(key.finalize().into()), quantum_nm }
    }

    /// Torque to add in this tick, within ± ½ quantum.
    pub fn at(&mut self, tick: u64) -> f64 {
        self.random.set_word_pos(u128::from(tick));
        let uniform = f64::from(self.random.next_u32()) / f64::from(u32::MAX);
        (uniform - 0.5) * self.quantum_nm
    }
}
