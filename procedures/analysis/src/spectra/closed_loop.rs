//! Responses of a plant in closed loop, where its noise reaches its input.
//!
//! With u = C·(r − y) and output noise of density P_v the direct estimate S_uy/S_uu tends to G·(1 −
//! (P_v/P_r)/(G·C))/(1 + P_v/P_r), and to −1/C where noise rules; through the reference, which noise does not
//! reach, S_ry/S_ru tends to G (Pintelon & Schoukens, *System Identification*, 2nd ed., §2.6; Söderström &
//! Stoica, *System Identification*, ch. 10).

use super::super::frf::{C64, Frf};
use super::{CrossSpectra, SpectraError};

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
