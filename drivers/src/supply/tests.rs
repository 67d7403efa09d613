use super::*;
use crate::scpi::tests::{Far, format_error};

fn settings() -> SupplySettings {
    SupplySettings {
        name: "supply".to_owned(),
        output: 2,
        set_points: SetPoints::default(),
        writes_set_points: false,
        period_s: 0.1,
        reply_timeout_s: 0.05,
    }
}

const IDENTITY: &[u8] = b"Keysight Technologies,E36312A,MY00000001,1.0.4\n";

/// Opens a supply that gives these answers: the driver, or the error.
fn opened(settings: SupplySettings, far: &mut Far) -> Result<Supply, DeviceError> {
    let mut supply = Supply::new(settings)?;
    for ms in 0..1000 {
        if supply.open(far, Duration::from_millis(ms))?.is_some() {
            return Ok(supply);
        }
    }
    panic!("it neither opens nor gives up")
}

fn after_identity(answers: &[&[u8]]) -> Far {
    Far::answering(&[&[IDENTITY], answers].concat())
}

#[test]
fn a_reading_asks_one_output_for_everything_and_waits_for_each_answer() {
    let mut far =
        after_identity(&[b"+2.40012345E+01\n", b"+1.25000000E+00\n", b"1\n", b"+2\n", b"0\n", b"0\n"]);
    let mut supply = opened(settings(), &mut far).expect("no set points to compare");
    assert_eq!(supply.reading(), None);
    far.heard.clear();
    let now = Duration::from_secs(1);
    assert_eq!(supply.poll(&mut far, now), Ok(true));
    let expected = Reading {
        voltage_v: 24.0012345,
        current_a: 1.25,
        is_on: true,
        regulation: Regulation::Voltage,
        over_voltage: false,
        over_current: false,
    };
    assert_eq!(supply.reading(), Some(&expected));
    let asked: Vec<&String> = far.heard.iter().step_by(2).collect();
    let queries = [
        ":MEAS:VOLT? (@2)",
        ":MEAS:CURR? (@2)",
        ":OUTP? (@2)",
        ":STAT:QUES:INST:ISUM2:COND?",
        ":VOLT:PROT:TRIP? (@2)",
        ":CURR:PROT:TRIP? (@2)",
    ];
    assert_eq!(asked, queries);
    assert!(far.heard.iter().skip(1).step_by(2).all(|heard| heard == ":SYST:ERR?"), "{:?}", far.heard);
    assert_eq!(supply.poll(&mut far, now + Duration::from_millis(50)), Ok(false), "not due yet");
    let [voltage_v, current_a, age_s, readings, is_on, regulation, ..] = supply.row();
    assert_eq!([voltage_v, current_a, readings, is_on, regulation], [24.0012345, 1.25, 1.0, 1.0, 1.0]);
    assert!((age_s - 0.05).abs() < 1e-9, "{age_s}");
}

#[test]
fn the_condition_register_tells_what_is_regulated() {
    let all = [0.0, 1.0, 2.0, 3.0, 514.0].map(regulation);
    use Regulation::{Current, Off, Unregulated, Voltage};
    assert_eq!(all, [Off, Current, Voltage, Unregulated, Voltage]);
}

#[test]
fn set_points_that_differ_are_refused_with_both_values() {
    let set_points = SetPoints { voltage_v: Some(24.0), current_limit_a: Some(2.0), over_voltage_v: None };
    let agreed = after_identity(&[b"+2.40010000E+01\n", b"+2.00000000E+00\n"]);
    let wanted = SupplySettings { set_points, ..settings() };
    assert!(opened(wanted.clone(), &mut { agreed }).is_ok());
    let mut far = after_identity(&[b"+2.40000000E+01\n", b"+5.00000000E-01\n"]);
    let text = opened(wanted, &mut far).expect_err("another limit").to_string();
    let expected = "supply, output 2: current limit: expected 2 A, found 0.5 A; set it at the instrument, or correct the rig file";
    assert_eq!(text, expected);
    assert!(far.heard.iter().all(|heard| heard.starts_with('*') || heard.contains('?')), "nothing was set");
}

#[test]
fn set_points_are_written_while_the_output_is_off_and_read_back() {
    let set_points = SetPoints { voltage_v: Some(24.0), over_voltage_v: Some(26.5), ..SetPoints::default() };
    let wanted = SupplySettings { set_points, writes_set_points: true, ..settings() };
    let mut far = after_identity(&[b"0\n", b"1\n", b"+2.40000000E+01\n", b"+2.65000000E+01\n"]);
    opened(wanted.clone(), &mut far).expect("it takes them");
    let told: Vec<&str> =
        far.heard.iter().map(String::as_str).filter(|heard| *heard != ":SYST:ERR?").collect();
    let expected = [
        "*CLS",
        "*IDN?",
        ":OUTP? (@2)",
        ":VOLT 24,(@2)",
        ":VOLT:PROT 26.5,(@2)",
        "*OPC?",
        ":VOLT? (@2)",
        ":VOLT:PROT? (@2)",
    ];
    assert_eq!(told, expected);
    let mut on = after_identity(&[b"1\n"]);
    let text = opened(wanted, &mut on).expect_err("it is on").to_string();
    assert!(text.contains("output: expected off") && text.contains("found on"), "{text}");
    assert!(!on.heard.iter().any(|heard| heard.starts_with(":VOLT")), "{:?}", on.heard);
}

#[test]
fn another_model_and_settings_that_cannot_be_are_refused() {
    let mut far = Far::answering(&[b"Keysight Technologies,E36103B,MY1,1.0\n"]);
    let text = opened(settings(), &mut far).expect_err("a single output").to_string();
    assert!(text.contains("E36312A") && text.contains("E36103B"), "{text}");
    for (wrong, setting) in [
        (SupplySettings { output: 4, ..settings() }, "output"),
        (SupplySettings { period_s: f64::NAN, ..settings() }, "period_s"),
        (SupplySettings { reply_timeout_s: 0.0, ..settings() }, "reply_timeout_s"),
        (
            SupplySettings {
                set_points: SetPoints { voltage_v: Some(-24.0), ..SetPoints::default() },
                ..settings()
            },
            "voltage_v",
        ),
    ] {
        let text = Supply::new(wrong).expect_err(setting).to_string();
        assert!(text.contains(setting), "{text}");
    }
}

#[test]
fn silence_and_text_that_is_no_number_are_errors_and_the_next_reading_begins_anew() {
    let mut far = after_identity(&[b"volts\n"]);
    let mut supply = opened(settings(), &mut far).expect("it opens");
    let error = supply.poll(&mut far, Duration::from_secs(1));
    assert!(matches!(format_error(error), FormatError::NotANumber { .. }));
    far.is_dead = true;
    let mut at = Duration::from_secs(2);
    let error = loop {
        match supply.poll(&mut far, at) {
            Ok(_) => at += Duration::from_millis(1),
            Err(error) => break error.to_string(),
        }
    };
    assert!(error.contains("answer: expected a whole one to :MEAS:VOLT? (@2), found none within"), "{error}");
    assert!(at < Duration::from_millis(2110), "{at:?}");
}
