use std::time::Duration;

use super::*;

/// A unit reduced to a table of entries; answers lie ready at once.
struct Table {
    entries: Vec<(&'static str, String)>,
    locked: bool,
    deaf: bool,
    config: bool,
    answers: Vec<u8>,
    log: Vec<String>,
}

impl Table {
    fn new(entries: &[(&'static str, &str)]) -> Self {
        let entries = entries.iter().map(|&(name, value)| (name, value.to_owned())).collect();
        // The tail of a binary message stands in front of the first answer.
        Self {
            entries,
            locked: false,
            deaf: false,
            config: false,
            answers: b"\xFE\x81\x34A".to_vec(),
            log: vec![],
        }
    }

    fn entry(&mut self, name: &str) -> Option<&mut String> {
        self.entries.iter_mut().find(|(entry, _)| *entry == name).map(|(_, value)| value)
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
        self.log.push(command.trim().to_owned());
        if self.deaf {
            return Ok(());
        }
        let (kind, rest) = command.trim().split_at(1);
        let (name, value) = rest.split_once(',').unwrap_or((rest, ""));
        let locked = self.locked;
        let answer = match (kind, name) {
            ("=", "CONFIG") => {
                self.config = value == "1";
                self.config.then(|| "CONFIG,1".to_owned())
            }
            _ => match self.entry(name) {
                Some(entry) => {
                    if kind == "=" && !locked {
                        value.clone_into(entry);
                    }
                    Some(format!("{name},{entry}"))
                }
                None => Some(format!("INVALID,{rest}")),
            },
        };
        if let Some(answer) = answer {
            self.answers.extend(answer.bytes());
            self.answers.extend(b"\r\n");
        }
        Ok(())
    }
}

const OTHERWISE: [(&str, &str); 9] = [
    ("IS", "A1234"),
    ("BAUD", "4147200"),
    ("OUTPUTFMT", "C"),
    ("ROTFMT", "DELTA"),
    ("ROTUNITS", "DEG"),
    ("LINFMT", "ACCEL"),
    ("TEMPUNITS", "F"),
    ("MSYNC", "IMU"),
    ("DR", "1000"),
];

fn open(table: &mut Table) -> Result<Kvh, DeviceError> {
    let mut opening = Opening::new(settings())?;
    for tick in 0..10_000 {
        if let Some(kvh) = opening.poll(table, Duration::from_millis(tick))? {
            return Ok(kvh);
        }
    }
    panic!("neither open nor refused after 10 s");
}

#[test]
fn a_unit_that_is_set_otherwise_is_changed_and_read_back() {
    let mut table = Table::new(&OTHERWISE);
    let imu = open(&mut table).expect("everything can be set");
    assert_eq!(imu.identity().serial, "A1234");
    for (name, value) in [("OUTPUTFMT", "A"), ("ROTFMT", "RATE"), ("ROTUNITS", "RAD"), ("MSYNC", "EXT")] {
        assert_eq!(table.entry(name).expect("listed"), value);
        let asked = table.log.iter().filter(|line| **line == format!("?{name}")).count();
        assert_eq!(asked, 2, "{name} is read back");
    }
    assert!(!table.log.iter().any(|line| line.starts_with("=LINFMT")), "right already");
    assert_eq!(table.log.last().expect("some"), "=CONFIG,0");
    assert!(!table.config);
}

#[test]
fn an_entry_that_does_not_stick_is_refused_with_expected_and_found() {
    let mut table = Table::new(&OTHERWISE);
    table.locked = true;
    let error = open(&mut table).expect_err("OUTPUTFMT stays C").to_string();
    assert!(error.starts_with("imu: OUTPUTFMT: expected A, found C;"), "{error}");
}

#[test]
fn another_bit_rate_is_refused_and_not_changed() {
    let mut entries = OTHERWISE;
    entries[1].1 = "921600";
    let mut table = Table::new(&entries);
    let error = open(&mut table).expect_err("the line runs at another rate").to_string();
    assert!(error.starts_with("imu: BAUD: expected 4147200, found 921600;"), "{error}");
    assert!(!table.log.iter().any(|line| line.starts_with("=BAUD")));
}

#[test]
fn an_unknown_command_is_refused_with_what_the_unit_said() {
    let mut table = Table::new(&OTHERWISE[..4]);
    let error = open(&mut table).expect_err("no ROTUNITS").to_string();
    assert!(error.starts_with("imu: ROTUNITS: expected RAD, found INVALID,ROTUNITS;"), "{error}");
}

#[test]
fn a_silent_unit_is_given_up_after_three_tries() {
    let mut table = Table::new(&OTHERWISE);
    table.deaf = true;
    let error = open(&mut table).expect_err("silence").to_string();
    assert!(error.starts_with("imu: CONFIG: expected 1, found no answer to 3 commands;"), "{error}");
    assert_eq!(table.log, ["=CONFIG,1"; 3]);
}

#[test]
fn messages_that_do_not_fit_on_the_line_are_refused() {
    let slow = KvhSettings { baud: 921_600, message_rate_hz: 4000.0, ..settings() };
    let error = Opening::new(slow).expect_err("1.44 Mbit/s").to_string();
    assert!(error.contains("at most 2560 Hz at 921600 baud"), "{error}");
}
