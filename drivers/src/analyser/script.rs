//! The dialogue of a sweep.

use super::{AnalyserSettings, Sweep};
use crate::scpi::Step;

/// What an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Want {
    Identity,
    Complete,
    Resistance,
    Reactance,
    Level,
    Current,
    Frequency,
}

/// Ends a sweep; all contacts of the relay open.
pub(super) const ABORT: &str = ":ABOR;:CONT:HAND:A 0";

/// A point of a sweep takes at most so many periods, and this time more.
const PERIODS_PER_POINT: f64 = 20.0;
const SETTLING_PER_POINT_S: f64 = 0.1;

/// The steps of a sweep.
pub(super) fn of(settings: &AnalyserSettings, sweep: &Sweep) -> Vec<Step<Want>> {
    let timeout_s = settings.reply_timeout_s;
    let tell = |text: String| Step::command(text, timeout_s);
    let relay = settings.relay.get(sweep.axis).copied().unwrap_or_default();
    let mut steps: Vec<Step<Want>> = ["*CLS", ":SYST:PRES", ":FORM:DATA ASC", ":SENS1:SWE:TYPE LOG"]
        .map(|text| tell(text.to_owned()))
        .into();
    steps.extend([
        tell(format!(":CONT:HAND:A {relay}")),
        tell(format!(":SENS1:FREQ:STAR {}", sweep.from_hz)),
        tell(format!(":SENS1:FREQ:STOP {}", sweep.to_hz)),
        tell(format!(":SENS1:SWE:POIN {}", sweep.points)),
        tell(":SENS1:SWE:DIR UP".to_owned()),
        tell(":SOUR1:MODE VOLT".to_owned()),
        tell(format!(":SOUR1:VOLT {:.5}", sweep.level_v_rms())),
        tell(":CALC1:PAR:COUN 4".to_owned()),
    ]);
    let traces =
        [("R", Want::Resistance), ("X", Want::Reactance), ("VAC", Want::Level), ("IAC", Want::Current)];
    for (k, (parameter, _)) in (1..).zip(traces) {
        steps.push(tell(format!(":CALC1:PAR{k}:DEF {parameter}")));
    }
    steps.extend([":INIT1:CONT ON", ":TRIG:SOUR BUS", ":TRIG:SING"].map(|text| tell(text.to_owned())));
    steps.push(Step::query("*OPC?", Want::Complete, timeout_s + longest_s(sweep)));
    for (k, (_, want)) in (1..).zip(traces) {
        steps.push(tell(format!(":CALC1:PAR{k}:SEL")));
        steps.push(Step::query(":CALC1:DATA:FDAT?", want, timeout_s));
    }
    steps.push(Step::query(":SENS1:FREQ:DATA?", Want::Frequency, timeout_s));
    steps.push(tell(":CONT:HAND:A 0".to_owned()));
    steps
}

/// Most time that a sweep may take.
fn longest_s(sweep: &Sweep) -> f64 {
    (0..sweep.points).map(|k| SETTLING_PER_POINT_S + PERIODS_PER_POINT / sweep.frequency_hz(k)).sum()
}
