//! What the bench believes of an axis while it is being stopped.

/// Slower than this is standing still (safety.md: standstill).
const STANDSTILL_RAD_PER_S: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// Angle and rate of an axis, from whichever sensor is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Believed {
    /// Angle.
    pub position_rad: f64,
    /// Rate, signed.
    pub rate_rad_per_s: f64,
    /// Speed, the larger of what encoder and gyro say: standstill is what both show.
    pub speed_rad_per_s: f64,
}

impl Believed {
    /// Whether both sensors show standstill. A speed that is no number is none.
    pub fn stands(&self) -> bool {
        self.speed_rad_per_s < STANDSTILL_RAD_PER_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twentieth_of_a_degree_per_second_is_motion_and_so_is_a_speed_that_nobody_knows() {
        let at = |deg_per_s: f64| Believed {
            position_rad: 0.0,
            rate_rad_per_s: 0.0,
            speed_rad_per_s: deg_per_s.to_radians(),
        };
        assert!(at(0.049).stands());
        assert!(!at(0.051).stands() && !at(f64::NAN).stands());
    }
}
