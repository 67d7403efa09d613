mod vectors;

use std::collections::VecDeque;

use super::protocol::*;
use super::*;

/// A line whose far end answers from a script and keeps what it was sent.
struct Script {
    sent: Vec<String>,
    replies: VecDeque<Vec<u8>>,
    incoming: VecDeque<u8>,
}

impl Script {
    fn new(replies: &[&[u8]]) -> Self {
        let replies = replies.iter().map(|reply| reply.to_vec()).collect();
        Self { sent: Vec::new(), replies, incoming: VecDeque::new() }
    }
}

impl ByteLine for Script {
    fn name(&self) -> &str {
        "mirror line"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.incoming.len());
        into.iter_mut().zip(self.incoming.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        self.sent.push(String::from_utf8_lossy(bytes).into_owned());
        self.incoming.extend(self.replies.pop_front().unwrap_or_default());
        Ok(())
    }
}

/// An analog card that echoes its outputs on the inputs ten channels up.
#[derive(Default)]
struct Card([f64; 4]);

impl AnalogPort for Card {
    fn name(&self) -> &str {
        "analog card"
    }

    fn write_v(&mut self, _: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        self.0[channel] = volts;
        Ok(())
    }

    fn read_v(&mut self, _: Duration, channel: usize) -> Result<f64, DeviceError> {
        Ok(self.0[channel - 10])
    }
}

fn settings(command: Path, feedback: Path) -> MirrorSettings {
    MirrorSettings {
        name: "fsm".into(),
        scale_rad_per_v: [500e-6; 2],
        stroke_rad: [1.05e-3; 2],
        command,
        feedback,
        command_outputs: [2, 3],
        feedback_inputs: [12, 13],
        reply_timeout_s: 0.05,
    }
}

fn driver(command: Path, feedback: Path) -> Mirror {
    Mirror::new(settings(command, feedback)).expect("the settings are sound")
}

fn ms(n: u64) -> Duration {
    Duration::from_millis(n)
}

fn parameter_reply(set: &ParameterSet) -> Vec<u8> {
    let mut bytes: Vec<u8> = set.to_words().iter().flat_map(|word| word.to_be_bytes()).collect();
    bytes.push(ACKNOWLEDGE);
    bytes
}

#[test]
fn the_feedback_vector_of_the_manual_is_minus_1_65_volts() {
    assert_eq!(Command::Feedback(1).encode().bytes(), b"Q2E");
    let mut line = Script::new(&[&[0xFF, 0xFF, 0xEA, 0xE2, 0x58]]);
    let mut transaction = Transaction::default();
    transaction.send(&mut line, Command::Feedback(1), ms(0)).expect("the line is up");
    let reply = transaction.poll(&mut line, 0.05, ms(1)).expect("the reply is whole");
    let Some(Reply::Feedback(1, volts)) = reply else { panic!("{reply:?}") };
    assert!((volts + 1.65).abs() < 0.5 / WORDS_PER_V * 2.0, "{volts}");
    assert_eq!(volts_to_word(volts).to_be_bytes(), [0xFF, 0xFF, 0xEA, 0xE2]);
}

#[test]
fn commands_are_written_and_read_as_the_manual_says() {
    let cases: [(Command, &str); 8] = [
        (Command::SelectAxis(1), "V2E"),
        (Command::CloseLoop(true), "B1E"),
        (Command::DigitalSource(false), "T0E"),
        (Command::Order(2.435), "Z2.43500E"),
        (Command::StoredOrder(-10.0), "W-10.00000E"),
        (Command::Feedback(0), "Q1E"),
        (Command::Parameters(0), "R1E"),
        (Command::BitRate(1171), "b1171E"),
    ];
    for (command, text) in cases {
        assert_eq!(command.encode().bytes(), text.as_bytes());
        assert_eq!(Command::decode(text.as_bytes()), Some(command), "{text}");
    }
    for bad in
        ["", "E", "ZE", "Z1", "V3E", "B2E", "Z10.1E", "Z1\rE", "Z2.435V", "Z1e1E", "ZinfE", "b70000E", "k1E"]
    {
        assert_eq!(Command::decode(bad.as_bytes()), None, "{bad}");
    }
    assert_eq!(Command::decode(b"Z0000000000000000.5E"), Some(Command::Order(0.5)));
    assert_eq!(Command::decode(b"Z00000000000000000.5E"), None, "21 characters");
    assert_eq!(Command::Order(f64::NAN).encode().bytes(), b"Z0.00000E");
    assert_eq!(Command::Order(1e9).encode().bytes(), b"Z10.00000E");
}

#[test]
fn a_parameter_set_survives_the_wire() {
    let set = ParameterSet {
        digital_source: true,
        order_v: -1.25,
        closed_loop: true,
        proportional_gain: 0.5,
        integral_gain: 500.0,
        filter: 2,
        filter_hz: [350, 0],
        limits_v: [2.5, -2.5],
        sensor_gain: 1.0,
        firmware: 100,
        serial_number: 15_001,
        ..ParameterSet::default()
    };
    assert_eq!(ParameterSet::from_words(&set.to_words()), set);
}

#[test]
fn configuring_selects_orders_zero_sets_the_source_closes_and_reads_back_each_axis() {
    let set =
        parameter_reply(&ParameterSet { closed_loop: true, digital_source: true, ..Default::default() });
    let x: &[u8] = b"X";
    let mut line = Script::new(&[x, x, x, x, &set, x, x, x, x, &set]);
    let mut mirror = driver(Path::Serial, Path::Serial);
    let identity = (0..20).find_map(|k| mirror.configure(&mut line, ms(k)).expect("the unit answers"));
    assert!(identity.is_some_and(|[az, el]| az.closed_loop && el.digital_source));
    let expected = ["V1E", "Z0.00000E", "T1E", "B1E", "R1E", "V2E", "Z0.00000E", "T1E", "B1E", "R2E"];
    assert_eq!(line.sent, expected);
}

#[test]
fn another_way_of_commands_waits_for_the_reply_under_way_and_leaves_the_line_to_the_configuration() {
    let set = |digital_source| {
        parameter_reply(&ParameterSet { closed_loop: true, digital_source, ..Default::default() })
    };
    let serial = set(true);
    let analog = set(false);
    let x: &[u8] = b"X";
    let zero: &[u8] = &[0, 0, 0, 0, 0x58];
    let configured = |set| [x, x, x, x, set, x, x, x, x, set];
    let replies = [&configured(&serial)[..], &[zero], &configured(&analog)].concat();
    let mut line = Script::new(&replies);
    let mut card = Card::default();
    let mut mirror = driver(Path::Serial, Path::Serial);
    let done = |mirror: &mut Mirror, line: &mut Script, from| {
        (from..from + 30).find(|&k| mirror.configure(line, ms(k)).expect("the unit answers").is_some())
    };
    done(&mut mirror, &mut line, 0).expect("the unit is configured");
    mirror.exchange(&mut line, &mut card, [0.0; 2], ms(40)).expect("the line is up");
    assert_eq!(line.sent.last().map(String::as_str), Some("Q1E"), "a question is under way");
    mirror.change_command_path(Path::Analog);
    mirror.exchange(&mut line, &mut card, [250e-6, 0.0], ms(41)).expect("the line is up");
    assert_eq!(line.sent.len(), 11, "the line is left to the configuration");
    done(&mut mirror, &mut line, 42).expect("the unit takes the other source");
    let expected = ["V1E", "Z0.00000E", "T0E", "B1E", "R1E", "V2E", "Z0.00000E", "T0E", "B1E", "R2E"];
    assert_eq!((&line.sent[11..], mirror.command_path()), (&expected.map(str::to_owned)[..], Path::Analog));
    let actuals = mirror.exchange(&mut line, &mut card, [250e-6, 0.0], ms(80)).expect("the card works");
    assert_eq!((actuals.command_rad[0], line.sent.len()), (250e-6, 22), "feedback goes on over the line");
}

#[test]
fn a_unit_whose_switch_keeps_it_analog_is_refused_for_serial_orders() {
    let set = parameter_reply(&ParameterSet { closed_loop: true, ..Default::default() });
    let mut line = Script::new(&[b"X", b"X", b"X", b"X", &set]);
    let mut mirror = driver(Path::Serial, Path::Serial);
    let error = (0..20).find_map(|k| mirror.configure(&mut line, ms(k)).err()).map(|error| error.to_string());
    assert!(
        error.as_ref().is_some_and(|text| text.contains("azimuth: source expected digital")),
        "{error:?}"
    );
}

#[test]
fn silence_and_a_wrong_last_byte_are_errors_that_name_the_command() {
    let mut mirror = driver(Path::Serial, Path::Serial);
    let mut mute = Script::new(&[]);
    let error =
        (0..100).find_map(|k| mirror.configure(&mut mute, ms(k)).err()).map(|error| error.to_string());
    assert!(
        error.as_ref().is_some_and(|text| text.contains("reply: expected 1 bytes to V1E, found 0 bytes within 0.051 s")),
        "{error:?}"
    );
    let mut mirror = driver(Path::Serial, Path::Serial);
    let mut noisy = Script::new(&[b"?"]);
    let error = (0..9).find_map(|k| mirror.configure(&mut noisy, ms(k)).err()).map(|error| error.to_string());
    assert!(error.as_ref().is_some_and(|text| text.contains("found 3Fh")), "{error:?}");
}

#[test]
fn analog_commands_are_scaled_limited_to_the_stroke_and_fed_back() {
    let mut mirror = driver(Path::Analog, Path::Analog);
    let mut line = Script::new(&[]);
    let mut card = Card::default();
    let actuals = mirror.exchange(&mut line, &mut card, [250e-6, -5e-3], ms(7)).expect("the card works");
    assert!(card.0[2] == 0.5 && (card.0[3] + 2.1).abs() < 1e-12, "{:?}", card.0);
    assert_eq!(actuals.angle_rad, actuals.command_rad);
    assert!((actuals.command_rad[1] + 1.05e-3).abs() < 1e-18);
    assert_eq!((actuals.feedback_at, actuals.feedback_counter), (ms(7), 1));
    assert!(line.sent.is_empty());
    let not_a_number = mirror.exchange(&mut line, &mut card, [f64::NAN, 0.0], ms(8)).expect("the card works");
    assert_eq!(not_a_number.command_rad, [0.0, 0.0]);
}

#[test]
fn serial_orders_go_only_when_they_change_and_share_the_line_with_the_feedback() {
    let minus: &[u8] = &[0xFF, 0xFF, 0xEA, 0xE2, 0x58];
    let zero: &[u8] = &[0, 0, 0, 0, 0x58];
    let mut line = Script::new(&[b"X", minus, zero, b"X", b"X", minus, zero, minus]);
    let mut mirror = driver(Path::Serial, Path::Serial);
    let mut card = Card::default();
    let mut last = Actuals::default();
    for (k, command) in [1e-4, 1e-4, 1e-4].iter().chain(&[2e-4; 5]).enumerate() {
        let both = if k < 3 { [*command, 0.0] } else { [1e-4, *command] };
        last = mirror.exchange(&mut line, &mut card, both, ms(k as u64)).expect("the unit answers");
    }
    assert_eq!(line.sent, ["Z0.20000E", "Q1E", "Q2E", "V2E", "Z0.40000E", "Q1E", "Q2E", "Q1E"]);
    assert_eq!(last.command_rad, [1e-4, 2e-4]);
    assert!((last.angle_rad[0] + 1.65 * 500e-6).abs() < 1e-6 && last.feedback_counter == 4, "{last:?}");
}

#[test]
fn after_a_lost_reply_the_orders_of_both_axes_are_sent_anew_and_a_late_reply_is_thrown_away() {
    let zero: &[u8] = &[0, 0, 0, 0, 0x58];
    let mut line = Script::new(&[b"", b"X", b"X", zero, zero, b"X", b"X"]);
    let mut mirror = driver(Path::Serial, Path::Serial);
    let mut card = Card::default();
    let lost = (0..100).find_map(|k| mirror.exchange(&mut line, &mut card, [1e-4, 0.0], ms(k)).err());
    let text = lost.expect("no reply comes").to_string();
    assert_eq!(
        text,
        "mirror line: reply: expected 1 bytes to Z0.20000E, found 0 bytes within 0.051 s; check power, cable and bit \
         rate of the mirror unit"
    );
    line.incoming.extend(b"X");
    for k in 100..107 {
        mirror.exchange(&mut line, &mut card, [0.0; 2], ms(k)).expect("the unit answers again");
    }
    assert_eq!(line.sent, ["Z0.20000E", "V2E", "Z0.00000E", "Q1E", "Q2E", "V1E", "Z0.00000E", "Q1E"]);
}

#[test]
fn a_scale_of_zero_or_no_stroke_is_refused() {
    let broken = MirrorSettings { stroke_rad: [1e-3, f64::NAN], ..settings(Path::Analog, Path::Analog) };
    assert!(matches!(
        Mirror::new(broken),
        Err(DeviceError::Setting { setting: "stroke_rad of elevation", .. })
    ));
}

#[test]
fn a_row_has_a_value_for_every_channel() {
    assert_eq!(Actuals::default().row().len(), Mirror::CHANNELS.len());
}
