use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

/// An instrument that answers from a list, in order, and has an error queue.
#[derive(Default)]
pub(crate) struct Far {
    pub(crate) answers: VecDeque<Vec<u8>>,
    pub(crate) errors: VecDeque<&'static str>,
    pub(crate) heard: Vec<String>,
    /// An instrument that answers nothing.
    pub(crate) is_dead: bool,
    input: Vec<u8>,
    output: VecDeque<u8>,
}

impl Far {
    pub(crate) fn answering(answers: &[&[u8]]) -> Self {
        Self { answers: answers.iter().map(|a| a.to_vec()).collect(), ..Self::default() }
    }

    fn hear(&mut self, message: String) {
        let asks = message.contains('?');
        if self.is_dead {
        } else if message == queue::QUERY {
            let entry = self.errors.pop_front().unwrap_or("+0,\"No error\"");
            self.output.extend(entry.bytes().chain([b'\n']));
        } else if asks {
            self.output.extend(self.answers.pop_front().unwrap_or_default());
        }
        self.heard.push(message);
    }
}

impl ByteLine for Far {
    fn name(&self) -> &str {
        "line"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.output.len());
        into.iter_mut().zip(self.output.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.input.extend_from_slice(bytes);
        while let Some(end) = self.input.iter().position(|byte| *byte == b'\n') {
            let message: Vec<u8> = self.input.drain(..=end).collect();
            self.hear(String::from_utf8_lossy(message.trim_ascii()).into_owned());
        }
        Ok(())
    }
}

/// Plays a script until it ends: what was answered, or the error.
fn played(far: &mut Far, script: Vec<Step<u8>>, limit: usize) -> Result<Vec<(u8, Vec<u8>)>, DeviceError> {
    let mut session = Session::new("meter", script, limit, 0.1);
    let mut all = Vec::new();
    session.start(far, Duration::ZERO)?;
    for ms in 0..5000 {
        loop {
            match session.poll(far, Duration::from_millis(ms))? {
                Progress::Waiting => break,
                Progress::Done => return Ok(all),
                Progress::Answered(what) => all.push((what, session.answer().to_vec())),
            }
        }
    }
    panic!("it neither ends nor gives up")
}

fn line(far: &mut Far) -> Result<Vec<(u8, Vec<u8>)>, DeviceError> {
    played(far, vec![Step::query("MEAS?", 7, 0.05)], 64)
}

fn block(answer: &[u8]) -> Result<Vec<(u8, Vec<u8>)>, DeviceError> {
    played(&mut Far::answering(&[answer]), vec![Step::block("DATA?", 1, 0.05)], 64)
}

/// The format error in a driver's error.
pub(crate) fn format_error<T: std::fmt::Debug>(outcome: Result<T, DeviceError>) -> FormatError {
    match outcome {
        Err(DeviceError::Answer { source, .. }) => source,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_error_queue_is_read_after_every_step() {
    let mut far = Far::answering(&[b"+1.5E0\n"]);
    let script = vec![Step::command("*CLS", 0.1), Step::query("MEAS?", 7, 0.1)];
    assert_eq!(played(&mut far, script, 64), Ok(vec![(7, b"+1.5E0".to_vec())]));
    assert_eq!(far.heard, ["*CLS", ":SYST:ERR?", "MEAS?", ":SYST:ERR?"]);
}

#[test]
fn what_the_instrument_refuses_is_told_in_its_own_words_and_the_queue_is_emptied() {
    let mut far =
        Far { errors: ["-222,\"Data out of range\"", "-113,\"Undefined header\""].into(), ..Far::default() };
    let refused = played(&mut far, vec![Step::command("FREQ 1", 0.1), Step::command("GO", 0.1)], 64);
    let text = refused.expect_err("it was refused").to_string();
    assert_eq!(text, "meter: FREQ 1: the instrument reports -222, \"Data out of range\"");
    assert_eq!(far.heard, ["FREQ 1", ":SYST:ERR?", ":SYST:ERR?", ":SYST:ERR?"], "nothing goes on after it");
}

#[test]
fn a_query_that_was_refused_is_told_with_the_reason_and_not_as_silence() {
    let mut far = Far { errors: ["-113,\"Undefined header\""].into(), ..Far::default() };
    assert!(matches!(line(&mut far), Err(DeviceError::Instrument { code: -113, .. })));
}

#[test]
fn an_instrument_that_is_only_too_slow_is_not_told_as_one_that_refuses() {
    let mut far = Far { errors: ["-410,\"Query INTERRUPTED\""].into(), ..Far::default() };
    let text = line(&mut far).expect_err("it never answers").to_string();
    assert!(text.contains("found none within"), "{text}");
}

#[test]
fn silence_ends_after_its_time() {
    let mut far = Far { is_dead: true, ..Far::default() };
    let text = line(&mut far).expect_err("nobody is there").to_string();
    assert!(
        text.contains("answer: expected a whole one to MEAS?, found none within 0.051 s, 0 bytes so far"),
        "{text}"
    );
}

#[test]
fn an_error_queue_that_never_ends_is_given_up() {
    let mut far =
        Far { errors: std::iter::repeat_n("-350,\"Queue overflow\"", 1000).collect(), ..Far::default() };
    assert!(matches!(line(&mut far), Err(DeviceError::Instrument { code: -350, .. })));
}

#[test]
fn what_was_left_of_an_earlier_dialogue_is_thrown_away() {
    let mut far = Far::answering(&[b"2\n"]);
    far.output.extend(*b"1\n1\n");
    assert_eq!(line(&mut far), Ok(vec![(7, b"2".to_vec())]));
}

#[test]
fn a_block_comes_whole_with_line_feeds_inside() {
    assert_eq!(block(b"#15\n\n#3\n\n"), Ok(vec![(1, b"\n\n#3\n".to_vec())]));
    assert_eq!(block(b"#800000002ab\r\n"), Ok(vec![(1, b"ab".to_vec())]));
    assert_eq!(block(b"#10\n").map(|all| all[0].0), Ok(1));
}

#[test]
fn a_damaged_block_says_what_is_wrong_with_it() {
    let cases: [(&[u8], FormatError); 8] = [
        (b"#15abc", FormatError::Truncated { expected: 5, found: 3 }),
        (b"#15abcde", FormatError::Truncated { expected: 5, found: 5 }),
        (b"#13abcde\n", FormatError::Unterminated { expected: 3, found: b'd' }),
        (b"#13abc\nx", FormatError::Trailing { count: 1 }),
        (b"#0abc\n", FormatError::Indefinite),
        (b"#2x1abc\n", FormatError::NotABlock { found: "#2x1abc".to_owned() }),
        (b"+1.0\n", FormatError::NotABlock { found: "+1.0".to_owned() }),
        (b"#9999999999abc\n", FormatError::TooLong { limit: 64 }),
    ];
    for (answer, expected) in cases {
        assert_eq!(format_error(block(answer)), expected, "{}", String::from_utf8_lossy(answer));
    }
}

#[test]
fn more_than_there_is_room_for_is_refused() {
    let mut far = Far::answering(&[&[b'1'; 100]]);
    assert_eq!(format_error(line(&mut far)), FormatError::TooLong { limit: 64 });
    let mut far = Far::answering(&[b"1\n2\n"]);
    assert_eq!(format_error(line(&mut far)), FormatError::Trailing { count: 2 });
}

#[test]
fn marks_of_what_is_no_value_are_no_values() {
    let read = |text: &[u8]| number::number(text, 3);
    let not_valid = |meaning| Err(FormatError::NotValid { place: 3, meaning });
    assert_eq!(read(b"+9.90000000000E+37"), not_valid("an overload (9.9E37)"));
    assert_eq!(read(b"-9.9E37"), not_valid("an overload (9.9E37)"));
    assert_eq!(read(b"9.91E37"), not_valid("not a number (9.91E37)"));
    assert_eq!(read(b" -1.25e-3 "), Ok(-1.25e-3));
    for word in ["nan", "inf", "infinity", "", "1_0", "0x1", "1,2", "1e999"] {
        assert!(matches!(read(word.as_bytes()), Err(FormatError::NotANumber { place: 3, .. })), "{word}");
    }
}

#[test]
fn a_list_has_as_many_values_as_were_asked_for() {
    let mut values = Vec::new();
    assert_eq!(number::list(b"1,2,3\n", 3, &mut values), Ok(()));
    assert_eq!(values, [1.0, 2.0, 3.0]);
    for (text, found) in [("1,2", 2), ("1,2,3,4", 4)] {
        let expected = Err(FormatError::Count { expected: 3, found });
        assert_eq!(number::list(text.as_bytes(), 3, &mut values), expected);
    }
}

proptest! {
    #[test]
    fn a_block_of_anything_comes_through(content in prop::collection::vec(any::<u8>(), 0..300), digits in 3_usize..9) {
        let mut bytes = format!("#{digits}{:0digits$}", content.len()).into_bytes();
        bytes.extend(&content);
        for length in 0..bytes.len() {
            prop_assert_eq!(block::is_whole(&bytes[..length], 1000), Ok(false));
        }
        bytes.push(b'\n');
        prop_assert_eq!(block::is_whole(&bytes, 1000), Ok(true));
        let found = block::read(&bytes).ok().flatten();
        prop_assert_eq!(found.map(|b| &bytes[b.start..b.end()]), Some(&content[..]));
    }

    #[test]
    fn no_bytes_make_a_parser_panic_or_give_what_is_no_number(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        let _ = block::is_whole(&bytes, 32);
        let _ = queue::entry(&bytes);
        let _ = Identity::parse(&bytes);
        let mut values = Vec::new();
        for expected in 0..4 {
            if number::list(&bytes, expected, &mut values).is_ok() {
                prop_assert!(values.len() == expected && values.iter().all(|v| v.abs() < 9.9e37));
            }
        }
    }

    #[test]
    fn numbers_come_back_as_they_were_written(value in -1e30_f64..1e30) {
        prop_assert_eq!(number::number(format!("{value:+E}").as_bytes(), 1), Ok(value));
    }
}
