//! Bytes of the CCBu40 (manual v1.21, pages 22 to 26), in both directions.

use proptest::prelude::*;

use super::*;

#[test]
fn registers_of_the_bit_rate_are_those_of_the_manual() {
    for (register, bit_rate_hz) in [(1171, 9599), (585, 19_198), (11, 937_500)] {
        assert_eq!((BIT_RATE_CLOCK_HZ / (f64::from(register) + 1.0)).round() as i32, bit_rate_hz);
    }
}

/// Order of the words and their scales, from bytes and to bytes.
#[test]
fn a_parameter_set_has_its_words_in_the_order_of_the_manual() {
    let words = [1, -5406, 1, 32_768, 65_536, -65_536, 4, 350, 322, 8192, -8192, 131_072, 100, 15_001, 0];
    let set = ParameterSet::from_words(&words);
    assert!(set.digital_source && set.closed_loop);
    assert!((set.order_v + 1.65).abs() < 0.5e-3);
    assert_eq!((set.proportional_gain, set.integral_gain, set.differential_gain), (0.5, 1.0, -1.0));
    assert_eq!((set.filter, set.filter_hz), (4, [350, 322]));
    assert_eq!((set.limits_v, set.sensor_gain), ([2.5, -2.5], 2.0));
    assert_eq!((set.firmware, set.serial_number), (100, 15_001));
    assert_eq!(set.to_words(), words);
    let mut line = Script::new(&[&parameter_reply(&set)]);
    let mut transaction = Transaction::default();
    transaction.send(&mut line, Command::Parameters(1), ms(0)).expect("the line is up");
    assert_eq!(line.sent, ["R2E"]);
    let reply = transaction.poll(&mut line, 0.05, ms(1)).expect("the reply is whole");
    assert_eq!(reply, Some(Reply::Parameters(1, set)));
}

fn command() -> impl Strategy<Value = Command> {
    // The resolution of an order on the line.
    let order = (-1_000_000..=1_000_000_i32).prop_map(|steps| f64::from(steps) * 1e-5);
    prop_oneof![
        (0..2_usize).prop_map(Command::SelectAxis),
        any::<bool>().prop_map(Command::CloseLoop),
        any::<bool>().prop_map(Command::DigitalSource),
        order.clone().prop_map(Command::Order),
        order.prop_map(Command::StoredOrder),
        (0..2_usize).prop_map(Command::Feedback),
        (0..2_usize).prop_map(Command::Parameters),
        any::<u16>().prop_map(Command::BitRate),
    ]
}

proptest! {
    #[test]
    fn every_command_is_read_as_it_was_written(command in command()) {
        let encoded = command.encode();
        prop_assert!(COMMAND_LENGTH.contains(&encoded.bytes().len()));
        let read = Command::decode(encoded.bytes()).expect("a command of the manual");
        match (read, command) {
            (Command::Order(read), Command::Order(written))
            | (Command::StoredOrder(read), Command::StoredOrder(written)) => {
                prop_assert!((read - written).abs() < 1e-9, "{read} for {written}");
            }
            _ => prop_assert_eq!(read, command),
        }
    }

    #[test]
    fn no_bytes_are_more_than_a_command_or_none(bytes in prop::collection::vec(any::<u8>(), 0..30)) {
        if let Some(command) = Command::decode(&bytes) {
            prop_assert!(COMMAND_LENGTH.contains(&bytes.len()), "{command:?}");
            prop_assert_eq!(bytes.last(), Some(&TERMINATOR));
        }
    }

    #[test]
    fn every_word_of_volts_survives(word in -32_768..=32_768_i32) {
        prop_assert_eq!(volts_to_word(word_to_volts(word)), word);
    }

    #[test]
    fn no_reply_makes_the_driver_panic(reply in prop::collection::vec(any::<u8>(), 0..70), command in command()) {
        let mut line = Script::new(&[&reply]);
        let mut transaction = Transaction::default();
        transaction.send(&mut line, command, ms(0)).expect("the line is up");
        let outcome = transaction.poll(&mut line, 0.05, ms(1));
        let needed = command.reply_length();
        prop_assert_eq!(matches!(outcome, Ok(None)), reply.len() < needed);
    }
}
