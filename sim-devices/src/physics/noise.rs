//! Random numbers by address: seed, procedure, point, source and tick, never by the order of drawing.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Address of a random stream: never by draw order, always by place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeedAddress {
    /// Seed of the run.
    pub seed: u64,
    /// Id of the procedure.
    pub procedure: String,
    /// Name of the point.
    pub point: String,
}

/// Words of the key stream that are kept at hand.
const PAGE_WORDS: usize = 64;
/// Words that one tick owns.
const WORDS_PER_TICK: u64 = 2;

/// White Gaussian noise of one source.
#[derive(Clone, Debug)]
pub struct Noise {
    stream: ChaCha8Rng,
    page: [u32; PAGE_WORDS],
    page_number: Option<u64>,
    deviation: f64,
}

impl Noise {
    /// Noise of this standard deviation for a named source.
    pub fn new(address: &SeedAddress, source: &str, deviation: f64) -> Self {
        Self {
            stream: ChaCha8Rng::from_seed(key(address, source)),
            page: [0; PAGE_WORDS],
            page_number: None,
            deviation,
        }
    }

    /// The value of a tick, whatever was asked before.
    pub fn at(&mut self, tick: u64) -> f64 {
        if self.deviation == 0.0 {
            return 0.0;
        }
        let [first, second] = self.words_at(tick);
        self.deviation * gaussian(first, second)
    }

    /// A number of a tick that is uniform in [0, 1), independent of the deviation.
    pub fn uniform_at(&mut self, tick: u64) -> f64 {
        f64::from(self.words_at(tick)[0]) / 4_294_967_296.0
    }

    fn words_at(&mut self, tick: u64) -> [u32; 2] {
        let word = tick * WORDS_PER_TICK;
        let page_number = word / PAGE_WORDS as u64;
        if self.page_number != Some(page_number) {
            self.turn_to(page_number);
        }
        let place = (word % PAGE_WORDS as u64) as usize;
        [self.page[place], self.page[place + 1]]
    }

    /// Two independent values of a tick for the price of little more than one; the first is that of [`Noise::at`].
    pub fn pair_at(&mut self, tick: u64) -> [f64; 2] {
        if self.deviation == 0.0 {
            return [0.0; 2];
        }
        let word = tick * WORDS_PER_TICK;
        let page_number = word / PAGE_WORDS as u64;
        if self.page_number != Some(page_number) {
            self.turn_to(page_number);
        }
        let place = (word % PAGE_WORDS as u64) as usize;
        pair(self.page[place], self.page[place + 1]).map(|value| self.deviation * value)
    }

    fn turn_to(&mut self, page_number: u64) {
        self.stream.set_word_pos(u128::from(page_number) * PAGE_WORDS as u128);
        self.page.iter_mut().for_each(|word| *word = self.stream.next_u32());
        self.page_number = Some(page_number);
    }
}

/// Box–Muller from two words; the half keeps the logarithm finite (largest value 6.7 deviations).
fn gaussian(first: u32, second: u32) -> f64 {
    pair(first, second)[0]
}

/// A pair of independent Gaussians.
#[inline]
fn pair(first: u32, second: u32) -> [f64; 2] {
    let unit = |word: u32| (f64::from(word) + 0.5) / 4_294_967_296.0;
    let radius = (-2.0 * ln(unit(first))).sqrt();
    let [cos, sin] = circle(unit(second));
    [radius * cos, radius * sin]
}

/// Natural logarithm to 10⁻¹² of a normal positive number: `ln m = 2·artanh((m − 1)/(m + 1))` of the mantissa. The
/// system's own is exact to the last bit, which noise does not need, and takes several times as long.
#[inline]
fn ln(x: f64) -> f64 {
    // Shifted so that the mantissa lies between √½ and √2.
    const SHIFT: u64 = 0x3FE6_A09E_667F_3BCD;
    let shifted = x.to_bits().wrapping_sub(SHIFT);
    let exponent = (shifted as i64 >> 52) as f64;
    let mantissa = f64::from_bits((shifted & 0x000F_FFFF_FFFF_FFFF).wrapping_add(SHIFT));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let q = s * s;
    let tail = 1.0 / 7.0 + q * (1.0 / 9.0 + q * (1.0 / 11.0 + q * (1.0 / 13.0)));
    let series = 2.0 * s * (1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * tail)));
    exponent * std::f64::consts::LN_2 + series
}

/// Cosine and sine of a part of a turn, 0 to 1, to 10⁻¹¹: by series about the nearest quarter.
#[inline]
fn circle(turn: f64) -> [f64; 2] {
    let quarter = (4.0 * turn + 0.5) as u32;
    let x = std::f64::consts::TAU * (turn - 0.25 * f64::from(quarter));
    let q = x * x;
    let sin =
        x * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0 * (1.0 - q / 110.0)))));
    let cos = 1.0
        - q / 2.0
            * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0 * (1.0 - q / 132.0)))));
    match quarter & 3 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

/// 256-bit key of an address: FNV-1a over the length-prefixed parts, spread by SplitMix64.
fn key(address: &SeedAddress, source: &str) -> [u8; 32] {
    let mut hash = fnv1a(0xcbf2_9ce4_8422_2325, &address.seed.to_le_bytes());
    for part in [address.procedure.as_str(), address.point.as_str(), source] {
        hash = fnv1a(hash, &(part.len() as u64).to_le_bytes());
        hash = fnv1a(hash, part.as_bytes());
    }
    let mut key = [0; 32];
    for lane in key.chunks_exact_mut(8) {
        hash = hash.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        lane.copy_from_slice(&(mixed ^ (mixed >> 31)).to_le_bytes());
    }
    key
}

fn fnv1a(start: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(start, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_and_circle_are_those_of_the_system_to_1e_11() {
        for k in 0..100_000_u32 {
            let word = k.wrapping_mul(42_949);
            let u = (f64::from(word) + 0.5) / 4_294_967_296.0;
            assert!((ln(u) - u.ln()).abs() < 1e-11, "ln {u}");
            let [cos, sin] = circle(u);
            let (s, c) = (std::f64::consts::TAU * u).sin_cos();
            assert!((cos - c).abs() < 1e-10 && (sin - s).abs() < 1e-10, "circle at {u}");
        }
        let smallest = 0.5 / 4_294_967_296.0;
        assert!((ln(smallest) - f64::ln(smallest)).abs() < 1e-11);
    }

    fn address(seed: u64, procedure: &str, point: &str) -> SeedAddress {
        SeedAddress { seed, procedure: procedure.into(), point: point.into() }
    }

    #[test]
    fn skipping_ticks_or_going_back_changes_no_value() {
        let mut all = Noise::new(&address(7, "AZ-FRICTION", "1"), "az.current", 1.0);
        let values: Vec<f64> = (0..1000).map(|tick| all.at(tick)).collect();
        let mut some = Noise::new(&address(7, "AZ-FRICTION", "1"), "az.current", 1.0);
        for tick in [999, 3, 500, 4, 31, 32, 33, 0] {
            assert_eq!(some.at(tick as u64), values[tick]);
        }
    }

    #[test]
    fn a_pair_is_the_value_of_the_tick_and_an_independent_one() {
        let mut noise = Noise::new(&address(7, "A", "1"), "s", 2.0);
        let pairs: Vec<[f64; 2]> = (0..100_000).map(|tick| noise.pair_at(tick)).collect();
        assert!((0..100).all(|tick| noise.at(tick) == pairs[tick as usize][0]));
        let mean = |value: fn(&[f64; 2]) -> f64| pairs.iter().map(value).sum::<f64>() / 1e5;
        // Four standard errors of mean, variance and covariance.
        assert!(mean(|pair| pair[1]).abs() < 4.0 * 2.0 / 1e5_f64.sqrt());
        assert!((mean(|pair| pair[1] * pair[1]) / 4.0 - 1.0).abs() < 4.0 * (2.0 / 1e5_f64).sqrt());
        assert!(mean(|pair| pair[0] * pair[1]).abs() < 4.0 * 4.0 / 1e5_f64.sqrt());
    }

    #[test]
    fn every_part_of_the_address_matters() {
        let base = address(7, "A", "BC");
        let others = [address(8, "A", "BC"), address(7, "AB", "C"), address(7, "A", "BD")];
        let first = Noise::new(&base, "s", 1.0).at(5);
        assert_eq!(first, Noise::new(&base, "s", 1.0).at(5));
        assert_ne!(first, Noise::new(&base, "t", 1.0).at(5));
        assert_ne!(first, Noise::new(&base, "s", 1.0).at(6));
        others.iter().for_each(|other| assert_ne!(first, Noise::new(other, "s", 1.0).at(5)));
    }

    /// 100 000 values of a fixed seed: mean within 4 standard errors, variance within 4, kurtosis within 4, and no
    /// correlation between neighbours.
    #[test]
    fn the_noise_is_gaussian_and_white() {
        let n = 100_000_u32;
        let mut noise = Noise::new(&address(1, "P", "Q"), "s", 1.0);
        let values: Vec<f64> = (0..u64::from(n)).map(|tick| noise.at(tick)).collect();
        let moment = |power: i32| values.iter().map(|v| v.powi(power)).sum::<f64>() / f64::from(n);
        let root_n = f64::from(n).sqrt();
        assert!(moment(1).abs() < 4.0 / root_n);
        assert!((moment(2) - 1.0).abs() < 4.0 * 2.0_f64.sqrt() / root_n);
        assert!((moment(4) - 3.0).abs() < 4.0 * 96.0_f64.sqrt() / root_n);
        let lag: f64 = values.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / f64::from(n);
        assert!(lag.abs() < 4.0 / root_n);
    }
}
