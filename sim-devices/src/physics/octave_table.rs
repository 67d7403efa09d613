//! A smooth function of a positive number over many octaves, by cubic interpolation.

/// Intervals per octave, as a power of two.
const INTERVAL_BITS: u32 = 6;
/// Bits of a double's mantissa.
const MANTISSA_BITS: u32 = 52;
const EXPONENT_BIAS: i32 = 1023;

/// Cubic polynomials on 64 intervals per octave, through four points of each: for a function that changes little
/// within an octave the error is about 10⁻⁹ of it. Dear functions that are asked for every step are kept in one.
#[derive(Clone, Debug)]
pub struct OctaveTable {
    /// Number of the first interval, as the bits of its lower end say it.
    first: u64,
    /// Coefficients in the place within the interval, 0 to 1.
    cubics: Vec<[f64; 4]>,
    below: f64,
    above: f64,
}

impl OctaveTable {
    /// The function between 2^`lowest` and 2^`highest`; `below` and `above` stand for it outside.
    pub fn new(lowest: i32, highest: i32, below: f64, above: f64, function: impl Fn(f64) -> f64) -> Self {
        let first = interval(2.0_f64.powi(lowest));
        let end = interval(2.0_f64.powi(highest));
        let cubic = |number: u64| {
            let [low, high] =
                [number, number + 1].map(|n| f64::from_bits(n << (MANTISSA_BITS - INTERVAL_BITS)));
            let [y0, y1, y2, y3] =
                [0.0, 1.0, 2.0, 3.0].map(|third| function(low + (high - low) * third / 3.0));
            // Newton's divided differences at 0, 1/3, 2/3, 1, in powers of the place.
            let d1 = y1 - y0;
            let d2 = y2 - 2.0 * y1 + y0;
            let d3 = y3 - 3.0 * (y2 - y1) - y0;
            [y0, 3.0 * d1 - 1.5 * d2 + d3, 4.5 * (d2 - d3), 4.5 * d3]
        };
        Self { first, cubics: (first..end).map(cubic).collect(), below, above }
    }

    /// Value at a number that is not negative.
    #[inline]
    pub fn at(&self, x: f64) -> f64 {
        let number = interval(x);
        if number < self.first {
            return self.below;
        }
        let Some([a, b, c, d]) = self.cubics.get((number - self.first) as usize) else { return self.above };
        let rest = (x.to_bits() << (64 - (MANTISSA_BITS - INTERVAL_BITS))) >> (64 - MANTISSA_BITS);
        let place = f64::from_bits((EXPONENT_BIAS as u64) << MANTISSA_BITS | rest) - 1.0;
        a + place * (b + place * (c + place * d))
    }
}

/// Exponent and leading bits of the mantissa.
#[inline]
fn interval(x: f64) -> u64 {
    x.to_bits() >> (MANTISSA_BITS - INTERVAL_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_stribeck_curve_is_met_to_1e_9(log2 in -44.0..2.0f64, shape in 0.5..3.0f64) {
            let curve = |v: f64| (-(v / 0.05).powf(shape)).exp();
            let table = OctaveTable::new(-50, 2, 1.0, 0.0, curve);
            let v = log2.exp2();
            prop_assert!((table.at(v) - curve(v)).abs() < 2e-9, "{} against {}", table.at(v), curve(v));
        }

        #[test]
        fn a_logarithm_of_the_age_is_met_to_1e_9(log2 in -29.0..9.9f64) {
            let table = OctaveTable::new(-30, 10, 0.0, 1000.0_f64.ln_1p(), f64::ln_1p);
            let age = log2.exp2();
            prop_assert!((table.at(age) / age.ln_1p() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn outside_it_is_what_was_said_and_inside_it_has_no_jumps() {
        let table = OctaveTable::new(-2, 3, -1.0, 99.0, |x| x * x * x);
        assert_eq!([table.at(0.0), table.at(0.2), table.at(8.0), table.at(1e300)], [-1.0, -1.0, 99.0, 99.0]);
        for k in 1..(5 << INTERVAL_BITS) {
            let node = f64::from_bits((table.first + k) << (MANTISSA_BITS - INTERVAL_BITS));
            let before = f64::from_bits(node.to_bits() - 1);
            assert!((table.at(node) - table.at(before)).abs() < 1e-12 * table.at(node));
            assert!((table.at(node) / (node * node * node) - 1.0).abs() < 1e-12);
        }
    }
}
