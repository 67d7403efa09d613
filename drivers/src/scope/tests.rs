use super::*;
use crate::scpi::tests::{Far, format_error};

const CAPTURE: Capture = Capture { axis: 0, sample_rate_hz: 100e3, duration_s: 0.9e-3 };
const PREAMBLE: &[u8] = b"+1,+3,+4,+1,+1.0E-05,-1.5E-05,+0,+1.0E-03,+0.0E+00,+32768\n";

fn settings() -> ScopeSettings {
    ScopeSettings {
        name: "scope".to_owned(),
        current_channels: [1, 3],
        sync_channel: 2,
        current_range_a: 20.0,
        reply_timeout_s: 0.05,
    }
}

/// A record against these answers.
fn taken(answers: &[&[u8]]) -> Result<(Scope, Far), DeviceError> {
    let mut scope = Scope::new(settings())?;
    let mut far = Far::answering(answers);
    scope.prepare(&CAPTURE)?;
    scope.start(&mut far, Duration::ZERO)?;
    for ms in 0..100_000 {
        if scope.poll(&mut far, Duration::from_millis(ms))? {
            return Ok((scope, far));
        }
    }
    panic!("it neither ends nor gives up")
}

fn words(codes: [u16; 4]) -> Vec<u8> {
    let mut block = b"#800000008".to_vec();
    block.extend(codes.iter().flat_map(|code| code.to_le_bytes()));
    block.push(b'\n');
    block
}

#[test]
fn a_record_is_scaled_by_its_preamble_and_holes_are_left_out() {
    let current = words([32_768, 33_768, 0, 31_768]);
    let sync = words([32_768, 37_768, 37_768, 37_768]);
    let answers: [&[u8]; 9] =
        [b"1\n", b"+0\n", b"+1\n", b"+8\n", b"+0\n", PREAMBLE, &current, PREAMBLE, &sync];
    let (scope, far) = taken(&answers).expect("a healthy instrument");
    let close = |found: Option<[f64; 3]>, expected: [f64; 3]| {
        let found = found.expect("no hole");
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-12), "{found:?} {expected:?}");
    };
    close(scope.row(0), [-15e-6, 0.0, 0.0]);
    close(scope.row(1), [-5e-6, 1.0, 5.0]);
    assert_eq!((scope.row(2), scope.row(4), scope.samples_count()), (None, None, 4));
    close(scope.row(3), [15e-6, -1.0, 5.0]);
    let asked = |text: &str| far.heard.iter().filter(|heard| *heard == text).count();
    assert_eq!((asked(":AER?"), asked(":OPER:COND?"), asked(":SING")), (2, 2, 1), "it looks until it is so");
    assert_eq!(asked(":WAV:POIN 100"), 2);
    assert_eq!(asked(":TRIG:EDGE:SOUR CHAN2"), 1);
}

#[test]
fn a_record_that_is_not_the_one_asked_for_is_an_error() {
    let with = |preamble: &'static [u8], codes: [u16; 4]| {
        let data = words(codes);
        taken(&[b"1\n", b"1\n", b"0\n", preamble, &data, preamble, &data]).map(|_| ())
    };
    let fine = [32_768; 4];
    assert_eq!(with(PREAMBLE, fine), Ok(()));
    let slow = b"+1,+3,+4,+1,+2.0E-05,-1.5E-05,+0,+1.0E-03,+0.0E+00,+32768\n";
    assert!(with(slow, fine).expect_err("50 kHz").to_string().contains("sample rate"));
    let bytes = b"+0,+3,+4,+1,+1.0E-05,-1.5E-05,+0,+1.0E-03,+0.0E+00,+32768\n";
    assert!(matches!(format_error(with(bytes, fine)), FormatError::Text { .. }));
    let nine = b"+1,+3,+4,+1,+1.0E-05,-1.5E-05,+0,+1.0E-03,+0.0E+00\n";
    assert_eq!(format_error(with(nine, fine)), FormatError::Count { expected: 10, found: 9 });
    let five = b"+1,+3,+5,+1,+1.0E-05,-1.5E-05,+0,+1.0E-03,+0.0E+00,+32768\n";
    assert_eq!(format_error(with(five, fine)), FormatError::Count { expected: 5, found: 4 });
    let clipped = with(PREAMBLE, [1, 32_768, u16::MAX, 40_000]).expect_err("off the screen").to_string();
    assert!(clipped.contains("found 2 off the screen"), "{clipped}");
}

#[test]
fn records_that_cannot_be_taken_are_refused_before_they_begin() {
    let mut scope = Scope::new(settings()).expect("sound settings");
    for capture in [
        Capture { sample_rate_hz: 99e3, ..CAPTURE },
        Capture { sample_rate_hz: f64::NAN, ..CAPTURE },
        Capture { duration_s: 0.0, ..CAPTURE },
        Capture { duration_s: 60.0, ..CAPTURE },
        Capture { axis: 2, ..CAPTURE },
    ] {
        assert!(matches!(scope.prepare(&capture), Err(DeviceError::Setting { .. })), "{capture:?}");
    }
    let shared = ScopeSettings { sync_channel: 3, ..settings() };
    assert!(matches!(Scope::new(shared), Err(DeviceError::Setting { setting: "sync_channel", .. })));
}
