//! Service mode (TS1524 rev. 31, section 9): text with echo, `\r>` when the unit is ready, errors as `E<nnn> <text>`.

use super::{Configuration, Content, SampleRate, Stim300Settings};

/// Most text that is kept: the listing at the begin of service mode has about 2200 characters.
const TEXT_BYTES: usize = 4096;
/// Ready for the next command.
const PROMPT: &[u8] = b"\r>";

/// What the unit has said since the last command.
#[derive(Clone, Debug, Default)]
pub(super) struct Text {
    bytes: Vec<u8>,
}

impl Text {
    /// Appends what arrived. Line feeds are left out; if it becomes too long, the oldest half is given up.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes.iter().filter(|byte| **byte != b'\n'));
        if self.bytes.len() > TEXT_BYTES {
            self.bytes.drain(..self.bytes.len() - TEXT_BYTES / 2);
        }
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
    }

    pub(super) fn contains(&self, text: &str) -> bool {
        self.bytes.windows(text.len()).any(|window| window == text.as_bytes())
    }

    /// Whether the unit is ready for the next command.
    pub(super) fn is_ready(&self) -> bool {
        self.bytes.ends_with(PROMPT)
    }

    /// The error message among the lines, if there is one.
    pub(super) fn error(&self) -> Option<String> {
        let is_error = |line: &&[u8]| {
            let number = line.strip_prefix(b"E").and_then(|rest| rest.first_chunk::<4>());
            number.is_some_and(|[a, b, c, space]| {
                [a, b, c].iter().all(|digit| digit.is_ascii_digit()) && *space == b' '
            })
        };
        let line = self.bytes.split(|byte| *byte == b'\r').find(is_error)?;
        Some(String::from_utf8_lossy(line).into_owned())
    }
}

/// Something that the unit is set to otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Difference {
    pub(super) field: &'static str,
    pub(super) expected: String,
    pub(super) found: String,
    /// Command that changes it; `None` if the driver may not or cannot.
    pub(super) command: Option<String>,
}

/// What differs between the settings and the unit.
pub(super) fn differences(settings: &Stim300Settings, unit: &Configuration) -> Vec<Difference> {
    let mut all = Vec::new();
    let mut compare = |field, expected: String, found: String, command| {
        if expected != found {
            all.push(Difference { field, expected, found, command });
        }
    };
    if let Some(bit_rate) = unit.bit_rate {
        compare("bit rate", settings.bit_rate.to_string(), bit_rate.to_string(), None);
    }
    compare("active gyros", active([true; 3]), active(unit.gyros_active), None);
    compare("datagram", name(settings.content), name(unit.content), content_command(settings, unit));
    let gyro_unit = format!("{:?}", settings.gyro_unit);
    let gyro_command = format!("u g,{:x}", settings.gyro_unit.code() | u8::from(unit.is_gyro_delayed) << 3);
    compare("gyro output unit", gyro_unit, format!("{:?}", unit.gyro_unit), Some(gyro_command));
    if settings.content.accelerometers {
        let force_unit = format!("{:?}", settings.accelerometer_unit);
        let command = format!("u a,{}", settings.accelerometer_unit.code());
        compare(
            "accelerometer output unit",
            force_unit,
            format!("{:?}", unit.accelerometer_unit),
            Some(command),
        );
        compare("active accelerometers", active([true; 3]), active(unit.accelerometers_active), None);
    }
    compare(
        "sample rate",
        rate(settings.sample_rate),
        rate(unit.sample_rate),
        settings.sample_rate.code().map(|code| format!("m {code}")),
    );
    all
}

/// Commands that remove the differences. The unit refuses a datagram that is too long for its sample rate, so the lowest rate is
/// set before the datagram, and the wanted one last.
pub(super) fn commands(settings: &Stim300Settings, differences: &[Difference]) -> Vec<String> {
    let mut commands: Vec<String> = differences.iter().filter_map(|one| one.command.clone()).collect();
    if differences.iter().any(|one| one.field == "datagram") {
        commands.insert(0, "m 0".to_owned());
        if !differences.iter().any(|one| one.field == "sample rate")
            && let Some(code) = settings.sample_rate.code()
        {
            commands.push(format!("m {code}"));
        }
    }
    commands
}

fn content_command(settings: &Stim300Settings, unit: &Configuration) -> Option<String> {
    let letter = settings.content.letter()?;
    Some(format!("d {letter},{}", u8::from(unit.line_end)))
}

fn name(content: Content) -> String {
    format!("{:02X}h", content.id())
}

fn rate(rate: SampleRate) -> String {
    match rate {
        SampleRate::Internal(rate_hz) => format!("{rate_hz} Hz"),
        SampleRate::External => "external trigger".to_owned(),
    }
}

/// Axes that are active, e.g. `XYZ` or `X--`.
fn active(axes: [bool; 3]) -> String {
    "XYZ".chars().zip(axes).map(|(letter, is_active)| if is_active { letter } else { '-' }).collect()
}
