use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

fn scale(scale_si: f64, most_si: f64, decimals: usize) -> ValueScale {
    ValueScale { scale_si, range_si: [-most_si, most_si], u_si: 0.5e-6, decimals }
}

/// Seconds of arc.
const ARCSEC: f64 = 4.848_136_811_095_36e-6;

fn autocollimator() -> ReaderProfile {
    ReaderProfile {
        id: "angles".to_owned(),
        identify: Some("*IDN?".to_owned()),
        query: Some("MEAS?".to_owned()),
        terminator: Terminator::Lf,
        period_s: 0.02,
        timeout_s: 0.1,
        pattern: Pattern::parse("{azimuth},{elevation}").expect("a pattern"),
        nothing: "9.9E37".to_owned(),
        values: [Some(scale(ARCSEC, 400e-6, 2)), Some(scale(-ARCSEC, 400e-6, 2)), None],
    }
}

fn gauge() -> ReaderProfile {
    ReaderProfile {
        id: "gauge".to_owned(),
        identify: None,
        query: None,
        terminator: Terminator::CrLf,
        period_s: 0.02,
        timeout_s: 0.1,
        pattern: Pattern::parse("{*} {force} N").expect("a pattern"),
        nothing: "OVER".to_owned(),
        values: [None, None, Some(scale(1.0, 2000.0, 1))],
    }
}

/// The far end of a line on which every query is answered by a fixed text, and what was put there arrives.
#[derive(Default)]
struct Far {
    answers: Vec<(&'static str, &'static str)>,
    arrives: VecDeque<u8>,
    heard: String,
}

impl ByteLine for Far {
    fn name(&self) -> &str {
        "line"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.arrives.len());
        into.iter_mut().zip(self.arrives.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.heard.push_str(&String::from_utf8_lossy(bytes));
        let answer = self.answers.iter().find(|(query, _)| self.heard.ends_with(&format!("{query}\n")));
        self.arrives.extend(answer.iter().flat_map(|(_, answer)| answer.bytes()));
        Ok(())
    }
}

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Opens a reader, a millisecond at a time; when that was done.
fn opened(profile: ReaderProfile, far: &mut Far) -> Result<(Reader, u64), DeviceError> {
    let mut reader = Reader::new("reader", Arc::new(profile));
    for at in 0..2000 {
        if reader.open(far, ms(at))? {
            return Ok((reader, at));
        }
    }
    panic!("it neither opens nor gives up")
}

const ANSWERS: [(&str, &str); 2] = [("*IDN?", "Maker,AC-1,7,1.0\n"), ("MEAS?", "+10.25,-2.50\n")];

#[test]
fn lines_fit_patterns_or_they_do_not() {
    for (pattern, line, expected) in [
        ("{force}", "12.5", Some(12.5)),
        ("{force}", "  -0012.50 ", Some(-12.5)),
        ("{force}", "- 12.5", Some(-12.5)),
        ("{force}", "+1.25E+01", Some(12.5)),
        ("{force}", "1.25e1", Some(12.5)),
        ("{force}", ".5", Some(0.5)),
        ("{force} N", "12.5 N", Some(12.5)),
        ("{force} N", "12.5   N", Some(12.5)),
        ("F={force}E", "F=12.5E", Some(12.5)),
        ("{*},{force},{*}", "no 7,12.5,ok", Some(12.5)),
        ("{*} {force} {*}", "ST,GS 12.5 N anything", Some(12.5)),
        ("{force}", "", None),
        ("{force}", "-", None),
        ("{force}", ".", None),
        ("{force}", "inf", None),
        ("{force}", "NaN", None),
        ("{force}", "12.5.1", None),
        ("{force}", "12.5 N", None),
        ("{force} N", "12.5N", None),
        ("{force} N", "12.5 kN", None),
        ("{*},{force}", "12.5", None),
        ("{force}", "1e999", None),
    ] {
        let read = Pattern::parse(pattern).expect(pattern).decode(line.as_bytes(), "");
        assert_eq!(read.and_then(|shown| shown.number(Measured::Force)), expected, "{pattern}: {line}");
        assert_eq!(read.is_some(), expected.is_some(), "{pattern}: {line}");
    }
}

#[test]
fn a_mark_of_no_reading_is_none_and_not_a_number() {
    let pattern = Pattern::parse("{azimuth};{elevation}").expect("a pattern");
    let shown = pattern.decode(b"----;1.5", "----").expect("it fits");
    assert_eq!([Measured::Azimuth, Measured::Elevation].map(|which| shown.number(which)), [None, Some(1.5)]);
    let overload = pattern.decode(b"+9.9E+37;-9.91E37", "").expect("it fits");
    assert_eq!(overload, Shown::default());
}

#[test]
fn texts_that_are_no_patterns_are_refused_with_what_is_wrong() {
    for (text, reason) in [
        ("", "it has no value"),
        ("X", "it has no value"),
        ("{*}", "it has no value"),
        ("{azimut}", "there is no value `{azimut}`"),
        ("{azimuth}{elevation}", "two fields without text between them"),
        ("{azimuth},{azimuth}", "`{azimuth}` stands in it twice"),
        ("{azimuth", "a `{` without its `}`"),
        ("azimuth}", "a `}` without its `{`"),
    ] {
        assert_eq!(Pattern::parse(text).expect_err(text).to_string(), reason, "{text}");
    }
}

#[test]
fn a_reader_is_identified_and_asked_once_a_period_and_its_numbers_become_si() {
    let mut far = Far { answers: ANSWERS.into(), ..Far::default() };
    let (mut reader, at) = opened(autocollimator(), &mut far).expect("it answers");
    assert_eq!((reader.identity(), at), (Some("Maker,AC-1,7,1.0"), 1));
    let readings = reader.readings(ms(at));
    let [azimuth, elevation] =
        [Measured::Azimuth, Measured::Elevation].map(|which| readings.value(which).expect("a value"));
    assert!((azimuth - 10.25 * ARCSEC).abs() < 1e-12 && (elevation - 2.5 * ARCSEC).abs() < 1e-12);
    let new = (at + 1..=at + 200).filter(|at| reader.poll(&mut far, ms(*at)).expect("it answers")).count();
    assert!((9..=10).contains(&new), "a reading each 20 ms, {new}");
    assert_eq!(far.heard.matches("MEAS?\n").count(), new + 1);
    assert_eq!(reader.counts(), Counts { readings: new as u64 + 1, ..Counts::default() });
}

#[test]
fn nothing_is_asked_while_an_answer_is_outstanding_and_a_late_one_is_not_the_next() {
    let mut far = Far { answers: ANSWERS.into(), ..Far::default() };
    let (mut reader, at) = opened(autocollimator(), &mut far).expect("it answers");
    far.answers = vec![("MEAS?", "")];
    far.heard.clear();
    // Asked 20 ms after the reading before, overdue 100 ms later, listened to for 100 ms more.
    for at in at + 1..at + 200 {
        assert_eq!(reader.poll(&mut far, ms(at)), Ok(false));
    }
    assert_eq!((far.heard.as_str(), reader.counts().timeouts), ("MEAS?\n", 1));
    far.arrives.extend(b"+99.00,+99.00\n");
    assert_eq!(reader.poll(&mut far, ms(at + 200)), Ok(false), "that was the answer to the query before");
    assert_eq!(reader.counts().rejected_lines, 1);
    assert_eq!(reader.readings(ms(at + 200)), Readings::default(), "the reading before is too old");
    far.answers = ANSWERS.into();
    let new = (at + 201..at + 300).find(|at| reader.poll(&mut far, ms(*at)).expect("it answers"));
    assert!(new.is_some() && reader.readings(ms(new.unwrap_or(0))).value(Measured::Azimuth).is_some());
}

#[test]
fn a_gauge_that_sends_by_itself_is_read_from_the_middle_of_a_line_on() {
    let mut far = Far::default();
    far.arrives.extend(b"");
    let mut reader = Reader::new("gauge", Arc::new(gauge()));
    assert_eq!(reader.open(&mut far, ms(0)), Ok(false));
    far.arrives.extend(b"5.0 N\r\nS1 +65");
    assert_eq!(reader.open(&mut far, ms(1)), Ok(false));
    far.arrives.extend(b"0.0 N\r\n");
    assert_eq!(reader.open(&mut far, ms(2)), Ok(true));
    assert_eq!(reader.readings(ms(2)).value(Measured::Force), Some(650.0));
    assert_eq!(reader.counts(), Counts { readings: 1, rejected_lines: 1, ..Counts::default() });
    far.arrives.extend(b"S1 OVER N\r\nS1 +2000.1 N\r\n");
    assert_eq!(reader.poll(&mut far, ms(3)), Ok(true));
    assert_eq!(reader.readings(ms(3)).value(Measured::Force), None, "outside the range");
    assert_eq!((reader.counts().readings, reader.counts().out_of_range), (3, 1));
    assert_eq!(far.heard, "", "nothing is asked of it");
}

#[test]
fn silence_and_another_language_end_the_opening_with_what_came_instead() {
    let text = opened(autocollimator(), &mut Far::default()).expect_err("nobody answers").to_string();
    assert!(text.contains("`*IDN?`: no answer within 0.1 s"), "{text}");
    let mut other = Far { answers: vec![ANSWERS[0], ("MEAS?", "ERROR 5\n")], ..Far::default() };
    let text = opened(autocollimator(), &mut other).expect_err("no reading").to_string();
    let parts = ["reader: reading: expected a line like `{azimuth},{elevation}`", "the last one `ERROR 5`"];
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
}

#[test]
fn a_reader_that_falls_silent_is_stale_at_once_and_an_error_after_5_s() {
    let mut far = Far { answers: ANSWERS.into(), ..Far::default() };
    let (mut reader, at) = opened(autocollimator(), &mut far).expect("it answers");
    far.answers.clear();
    let fails = (at + 1..at + 6000).find(|at| reader.poll(&mut far, ms(*at)).is_err()).expect("it fails");
    assert!((5000..5030).contains(&(fails - at)), "{fails}");
    assert_eq!(reader.readings(ms(at + 121)), Readings::default());
}

#[test]
fn a_line_without_an_end_is_thrown_away_and_the_next_one_is_read() {
    let mut far = Far::default();
    let mut reader = Reader::new("gauge", Arc::new(gauge()));
    assert_eq!(reader.open(&mut far, ms(0)), Ok(false));
    far.arrives.extend([b'7'; 1000]);
    far.arrives.extend(b"\r\nS1 +1.0 N\r\n");
    assert_eq!(reader.open(&mut far, ms(1)), Ok(true));
    assert_eq!(reader.counts().rejected_lines, 1);
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_a_panic_and_counted(
        bytes in prop::collection::vec(any::<u8>(), 0..600),
        asks in any::<bool>(),
    ) {
        let profile = if asks { autocollimator() } else { gauge() };
        let mut reader = Reader::new("reader", Arc::new(profile));
        let mut far = Far::default();
        let _ = reader.open(&mut far, ms(0));
        far.arrives.extend(&bytes);
        for at in 1..20 {
            let _ = reader.open(&mut far, ms(at));
        }
        let lines = bytes.iter().filter(|byte| **byte == b'\n').count() as u64;
        let Counts { readings, rejected_lines, .. } = reader.counts();
        prop_assert!(readings + rejected_lines <= lines);
    }

    #[test]
    fn any_text_is_a_pattern_or_is_refused_without_a_panic(text in "\\PC{0,40}", line in "\\PC{0,40}") {
        if let Ok(pattern) = Pattern::parse(&text) {
            pattern.decode(line.as_bytes(), "OVER");
        }
    }

    #[test]
    fn what_a_line_shows_is_read_within_half_a_quantum(
        azimuth in prop::option::of(-400e-6..400e-6_f64),
        elevation in prop::option::of(-400e-6..400e-6_f64),
        force in prop::option::of(-2000.0..2000.0_f64),
    ) {
        for (profile, values) in [
            (autocollimator(), [(Measured::Azimuth, azimuth), (Measured::Elevation, elevation)].as_slice()),
            (gauge(), [(Measured::Force, force)].as_slice()),
        ] {
            let sent = values.iter().fold(Readings::default(), |all, (which, value)| all.with(*which, *value));
            let line = profile.line(&sent);
            let shown = profile.pattern.decode(line.as_bytes(), &profile.nothing);
            let (read, _) = profile.scaled(&shown.expect("its own line fits"));
            for &(which, value) in values {
                let half = 0.5001 * profile.scale(which).map_or(0.0, ValueScale::quantum_si);
                match (value, read.value(which)) {
                    (Some(sent), Some(read)) => prop_assert!((sent - read).abs() <= half, "{line}"),
                    // What rounds to beyond the end of the range is none.
                    (Some(sent), None) => {
                        let most = profile.scale(which).map_or(0.0, |scale| scale.range_si[1]);
                        prop_assert!(sent.abs() > most - half, "{line}");
                    }
                    (None, read) => prop_assert_eq!(read, None),
                }
            }
        }
    }
}
