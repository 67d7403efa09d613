use super::*;
use crate::scpi::tests::{Far, format_error};

const IDENTITY: &[u8] = b"Keysight Technologies,E4990A,MY1,A.01.02\n";

fn settings() -> AnalyserSettings {
    AnalyserSettings { name: "analyser".to_owned(), relay: [1, 2], reply_timeout_s: 0.05 }
}

fn sweep() -> Sweep {
    Sweep { axis: 1, level_v_ptp: 1.0, from_hz: 20.0, to_hz: 80.0, points: 3 }
}

/// Calls until something comes of it.
fn until<T>(mut call: impl FnMut(Duration) -> Result<Option<T>, DeviceError>) -> Result<T, DeviceError> {
    for ms in 0..100_000 {
        if let Some(done) = call(Duration::from_millis(ms))? {
            return Ok(done);
        }
    }
    panic!("it neither ends nor gives up")
}

fn identified(answer: &[u8]) -> Result<Analyser, DeviceError> {
    let mut analyser = Analyser::new(settings())?;
    let mut far = Far::answering(&[answer]);
    until(|now| analyser.identify(&mut far, now))?;
    Ok(analyser)
}

/// A sweep against these answers to `*OPC?`, the four traces and the frequencies.
fn swept(answers: &[&[u8]]) -> Result<(Analyser, Far), DeviceError> {
    let mut analyser = identified(IDENTITY)?;
    let mut far = Far::answering(answers);
    analyser.prepare(&sweep())?;
    analyser.start(&mut far, Duration::ZERO)?;
    until(|now| Ok(analyser.poll(&mut far, now)?.then_some(())))?;
    Ok((analyser, far))
}

const GOOD: [&[u8]; 6] = [
    b"+1\n",
    b"1,0,2,0,3,0\n",
    b"-10,0,-20,0,-30,0\n",
    b"0.35,0,0.34,0,0.33,0\n",
    b"0.001,0,0.002,0,0.003,0\n",
    b"20,40,80\n",
];

#[test]
fn every_second_value_of_formatted_data_is_the_point() {
    let (analyser, far) = swept(&GOOD).expect("a healthy instrument");
    let second = Point {
        frequency_hz: 40.0,
        resistance_ohm: 2.0,
        reactance_ohm: -20.0,
        level_v: 0.34,
        current_a: 0.002,
    };
    assert_eq!(analyser.points()[1], second);
    assert_eq!(analyser.row(2), Some([80.0, 3.0, -30.0, 0.33, 0.003, 2.0]));
    assert_eq!(analyser.row(3), None);
    for command in [
        ":SOUR1:VOLT 0.35355",
        ":CONT:HAND:A 2",
        ":SENS1:SWE:TYPE LOG",
        ":TRIG:SOUR BUS",
        ":SENS1:FREQ:STAR 20",
    ] {
        assert!(far.heard.iter().any(|heard| heard == command), "{command} in {:?}", far.heard);
    }
    assert_eq!(
        far.heard.iter().rfind(|heard| *heard != ":SYST:ERR?").map(String::as_str),
        Some(":CONT:HAND:A 0")
    );
}

#[test]
fn too_few_values_an_overload_and_other_frequencies_are_errors() {
    let with = |place: usize, answer: &'static [u8]| {
        let mut answers = GOOD;
        answers[place] = answer;
        swept(&answers).map(|_| ())
    };
    assert_eq!(format_error(with(1, b"1,0,2,0,3\n")), FormatError::Count { expected: 6, found: 5 });
    let overload = format_error(with(2, b"-10,0,9.9E37,0,-30,0\n"));
    assert!(matches!(overload, FormatError::NotValid { place: 3, .. }), "{overload}");
    assert!(matches!(with(5, b"20,41,80\n"), Err(DeviceError::Field { .. })));
    assert!(matches!(format_error(with(0, b"0\n")), FormatError::Text { .. }));
}

#[test]
fn an_analyser_that_begins_at_40_hz_is_refused_in_words() {
    let text =
        identified(b"Agilent Technologies,4294A,JP1,R1.11\n").expect_err("the wrong model").to_string();
    assert!(text.contains("4294A, which begins at 40 Hz") && text.contains("20 Hz"), "{text}");
    let text = identified(b"FLUKE,8846A,1,2\n").expect_err("the wrong instrument").to_string();
    assert!(text.contains("expected an E4990A, found `FLUKE 8846A"), "{text}");
    assert!(matches!(format_error(identified(b"hello\n").map(|_| ())), FormatError::Text { .. }));
}

#[test]
fn sweeps_beyond_the_instrument_are_refused_before_they_begin() {
    let mut analyser = identified(IDENTITY).expect("an E4990A");
    let good = sweep();
    assert_eq!(analyser.prepare(&good), Ok(()));
    let bad = [
        (Sweep { from_hz: 19.0, ..good }, "first frequency (Hz)"),
        (Sweep { to_hz: 20.0, ..good }, "last frequency (Hz)"),
        (Sweep { to_hz: f64::NAN, ..good }, "last frequency (Hz)"),
        (Sweep { level_v_ptp: 0.014, ..good }, "level (V RMS)"),
        (Sweep { level_v_ptp: 2.83, ..good }, "level (V RMS)"),
        (Sweep { points: 1602, ..good }, "points"),
        (Sweep { axis: 2, ..good }, "axis"),
    ];
    for (sweep, expected) in bad {
        match analyser.prepare(&sweep) {
            Err(DeviceError::Setting { setting, .. }) => assert_eq!(setting, expected),
            other => panic!("{sweep:?}: {other:?}"),
        }
    }
}
