//! The text side of the unit: Normal mode without echo, service mode with echo and prompt.

use proptest::prelude::*;

use super::*;

fn unit() -> Stim300 {
    Stim300::new(&perfect(), Stim300Setup::default(), &address(), RATE_HZ)
}

/// What arrives within a second of what was typed, as text.
fn reply(unit: &mut Stim300, typed: &str) -> String {
    unit.write(at(0), typed.as_bytes());
    let mut bytes = [0; 4096];
    let count = unit.read(at(4000), &mut bytes);
    String::from_utf8_lossy(&bytes[..count]).into_owned()
}

fn in_service_mode() -> Stim300 {
    let mut unit = unit();
    let listing = reply(&mut unit, "SERVICEMODE\r");
    assert!(listing.starts_with("SERIAL NUMBER = N00000000000300-SIM\rPRODUCT = STIM300\r"), "{listing}");
    assert!(listing.ends_with("LINE TERMINATION = ON\r>"), "{listing}");
    unit
}

#[test]
fn normal_mode_ignores_what_it_does_not_know_and_never_echoes() {
    let mut unit = unit();
    for typed in ["n\r", "SERVICEMODE", "X\r", "servicemode\r", "\r\r", "UTILITYMODE\r", "N \r", "NI\r"] {
        assert_eq!(reply(&mut unit, typed), "", "{typed}");
    }
    assert!(unit.requested.is_empty());
    unit.write(at(0), b"E\rN\r");
    assert_eq!(unit.requested, [SpecialKind::ExtendedError, SpecialKind::PartNumber]);
}

#[test]
fn service_mode_echoes_answers_and_prompts() {
    let mut unit = in_service_mode();
    for (typed, answer) in [
        ("m 2", "SAMPLE RATE [samples/s] = 500\r"),
        ("m 5", "SAMPLE RATE = EXTERNAL TRIGGER\r"),
        ("m 6", "E003 INVALID PARAMETER\r"),
        ("m 4", "SAMPLE RATE [samples/s] = 2000\r"),
        ("d 0,0", "DATAGRAM = RATE\rDATAGRAM TERMINATION = NONE\r"),
        ("d 3,1", "DATAGRAM = RATE, ACCELERATION, INCLINATION\rDATAGRAM TERMINATION = <CR><LF>\r"),
        (
            "d t,0",
            "DATAGRAM = RATE, ACCELERATION, INCLINATION, TEMPERATURE, PPS\rDATAGRAM TERMINATION = NONE\r",
        ),
        ("d o,0", "E003 INVALID PARAMETER\r"),
        ("d 0", "E002 INCORRECT NUMBER OF PARAMETERS\r"),
        ("u g,0", "GYRO OUTPUT UNIT = [deg/s] ANGULAR RATE\r"),
        ("u g,9", "GYRO OUTPUT UNIT = [deg] INCREMENTAL ANGLE DELAYED\r"),
        ("u a,2", "ACCELEROMETER OUTPUT UNIT = [g] AVERAGE ACCELERATION\r"),
        ("u g,4", "E003 INVALID PARAMETER\r"),
        ("r 0", "LINE TERMINATION = OFF\r"),
        ("i n", "PRODUCT = STIM300\r"),
        ("i s", "SERIAL NUMBER = N00000000000300-SIM\r"),
        ("i x", "PART NUMBER = 00300-0000000-001 REV S\r"),
        ("i t", "BIT-RATE [bits/s] = 1843200\rDATA LENGTH = 8\rSTOP BITS = 1\rPARITY = NONE\r"),
        ("hello", "E001 UNKNOWN COMMAND\r"),
        ("c", "E001 UNKNOWN COMMAND\r"),
        ("M 2", "E001 UNKNOWN COMMAND\r"),
        ("", ""),
    ] {
        assert_eq!(reply(&mut unit, &format!("{typed}\r")), format!("{typed}\r{answer}>"), "{typed}");
    }
    assert_eq!(reply(&mut unit, "m 3x\u{8}\r"), "m 3x\u{8}\rSAMPLE RATE [samples/s] = 1000\r>");
}

/// 59 bytes at 2000 Hz need 1.3 Mbit/s.
#[test]
fn a_datagram_that_does_not_fit_is_refused_and_a_rate_is_set_with_a_warning() {
    let setup = Stim300Setup { bit_rate: 921_600, ..Stim300Setup::default() };
    let mut unit = Stim300::new(&perfect(), setup, &address(), RATE_HZ);
    reply(&mut unit, "SERVICEMODE\r");
    assert_eq!(reply(&mut unit, "d 7,0\r"), "d 7,0\rE007 DATAGRAM WILL BE TOO LONG TO TRANSMIT\r>");
    reply(&mut unit, "m 3\r");
    assert!(!reply(&mut unit, "d 7,0\r").contains("E007"));
    let warned = reply(&mut unit, "m 4\r");
    assert_eq!(warned, "m 4\rSAMPLE RATE [samples/s] = 2000\rE007 DATAGRAM WILL BE TOO LONG TO TRANSMIT\r>");
    assert_eq!(unit.setup.sample_rate, SampleRate::Internal(2000));
}

#[test]
fn saved_settings_survive_a_reset_and_others_do_not() {
    let mut unit = in_service_mode();
    reply(&mut unit, "m 3\r");
    assert!(reply(&mut unit, "s\r").ends_with("CONFIRM SAVE(Y/N): "));
    assert_eq!(reply(&mut unit, "y"), "y\rSAVE COMMAND ABORTED.\rE003 INVALID PARAMETER\r>");
    reply(&mut unit, "s\r");
    let saved = reply(&mut unit, "Y");
    assert_eq!(saved, "Y\rSYSTEM PARAMETERS SUCCESSFULLY STORED IN FLASH.\rNUMBER OF SAVES = 1\r>");
    reply(&mut unit, "m 1\r");
    assert!(reply(&mut unit, "x n\r").ends_with("CONFIRM EXIT(Y/N): "));
    assert_eq!(reply(&mut unit, "N"), "N\r>");
    assert_eq!(reply(&mut unit, "x N\r"), "x N\rSYSTEM RETURNING TO NORMAL MODE\r");
    assert_eq!((unit.mode, unit.setup.sample_rate), (Mode::Normal, SampleRate::Internal(250)));
    unit.write(at(0), b"R\r");
    assert_eq!(unit.setup.sample_rate, SampleRate::Internal(1000));
    assert!(matches!(unit.mode, Mode::Init { .. }));
}

#[test]
fn service_mode_sends_no_measurements() {
    let mut unit = in_service_mode();
    (0..100).for_each(|tick| unit.pulse(tick, &standing()));
    assert_eq!(unit.read(at(4000), &mut [0; 512]), 0);
    assert_eq!(reply(&mut unit, "x I\r"), "x I\rSYSTEM RETURNING TO INIT MODE\r");
}

proptest! {
    #[test]
    fn no_bytes_bring_the_unit_down(service: bool, typed in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut unit = if service { in_service_mode() } else { unit() };
        unit.write(at(0), &typed);
        unit.write(at(0), b"\r");
        unit.pulse(8000, &standing());
        unit.pulse(8001, &standing());
        unit.read(at(9000), &mut [0; 4096]);
    }
}
