//! Periodic excitation with flat lines and low crest.

use num_complex::Complex64;

/// One period of a multisine, and the spectrum of records of the same length.
#[derive(Clone, Debug)]
pub struct Multisine {
    samples: Vec<f64>,
    /// Line numbers: multiples of one per period.
    lines: Vec<usize>,
    rate_hz: f64,
}

impl Multisine {
    /// Lines from `from_hz` to `to_hz`, at most one per `spacing_hz` and not closer than 1 % of their frequency, in a
    /// period of `length_s` sampled at `rate_hz`; every sample stays below `peak` (phases by Schroeder 1970).
    pub fn new(from_hz: f64, to_hz: f64, length_s: f64, rate_hz: f64, peak: f64) -> Self {
        let length = (length_s * rate_hz).round() as usize;
        let mut lines: Vec<usize> = Vec::new();
        for line in (from_hz * length_s).round() as usize..=(to_hz * length_s).round() as usize {
            let sparse = lines.last().is_none_or(|last| line - last >= line.div_ceil(100));
            if sparse {
                lines.push(line);
            }
        }
        let mut spectrum = vec![Complex64::default(); length / 2 + 1];
        let mut phase = 0.0;
        let mut before = 0;
        for (k, line) in lines.iter().enumerate() {
            // Group delay grows with the power that lies below: the lines take turns over the period.
            phase -= std::f64::consts::TAU * (line - before) as f64 * k as f64 / lines.len() as f64;
            before = *line;
            spectrum[*line] = Complex64::from_polar(1.0, phase);
        }
        let mut samples = vec![0.0; length];
        let inverse = fourier::inverse(length);
        inverse.process(&mut spectrum, &mut samples).expect("lengths agree, and DC has no imaginary part");
        let highest = samples.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
        samples.iter_mut().for_each(|x| *x *= peak / highest);
        Self { samples, lines, rate_hz }
    }

    /// Value at a sample, the period repeated.
    pub fn at(&self, sample: usize) -> f64 {
        self.samples[sample % self.samples.len()]
    }

    /// Samples of a period.
    pub fn period(&self) -> usize {
        self.samples.len()
    }

    /// Frequencies of the lines.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.lines.iter().map(|line| *line as f64 * self.rate_hz / self.samples.len() as f64).collect()
    }

    /// Spectrum of one period of a record at the lines.
    pub fn spectrum(&self, record: &[f64]) -> Vec<Complex64> {
        let mut input = record.to_vec();
        let mut output = vec![Complex64::default(); record.len() / 2 + 1];
        let forward = fourier::forward(record.len());
        forward.process(&mut input, &mut output).expect("lengths agree");
        self.lines.iter().map(|line| output[*line]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_equally_strong_and_the_peak_is_kept() {
        let signal = Multisine::new(0.5, 60.0, 10.0, 4000.0, 0.01);
        let record: Vec<f64> = (0..signal.period()).map(|k| signal.at(k + 7 * signal.period())).collect();
        let lines = signal.spectrum(&record);
        assert!(lines.iter().all(|line| (line.norm() / lines[0].norm() - 1.0).abs() < 1e-9));
        let highest = record.iter().fold(0.0_f64, |top, x| top.max(x.abs()));
        assert!((highest - 0.01).abs() < 1e-12);
        let sum: f64 = record.iter().map(|x| x * x).sum();
        let crest = highest / (sum / record.len() as f64).sqrt();
        assert!(crest < 4.0, "crest factor {crest}, a Gaussian record of this length has 4.4");
    }
}
