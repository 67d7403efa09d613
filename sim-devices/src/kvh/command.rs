//! The unit's command interpreter: `=` sets or acts, `?` asks, comma-separated, any case in, upper case out.
//!
//! In Normal mode only `=CONFIG,1` and `?BIT` are heard, all else is silently ignored. In Config mode what is unknown
//! is answered with `INVALID,<echo>`, a bad parameter with a usage line.

use super::configuration::Configuration;
use drivers::kvh::Format;

/// Longest command.
const LINE_BYTES: usize = 128;
/// Bit rates that the unit knows.
pub const BAUDS: [u32; 9] = [9600, 19_200, 38_400, 57_600, 115_200, 460_800, 576_000, 921_600, 4_147_200];
/// Data rates that the unit knows, Hz.
const DATA_RATES_HZ: [u32; 12] = [1, 5, 10, 25, 50, 100, 250, 500, 750, 1000, 3600, 5000];
const SERIAL: &str = "SIM1775";
const END: &str = "\r\n";

/// What was typed so far, and the mode.
#[derive(Clone, Debug, Default)]
pub(super) struct Interpreter {
    line: Vec<u8>,
    config_mode: bool,
    factory: Option<Configuration>,
    /// Data bytes of the report that is due.
    bit: Option<usize>,
}

/// Outcome of a command in Config mode.
enum Answer {
    /// The command's name with its value.
    Value(String),
    /// What would be right.
    Usage(&'static str),
    /// No such command.
    Unknown,
    /// Nothing is said.
    Silence,
}

impl Interpreter {
    /// Whether the unit listens instead of sending messages.
    pub(super) fn in_config_mode(&self) -> bool {
        self.config_mode
    }

    /// A report of the built-in test becomes due.
    pub(super) fn ask_for_bit(&mut self, data_bytes: usize) {
        self.bit = Some(data_bytes);
    }

    /// Data bytes of the report that is due, once.
    pub(super) fn take_bit_request(&mut self) -> Option<usize> {
        self.bit.take()
    }

    /// Takes a byte; the reply if it ends a command.
    pub(super) fn feed(&mut self, byte: u8, configuration: &mut Configuration) -> Option<String> {
        if byte != b'\r' && byte != b'\n' {
            if self.line.len() <= LINE_BYTES {
                self.line.push(byte.to_ascii_uppercase());
            }
            return None;
        }
        let command = String::from_utf8_lossy(&self.line).trim().to_owned();
        self.line.clear();
        if command.is_empty() || command.len() > LINE_BYTES {
            return None;
        }
        if self.config_mode { self.configure(&command, configuration) } else { self.listen(&command) }
    }

    /// Normal mode.
    fn listen(&mut self, command: &str) -> Option<String> {
        match command {
            "=CONFIG,1" => {
                self.config_mode = true;
                return Some(format!("CONFIG,1{END}"));
            }
            "?BIT" => self.ask_for_bit(6),
            "?BIT,2" => self.ask_for_bit(8),
            _ => {}
        }
        None
    }

    /// Config mode.
    fn configure(&mut self, command: &str, configuration: &mut Configuration) -> Option<String> {
        // What power-up gave is what RSTCFG goes back to.
        let factory = self.factory.get_or_insert_with(|| configuration.clone()).clone();
        // A line may begin with more than one byte of a character: then it is no command.
        let after_sign = command.get(1..).unwrap_or_default();
        let (name, value) = after_sign.split_once(',').unwrap_or((after_sign, ""));
        let answer = match command.as_bytes()[0] {
            b'=' => match (name, value) {
                ("CONFIG", "0") => {
                    self.config_mode = false;
                    Answer::Silence
                }
                ("CONFIG", "1") => Answer::Value("1".to_owned()),
                ("RSTCFG", "") => {
                    *configuration = Configuration { baud: configuration.baud, ..factory };
                    Answer::Value(String::new())
                }
                _ => set(name, value, configuration),
            },
            b'?' => ask(name, value, configuration),
            _ => Answer::Unknown,
        };
        match answer {
            Answer::Value(value) if value.is_empty() => Some(format!("{name}{END}")),
            Answer::Value(value) => Some(format!("{name},{value}{END}")),
            Answer::Usage(usage) => Some(format!("USAGE: {usage}{END}")),
            Answer::Unknown => Some(format!("INVALID,{}{END}", command.trim_start_matches(['=', '?']))),
            Answer::Silence => None,
        }
    }
}

fn set(name: &str, value: &str, configuration: &mut Configuration) -> Answer {
    let usage = match change(name, value, configuration) {
        Some(Ok(())) => return ask(name, "", configuration),
        Some(Err(usage)) => usage,
        None if name == "HELP" => return ask(name, value, configuration),
        None => return Answer::Unknown,
    };
    Answer::Usage(usage)
}

/// Carries out a setting: `None` if there is no such command, the usage if the value is not allowed.
fn change(name: &str, value: &str, to: &mut Configuration) -> Option<Result<(), &'static str>> {
    Some(match name {
        "DR" => match number_of(&DATA_RATES_HZ, value) {
            Some(rate_hz) => put(&mut to.data_rate_hz, f64::from(rate_hz)),
            None => Err("=DR,<1|5|10|25|50|100|250|500|750|1000|3600|5000>"),
        },
        "BAUD" => match number_of(&BAUDS, value) {
            Some(baud) => put(&mut to.baud, f64::from(baud)),
            None => Err("=BAUD,<9600|19200|38400|57600|115200|460800|576000|921600|4147200>"),
        },
        "OUTPUTFMT" => match value {
            "A" => put(&mut to.format, Format::A),
            "B" => put(&mut to.format, Format::B),
            "C" => put(&mut to.format, Format::C),
            _ => Err("=OUTPUTFMT,<A|B|C>"),
        },
        // RESET begins a new increment; each message begins one anyway.
        "ROTFMT" if value == "RESET" => Ok(()),
        "ROTFMT" => choose(&mut to.rates, value, ["DELTA", "RATE"]).ok_or("=ROTFMT,<DELTA|RATE|RESET>"),
        "ROTUNITS" => choose(&mut to.degrees, value, ["RAD", "DEG"]).ok_or("=ROTUNITS,<DEG|RAD>"),
        "LINFMT" => {
            choose(&mut to.velocity_increments, value, ["ACCEL", "DELTA"]).ok_or("=LINFMT,<ACCEL|DELTA>")
        }
        "LINUNITS" => choose(&mut to.feet, value, ["METERS", "FEET"]).ok_or("=LINUNITS,<METERS|FEET>"),
        "MSYNC" => choose(&mut to.external, value, ["IMU", "EXT"]).ok_or("=MSYNC,<EXT|IMU>"),
        "TEMPUNITS" => {
            let units = TEMPERATURES.iter().find(|(token, ..)| *token == value);
            units
                .map(|&(_, f, h)| (to.fahrenheit, to.hundredths) = (f, h))
                .ok_or("=TEMPUNITS,<C|F|C_100|F_100>")
        }
        "AXES" => axes(value).map(|axes| to.axes = axes).ok_or("=AXES,x0,x1,x2,y0,y1,y2,z0,z1,z2"),
        _ => return None,
    })
}

/// Token, Fahrenheit, hundredths. The tokens of the last two are believed, not documented.
const TEMPERATURES: [(&str, bool, bool); 4] =
    [("C", false, false), ("F", true, false), ("C_100", false, true), ("F_100", true, true)];

fn ask(name: &str, value: &str, from: &Configuration) -> Answer {
    let pick = |choice: bool, tokens: [&str; 2]| tokens[usize::from(choice)].to_owned();
    Answer::Value(match name {
        "DR" => from.data_rate_hz.to_string(),
        "BAUD" => from.baud.to_string(),
        "OUTPUTFMT" => from.format.letter().to_string(),
        "ROTFMT" => pick(from.rates, ["DELTA", "RATE"]),
        "ROTUNITS" => pick(from.degrees, ["RAD", "DEG"]),
        "LINFMT" => pick(from.velocity_increments, ["ACCEL", "DELTA"]),
        "LINUNITS" => pick(from.feet, ["METERS", "FEET"]),
        "MSYNC" => pick(from.external, ["IMU", "EXT"]),
        "TEMPUNITS" => {
            let units = TEMPERATURES.iter().find(|&&(_, f, h)| (f, h) == (from.fahrenheit, from.hundredths));
            units.map_or("C", |(token, ..)| token).to_owned()
        }
        "AXES" => from.axes.as_flattened().iter().map(f64::to_string).collect::<Vec<_>>().join(","),
        // EXT forces the uniform averager; otherwise the default Butterworth at half the data rate.
        "FILTTYPE" => match value {
            "A" | "G" => format!("{value},{}", pick(from.external, ["BUTTER", "AVE"])),
            _ => return Answer::Usage("?FILTTYPE,<A|G>"),
        },
        "IS" => SERIAL.to_owned(),
        "LOGS" => format!("Start of log entries!{END}End of log entries!"),
        "HELP" => {
            "CONFIG,DR,BAUD,OUTPUTFMT,ROTFMT,ROTUNITS,LINFMT,LINUNITS,MSYNC,TEMPUNITS,AXES,FILTTYPE,IS,LOGS,\
                   RSTCFG"
                .to_owned()
        }
        _ => return Answer::Unknown,
    })
}

fn put<T>(place: &mut T, value: T) -> Result<(), &'static str> {
    *place = value;
    Ok(())
}

/// Puts false or true for the first or second token.
fn choose(place: &mut bool, value: &str, tokens: [&str; 2]) -> Option<()> {
    *place = tokens.iter().position(|token| *token == value)? == 1;
    Some(())
}

fn number_of(allowed: &[u32], value: &str) -> Option<u32> {
    value.parse().ok().filter(|number| allowed.contains(number))
}

fn axes(value: &str) -> Option<[[f64; 3]; 3]> {
    let numbers: Vec<f64> = value.split(',').map(str::trim).map_while(|text| text.parse().ok()).collect();
    let all: [f64; 9] = numbers.try_into().ok()?;
    let finite = all.iter().all(|number| number.is_finite()) && value.split(',').count() == 9;
    finite.then(|| std::array::from_fn(|i| std::array::from_fn(|k| all[3 * i + k])))
}
