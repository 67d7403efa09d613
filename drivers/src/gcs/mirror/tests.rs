use std::collections::VecDeque;

use super::*;

/// A controller with servos and target inputs, and a line on which replies take a millisecond.
#[derive(Default)]
struct Controller {
    sent: Vec<String>,
    incoming: VecDeque<u8>,
    error: i32,
    servos: bool,
    inputs: [u32; 2],
    is_deaf: bool,
    /// Replies in pieces of this many bytes.
    piece: usize,
    travel: f64,
}

impl Controller {
    fn new() -> Self {
        Self { piece: 256, travel: 1050.0, error: 10, ..Self::default() }
    }

    fn answer(&mut self, line: &str) -> Option<String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["ERR?"] => Some(format!("{}\n", std::mem::take(&mut self.error))),
            ["*IDN?"] => Some("(c)2015 PI, E-727.3SDA, 116051234, 12.34\n".to_owned()),
            ["SAI?"] => Some("1 \n2\n".to_owned()),
            ["TMN?", ..] => Some(format!("1=-{0} \n2=-{0}\n", self.travel)),
            ["TMX?", ..] => Some(format!("1={0} \n2={0}\n", self.travel)),
            ["SPA", axis, "0x06000500", value] => {
                let place: usize = axis.parse().expect("a number");
                self.inputs[place - 1] = value.parse().expect("a number");
                None
            }
            ["SPA?", axis, id] => {
                let place: usize = axis.parse().expect("a number");
                Some(format!("{axis} {id}={}\n", self.inputs[place - 1]))
            }
            ["SVO", ..] => {
                self.servos = true;
                None
            }
            ["SVO?", ..] => Some(format!("1={0} \n2={0}\n", u8::from(self.servos))),
            ["MOV", ..] => None,
            ["POS?", ..] => Some("1=12.5 \n2=-700.25\n".to_owned()),
            other => panic!("{other:?}"),
        }
    }
}

impl ByteLine for Controller {
    fn name(&self) -> &str {
        "mirror line"
    }

    fn read(&mut self, _: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = into.len().min(self.incoming.len()).min(self.piece);
        into.iter_mut().zip(self.incoming.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, _: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        for line in String::from_utf8_lossy(bytes).lines() {
            self.sent.push(line.to_owned());
            let answer = if self.is_deaf { None } else { self.answer(line) };
            self.incoming.extend(answer.unwrap_or_default().bytes());
        }
        Ok(())
    }
}

/// Volts at inputs and outputs.
#[derive(Default)]
struct Card {
    outputs_v: [f64; 2],
}

impl AnalogPort for Card {
    fn name(&self) -> &str {
        "card"
    }

    fn write_v(&mut self, _: Duration, channel: usize, volts: f64) -> Result<(), DeviceError> {
        self.outputs_v[channel] = volts;
        Ok(())
    }

    fn read_v(&mut self, _: Duration, channel: usize) -> Result<f64, DeviceError> {
        Ok([0.25, -0.5][channel])
    }
}

fn settings(command: Path, feedback: Path) -> GcsMirrorSettings {
    GcsMirrorSettings {
        name: "fsm".into(),
        axes: ["1".into(), "2".into()],
        position_unit_rad: 1e-6,
        scale_rad_per_v: [500e-6; 2],
        stroke_rad: [1e-3; 2],
        command,
        feedback,
        target_inputs: [5, 6],
        command_outputs: [0, 1],
        feedback_inputs: [0, 1],
        answer_timeout_s: 0.05,
    }
}

/// Configures once a millisecond.
fn configure(
    mirror: &mut GcsMirror,
    line: &mut Controller,
    now: &mut Duration,
) -> Result<String, DeviceError> {
    for _ in 0..1000 {
        *now += Duration::from_millis(1);
        if let Some(identity) = mirror.configure(line, *now)? {
            return Ok(identity);
        }
    }
    panic!("neither configured nor an error after 1 s");
}

fn opened(settings: GcsMirrorSettings) -> (GcsMirror, Controller, Duration) {
    let mut mirror = GcsMirror::new(settings).expect("sound settings");
    let (mut line, mut now) = (Controller::new(), Duration::ZERO);
    let identity = configure(&mut mirror, &mut line, &mut now).expect("it answers");
    assert!(identity.contains("E-727"), "{identity}");
    (mirror, line, now)
}

#[test]
fn a_controller_with_an_old_error_is_identified_closed_and_sent_to_its_middle() {
    let (_, line, _) = opened(settings(Path::Serial, Path::Serial));
    let expected = [
        "ERR?",
        "*IDN?",
        "SAI?",
        "TMN? 1 2",
        "TMX? 1 2",
        "SPA 1 0x06000500 0",
        "ERR?",
        "SPA 2 0x06000500 0",
        "ERR?",
        "SVO 1 1 2 1",
        "ERR?",
        "SVO? 1 2",
        "SPA? 1 0x06000500",
        "SPA? 2 0x06000500",
        "MOV 1 0.000000 2 0.000000",
        "ERR?",
    ];
    assert_eq!(line.sent, expected);
}

#[test]
fn analog_commands_are_made_the_targets_and_no_position_is_sent() {
    let (mut mirror, mut line, now) = opened(settings(Path::Analog, Path::Analog));
    assert_eq!(line.inputs, [5, 6]);
    let mut card = Card::default();
    let sent = line.sent.len();
    let actuals = mirror.exchange(&mut line, &mut card, [250e-6, -2e-3], now).expect("all is there");
    assert_eq!((card.outputs_v, line.sent.len()), ([0.5, -2.0], sent), "limited to the stroke of 1 mrad");
    assert_eq!((actuals.command_rad, actuals.angle_rad), ([250e-6, -1e-3], [125e-6, -250e-6]));
}

#[test]
fn positions_that_changed_and_feedback_take_turns_on_the_line() {
    let (mut mirror, mut line, mut now) = opened(settings(Path::Serial, Path::Serial));
    line.sent.clear();
    // Cut anywhere: a space and a line feed in different reads do not end a reply.
    line.piece = 5;
    let mut actuals = Actuals::default();
    for tick in 0..8 {
        now += Duration::from_millis(1);
        let command_rad = if tick < 4 { [100e-6, 0.0] } else { [f64::NAN, 5e-3] };
        actuals = mirror.exchange(&mut line, &mut Card::default(), command_rad, now).expect("it answers");
    }
    let (ask, error) = ("POS? 1 2", "ERR?");
    let (first, second) = ("MOV 1 100.000000 2 0.000000", "MOV 1 0.000000 2 1000.000000");
    assert_eq!(line.sent[..8], [ask, first, error, ask, ask, second, error, ask]);
    let [az, el] = actuals.angle_rad;
    assert!((az - 12.5e-6).abs() < 1e-12 && (el + 700.25e-6).abs() < 1e-12, "{actuals:?}");
    assert!((actuals.command_rad[1] - 1e-3).abs() < 1e-12 && actuals.feedback_counter > 2, "{actuals:?}");
}

#[test]
fn what_the_tick_asked_is_answered_before_the_path_changes() {
    let (mut mirror, mut line, mut now) = opened(settings(Path::Serial, Path::Analog));
    mirror.exchange(&mut line, &mut Card::default(), [1e-4; 2], now).expect("it is there");
    mirror.change_command_path(Path::Analog);
    assert!(mirror.is_changing());
    configure(&mut mirror, &mut line, &mut now).expect("no reply is taken for another one");
    assert_eq!((line.inputs, mirror.command_path(), mirror.is_changing()), ([5, 6], Path::Analog, false));
}

#[test]
fn errors_name_command_number_and_meaning_and_the_position_is_sent_again() {
    let (mut mirror, mut line, now) = opened(settings(Path::Serial, Path::Analog));
    let mut card = Card::default();
    line.error = 5;
    mirror.exchange(&mut line, &mut card, [1e-4; 2], now).expect("it is there");
    let error = mirror.exchange(&mut line, &mut card, [1e-4; 2], now).expect_err("servo off").to_string();
    assert!(error.starts_with("fsm: MOV: the instrument reports 5, \"move refused"), "{error}");
    let before = line.sent.len();
    mirror.exchange(&mut line, &mut card, [1e-4; 2], now).expect("it is there");
    assert_eq!(line.sent[before], "MOV 1 100.000000 2 100.000000");
    line.incoming.clear();
    let late = now + Duration::from_millis(60);
    let error = mirror.exchange(&mut line, &mut card, [1e-4; 2], late).expect_err("silence").to_string();
    assert!(error.starts_with("fsm: reply: expected one to MOV, found 0 bytes in 0.05 s;"), "{error}");
}

#[test]
fn a_controller_that_does_not_fit_is_refused() {
    let refused = |own: GcsMirrorSettings, mut line: Controller| {
        let mut mirror = GcsMirror::new(own).expect("sound settings");
        configure(&mut mirror, &mut line, &mut Duration::ZERO.clone()).expect_err("refused").to_string()
    };
    let usual = || settings(Path::Serial, Path::Serial);
    let other = GcsMirrorSettings { axes: ["1".into(), "B".into()], ..usual() };
    let error = refused(other, Controller::new());
    assert!(error.starts_with("fsm: axes (SAI?): expected axis `B` among them, found 1, 2;"), "{error}");
    let error = refused(usual(), Controller { travel: 900.0, ..Controller::new() });
    assert!(
        error.contains("expected -1000.000000 to 1000.000000 for axis `1`, found -900 to 900;"),
        "{error}"
    );
    let error = refused(usual(), Controller { is_deaf: true, ..Controller::new() });
    assert!(error.contains("expected one to \"ERR?\", found 0 bytes"), "{error}");
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let usual = || settings(Path::Serial, Path::Serial);
    let long = "A".repeat(17);
    for own in [
        GcsMirrorSettings { position_unit_rad: 0.0, ..usual() },
        GcsMirrorSettings { stroke_rad: [f64::NAN, 1e-3], ..usual() },
        GcsMirrorSettings { position_unit_rad: 1e-15, ..usual() },
        GcsMirrorSettings { axes: ["1".into(), "1".into()], ..usual() },
        GcsMirrorSettings { axes: [long, "2".into()], ..usual() },
    ] {
        assert!(GcsMirror::new(own.clone()).is_err(), "{own:?}");
    }
}
