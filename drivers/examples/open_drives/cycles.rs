//! Exchanges at a fixed rate, and what became of them.

use std::time::Duration;

use drivers::cia402::{PowerState, PowerTarget, error_code_meaning};
use drivers::wire::ethercat::EtherCatBus;
use drivers::wire::{BusState, Fieldbus, ProcessImage};

use super::axis::Axis;
use super::clock;

/// Longest way into OP, and longest way of a drive out of "operation enabled".
const OP_LIMIT: Duration = Duration::from_secs(5);
const DISABLE_LIMIT: Duration = Duration::from_secs(2);
/// Without a reply for so long, there is nobody any more.
const SILENCE_LIMIT: Duration = Duration::from_secs(1);
/// Part of the lateness on the clock of the bus by which a tick is shifted.
const PHASE_GAIN: f64 = 1.0 / 16.0;

/// What became of the exchanges.
#[derive(Default)]
pub(crate) struct Seen {
    pub(crate) exchanges_count: u64,
    /// Without a reply.
    pub(crate) lost_count: u64,
    /// With another working counter than expected.
    pub(crate) short_count: u64,
    /// Periods that had passed before an exchange could begin.
    pub(crate) missed_count: u64,
    pub(crate) notices_count: u64,
    pub(crate) has_left_op: bool,
    /// From the instant at which an exchange was due until it began, and until its inputs were there.
    pub(crate) lateness_us: Vec<f64>,
    pub(crate) done_us: Vec<f64>,
    /// Lateness of the frame on the clock of the bus, either way.
    pub(crate) phase_us: Vec<f64>,
}

/// A bus in its cycle.
pub(crate) struct Cycles<'a> {
    pub(crate) bus: &'a mut EtherCatBus,
    pub(crate) image: ProcessImage,
    pub(crate) axis: Option<Axis>,
    pub(crate) cycle: Duration,
    next: Duration,
    heard: Duration,
    power: Option<PowerState>,
    pub(crate) seen: Seen,
}

impl<'a> Cycles<'a> {
    pub(crate) fn new(
        bus: &'a mut EtherCatBus,
        image: ProcessImage,
        axis: Option<Axis>,
        cycle: Duration,
    ) -> Self {
        let now = clock::now();
        Self { bus, image, axis, cycle, next: now, heard: now, power: None, seen: Seen::default() }
    }

    /// Goes to OP, passes so many exchanges with the axis enabled, and disables it.
    pub(crate) fn pass(&mut self, count: u32) -> Result<(), String> {
        self.bus.request(BusState::Op);
        let begun = clock::now();
        while self.bus.state() != BusState::Op {
            if clock::now() > begun + OP_LIMIT {
                return Err("the stations do not reach OP".to_owned());
            }
            self.tick(PowerTarget::Disabled)?;
        }
        println!("in OP after {:.1} ms", (clock::now() - begun).as_secs_f64() * 1e3);
        self.seen = Seen { notices_count: self.seen.notices_count, ..Seen::default() };
        for _ in 0..count {
            self.tick(PowerTarget::Enabled)?;
            if self.bus.state() != BusState::Op && !self.seen.has_left_op {
                println!("the stations have left OP");
                self.seen.has_left_op = true;
            }
        }
        let limit = clock::now() + DISABLE_LIMIT;
        while self.power.is_some_and(|state| !PowerTarget::Disabled.is_reached(state)) {
            if self.seen.has_left_op || clock::now() > limit {
                return Err("the drive could not be disabled in OP".to_owned());
            }
            self.tick(PowerTarget::Disabled)?;
        }
        Ok(())
    }

    fn tick(&mut self, target: PowerTarget) -> Result<(), String> {
        clock::rest_until(self.next);
        let now = clock::now();
        let late_us = us(now.saturating_sub(self.next));
        if let Some(axis) = &mut self.axis
            && !self.seen.has_left_op
            && self.seen.exchanges_count > 0
        {
            let state = axis.step(target, &mut self.image, now)?;
            if self.power != Some(state) {
                println!("exchange {}: {}", self.seen.exchanges_count, state.name());
                self.power = Some(state);
            }
        }
        let done = self.bus.exchange(now, &mut self.image).map_err(|error| error.to_string())?;
        let after = clock::now();
        self.seen.exchanges_count += 1;
        self.seen.lateness_us.push(late_us);
        if done.working_counter == 0 {
            self.seen.lost_count += 1;
        } else {
            self.heard = after;
            self.seen.short_count += u64::from(done.working_counter != done.expected);
            self.seen.done_us.push(us(after.saturating_sub(now)));
        }
        self.notices();
        if after.saturating_sub(self.heard) > SILENCE_LIMIT {
            return Err(format!("no reply for {} s: check cables and supplies", SILENCE_LIMIT.as_secs()));
        }
        self.set_next(done.working_counter > 0, after);
        Ok(())
    }

    /// The next instant, shifted towards the middle between two SYNC0; periods that have passed are skipped.
    fn set_next(&mut self, has_clock: bool, after: Duration) {
        let late_ns = if has_clock { self.bus.lateness_ns().unwrap_or(0) } else { 0 };
        if has_clock && self.bus.dc_status().is_some() {
            self.seen.phase_us.push(late_ns as f64 / 1e3);
        }
        let shift = late_ns as f64 * PHASE_GAIN * 1e-9;
        let most = self.cycle.as_secs_f64() / 4.0;
        let period = self.cycle.as_secs_f64() - shift.clamp(-most, most);
        self.next += Duration::from_secs_f64(period);
        while self.next < after {
            self.next += self.cycle;
            self.seen.missed_count += 1;
        }
    }

    fn notices(&mut self) {
        let exchange = self.seen.exchanges_count;
        let mut count = 0;
        for emergency in self.bus.emergencies() {
            let meaning = error_code_meaning(emergency.code);
            println!(
                "exchange {exchange}: station {}: emergency {:04X}h, {meaning} (error register {:02X}h)",
                emergency.station, emergency.code, emergency.register
            );
            count += 1;
        }
        for error in self.bus.al_errors() {
            println!("exchange {exchange}: {error}");
            count += 1;
        }
        self.seen.notices_count += count;
    }
}

impl Seen {
    /// Whether nothing was wrong.
    pub(crate) fn is_clean(&self) -> bool {
        self.lost_count + self.short_count + self.notices_count == 0 && !self.has_left_op
    }

    pub(crate) fn print(&mut self) {
        println!(
            "{} exchanges: {} without reply, {} with another working counter, {} periods missed, {} notices",
            self.exchanges_count, self.lost_count, self.short_count, self.missed_count, self.notices_count
        );
        for (name, values) in [
            ("begun late", &mut self.lateness_us),
            ("exchange takes", &mut self.done_us),
            ("late on the clock of the bus", &mut self.phase_us),
        ] {
            values.sort_by(f64::total_cmp);
            if let [least, .., most] = values[..] {
                let quantile = |part: f64| values[(part * (values.len() - 1) as f64).round() as usize];
                println!(
                    "{name}: least {least:.1}, p50 {:.1}, p99 {:.1}, p99.9 {:.1}, most {most:.1} us",
                    quantile(0.5),
                    quantile(0.99),
                    quantile(0.999)
                );
            }
        }
    }
}

fn us(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}
