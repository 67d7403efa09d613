//! What cannot be fitted is refused.

use crate::frf::Line;

/// Why an input is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InputError {
    /// Too few values.
    #[error("{found} values, at least {least} are needed: measure more")]
    TooFew {
        /// Values given.
        found: usize,
        /// Least number.
        least: usize,
    },
    /// Two arrays that belong together differ in length.
    #[error("expected {expected} values as in the other array, found {found}")]
    Length {
        /// Length of the first.
        expected: usize,
        /// Length of the second.
        found: usize,
    },
    /// A number that is none, or below zero where that means nothing.
    #[error("value {index} is not a finite number in its range")]
    NotFinite {
        /// Index of the value.
        index: usize,
    },
    /// Not in ascending order.
    #[error("value {index} does not ascend: sort the values and keep each once")]
    NotAscending {
        /// Index of the value.
        index: usize,
    },
    /// Some lines exact, some not.
    #[error("line {index} has variance 0 and others do not: either all lines must be exact or none")]
    MixedVariance {
        /// First line of variance 0.
        index: usize,
    },
    /// A setting outside its range.
    #[error("setting {name} is {found}: expected {expected}")]
    Setting {
        /// Which.
        name: &'static str,
        /// Given.
        found: f64,
        /// What it must be.
        expected: &'static str,
    },
}

/// Lines that can be fitted: finite, not 0, ascending from above 0 Hz, all exact or none.
pub(crate) fn check_lines(lines: &[Line], least: usize) -> Result<(), InputError> {
    if lines.len() < least {
        return Err(InputError::TooFew { found: lines.len(), least });
    }
    let bad = |l: &Line| {
        let size = l.value.norm();
        let given = l.frequency_hz.is_finite() && size.is_finite() && l.variance.is_finite();
        !(given && size > 0.0 && l.variance >= 0.0 && l.dof >= 0.0)
    };
    if let Some(index) = lines.iter().position(bad) {
        return Err(InputError::NotFinite { index });
    }
    let mut before = 0.0;
    for (index, line) in lines.iter().enumerate() {
        if line.frequency_hz <= before {
            return Err(InputError::NotAscending { index });
        }
        before = line.frequency_hz;
    }
    match lines.iter().position(|l| l.variance <= 0.0) {
        Some(index) if lines.iter().any(|l| l.variance > 0.0) => Err(InputError::MixedVariance { index }),
        _ => Ok(()),
    }
}

/// Finite values, as many as expected.
pub(super) fn check_values(values: &[f64], expected: usize) -> Result<(), InputError> {
    if values.len() != expected {
        return Err(InputError::Length { expected, found: values.len() });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(InputError::NotFinite { index }),
        None => Ok(()),
    }
}

/// Standard deviation of the real and of the imaginary part of a line; its size if it is exact (equal relative weights).
pub(crate) fn line_sd(line: &Line) -> f64 {
    if line.variance > 0.0 { (0.5 * line.variance).sqrt() } else { line.value.norm() }
}
