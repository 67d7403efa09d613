//! Numbers on paper: an uncertainty has two significant digits, its value ends at the same place.
//!
//! Source: JCGM 100:2008 7.2.6. SI numbers come in; [`Shown`] says in which unit they go out.

mod shown;

pub(crate) use shown::Shown;

/// Digits after the decimal point that show `u` with two significant digits; negative from 100 up.
fn places(u: f64) -> i32 {
    let magnitude = u.abs();
    let mut places = 1 - magnitude.log10().floor() as i32;
    // 0.0996 has its second digit one place higher once it is rounded to 0.10.
    if (magnitude * 10f64.powi(places)).round() >= 100.0 {
        places -= 1;
    }
    places
}

/// `value` rounded to `places` digits after the point; negative places round to tens, hundreds, …
fn fixed(value: f64, places: i32) -> String {
    let text = if places >= 0 {
        format!("{value:.*}", places as usize)
    } else {
        let unit = 10f64.powi(-places);
        format!("{:.0}", (value / unit).round() * unit)
    };
    unsigned_zero(text)
}

fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// `value` with `digits` significant digits, trailing zeros kept.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "—".to_owned() };
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-5..=6).contains(&exponent) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    fixed(value, digits - 1 - exponent)
}

/// `value` with at most `digits` significant digits and no trailing zeros.
pub(crate) fn short(value: f64, digits: i32) -> String {
    let text = significant(value, digits);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A whole number in groups of three digits, thin spaces between.
pub(crate) fn grouped<N: std::fmt::Display>(number: N) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

/// A value and its uncertainty, in whatever unit both have, to the place of the uncertainty's second digit.
pub(crate) fn pair(value: f64, u: f64) -> (String, String) {
    if !(u.is_finite() && u > 0.0 && value.is_finite()) {
        return (significant(value, 4), if u == 0.0 { "0".to_owned() } else { "—".to_owned() });
    }
    let places = places(u);
    if places > 9 || value.abs().max(u) >= 1e7 {
        let digits = (value.abs().max(u).log10().floor() as i32 + places).clamp(0, 12);
        return (format!("{value:.*e}", digits as usize), format!("{u:.1e}"));
    }
    (fixed(value, places), fixed(u, places))
}

/// A probability or ratio in per cent with two significant digits; never rounded to a certainty.
pub(crate) fn percent(ratio: f64) -> String {
    let percent = ratio * 100.0;
    match percent {
        p if p < 0.001 => "< 0.001 %".to_owned(),
        p if p > 99.99 => "> 99.99 %".to_owned(),
        p if p > 99.0 => format!("{p:.2} %"),
        p => format!("{} %", short(p, 2)),
    }
}

/// Signs of print for a text of numbers and units: `-1.5 N*m/deg^2` becomes `−1.5 N·m/°²`, `2e-5` becomes `2·10⁻⁵`.
///
/// Only for texts of names, numbers and units, not for prose. Hyphens in names stay.
pub(crate) fn typeset(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let after_number = out.ends_with(|p: char| p.is_numeric());
        let after_name = out.ends_with(|p: char| p.is_alphanumeric());
        let word_end = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
        if let Some((exponent, length)) = exponent(rest).filter(|_| after_number) {
            out.push_str("·10");
            out.extend(exponent.chars().map(superscript));
            rest = &rest[length..];
        } else if word_end > 0 {
            out.push_str(word(&rest[..word_end]));
            rest = &rest[word_end..];
        } else {
            let number_follows = rest[c.len_utf8()..].starts_with(|n: char| n.is_ascii_digit() || n == '.');
            match c {
                '*' => out.push('·'),
                // A number and its unit stay on one line.
                ' ' if after_number && unit_follows(&rest[1..]) => out.push('\u{a0}'),
                '-' if number_follows && !after_name => out.push('−'),
                _ => out.push(c),
            }
            rest = &rest[c.len_utf8()..];
        }
    }
    out.replace("<=", "≤").replace(">=", "≥").replace("^2", "²").replace("^3", "³").replace(" .. ", " … ")
}

fn unit_follows(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '%' || c == '°')
}

/// The exponent of `e-12…` and its length with the `e`.
fn exponent(text: &str) -> Option<(&str, usize)> {
    let digits = text.strip_prefix('e')?;
    let sign = usize::from(digits.starts_with('-'));
    let end = digits[sign..].find(|c: char| !c.is_ascii_digit()).map_or(digits.len(), |e| e + sign);
    let word_goes_on = digits[end..].starts_with(char::is_alphabetic);
    (end > sign && !word_goes_on).then_some((&digits[..end], end + 1))
}

fn superscript(c: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize])
}

fn word(word: &str) -> &str {
    match word {
        "deg" => "°",
        "degC" => "°C",
        "urad" => "µrad",
        "us" => "µs",
        "ohm" => "Ω",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uncertainty_has_two_digits_and_its_value_ends_there() {
        let table = [
            ((212.3456, 4.123), ("212.3", "4.1")),
            ((212.3456, 0.0996), ("212.35", "0.10")),
            ((0.0512345, 0.0021), ("0.0512", "0.0021")),
            ((12345.0, 234.0), ("12350", "230")),
            ((12345.0, 996.0), ("12300", "1000")),
            ((-0.02, 1.3), ("0.0", "1.3")),
            ((-3.26, 1.3), ("-3.3", "1.3")),
            ((5.0, 0.0), ("5.000", "0")),
            ((1.2346e-12, 2.3e-14), ("1.235e-12", "2.3e-14")),
        ];
        for ((value, u), (text, u_text)) in table {
            assert_eq!(pair(value, u), (text.to_owned(), u_text.to_owned()), "{value} ± {u}");
        }
    }

    #[test]
    fn short_numbers_drop_zeros_but_not_digits() {
        let texts: Vec<String> =
            [10.0, 0.05, 60.0001, -200.0, 9.998, 0.0, 1234567.0, 1e-9].iter().map(|&v| short(v, 4)).collect();
        assert_eq!(texts, ["10", "0.05", "60", "-200", "9.998", "0", "1235000", "1.000e-9"]);
    }

    #[test]
    fn a_probability_is_never_printed_as_certain() {
        assert_eq!(percent(0.0668), "6.7 %");
        assert_eq!(percent(1e-9), "< 0.001 %");
        assert_eq!(percent(0.99999), "> 99.99 %");
        assert_eq!(percent(0.994), "99.40 %");
        assert_eq!(percent(0.5), "50 %");
    }

    #[test]
    fn units_are_typeset_and_words_are_left_alone() {
        assert_eq!(typeset("≤ 260 N*m"), "≤ 260\u{a0}N·m");
        assert_eq!(typeset("<= -10 deg .. 90 deg"), "≤ −10\u{a0}° … 90\u{a0}°");
        assert_eq!(typeset("90 deg/s^2, 60 degC"), "90\u{a0}°/s², 60\u{a0}°C");
        assert_eq!(
            typeset("FRC-AZ < 75 urad, heat-sink -3 degC"),
            "FRC-AZ < 75\u{a0}µrad, heat-sink −3\u{a0}°C"
        );
        assert_eq!(typeset("1.5e-12 rad, -2e7"), "1.5·10⁻¹²\u{a0}rad, −2·10⁷");
        assert_eq!(typeset("degraded 3e 5east"), "degraded 3e 5east");
    }
}
