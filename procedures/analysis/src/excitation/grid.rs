//! The frequencies of a multisine.

use std::ops::RangeInclusive;

use super::{ExcitationError, positive, slow_enough};

/// Lines of odd harmonic in a group of which one is left out.
const GROUP: usize = 4;

/// Offset φ of all lines, in parts of the line spacing 1/T_w.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offset {
    /// φ = 0: repeats after one window.
    Zero,
    /// φ = ¼: repeats after four windows. Sine and cosine of different lines are not orthogonal on one window (their
    /// sum frequency is no whole multiple of 1/T_w), so the least squares couple them.
    Quarter,
    /// φ = ½: repeats (with the sign changed) after one window.
    Half,
    /// φ = ¾: as ¼.
    ThreeQuarters,
}

impl Offset {
    /// φ as a number.
    pub fn value(self) -> f64 {
        let (numerator, denominator) = self.fraction();
        f64::from(numerator) / f64::from(denominator)
    }

    /// φ as a fraction in lowest terms.
    fn fraction(self) -> (u32, u32) {
        match self {
            Self::Zero => (0, 1),
            Self::Quarter => (1, 4),
            Self::Half => (1, 2),
            Self::ThreeQuarters => (3, 4),
        }
    }
}

/// Which harmonics are excited. A line's harmonic counts in multiples of one over the time after which the signal
/// repeats: m at φ = 0, 2m + 1 at φ = ½, which is always odd, as are those at ¼ and ¾.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// All.
    Full,
    /// The odd ones.
    Odd,
    /// The odd ones but one, at random, in each group of four (Pintelon, Vandersteen, De Locht, Rolain & Schoukens,
    /// *IEEE Trans. Instrum. Meas.* 53, 854, 2004).
    OddRandom,
}

/// How lines are picked from those of the kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// All.
    Every,
    /// About so many, the nearest to equal steps of frequency.
    Linear(usize),
    /// About so many, the nearest to equal ratios of frequency.
    Logarithmic(usize),
}

/// What is wanted of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Lowest and highest frequency, Hz.
    pub band_hz: RangeInclusive<f64>,
    /// Which harmonics.
    pub kind: Kind,
    /// Which of them.
    pub spacing: Spacing,
    /// Bands without lines, Hz (cogging at the plateau's speed ± 0.3 Hz).
    pub forbidden_hz: Vec<RangeInclusive<f64>>,
}

/// Lines f = (m + φ)/T_w of a multisine.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Window T_w, s.
    pub window_s: f64,
    /// φ.
    pub offset: Offset,
    /// m of the excited lines, ascending.
    pub orders: Vec<u32>,
    /// m of the lines with odd harmonic that are left out of the groups: they show odd distortion. Empty but for
    /// [`Kind::OddRandom`], and at φ = ¼, ¾, where products of odd order leave the grid (3·φ is another offset).
    pub odd_detection: Vec<u32>,
    /// m of the even lines between the outermost excited ones, which show even distortion. Only at φ = 0 with odd
    /// lines: at φ = ½ products of even order fall between the lines of the grid, at whole multiples of 1/T_w.
    pub even_detection: Vec<u32>,
}

impl Grid {
    /// Picks lines. `random` (uniform, 0…1) is asked once a group of [`Kind::OddRandom`].
    ///
    /// # Errors
    /// [`ExcitationError::Window`] if T_w·f_s is not whole, [`ExcitationError::TooFast`], [`ExcitationError::Band`],
    /// [`ExcitationError::Empty`], [`ExcitationError::NotPositive`].
    pub fn new(
        window_s: f64,
        offset: Offset,
        sample_rate_hz: f64,
        wanted: &Selection,
        random: &mut dyn FnMut() -> f64,
    ) -> Result<Self, ExcitationError> {
        check(window_s, sample_rate_hz, wanted)?;
        let mut grid =
            Self { window_s, offset, orders: vec![], odd_detection: vec![], even_detection: vec![] };
        let allowed = grid.allowed(wanted);
        let odd = |m: &u32| wanted.kind == Kind::Full || grid.harmonic(*m) % 2 == 1;
        let mut candidates: Vec<u32> = allowed.iter().copied().filter(odd).collect();
        let mut left_out = vec![];
        if wanted.kind == Kind::OddRandom {
            (candidates, left_out) = thin(&candidates, random);
        }
        grid.orders = grid.pick(&candidates, wanted.spacing);
        let (Some(&first), Some(&last)) = (grid.orders.first(), grid.orders.last()) else {
            let from_hz = *wanted.band_hz.start();
            let to_hz = *wanted.band_hz.end();
            return Err(ExcitationError::Empty { from_hz, to_hz });
        };
        if matches!(offset, Offset::Zero | Offset::Half) {
            grid.odd_detection = left_out;
        }
        if wanted.kind != Kind::Full && offset == Offset::Zero {
            let even = |m: &u32| m.is_multiple_of(2) && (first..=last).contains(m);
            grid.even_detection = allowed.into_iter().filter(even).collect();
        }
        Ok(grid)
    }

    /// Frequency of order m, Hz.
    pub fn frequency_hz(&self, order: u32) -> f64 {
        (f64::from(order) + self.offset.value()) / self.window_s
    }

    /// Frequencies of the excited lines, Hz, ascending.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.orders.iter().map(|&m| self.frequency_hz(m)).collect()
    }

    /// Time after which all lines repeat, s.
    pub fn repeats_after_s(&self) -> f64 {
        self.window_s * f64::from(self.offset.fraction().1)
    }

    fn harmonic(&self, order: u32) -> u32 {
        let (numerator, denominator) = self.offset.fraction();
        order * denominator + numerator
    }

    /// Orders in the band and outside what is forbidden.
    fn allowed(&self, wanted: &Selection) -> Vec<u32> {
        let last = (wanted.band_hz.end() * self.window_s) as u32;
        let free = |m: &u32| {
            let f = self.frequency_hz(*m);
            f > 0.0 && wanted.band_hz.contains(&f) && !wanted.forbidden_hz.iter().any(|b| b.contains(&f))
        };
        (0..=last).filter(free).collect()
    }

    fn pick(&self, candidates: &[u32], spacing: Spacing) -> Vec<u32> {
        let (Some(&first), Some(&last)) = (candidates.first(), candidates.last()) else { return vec![] };
        let low = self.frequency_hz(first);
        let high = self.frequency_hz(last);
        let (count, target): (usize, Box<dyn Fn(f64) -> f64>) = match spacing {
            Spacing::Every => return candidates.to_vec(),
            Spacing::Linear(count) => (count, Box::new(move |part| low + (high - low) * part)),
            Spacing::Logarithmic(count) => (count, Box::new(move |part| low * (high / low).powf(part))),
        };
        let steps = count.saturating_sub(1).max(1) as f64;
        let nearest = |f: f64| -> u32 {
            let above = candidates.partition_point(|&m| self.frequency_hz(m) < f).min(candidates.len() - 1);
            let below = above.saturating_sub(1);
            let far = |i: usize| (self.frequency_hz(candidates[i]) - f).abs();
            candidates[if far(below) <= far(above) { below } else { above }]
        };
        let mut orders: Vec<u32> = (0..count).map(|i| nearest(target(i as f64 / steps))).collect();
        orders.dedup();
        orders
    }
}

fn check(window_s: f64, sample_rate_hz: f64, wanted: &Selection) -> Result<(), ExcitationError> {
    positive("window, s", window_s)?;
    positive("sample rate, Hz", sample_rate_hz)?;
    let samples = window_s * sample_rate_hz;
    if (samples - samples.round()).abs() > 1e-9 * samples {
        return Err(ExcitationError::Window { window_s, samples });
    }
    let from_hz = *wanted.band_hz.start();
    let to_hz = *wanted.band_hz.end();
    if !(from_hz >= 0.0 && from_hz <= to_hz) {
        return Err(ExcitationError::Band { from_hz, to_hz });
    }
    slow_enough(to_hz, sample_rate_hz)
}

/// Leaves one at random out of each whole group: what stays, what goes.
fn thin(candidates: &[u32], random: &mut dyn FnMut() -> f64) -> (Vec<u32>, Vec<u32>) {
    let mut kept = vec![];
    let mut left_out = vec![];
    for group in candidates.chunks(GROUP) {
        let out = (group.len() == GROUP).then(|| ((random() * GROUP as f64) as usize).min(GROUP - 1));
        for (i, &m) in group.iter().enumerate() {
            if Some(i) == out { left_out.push(m) } else { kept.push(m) }
        }
    }
    (kept, left_out)
}
