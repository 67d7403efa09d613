//! First poles by relaxed vector fitting (Gustavsen & Semlyen, *IEEE Trans. Power Delivery* 14, 1052, 1999;
//! Gustavsen, ibid. 21, 1587, 2006; one QR a response: Deschrijver et al., *IEEE Microw. Wireless Compon. Lett.* 18,
//! 383, 2008), which is the iteration of Sanathanan & Koerner (*IEEE Trans. Autom. Control* 8, 56, 1963) on partial
//! fractions.

use nalgebra::{DMatrix, DVector};

use super::super::frf::C64;
use super::lines::{Data, Weighed};
use super::projection::cost_at;
use super::shape::Shape;

/// Relocations: poles stand after 5 to 10 where the noise is small, later ones only wander.
const RELOCATIONS: usize = 12;
/// Damping ratio of the first poles.
const START_DAMPING: f64 = 0.01;
/// Smallest constant of σ(s) over its largest residue that is divided by.
const LEAST_CONSTANT: f64 = 1e-10;

/// Poles: the upper one of each complex pair, and the real ones.
#[derive(Clone, Debug, Default)]
struct Poles {
    upper: Vec<C64>,
    real: Vec<f64>,
}

impl Poles {
    fn count(&self) -> usize {
        2 * self.upper.len() + self.real.len()
    }

    /// Lightly damped pairs spread over the lines, and one slow real pole if the count is odd.
    fn spread(data: &Data, count: usize) -> Self {
        let s = &data.responses[0].s;
        let pairs = count / 2;
        let frequency = |k: usize| s[((2 * k + 1) * s.len() / (2 * pairs)).min(s.len() - 1)].im;
        let upper = (0..pairs).map(|k| C64::new(-START_DAMPING * frequency(k), frequency(k))).collect();
        Self { upper, real: (count % 2 == 1).then(|| -data.lowest()).into_iter().collect() }
    }

    /// Real partial fractions at `s`.
    fn fractions(&self, s: C64, out: &mut [C64]) {
        for (slot, p) in out.chunks_exact_mut(2).zip(&self.upper) {
            let one = (s - p).inv();
            let other = (s - p.conj()).inv();
            slot[0] = one + other;
            slot[1] = C64::i() * (one - other);
        }
        for (slot, p) in out[2 * self.upper.len()..].iter_mut().zip(&self.real) {
            *slot = (s - p).inv();
        }
    }

    /// Zeros of `constant + Σ residues·fractions`, those to the right of the axis mirrored if `stable`.
    fn zeros(&self, residues: &[f64], constant: f64, stable: bool) -> Option<Self> {
        let n = self.count();
        let mut matrix = DMatrix::zeros(n, n);
        let mut input = DVector::zeros(n);
        for (k, p) in self.upper.iter().enumerate() {
            matrix[(2 * k, 2 * k)] = p.re;
            matrix[(2 * k + 1, 2 * k + 1)] = p.re;
            matrix[(2 * k, 2 * k + 1)] = p.im;
            matrix[(2 * k + 1, 2 * k)] = -p.im;
            input[2 * k] = 2.0;
        }
        for (k, p) in self.real.iter().enumerate() {
            let at = 2 * self.upper.len() + k;
            matrix[(at, at)] = *p;
            input[at] = 1.0;
        }
        matrix -= input * DVector::from_column_slice(residues).transpose() / constant;
        if matrix.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let mut found = Self::default();
        for p in matrix.complex_eigenvalues().iter() {
            let re = if stable { -p.re.abs() } else { p.re };
            if p.im > 0.0 {
                // A pole on the axis may stand on a line.
                found.upper.push(C64::new(if re == 0.0 { -1e-12 * p.im } else { re }, p.im));
            } else if p.im == 0.0 {
                found.real.push(re);
            }
        }
        (found.count() == n).then_some(found)
    }

    /// Coefficients a, b of sections of second order, then q of one of first order if the count is odd.
    fn theta(&self) -> Vec<f64> {
        let mut real = self.real.clone();
        real.sort_by(|x, y| x.abs().total_cmp(&y.abs()));
        let single = (real.len() % 2 == 1).then(|| -real.remove(0));
        let complex = self.upper.iter().flat_map(|p| [-2.0 * p.re, p.norm_sqr()]);
        let joined = real.chunks_exact(2).flat_map(|p| [-p[0] - p[1], p[0] * p[1]]);
        complex.chain(joined).chain(single).collect()
    }
}

/// Triangle of one response's equations in the residues and the constant of σ, its own residues eliminated.
fn reduced(response: &Weighed, poles: &Poles, terms: &[i32]) -> DMatrix<f64> {
    let count = response.s.len();
    let n = poles.count();
    let own = n + terms.len();
    let mut matrix = DMatrix::zeros(2 * count, own + n + 1);
    let mut row = vec![C64::default(); own + n + 1];
    for (line, s) in response.s.iter().enumerate() {
        poles.fractions(*s, &mut row[..n]);
        for (slot, power) in row[n..own].iter_mut().zip(terms) {
            *slot = s.powi(*power);
        }
        for k in 0..n {
            row[own + k] = -response.value[line] * row[k];
        }
        row[own + n] = -response.value[line];
        for (k, v) in row.iter().enumerate() {
            matrix[(line, k)] = response.root[line] * v.re;
            matrix[(count + line, k)] = response.root[line] * v.im;
        }
    }
    matrix.qr().r().view((own, own), (n + 1, n + 1)).into_owned()
}

/// One relocation.
fn relocate(data: &Data, poles: &Poles, terms: &[i32], stable: bool) -> Option<Poles> {
    let n = poles.count();
    let responses = data.responses.len();
    let mut system = DMatrix::zeros(responses * (n + 1) + 1, n + 1);
    let mut size = 0.0;
    let mut relaxed = DVector::<f64>::zeros(n + 1);
    let mut row = vec![C64::default(); n];
    for (m, response) in data.responses.iter().enumerate() {
        system.rows_mut(m * (n + 1), n + 1).copy_from(&reduced(response, poles, terms));
        for (line, s) in response.s.iter().enumerate() {
            poles.fractions(*s, &mut row);
            row.iter().zip(relaxed.iter_mut()).for_each(|(v, sum)| *sum += v.re);
            relaxed[n] += 1.0;
            size += (response.root[line] * response.value[line].norm()).powi(2);
        }
    }
    // σ is 1 on average over the lines: keeps it from vanishing without holding its constant (relaxed non-triviality).
    let lines = data.line_count() as f64;
    let weight = size.sqrt() / lines;
    let last = responses * (n + 1);
    system.row_mut(last).copy_from(&(relaxed.transpose() * weight));
    let scale: Vec<f64> = system.column_iter().map(|c| c.norm()).collect();
    if scale.iter().any(|s| !s.is_finite() || *s <= 0.0) {
        return None;
    }
    for (k, s) in scale.iter().enumerate() {
        system.column_mut(k).unscale_mut(*s);
    }
    let mut target = DVector::zeros(last + 1);
    target[last] = weight * lines;
    let mut sigma = system.svd(true, true).solve(&target, f64::EPSILON).ok()?;
    sigma.iter_mut().zip(&scale).for_each(|(v, s)| *v /= s);
    let largest = sigma.rows(0, n).amax();
    let least = LEAST_CONSTANT * largest.max(f64::MIN_POSITIVE);
    let constant = if sigma[n].abs() < least { least.copysign(sigma[n]) } else { sigma[n] };
    poles.zeros(&sigma.as_slice()[..n], constant, stable)
}

/// Nonlinear parameters to start from: of all relocations those of the least cost.
///
/// `count` poles, `terms` powers beside them; the delay is not among the parameters.
pub(crate) fn first_poles(data: &Data, count: usize, terms: &[i32], stable: bool) -> Option<Vec<f64>> {
    from(data, Poles::spread(data, count), terms, stable)
}

/// First poles: one pair at a scaled frequency.
pub(crate) fn first_pair(data: &Data, frequency: f64) -> Option<Vec<f64>> {
    let damping = START_DAMPING * frequency;
    let poles = Poles { upper: vec![C64::new(-damping, frequency)], real: Vec::new() };
    from(data, poles, &[], true)
}

fn from(data: &Data, start: Poles, terms: &[i32], stable: bool) -> Option<Vec<f64>> {
    let count = start.count();
    let shape = Shape { pairs: count / 2, singles: count % 2, terms: terms.to_vec(), delay: false };
    let mut poles = start;
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..RELOCATIONS {
        let Some(next) = relocate(data, &poles, terms, stable) else { break };
        let theta = next.theta();
        if let Some(cost) = cost_at(data, &shape, &theta)
            && best.as_ref().is_none_or(|(least, _)| cost < *least)
        {
            best = Some((cost, theta));
        }
        poles = next;
    }
    best.map(|(_, theta)| theta)
}
