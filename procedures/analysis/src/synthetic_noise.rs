//! Noise of tests, the same on every machine.

/// A sample of noise by its number, uniform in −½…½.
pub(crate) fn uniform(k: usize) -> f64 {
    let mut bits = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits ^= bits >> 29;
    bits = bits.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (bits >> 40) as f64 / f64::from(1 << 24) - 0.5
}

/// Sample after sample, Gaussian enough, deviation 1: the sum of twelve uniform numbers of a linear congruential generator,
/// less six.
pub(crate) fn gaussian(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}
