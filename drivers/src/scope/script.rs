//! The dialogue of a record.

use super::{Capture, LEAST_RATE_HZ, ScopeSettings};
use crate::device::DeviceError;
use crate::scpi::Step;

/// What an answer is; the numbers are 0 for the current, 1 for the synchronisation signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Want {
    Identity,
    Ready,
    Armed,
    Running,
    Preamble(usize),
    Data(usize),
}

/// Ends a record.
pub(super) const ABORT: &str = ":STOP";

/// Divisions across the screen, and up it.
const DIVISIONS: [f64; 2] = [10.0, 8.0];
/// Numbers of samples that raw records may have: 1, 2 or 5 times a power of ten.
const MOST_SAMPLES: u32 = 500_000;
/// Volts per division for a signal of 5 V, and the level that triggers.
const SYNC_V_PER_DIVISION: f64 = 2.0;
const TRIGGER_V: f64 = 2.5;

/// Samples of a record: enough for its rate, and a number that the instrument knows.
pub(super) fn samples(device: &str, capture: &Capture) -> Result<u32, DeviceError> {
    let refused = |setting, value, allowed: String| {
        Err(DeviceError::Setting { device: device.to_owned(), setting, value, allowed })
    };
    if capture.axis > 1 {
        return refused("axis", capture.axis as f64, "0 is azimuth, 1 elevation".to_owned());
    }
    if !(capture.sample_rate_hz.is_finite() && capture.sample_rate_hz >= LEAST_RATE_HZ) {
        let allowed = format!("a current loop of 1 kHz needs at least {LEAST_RATE_HZ} samples/s");
        return refused("sample rate (Hz)", capture.sample_rate_hz, allowed);
    }
    let needed = range_s(capture) * capture.sample_rate_hz;
    if !(capture.duration_s > 0.0 && needed <= f64::from(MOST_SAMPLES)) {
        let allowed = format!("above 0, with at most {MOST_SAMPLES} samples at the rate asked for");
        return refused("duration (s)", capture.duration_s, allowed);
    }
    let allowed = (2..=5).flat_map(|decade| [1, 2, 5].map(|digit| digit * 10_u32.pow(decade)));
    Ok(allowed.into_iter().find(|count| f64::from(*count) >= needed).unwrap_or(MOST_SAMPLES))
}

/// Width of the screen: one of ten divisions lies before the trigger.
fn range_s(capture: &Capture) -> f64 {
    capture.duration_s * DIVISIONS[0] / (DIVISIONS[0] - 1.0)
}

/// The steps of a record.
pub(super) fn of(settings: &ScopeSettings, capture: &Capture, samples: u32) -> Vec<Step<Want>> {
    let timeout_s = settings.reply_timeout_s;
    let current = settings.current_channels.get(capture.axis).copied().unwrap_or(1);
    let sync = settings.sync_channel;
    let tell = |text: String| Step::command(text, timeout_s);
    let mut steps: Vec<Step<Want>> = [
        "*RST".to_owned(),
        "*CLS".to_owned(),
        format!(":CHAN{current}:DISP 1"),
        format!(":CHAN{current}:UNIT AMP"),
        format!(":CHAN{current}:PROB 1"),
        format!(":CHAN{current}:SCAL {}", 2.0 * settings.current_range_a / DIVISIONS[1]),
        format!(":CHAN{current}:OFFS 0"),
        format!(":CHAN{sync}:DISP 1"),
        format!(":CHAN{sync}:UNIT VOLT"),
        format!(":CHAN{sync}:PROB 1"),
        format!(":CHAN{sync}:SCAL {SYNC_V_PER_DIVISION}"),
        format!(":CHAN{sync}:OFFS 0"),
        ":TIM:MODE MAIN".to_owned(),
        ":TIM:REF LEFT".to_owned(),
        ":TIM:POS 0".to_owned(),
        format!(":TIM:RANG {:E}", range_s(capture)),
        ":ACQ:TYPE HRES".to_owned(),
        ":TRIG:MODE EDGE".to_owned(),
        format!(":TRIG:EDGE:SOUR CHAN{sync}"),
        ":TRIG:EDGE:SLOP POS".to_owned(),
        format!(":TRIG:EDGE:LEV {TRIGGER_V}"),
        ":TRIG:SWE NORM".to_owned(),
    ]
    .map(tell)
    .into();
    steps.push(Step::query("*OPC?", Want::Ready, timeout_s));
    steps.push(tell(":SING".to_owned()));
    steps.push(Step::query(":AER?", Want::Armed, timeout_s));
    steps.push(Step::query(":OPER:COND?", Want::Running, timeout_s));
    for (which, channel) in [current, sync].into_iter().enumerate() {
        steps.extend([
            tell(format!(":WAV:SOUR CHAN{channel}")),
            tell(":WAV:FORM WORD".to_owned()),
            tell(":WAV:BYT LSBF".to_owned()),
            tell(":WAV:UNS 1".to_owned()),
            tell(":WAV:POIN:MODE RAW".to_owned()),
            tell(format!(":WAV:POIN {samples}")),
            Step::query(":WAV:PRE?", Want::Preamble(which), timeout_s),
            Step::block(":WAV:DATA?", Want::Data(which), timeout_s),
        ]);
    }
    steps
}
