//! The dialogue that opens a unit, against a unit that is a table of answers.

use super::*;

/// A unit reduced to its answers, which lie ready at once.
struct Table {
    payload: [u8; 21],
    /// What service mode does not keep.
    stubborn: bool,
    refuses: Option<&'static str>,
    deaf: bool,
    in_service: bool,
    answers: Vec<u8>,
    log: Vec<String>,
}

impl Table {
    fn new(payload: [u8; 21]) -> Self {
        // The tail of a measurement stands in front of the first answer.
        let answers = bytes("90 00 40 11 08");
        Self { payload, stubborn: false, refuses: None, deaf: false, in_service: false, answers, log: vec![] }
    }

    fn normal(&mut self, command: &str) {
        let answer = match command {
            "N" => datagram(0xB1, b"\x08\x41\x67\x2D\x44\x00\x00\x2D\x32\x10\x03\0\0\0K"),
            "I" => datagram(0xB5, b"N\x25\x58\x24\x05\x00\x20\x02SIM\0\0\0\0"),
            "C" => datagram(0xBC, &self.payload),
            "SERVICEMODE" => {
                self.in_service = true;
                b"SERIAL NUMBER = N25582405002002\rPRODUCT = STIM300\r>".to_vec()
            }
            _ => vec![],
        };
        self.answers.extend(answer);
    }

    fn service(&mut self, command: &str) {
        self.answers.extend(command.bytes());
        self.answers.push(b'\r');
        let mut payload = self.payload;
        let text = match command {
            _ if self.refuses.is_some_and(|refused| command.starts_with(refused)) => {
                "E003 INVALID PARAMETER\r"
            }
            "m 0" => (payload[2] &= 0x1F, "SAMPLE RATE [samples/s] = 125\r").1,
            "m 3" => (payload[2] = payload[2] & 0x1F | 0x60, "SAMPLE RATE [samples/s] = 1000\r").1,
            "d 1,0" => (payload[2] = payload[2] & 0xE0 | 0x02, "DATAGRAM = RATE, ACCELERATION\r").1,
            "u g,0" => (payload[4] = 0x70, "GYRO OUTPUT UNIT\r").1,
            "u a,0" => (payload[7] = 0x70, "ACCELEROMETER OUTPUT UNIT\r").1,
            "x N" => {
                self.in_service = false;
                self.answers.extend(b"SYSTEM RETURNING TO NORMAL MODE\r");
                return;
            }
            _ => "E001 UNKNOWN COMMAND\r",
        };
        if !self.stubborn {
            self.payload = payload;
        }
        self.answers.extend(text.bytes());
        self.answers.push(b'>');
    }
}

impl ByteLine for Table {
    fn name(&self) -> &str {
        "table"
    }

    fn read(&mut self, _now: Duration, into: &mut [u8]) -> Result<usize, DeviceError> {
        let count = self.answers.len().min(into.len());
        into[..count].copy_from_slice(&self.answers[..count]);
        self.answers.drain(..count);
        Ok(count)
    }

    fn write(&mut self, _now: Duration, bytes: &[u8]) -> Result<(), DeviceError> {
        let command = String::from_utf8(bytes.to_vec()).expect("commands are text");
        let command = command.strip_suffix('\r').expect("a CR ends a command").to_owned();
        self.log.push(command.clone());
        match (self.deaf, self.in_service) {
            (true, _) => {}
            (false, true) => self.service(&command),
            (false, false) => self.normal(&command),
        }
        Ok(())
    }
}

fn open_with(table: &mut Table, settings: Stim300Settings) -> Result<Stim300, DeviceError> {
    let mut opening = Opening::new(settings)?;
    for tick in 0..10_000 {
        if let Some(unit) = opening.poll(table, Duration::from_millis(tick))? {
            return Ok(unit);
        }
    }
    panic!("neither open nor refused after 10 s");
}

fn open(table: &mut Table) -> Result<Stim300, DeviceError> {
    open_with(table, settings())
}

/// Rates and inclinations with CR LF off, incremental angles and velocities, 2 kHz.
fn otherwise() -> [u8; 21] {
    let mut payload = AS_WANTED;
    (payload[2], payload[4], payload[7]) = (0x84, 0x71, 0x71);
    payload
}

#[test]
fn a_unit_that_is_right_is_only_asked() {
    let mut table = Table::new(AS_WANTED);
    let imu = open(&mut table).expect("nothing to change");
    assert_eq!(table.log, ["N", "I", "C"]);
    assert_eq!(imu.identity().part_number, "84167-4400003-321 REV K");
    assert_eq!(imu.identity().serial, "N25582405002002-SIM");
    assert_eq!(imu.identity().configuration.accelerometer_range, [AccelerometerRange::G10; 3]);
}

#[test]
fn a_unit_that_is_set_otherwise_is_changed_in_service_mode_and_read_back() {
    let mut table = Table::new(otherwise());
    let imu = open(&mut table).expect("everything can be set");
    let expected = ["N", "I", "C", "SERVICEMODE", "m 0", "d 1,0", "u g,0", "u a,0", "m 3", "x N", "C"];
    assert_eq!(table.log, expected);
    assert_eq!(imu.identity().configuration, Configuration::decode(&AS_WANTED).expect("listed codes"));
    assert!(!table.in_service);
}

#[test]
fn a_unit_that_may_not_be_changed_is_refused_with_expected_and_found() {
    let mut table = Table::new(otherwise());
    let fixed = Stim300Settings { may_change_unit: false, ..settings() };
    let error = open_with(&mut table, fixed).expect_err("92h").to_string();
    assert!(
        error.starts_with("imu: datagram: expected 91h, found 92h; change it in service mode"),
        "{error}"
    );
    assert!(!table.log.contains(&"SERVICEMODE".to_owned()));
}

#[test]
fn a_setting_that_does_not_stick_is_refused() {
    let mut table = Table::new(otherwise());
    table.stubborn = true;
    let error = open(&mut table).expect_err("it stays").to_string();
    assert!(error.starts_with("imu: datagram: expected 91h, found 92h; the unit did not keep"), "{error}");
}

#[test]
fn an_error_of_service_mode_is_told_in_the_words_of_the_unit() {
    let mut table = Table::new(otherwise());
    table.refuses = Some("u g");
    let error = open(&mut table).expect_err("E003").to_string();
    let expected = "imu: service mode: expected \"u g,0\" to be accepted, found E003 INVALID PARAMETER;";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn another_bit_rate_or_a_dead_axis_is_refused_and_not_changed() {
    let mut payload = otherwise();
    payload[3] = 0x31;
    let mut table = Table::new(payload);
    let error = open(&mut table).expect_err("the line runs at another rate").to_string();
    assert!(error.starts_with("imu: bit rate: expected 921600, found 1843200;"), "{error}");
    let mut payload = AS_WANTED;
    payload[4] = 0x50;
    let mut table = Table::new(payload);
    let error = open(&mut table).expect_err("no gyro Y").to_string();
    assert!(error.starts_with("imu: active gyros: expected XYZ, found X-Z;"), "{error}");
    assert_eq!(table.log.len(), 3);
}

#[test]
fn a_unit_that_was_left_in_service_mode_is_brought_back() {
    let mut table = Table::new(AS_WANTED);
    table.in_service = true;
    let imu = open(&mut table).expect("it comes back");
    assert_eq!(table.log, ["N", "x N", "N", "I", "C"]);
    assert_eq!(imu.identity().serial, "N25582405002002-SIM");
}

#[test]
fn a_silent_unit_is_given_up_after_three_tries() {
    let mut table = Table::new(AS_WANTED);
    table.deaf = true;
    let error = open(&mut table).expect_err("silence").to_string();
    assert!(error.starts_with("imu: answer: expected one, found no answer to 3 commands \"N\";"), "{error}");
    assert_eq!(table.log, ["N"; 3]);
}

#[test]
fn an_unknown_code_of_the_configuration_is_refused_by_name() {
    let mut payload = AS_WANTED;
    payload[16] = 0x11;
    let error = open(&mut Table::new(payload)).expect_err("no such range").to_string();
    assert!(
        error.starts_with("imu: accelerometer range: expected a code of the datasheet, found 1h;"),
        "{error}"
    );
}

/// TS1524, table 5-12: bytes of the datagram, highest rate at 374400, 460800, 921600, 1843200 bit/s.
#[test]
fn the_highest_rate_by_bit_rate_is_that_of_the_datasheet() {
    let table = [
        (0x90, [1000, 2000, 2000, 2000]),
        (0x91, [1000, 1000, 2000, 2000]),
        (0x93, [500, 1000, 2000, 2000]),
        (0x94, [1000, 1000, 2000, 2000]),
        (0xA5, [500, 500, 1000, 2000]),
        (0xA7, [500, 500, 1000, 2000]),
        (0xF0, [1000, 1000, 2000, 2000]),
        (0xF1, [1000, 1000, 2000, 2000]),
        (0xF3, [500, 500, 1000, 2000]),
        (0xF4, [1000, 1000, 2000, 2000]),
        (0xF5, [500, 500, 1000, 2000]),
        (0xF7, [500, 500, 1000, 2000]),
    ];
    for (id, highest_hz) in table {
        for (bit_rate, highest_hz) in [374_400, 460_800, 921_600, 1_843_200].into_iter().zip(highest_hz) {
            let content = Content::by_id(id).expect("listed");
            let possible = |rate_hz: &u32| {
                let sample_rate = SampleRate::Internal(*rate_hz);
                Opening::new(Stim300Settings { bit_rate, content, sample_rate, ..settings() }).is_ok()
            };
            let found = [2000, 1000, 500, 250, 125].into_iter().find(possible);
            assert_eq!(found, Some(highest_hz), "{id:02X}h at {bit_rate} bit/s");
        }
    }
}

#[test]
fn rates_and_units_that_the_driver_cannot_use_are_refused() {
    let odd = Stim300Settings { sample_rate: SampleRate::Internal(300), ..settings() };
    let error = Opening::new(odd).expect_err("not a rate of the unit").to_string();
    assert!(error.starts_with("imu: setting sample rate, Hz is 300;"), "{error}");
    let slow = Stim300Settings { bit_rate: 300_000, ..settings() };
    let error = Opening::new(slow).expect_err("308 kbit/s").to_string();
    assert_eq!(
        error,
        "imu: setting bit rate, bit/s is 300000; datagram 91h at 1000 Hz needs at least 308000 bit/s"
    );
    let velocity = Stim300Settings { accelerometer_unit: ForceUnit::IntegratedVelocity, ..settings() };
    assert!(Opening::new(velocity).is_err());
}
