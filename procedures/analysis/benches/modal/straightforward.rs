//! The fit as one writes it down, told where to begin.

use analysis::frf::{C64, Frf};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

struct Lines {
    /// jω over the highest ω.
    s: Vec<C64>,
    value: Vec<C64>,
    /// 1/sd of either part.
    root: Vec<f64>,
}

impl Lines {
    /// A real row for the real and one for the imaginary part of each line.
    fn rows(&self, n: usize, of: impl Fn(usize, &mut [C64])) -> DMatrix<f64> {
        let count = self.s.len();
        let mut matrix = DMatrix::zeros(2 * count, n);
        let mut row = vec![C64::default(); n];
        for line in 0..count {
            of(line, &mut row);
            for (k, v) in row.iter().enumerate() {
                matrix[(line, k)] = self.root[line] * v.re;
                matrix[(count + line, k)] = self.root[line] * v.im;
            }
        }
        matrix
    }
}

/// a, b of each section, then c, d of each, then a constant.
struct Joint<'a> {
    lines: &'a Lines,
    x: DVector<f64>,
}

impl Joint<'_> {
    fn pairs(&self) -> usize {
        self.x.len() / 4
    }

    fn section(&self, k: usize, s: C64) -> (C64, C64) {
        let x = &self.x;
        let at = 2 * self.pairs() + 2 * k;
        let inverse = (s * s + s * x[2 * k] + x[2 * k + 1]).inv();
        (inverse, (s * x[at] + x[at + 1]) * inverse)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Joint<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let constant = self.x[self.x.len() - 1];
        let residual = |line: usize, row: &mut [C64]| {
            let sum: C64 = (0..self.pairs()).map(|k| self.section(k, self.lines.s[line]).1).sum();
            row[0] = sum + constant - self.lines.value[line];
        };
        Some(self.lines.rows(1, residual).column(0).into_owned())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let pairs = self.pairs();
        Some(self.lines.rows(self.x.len(), |line, row| {
            let s = self.lines.s[line];
            for k in 0..pairs {
                let (inverse, value) = self.section(k, s);
                (row[2 * k], row[2 * k + 1]) = (-value * inverse * s, -value * inverse);
                (row[2 * pairs + 2 * k], row[2 * pairs + 2 * k + 1]) = (s * inverse, inverse);
            }
            row[4 * pairs] = C64::new(1.0, 0.0);
        }))
    }
}

/// Sections with the residues that suit the poles best.
fn with_residues<'a>(lines: &'a Lines, poles: &[C64]) -> Joint<'a> {
    let sections = poles.iter().flat_map(|p| [-2.0 * p.re, p.norm_sqr()]);
    let n = 2 * poles.len();
    let zeros = std::iter::repeat_n(0.0, n + 1);
    let mut joint = Joint { lines, x: DVector::from_vec(sections.chain(zeros).collect()) };
    let jacobian = joint.jacobian().expect("always one");
    let target = -joint.residuals().expect("always some");
    let qr = jacobian.columns(n, n + 1).into_owned().qr();
    let c = qr.r().solve_upper_triangular(&(qr.q().transpose() * target)).expect("poles apart");
    joint.x.rows_mut(n, n + 1).copy_from(&c);
    joint
}

/// Undamped frequencies of the modes, searched from `begin_hz` and `damping_ratio` on.
pub(crate) fn frequencies_hz(frf: &Frf, begin_hz: &[f64], damping_ratio: f64) -> Vec<f64> {
    let highest_hz = frf[frf.len() - 1].frequency_hz;
    let lines = Lines {
        s: frf.iter().map(|l| C64::new(0.0, l.frequency_hz / highest_hz)).collect(),
        value: frf.iter().map(|l| l.value).collect(),
        root: frf.iter().map(|l| (2.0 / l.variance).sqrt()).collect(),
    };
    let turn = (1.0 - damping_ratio * damping_ratio).sqrt();
    let pole = |hz: &f64| C64::new(-damping_ratio, turn) * (hz / highest_hz);
    let poles: Vec<C64> = begin_hz.iter().map(pole).collect();
    let search = LevenbergMarquardt::new().with_tol(1e-9);
    let (solved, _) = search.minimize(with_residues(&lines, &poles));
    let mut found_hz: Vec<f64> =
        (0..poles.len()).map(|k| solved.x[2 * k + 1].max(0.0).sqrt() * highest_hz).collect();
    found_hz.sort_by(f64::total_cmp);
    found_hz
}
