//! Single-turn absolute encoder.

use crate::unit::AxisSettings;

/// Turns an angle into counts.
#[derive(Clone, Debug)]
pub struct Encoder {
    counts_per_rev: i64,
    counts_per_rad: f64,
    zero_rad: f64,
}

impl Encoder {
    /// The encoder of an axis.
    pub fn new(axis: &AxisSettings) -> Self {
        let counts_per_rev = axis.encoder_bits_count.exp2().round();
        Self {
            counts_per_rev: counts_per_rev as i64,
            counts_per_rad: axis.encoder_sign_factor.signum() * counts_per_rev / std::f64::consts::TAU,
            zero_rad: axis.encoder_zero_rad,
        }
    }

    /// Counts per revolution, a power of two.
    pub fn counts_per_rev(&self) -> i64 {
        self.counts_per_rev
    }

    /// Counts without the single-turn wrap: what differences of samples are made of.
    #[inline]
    pub fn unwrapped_counts(&self, angle_rad: f64) -> i64 {
        // The bias keeps the truncating conversion on one side of zero, so that it rounds to nearest everywhere.
        const BIAS: i64 = 1 << 40;
        ((angle_rad - self.zero_rad) * self.counts_per_rad + (BIAS as f64 + 0.5)) as i64 - BIAS
    }

    /// What the encoder reports: 0 ≤ counts < counts per revolution.
    pub fn counts(&self, angle_rad: f64) -> i64 {
        self.unwrapped_counts(angle_rad).rem_euclid(self.counts_per_rev)
    }

    /// Angle that one count is worth, with the sign of the encoder.
    pub fn rad_per_count(&self) -> f64 {
        1.0 / self.counts_per_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::UnitSettings;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_count_is_the_nearest_one_in_one_turn(angle in -3.2..3.2f64) {
            let encoder = Encoder::new(&UnitSettings::default().az);
            let counts = encoder.counts(angle);
            prop_assert!((0..1 << 26).contains(&counts));
            let back = encoder.unwrapped_counts(angle) as f64 * encoder.rad_per_count();
            prop_assert!((back - angle).abs() <= 0.5000001 * encoder.rad_per_count());
        }
    }

    #[test]
    fn sign_and_zero_of_the_unit_are_obeyed() {
        let mut axis = UnitSettings::default().az;
        (axis.encoder_sign_factor, axis.encoder_zero_rad) = (-1.0, 0.5);
        let encoder = Encoder::new(&axis);
        assert_eq!(encoder.counts(0.5), 0);
        assert_eq!(encoder.counts(0.5 - std::f64::consts::FRAC_PI_2), 1 << 24);
    }
}
