//! Complex numbers, as far as frequency responses need them.

use core::ops::{Add, Div, Mul, Sub};

/// `re + j im`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// One.
    pub const ONE: Self = Self::real(1.0);

    /// `re + j im`.
    pub const fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// A real number.
    pub const fn real(re: f64) -> Self {
        Self { re, im: 0.0 }
    }

    /// `e^{jφ}`.
    pub fn unit(phase_rad: f64) -> Self {
        Self { re: libm::cos(phase_rad), im: libm::sin(phase_rad) }
    }

    /// Absolute value.
    pub fn magnitude(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// Argument, −π … π.
    pub fn phase_rad(self) -> f64 {
        libm::atan2(self.im, self.re)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)
    }
}

impl Mul<f64> for Complex {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }
}

impl Div for Complex {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        self * Self::new(other.re / square, -other.im / square)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

    use super::*;

    #[test]
    fn arithmetic_follows_the_field() {
        let a = Complex::new(3.0, -2.0);
        let b = Complex::new(-1.0, 4.0);
        assert_eq!(a + b, Complex::new(2.0, 2.0));
        assert_eq!(a - b, Complex::new(4.0, -6.0));
        assert_eq!(a * b, Complex::new(5.0, 14.0));
        assert!((a * b / b - a).magnitude() < 1e-15);
        assert_eq!(a * 2.0, a * Complex::real(2.0));
    }

    #[test]
    fn polar_form_is_that_of_the_plane() {
        let diagonal = Complex::new(1.0, 1.0);
        assert!((diagonal.magnitude() - SQRT_2).abs() < 1e-15);
        assert!((diagonal.phase_rad() - FRAC_PI_4).abs() < 1e-15);
        assert!((Complex::unit(FRAC_PI_2) - Complex::new(0.0, 1.0)).magnitude() < 1e-15);
        assert!((Complex::ONE / Complex::unit(0.3) - Complex::unit(-0.3)).magnitude() < 1e-15);
    }
}
