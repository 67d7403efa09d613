//! `bench rtcheck`: whether this machine keeps the beat of a loop. No device is opened, nothing moves.

use std::path::Path;
use std::time::Duration;

use procedures::quantity::QuantityKind;

use super::output;
use crate::exit;
use crate::realtime::check::{self, Report};
use crate::realtime::facts::Facts;

mod page;

/// Slowest and fastest loop that can be asked for, Hz.
const RATE_HZ: [f64; 2] = [100.0, 10_000.0];
/// Shortest and longest measurement of a rate, s.
const LASTS_S: [f64; 2] = [0.01, 86_400.0];

#[derive(clap::Args, Debug)]
#[command(
    after_help = "Exit codes: 0 the rate is held; 3 it is not; 2 a mistake in the options; 4 no thread \
                        could be started. How to prepare a machine: docs/realtime.md."
)]
pub(super) struct Args {
    /// Rate of the loop that this machine must keep
    #[arg(long, value_name = "RATE", default_value = "4 kHz", value_parser = rate_hz)]
    rate: f64,
    /// How long each rate is measured: half of it idle, half with work in each tick
    #[arg(long, value_name = "N", default_value = "5", value_parser = seconds)]
    seconds: f64,
    /// Network interface whose interrupts are looked up
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

fn rate_hz(text: &str) -> Result<f64, String> {
    let expected = "expected a rate from 100 Hz to 10 kHz, e.g. `4 kHz`";
    let rate_hz = QuantityKind::Frequency.parse(text).map_err(|error| format!("{error}; {expected}"))?;
    if (RATE_HZ[0]..=RATE_HZ[1]).contains(&rate_hz) { Ok(rate_hz) } else { Err(expected.to_owned()) }
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let fits = number.filter(|seconds| (LASTS_S[0]..=LASTS_S[1]).contains(seconds));
    fits.ok_or_else(|| "expected a number of seconds from 0.01 to 86400".to_owned())
}

pub(super) fn run(args: &Args) -> u8 {
    let rounds = check::rounds(args.rate, Duration::from_secs_f64(args.seconds));
    let lasts_s: f64 = rounds.iter().map(|round| round.lasts.as_secs_f64()).sum();
    output::note(&format!("measuring {} loops for {lasts_s:.1} s; Ctrl-C ends it", rounds.len()));
    let (grants, measured) = match check::measure(rounds) {
        Ok(found) => found,
        Err(error) => {
            output::error(&format!("cannot measure: {error}; raise the limit of processes (`ulimit -u`)"));
            return exit::BENCH;
        }
    };
    let facts = Facts::read(Path::new("/"), args.interface.as_deref());
    let report = Report { asked_hz: args.rate, grants, facts, measured };
    if args.json {
        output::say(&page::json(&report));
    } else {
        output::say(&page::text(&report));
    }
    if report.holds(report.asked_hz) { exit::PASS } else { exit::INCONCLUSIVE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_has_a_unit_and_a_loop_that_can_be_measured() {
        assert_eq!(rate_hz("4kHz"), Ok(4000.0));
        assert_eq!(rate_hz("500 Hz"), Ok(500.0));
        for text in ["4", "0 Hz", "-1 kHz", "1 MHz", "20 kHz", "4 kg", ""] {
            let error = rate_hz(text).expect_err(text);
            assert!(error.contains("100 Hz to 10 kHz"), "{error}");
        }
    }

    #[test]
    fn seconds_are_a_number_that_a_measurement_can_last() {
        assert_eq!(seconds("0.5"), Ok(0.5));
        for text in ["0", "-1", "NaN", "inf", "1e9", "5 s"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
