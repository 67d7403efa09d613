//! Numbers of answers.

/// A number with an exponent (NR3: IEEE 488.2, 8.7.4) as Keysight instruments write it: sign, one digit, `places` more, and an
/// exponent of a sign and two digits or more, `+2.40000000E+01`.
pub(crate) fn nr3(value: f64, places: usize) -> String {
    let text = format!("{value:+.places$E}");
    let Some((mantissa, exponent)) = text.split_once('E') else { return text };
    let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
    format!("{mantissa}E{sign}{digits:0>2}")
}

#[cfg(test)]
mod tests {
    use super::nr3;

    #[test]
    fn exponents_have_a_sign_and_two_digits() {
        assert_eq!(nr3(24.0, 8), "+2.40000000E+01");
        assert_eq!(nr3(-1.5e-3, 3), "-1.500E-03");
        assert_eq!(nr3(0.0, 2), "+0.00E+00");
        assert_eq!(nr3(9.9e37, 1), "+9.9E+37");
        assert_eq!(nr3(1e-100, 0), "+1E-100");
    }
}
