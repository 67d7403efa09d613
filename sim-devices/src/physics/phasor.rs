//! Sine and cosine of a multiple of an angle that moves a little each step.

/// Turns after which the rotation is replaced by a fresh evaluation: rounding stays below 10⁻¹⁴.
const TURNS_BETWEEN_EVALUATIONS: u32 = 64;
/// Largest turn for which the series below is exact in double precision.
const LARGEST_TURN_RAD: f64 = 0.02;

/// `sin(n·θ)` and `cos(n·θ)`, followed by small rotations instead of library calls.
#[derive(Clone, Debug)]
pub struct Phasor {
    orders_per_rev: f64,
    angle_rad: f64,
    turns_count: u32,
    sin: f64,
    cos: f64,
}

impl Phasor {
    /// At an angle.
    pub fn new(orders_per_rev: f64, angle_rad: f64) -> Self {
        let (sin, cos) = (orders_per_rev * angle_rad).sin_cos();
        Self { orders_per_rev, angle_rad, turns_count: 0, sin, cos }
    }

    /// Sine and cosine at another angle; no work and no rounding if it is the same one.
    #[inline]
    pub fn turn_to(&mut self, angle_rad: f64) -> (f64, f64) {
        let turn = self.orders_per_rev * (angle_rad - self.angle_rad);
        if turn != 0.0 {
            self.angle_rad = angle_rad;
            self.turns_count += 1;
            if self.turns_count >= TURNS_BETWEEN_EVALUATIONS || turn.abs() > LARGEST_TURN_RAD {
                self.turns_count = 0;
                (self.sin, self.cos) = (self.orders_per_rev * angle_rad).sin_cos();
            } else {
                self.rotate(turn);
            }
        }
        (self.sin, self.cos)
    }

    #[inline]
    fn rotate(&mut self, turn: f64) {
        let square = turn * turn;
        let sin = turn * (1.0 - square * (1.0 / 6.0 - square / 120.0));
        let cos = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square / 720.0));
        (self.sin, self.cos) = (self.sin * cos + self.cos * sin, self.cos * cos - self.sin * sin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_small_turns_stay_on_the_circle() {
        let mut phasor = Phasor::new(144.0, -0.3);
        let mut worst = 0.0_f64;
        for k in 0..1_000_000_u32 {
            let angle = -0.3 + 1.0e-6 * f64::from(k) * (1.0 + 0.3 * (f64::from(k) * 1e-5).sin());
            let (sin, cos) = phasor.turn_to(angle);
            worst = worst.max((sin - (144.0 * angle).sin()).abs()).max((cos - (144.0 * angle).cos()).abs());
        }
        assert!(worst < 1e-13, "worst {worst:e}");
    }

    #[test]
    fn a_jump_is_followed_at_once() {
        let mut phasor = Phasor::new(108.0, 0.0);
        assert_eq!(phasor.turn_to(1.5), (162.0_f64.sin(), 162.0_f64.cos()));
    }
}
