//! One output of the supply and its load.

use std::time::Duration;

use crate::scpi::{Error, code};

/// Time constant of an output with its load (ours: a set point is reached to 1 % within 46 ms).
const TIME_CONSTANT_S: f64 = 0.01;
/// Set points reach this share of the ratings, as the instrument's ranges do (103 %).
const RANGE_RATIO: f64 = 1.03;
/// Over-voltage protection reaches this share (110 %), and stands there after a reset.
const OVER_VOLTAGE_RATIO: f64 = 1.1;
/// Least level of the over-voltage protection.
const LEAST_OVER_VOLTAGE_V: f64 = 1.0;
/// From constant current on until the over-current protection trips.
const OVER_CURRENT_DELAY_S: f64 = 0.05;

/// What an output can give.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratings {
    pub(super) voltage_v: f64,
    pub(super) current_a: f64,
}

/// An output.
#[derive(Clone, Debug)]
pub(super) struct Output {
    ratings: Ratings,
    load_ohm: f64,
    pub(super) voltage_v: f64,
    pub(super) current_limit_a: f64,
    pub(super) over_voltage_v: f64,
    pub(super) watches_voltage: bool,
    pub(super) watches_current: bool,
    is_switched_on: bool,
    over_voltage: bool,
    over_current: bool,
    /// Voltage at the last instant that anybody looked at.
    now_v: f64,
    at: Duration,
    /// How long it has limited the current.
    limited_s: f64,
}

impl Output {
    pub(super) fn new(ratings: Ratings, load_ohm: f64) -> Self {
        Self {
            ratings,
            load_ohm,
            voltage_v: 0.0,
            current_limit_a: ratings.current_a,
            over_voltage_v: OVER_VOLTAGE_RATIO * ratings.voltage_v,
            watches_voltage: true,
            watches_current: false,
            is_switched_on: false,
            over_voltage: false,
            over_current: false,
            now_v: 0.0,
            at: Duration::ZERO,
            limited_s: 0.0,
        }
    }

    /// It has been on with these set points for long.
    pub(super) fn leave_on(&mut self, voltage_v: f64, current_limit_a: f64) {
        (self.voltage_v, self.current_limit_a, self.is_switched_on) = (voltage_v, current_limit_a, true);
        self.now_v = self.target_v();
    }

    /// The state after `*RST`: off, 0 V, the rated current.
    pub(super) fn reset(&mut self) {
        let Self { now_v, at, load_ohm, ratings, .. } = *self;
        *self = Self { now_v, at, ..Self::new(ratings, load_ohm) };
    }

    pub(super) fn set_load_ohm(&mut self, load_ohm: f64) {
        self.load_ohm = load_ohm;
    }

    pub(super) fn switch(&mut self, on: bool) {
        self.is_switched_on = on;
    }

    pub(super) fn set_voltage(&mut self, word: &str) -> Result<(), Error> {
        self.voltage_v = value(word, "V", [0.0, RANGE_RATIO * self.ratings.voltage_v], 0.0)?;
        Ok(())
    }

    pub(super) fn set_current(&mut self, word: &str) -> Result<(), Error> {
        let most_a = RANGE_RATIO * self.ratings.current_a;
        self.current_limit_a = value(word, "A", [0.0, most_a], self.ratings.current_a)?;
        Ok(())
    }

    pub(super) fn set_over_voltage(&mut self, word: &str) -> Result<(), Error> {
        let most_v = OVER_VOLTAGE_RATIO * self.ratings.voltage_v;
        self.over_voltage_v = value(word, "V", [LEAST_OVER_VOLTAGE_V, most_v], most_v)?;
        Ok(())
    }

    pub(super) fn clear_over_voltage(&mut self) {
        self.over_voltage = false;
    }

    pub(super) fn clear_over_current(&mut self) {
        (self.over_current, self.limited_s) = (false, 0.0);
    }

    pub(super) fn clear_both(&mut self) {
        self.clear_over_voltage();
        self.clear_over_current();
    }

    /// Whether it is switched on and no protection has tripped.
    pub(super) fn is_on(&self) -> bool {
        self.is_switched_on && !self.over_voltage && !self.over_current
    }

    pub(super) fn over_voltage_tripped(&self) -> bool {
        self.over_voltage
    }

    pub(super) fn over_current_tripped(&self) -> bool {
        self.over_current
    }

    pub(super) fn volts(&self) -> f64 {
        self.now_v
    }

    pub(super) fn amperes(&self) -> f64 {
        self.now_v / self.load_ohm
    }

    /// Whether the load takes all that the limit allows.
    fn is_limited(&self) -> bool {
        self.is_on() && self.current_limit_a * self.load_ohm < self.voltage_v
    }

    /// Condition of the questionable instrument summary: bit 0 constant current, bit 1 constant voltage.
    pub(super) fn condition(&self) -> u8 {
        match (self.is_on(), self.is_limited()) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => 2,
        }
    }

    /// Where the voltage goes to.
    fn target_v(&self) -> f64 {
        if self.is_on() { self.voltage_v.min(self.current_limit_a * self.load_ohm) } else { 0.0 }
    }

    /// Time passes; protections trip at their own instants.
    pub(super) fn settle(&mut self, now: Duration) {
        let mut rest_s = now.saturating_sub(self.at).as_secs_f64();
        self.at = self.at.max(now);
        if let Some((after_s, is_voltage)) = self.next_trip_s().filter(|(after_s, _)| *after_s <= rest_s) {
            self.pass(after_s);
            rest_s -= after_s;
            (self.over_voltage, self.over_current) = (is_voltage, !is_voltage);
        }
        self.pass(rest_s);
    }

    fn pass(&mut self, passed_s: f64) {
        self.limited_s = if self.is_limited() { self.limited_s + passed_s } else { 0.0 };
        let target_v = self.target_v();
        self.now_v = target_v + (self.now_v - target_v) * (-passed_s / TIME_CONSTANT_S).exp();
    }

    /// When a protection trips if nothing changes, and whether it is that of the voltage.
    fn next_trip_s(&self) -> Option<(f64, bool)> {
        if !self.is_on() {
            return None;
        }
        let target_v = self.target_v();
        let over_voltage_s = match () {
            () if !self.watches_voltage => None,
            () if self.now_v > self.over_voltage_v => Some(0.0),
            () if target_v > self.over_voltage_v => {
                Some(TIME_CONSTANT_S * ((target_v - self.now_v) / (target_v - self.over_voltage_v)).ln())
            }
            () => None,
        };
        let over_current_s = (self.watches_current && self.is_limited())
            .then(|| (OVER_CURRENT_DELAY_S - self.limited_s).max(0.0));
        match (over_voltage_s, over_current_s) {
            (Some(voltage_s), Some(current_s)) => Some((voltage_s.min(current_s), voltage_s <= current_s)),
            (Some(voltage_s), None) => Some((voltage_s, true)),
            (None, current_s) => current_s.map(|current_s| (current_s, false)),
        }
    }
}

/// A number with or without its unit, or one of `MIN`, `MAX`, `DEF`; `default` is what the last one means.
fn value(word: &str, unit: &str, range: [f64; 2], default: f64) -> Result<f64, Error> {
    let [least, most] = range;
    match word {
        "MIN" | "MINIMUM" => return Ok(least),
        "MAX" | "MAXIMUM" => return Ok(most),
        "DEF" | "DEFAULT" => return Ok(default),
        _ => {}
    }
    let (number, factor) = match word.strip_suffix(unit) {
        Some(rest) => rest.strip_suffix('M').map_or((rest, 1.0), |rest| (rest, 1e-3)),
        None => (word, 1.0),
    };
    let number: f64 = number.trim().parse().map_err(|_| code::ILLEGAL_PARAMETER)?;
    let value = number * factor;
    if (least..=most).contains(&value) { Ok(value) } else { Err(code::OUT_OF_RANGE) }
}
