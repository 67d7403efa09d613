use proptest::prelude::*;

use super::QuantityKind as K;
use super::*;

fn message(kind: K, text: &str) -> String {
    let error = kind.parse(text).expect_err("the text is wrong");
    match error.help() {
        Some(help) => format!("{error} | {help}"),
        None => error.to_string(),
    }
}

#[test]
fn every_documented_spelling_gives_its_si_value() {
    let degree = std::f64::consts::PI / 180.0;
    let table: &[(K, &str, f64)] = &[
        (K::Angle, "180 deg", std::f64::consts::PI),
        (K::Angle, "5 µrad", 5e-6),
        (K::Angle, "5 μrad", 5e-6),
        (K::Angle, "5 urad", 5e-6),
        (K::Angle, "1 mrad", 1e-3),
        (K::Angle, "3600 arcsec", degree),
        (K::Angle, "−10°", -10.0 * degree),
        (K::AngularVelocity, "0.1 deg/s", 0.1 * degree),
        (K::AngularVelocity, "2°/s", 2.0 * degree),
        (K::AngularVelocity, "60 rpm", std::f64::consts::TAU),
        (K::AngularAcceleration, "90 deg/s^2", 90.0 * degree),
        (K::AngularAcceleration, "90 deg/s2", 90.0 * degree),
        (K::AngularAcceleration, "90 °/s²", 90.0 * degree),
        (K::AngularJerk, "1 rad/s³", 1.0),
        (K::Torque, "45 N*m", 45.0),
        (K::Torque, "45Nm", 45.0),
        (K::Torque, "45 N·m", 45.0),
        (K::Torque, "45 N m", 45.0),
        (K::Torque, "2.5 kN*m", 2500.0),
        (K::TorqueRate, "6 N*m/s", 6.0),
        (K::Current, "250 mA", 0.25),
        (K::CurrentRate, "0.01 A/s", 0.01),
        (K::TorqueConstant, "60 Nm/A", 60.0),
        (K::Stiffness, "9e4 N*m/rad", 9e4),
        (K::Damping, "273.6 Nm*s/rad", 273.6),
        (K::Damping, "273.6 N m s/rad", 273.6),
        (K::Inertia, "1200 kg·m²", 1200.0),
        (K::Inertia, "1200 kg m2", 1200.0),
        (K::Time, "5 ms", 0.005),
        (K::Time, "5 µs", 5e-6),
        (K::Time, "2 min", 120.0),
        (K::Time, "1 h", 3600.0),
        (K::Frequency, "4 kHz", 4000.0),
        (K::SpatialOrder, "144 1/rev", 144.0),
        (K::Gain, "4.5 1/s", 4.5),
        (K::Temperature, "60 °C", 60.0),
        (K::Temperature, "60 degC", 60.0),
        (K::Voltage, "560 V", 560.0),
        (K::Power, "6.7 kW", 6700.0),
        (K::Length, "630 mm", 0.63),
        (K::Ratio, "0.1 %", 0.001),
        (K::Ratio, "3 ppm", 3e-6),
        (K::Ratio, "0.5", 0.5),
        (K::Decibel, "-3 dB", -3.0),
        (K::Count, "17", 17.0),
        (K::AngleRandomWalk, "0.6 deg/√h", 0.01 * degree),
        (K::AngleRandomWalk, "0.6 deg/sqrt(h)", 0.01 * degree),
    ];
    for (kind, text, si) in table {
        let parsed = kind.parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert!((parsed - si).abs() <= 1e-15 * si.abs(), "{text} gives {parsed}, not {si}");
    }
}

#[test]
fn a_unit_of_another_kind_names_both_kinds_even_where_dimensions_agree() {
    insta::assert_snapshot!(
        message(K::AngularVelocity, "10 Hz"),
        @"expected an angular velocity such as `10 deg/s`, found `10 Hz`, a frequency"
    );
    insta::assert_snapshot!(
        message(K::Gain, "10 Hz"),
        @"expected a gain such as `4.5 1/s`, found `10 Hz`, a frequency"
    );
    insta::assert_snapshot!(
        message(K::Ratio, "3 dB"),
        @"expected a ratio such as `5 %`, found `3 dB`, a ratio in decibels"
    );
}

#[test]
fn wrong_texts_say_what_was_expected_and_what_to_do() {
    insta::assert_snapshot!(
        message(K::AngularVelocity, "10"),
        @"expected an angular velocity such as `10 deg/s`, found `10` without a unit | write the unit: `10 deg/s`"
    );
    insta::assert_snapshot!(
        message(K::AngularVelocity, "10 deg/sec"),
        @"unknown unit `deg/sec`: expected an angular velocity such as `10 deg/s` | did you mean `deg/s`?"
    );
    insta::assert_snapshot!(
        message(K::Time, "5 m s"),
        @"unknown unit `m s`: expected a time such as `5 s` | did you mean `ms`?"
    );
    insta::assert_snapshot!(message(K::Torque, "lots"), @"expected a torque such as `45 N*m`, found `lots`");
    insta::assert_snapshot!(message(K::Torque, ""), @"expected a torque such as `45 N*m`, found ``");
    insta::assert_snapshot!(message(K::Torque, "1e400 N*m"), @"`1e400 N*m` is too large a number");
    insta::assert_snapshot!(message(K::Torque, "1e307 kN*m"), @"`1e307 kN*m` is too large a number");
}

#[test]
fn not_a_number_and_infinity_are_not_numbers() {
    for text in
        ["nan N*m", "inf N*m", "-inf N*m", "NaN", "infinity N*m", ".5 N*m", "0x10 N*m", "1_0 N*m", "--1 N*m"]
    {
        assert!(K::Torque.parse(text).is_err(), "{text}");
    }
}

#[test]
fn a_range_takes_the_unit_of_its_upper_end_and_must_ascend() {
    let [low, high] = K::Angle.parse_range("-10 .. 90 deg").expect("a range");
    assert_eq!([low, high], K::Angle.parse_range("-10 deg .. 90 deg").expect("a range"));
    assert!((low + 10f64.to_radians()).abs() < 1e-15 && (high - 90f64.to_radians()).abs() < 1e-15);
    assert_eq!(K::SpatialOrder.parse_range("143.5..144.5 1/rev"), Ok([143.5, 144.5]));
    assert_eq!(K::Angle.parse_range("500 mrad .. 1 rad"), Ok([0.5, 1.0]));
    let error = |text| K::Angle.parse_range(text).expect_err("a wrong range").to_string();
    insta::assert_snapshot!(
        error("90 deg .. -10 deg"),
        @"the range `90 deg .. -10 deg` is empty: write the lower end first; it must be below the upper end"
    );
    insta::assert_snapshot!(error("10 deg"), @"expected a range such as `0 .. 10 deg`, found `10 deg`");
    insta::assert_snapshot!(
        error("1 Hz .. 90 deg"),
        @"expected an angle such as `10 deg`, found `1 Hz`, a frequency"
    );
}

#[test]
fn limits_know_their_comparator_and_hold_or_not_at_the_bound() {
    let limit = |text| K::Torque.parse_limit(text).expect("a limit");
    for (text, comparator, at_bound) in [
        ("<= 45 N*m", Comparator::AtMost, true),
        ("≤ 45 N*m", Comparator::AtMost, true),
        ("< 45 N*m", Comparator::Less, false),
        (">= 45 N*m", Comparator::AtLeast, true),
        ("≥45 N*m", Comparator::AtLeast, true),
        ("> 45 N*m", Comparator::Greater, false),
        ("45 .. 46 N*m", Comparator::Within, true),
    ] {
        assert_eq!((limit(text).comparator, limit(text).holds(45.0)), (comparator, at_bound), "{text}");
        assert!(!limit(text).holds(f64::NAN), "{text}");
    }
    assert!(limit("45 .. 46 N*m").holds(46.0) && !limit("45 .. 46 N*m").holds(46.1));
    assert_eq!(limit(" ≤ 45 N*m ").text, "≤ 45 N*m");
    let error = K::Torque.parse_limit("45 N*m").expect_err("no comparator");
    insta::assert_snapshot!(error, @"expected a limit such as `<= 45 N*m` or `0 .. 45 N*m`, found `45 N*m`");
}

#[test]
fn printed_values_are_short_and_round() {
    assert_eq!(K::AngularVelocity.format(10f64.to_radians()), "10 deg/s");
    assert_eq!(K::Angle.format(-160f64.to_radians()), "-160 deg");
    assert_eq!(K::Torque.format(0.1 + 0.2), "0.3 N*m");
    assert_eq!(K::Torque.format(-0.0), "0 N*m");
    assert_eq!(K::Torque.format(123_456_789.0), "123456789 N*m");
    assert_eq!(K::Torque.format(1.5e12), "1.5e12 N*m");
    assert_eq!(K::Torque.format(1.25e-9), "1.25e-9 N*m");
    assert_eq!(K::Ratio.format(0.05), "5 %");
    assert_eq!(K::Count.format(17.0), "17");
}

#[test]
fn every_kind_has_its_units_and_its_example_parses() {
    for kind in K::ALL {
        assert!(kind.parse(kind.example()).is_ok(), "{kind:?}");
        assert!(kind.parse_range(&kind.range_example()).is_ok(), "{kind:?}");
        assert!((kind.to_display(kind.parse(kind.example()).expect("parses"))).is_finite());
        assert!(unit::of_kind(kind).any(|u| u.symbol == kind.display_unit()), "{kind:?}");
        let si = if kind.si_unit() == "1" { "" } else { kind.si_unit() };
        assert!(unit::of_kind(kind).any(|u| u.symbol == si && u.factor == 1.0), "{kind:?}");
    }
}

proptest! {
    #[test]
    fn what_is_printed_reads_back(index in 0usize..24, mantissa in -9.999f64..9.999, exponent in -12i32..12) {
        let kind = K::ALL[index];
        let si = mantissa * 10f64.powi(exponent);
        let back = kind.parse(&kind.format(si)).expect("printed text parses");
        prop_assert!((back - si).abs() <= 1e-5 * si.abs(), "{} gave {back}, not {si}", kind.format(si));
    }

    #[test]
    fn no_text_makes_the_parser_panic(index in 0usize..24, text in "\\PC*|[-+0-9.eE <>=µ°²N*m/]{0,24}") {
        let kind = K::ALL[index];
        for value in kind.parse(&text).into_iter().chain(kind.parse_range(&text).into_iter().flatten()) {
            prop_assert!(value.is_finite());
        }
        if let Err(error) = kind.parse_limit(&text) {
            prop_assert!(!error.to_string().is_empty());
            let _ = error.help();
        }
    }

    #[test]
    fn every_unit_reads_with_its_factor(si in -1e6f64..1e6) {
        for kind in K::ALL {
            for unit in unit::of_kind(kind) {
                let text = format!("{si} {}", unit.symbol);
                let read = kind.parse(&text).expect("own unit");
                prop_assert!((read - si * unit.factor).abs() <= 1e-12 * read.abs(), "{text}");
            }
        }
    }
}
