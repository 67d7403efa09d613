use super::*;

fn supply() -> Supply {
    let address = SeedAddress { seed: 1, procedure: "test".to_owned(), point: String::new() };
    Supply::new(&InstrumentsSettings::default(), &address)
}

/// Sends a message at a time and takes the answer half a second later.
fn say(supply: &mut Supply, at_s: f64, message: &str) -> String {
    let at = Duration::from_secs_f64(at_s);
    supply.receive(at, format!("{message}\n").as_bytes());
    let mut into = [0; 256];
    let count = supply.take(at + Duration::from_millis(500), &mut into);
    String::from_utf8_lossy(&into[..count]).trim_end().to_owned()
}

fn number(supply: &mut Supply, at_s: f64, message: &str) -> f64 {
    let text = say(supply, at_s, message);
    text.parse().unwrap_or_else(|_| panic!("{message}: {text}"))
}

fn near(value: f64, expected: f64, within: f64) {
    assert!((value - expected).abs() <= within, "{value}, expected {expected}");
}

#[test]
fn it_stands_as_somebody_left_it_and_feeds_its_load() {
    let mut supply = supply();
    assert_eq!(say(&mut supply, 0.0, "*IDN?"), "Simulated,E36313A-SIM,SIM0003,1.0");
    assert_eq!(say(&mut supply, 1.0, "OUTP? (@1:3)"), "0,1,1");
    near(number(&mut supply, 2.0, "MEAS:VOLT? (@2)"), 24.0, 0.003);
    // 24 V at 24 ohm.
    near(number(&mut supply, 3.0, "MEAS:CURR? (@2)"), 1.0, 0.002);
    assert_eq!(say(&mut supply, 4.0, "STAT:QUES:INST:ISUM2:COND?"), "+2");
    assert_eq!(say(&mut supply, 5.0, "VOLT? (@2)"), "+2.40000000E+01");
    assert_eq!(say(&mut supply, 6.0, "SYST:ERR?"), "+0,\"No error\"");
}

#[test]
fn a_set_point_is_reached_within_50_ms_and_not_at_once() {
    let mut supply = supply();
    say(&mut supply, 0.0, "APPL CH1,5,1;:OUTP ON,(@1)");
    let after = |supply: &mut Supply, ms: f64| number(supply, ms * 1e-3, "MEAS:VOLT? (@1)");
    near(after(&mut supply, 10.0), 5.0 * (1.0 - (-1.0_f64).exp()), 0.003);
    near(after(&mut supply, 50.0), 5.0, 0.05);
    near(after(&mut supply, 200.0), 5.0, 0.003);
}

#[test]
fn a_load_that_takes_more_than_the_limit_is_fed_with_constant_current() {
    let mut supply = supply();
    supply.load(Duration::ZERO, 1, 6.0);
    near(number(&mut supply, 1.0, "MEAS:CURR? (@2)"), 2.0, 0.002);
    near(number(&mut supply, 2.0, "MEAS:VOLT? (@2)"), 12.0, 0.003);
    assert_eq!(say(&mut supply, 3.0, "STAT:QUES:INST:ISUM2:COND?"), "+1");
    supply.load(Duration::from_secs(4), 1, 48.0);
    assert_eq!(say(&mut supply, 5.0, "STAT:QUES:INST:ISUM2:COND?"), "+2");
    near(number(&mut supply, 6.0, "MEAS:CURR? (@2)"), 0.5, 0.002);
}

#[test]
fn over_voltage_trips_where_the_voltage_crosses_its_level_and_stays_until_it_is_cleared() {
    let mut supply = supply();
    say(&mut supply, 0.0, "VOLT:PROT 20,(@2)");
    assert_eq!(say(&mut supply, 0.001, "VOLT:PROT:TRIP? (@2)"), "1");
    assert_eq!(say(&mut supply, 1.0, "OUTP? (@2)"), "0");
    near(number(&mut supply, 2.0, "MEAS:VOLT? (@2)"), 0.0, 0.003);
    say(&mut supply, 3.0, "VOLT 18,(@2);:OUTP ON,(@2)");
    assert_eq!(say(&mut supply, 4.0, "VOLT:PROT:TRIP? (@2)"), "1", "switching on clears nothing");
    say(&mut supply, 5.0, "VOLT:PROT:CLE (@2)");
    near(number(&mut supply, 6.0, "MEAS:VOLT? (@2)"), 18.0, 0.003);
    say(&mut supply, 7.0, "VOLT 24,(@2)");
    // 18 V to 24 V crosses 20 V after 4 ms.
    assert_eq!(say(&mut supply, 7.003, "VOLT:PROT:TRIP? (@2)"), "0");
    assert_eq!(say(&mut supply, 7.006, "VOLT:PROT:TRIP? (@2)"), "1");
}

#[test]
fn over_current_trips_after_its_delay_and_only_where_it_is_watched() {
    let mut supply = supply();
    supply.load(Duration::ZERO, 1, 6.0);
    assert_eq!(say(&mut supply, 1.0, "CURR:PROT:TRIP? (@2)"), "0");
    supply.load(Duration::from_secs(2), 1, 48.0);
    say(&mut supply, 2.0, "CURR:PROT:STAT ON,(@2)");
    supply.load(Duration::from_secs(3), 1, 6.0);
    assert_eq!(say(&mut supply, 3.04, "CURR:PROT:TRIP? (@2)"), "0");
    assert_eq!(say(&mut supply, 3.06, "CURR:PROT:TRIP? (@2)"), "1");
    assert_eq!(say(&mut supply, 4.0, "STAT:QUES:INST:ISUM2:COND?"), "+0");
    supply.load(Duration::from_secs(4), 1, 48.0);
    say(&mut supply, 5.0, "OUTP:PROT:CLE (@2)");
    near(number(&mut supply, 6.0, "MEAS:VOLT? (@2)"), 24.0, 0.003);
}

#[test]
fn what_it_cannot_do_goes_into_the_error_queue_and_changes_nothing() {
    let mut supply = supply();
    for (wrong, code) in [
        ("VOLT 30,(@2)", -222),
        ("VOLT 24,(@4)", -222),
        ("VOLT 24,@2", -102),
        ("VOLT twelve,(@2)", -224),
        ("VOLT", -109),
        ("OUTP MAYBE,(@2)", -224),
        ("APPL CH7,1", -224),
        ("VOLT 1,(@1),3", -108),
        ("FREQ 50", -113),
        ("FREQ?", -113),
    ] {
        assert_eq!(say(&mut supply, 1.0, wrong), "", "{wrong}");
        let entry = say(&mut supply, 1.0, "SYST:ERR?");
        assert!(entry.starts_with(&format!("{code},")), "{wrong}: {entry}");
    }
    assert_eq!(say(&mut supply, 2.0, "VOLT? (@1,2)"), "+0.00000000E+00,+2.40000000E+01");
}

#[test]
fn commands_without_a_channel_list_mean_the_selected_output_and_units_are_known() {
    let mut supply = supply();
    say(&mut supply, 0.0, "INST:SEL CH3;:VOLT 12V;:CURR 500mA");
    assert_eq!(say(&mut supply, 1.0, "VOLT?;CURR?"), "+1.20000000E+01;+5.00000000E-01");
    assert_eq!(say(&mut supply, 2.0, "APPL? CH3"), "\"12.000000,0.500000\"");
    assert_eq!(say(&mut supply, 3.0, "VOLT? (@2)"), "+2.40000000E+01");
    say(&mut supply, 4.0, "SOURCE:VOLTAGE:LEVEL:IMMEDIATE:AMPLITUDE MAX");
    assert_eq!(say(&mut supply, 5.0, "VOLT?"), "+2.57500000E+01");
}

#[test]
fn a_reset_switches_everything_off() {
    let mut supply = supply();
    say(&mut supply, 0.0, "*RST");
    assert_eq!(say(&mut supply, 1.0, "OUTP? (@1,2,3)"), "0,0,0");
    near(number(&mut supply, 2.0, "MEAS:VOLT? (@2)"), 0.0, 0.003);
    assert_eq!(say(&mut supply, 3.0, "CURR? (@1)"), "+1.00000000E+01");
    assert_eq!(say(&mut supply, 4.0, "*OPC?"), "1");
}
