//! Responses of a plant in closed loop, where its noise reaches its input.
//!
//! With u = C·(r − y) and output noise of density P_v the direct estimate S_uy/S_uu tends to G·(1 −
//! (P_v/P_r)/(G·C))/(1 + P_v/P_r), and to −1/C where noise rules; through the reference, which noise does not
//! reach, S_ry/S_ru tends to G (Pintelon & Schoukens, *System Identification*, 2nd ed., §2.6; Söderström &
//! Stoica, *System Identification*, ch. 10).

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::super::frf::{C64, Frf};
use super::{CrossSpectra, SpectraError};

/// Probability of the circle that a line of an unbiased direct estimate leaves in 1 of 100 cases.
const CIRCLE_PROBABILITY: f64 = 0.99;
/// Spreads of the share of lines outside their circles that chance is granted.
const GRANTED_SPREADS: f64 = 4.0;
/// −ln of the probability, 0.001, at which chance moves the mean over a band this far.
const GRANTED_MEAN: f64 = 6.9;
/// Relative variance of rounding: what two estimates of the same differ by.
const ROUNDING: f64 = 1e-20;

/// How far the direct estimate is from the one through the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectBias {
    /// Lines in ascending frequency.
    pub lines: Vec<DirectBiasLine>,
    lines_per_independent: f64,
}

/// One line of the comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectBiasLine {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Direct estimate over the joint one; 1 without bias.
    pub ratio: C64,
    /// E|ratio − 1|² if the direct estimate had no bias.
    pub variance: f64,
    /// The ratio lies outside the 99 % circle around 1.
    pub outside: bool,
}

/// The comparison over a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandBias {
    /// Lines in the band.
    pub lines: usize,
    /// Mean ratio of direct to joint estimate, weighted by certainty.
    pub ratio: C64,
    /// Standard uncertainty of its modulus if there were no bias.
    pub ratio_u: f64,
    /// Share of the lines outside their 99 % circles.
    pub outside_ratio: f64,
    /// The difference is more than chance: the direct estimate must not be used.
    pub warns: bool,
}

/// Spectra of reference r, input u and output y at one line, and what follows.
struct Joint {
    value: C64,
    /// Density of y − G·u.
    residual: f64,
    /// S_rr/|S_ru|²: one over the density of u that r drives.
    per_driven: f64,
}

impl CrossSpectra {
    /// Joint input-output estimate G = S_ry/S_ru of a plant in closed loop; the reference may be any recorded
    /// signal that drives the loop and that noise does not reach (setpoint, injected torque).
    ///
    /// With the residual e = y − G·u, `variance` = S_ee/((n_d − 1)·|S_ru|²/S_rr): error of an instrumental
    /// variable (Söderström & Stoica, §8.3), line by line. `coherence` is the share that u, as far as r drives
    /// it, has of the output beside the residual: |G|²·|S_ru|²/S_rr over itself plus S_ee; in open loop that of
    /// input and output. Lines as [`CrossSpectra::h1`].
    ///
    /// # Errors
    /// As [`CrossSpectra::h1`].
    pub fn joint(&self, reference: usize, input: usize, output: usize) -> Result<Frf, SpectraError> {
        self.check_averaged(&[reference, input, output])?;
        let line = |k: usize| {
            let joint = self.joint_at(reference, input, output, k)?;
            let variance = joint.residual * joint.per_driven / (self.averages - 1.0);
            let driven = joint.value.norm_sqr() / joint.per_driven;
            self.line(k, joint.value, variance, driven / (driven + joint.residual))
        };
        Ok(self.driven_lines(reference).filter_map(line).collect())
    }

    /// Compares the direct estimate H1 of input and output with the joint one. Without noise in the input the
    /// direct one has the smaller variance and their difference that of the joint one less its own: Hausman's
    /// test (*Econometrica* 46, 1251, 1978) line by line, with E|Ĥ1 − Ĝ|² = S_ee/(n_d − 1)·(S_rr/|S_ru|² −
    /// 1/S_uu).
    ///
    /// # Errors
    /// As [`CrossSpectra::h1`].
    pub fn direct_bias(
        &self,
        reference: usize,
        input: usize,
        output: usize,
    ) -> Result<DirectBias, SpectraError> {
        self.check_averaged(&[reference, input, output])?;
        let dof = self.averages - 1.0;
        let quantile =
            FisherSnedecor::new(2.0, 2.0 * dof).map_or(f64::INFINITY, |f| f.inverse_cdf(CIRCLE_PROBABILITY));
        let line = |k: usize| {
            let joint = self.joint_at(reference, input, output, k)?;
            let two = self.two(input, output, k);
            let ratio = two.xy / two.xx / joint.value;
            let excess = (joint.per_driven - 1.0 / two.xx).max(0.0);
            let variance = (joint.residual * excess / dof / joint.value.norm_sqr()).max(ROUNDING);
            let outside = (ratio - 1.0).norm_sqr() > quantile * variance;
            let finite = ratio.is_finite() && variance.is_finite();
            finite.then_some(DirectBiasLine { frequency_hz: self.frequency_hz[k], ratio, variance, outside })
        };
        let lines = self.driven_lines(reference).filter_map(line).collect();
        Ok(DirectBias { lines, lines_per_independent: self.settings.window.lines_per_independent() })
    }

    fn joint_at(&self, reference: usize, input: usize, output: usize, k: usize) -> Option<Joint> {
        let ru = self.cross_at(reference, input, k);
        let ry = self.cross_at(reference, output, k);
        let uy = self.two(input, output, k);
        let per_driven = self.auto[reference][k] / ru.norm_sqr();
        let value = ry / ru;
        let residual = uy.yy + value.norm_sqr() * uy.xx - 2.0 * (value.conj() * uy.xy).re;
        let usable = per_driven.is_finite() && value.is_finite() && value.norm_sqr() > 0.0 && uy.xx > 0.0;
        // A sum of squares: below 0 only by rounding.
        usable.then_some(Joint { value, residual: residual.max(0.0), per_driven })
    }
}

impl DirectBias {
    /// The comparison over the lines from `low_hz` to `high_hz`; `None` if there is none.
    ///
    /// Warns if more lines lie outside their circles than chance puts there (1 % and four spreads; neighbouring
    /// lines of a window count for less than one each), or if the weighted mean ratio is further from 1 than
    /// chance moves it in 1 of 1000 cases. The first sees a bias of any phase, the second a small one that all
    /// lines share.
    pub fn over(&self, low_hz: f64, high_hz: f64) -> Option<BandBias> {
        let band: Vec<&DirectBiasLine> =
            self.lines.iter().filter(|l| (low_hz..=high_hz).contains(&l.frequency_hz)).collect();
        if band.is_empty() {
            return None;
        }
        let weight: f64 = band.iter().map(|l| 1.0 / l.variance).sum();
        let mean = band.iter().map(|l| (l.ratio - 1.0) / l.variance).sum::<C64>() / weight;
        let variance = self.lines_per_independent / weight;
        let count = band.len() as f64;
        let outside_ratio = band.iter().filter(|l| l.outside).count() as f64 / count;
        let by_chance = 1.0 - CIRCLE_PROBABILITY;
        let spread = (by_chance * CIRCLE_PROBABILITY * self.lines_per_independent / count).sqrt();
        let warns =
            outside_ratio > by_chance + GRANTED_SPREADS * spread || mean.norm_sqr() > GRANTED_MEAN * variance;
        let ratio_u = (0.5 * variance).sqrt();
        Some(BandBias { lines: band.len(), ratio: mean + 1.0, ratio_u, outside_ratio, warns })
    }
}
