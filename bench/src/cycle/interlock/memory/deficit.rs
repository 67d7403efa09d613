//! A motor that gives less than it is asked for: what it has shown is what a stop can rely on.

use super::Seen;
use super::spell::Spell;
use crate::model::axis::AxisGuard;

/// How far back the command is looked at: transport both ways and the current loop take 3 ms, and 15 ms on the slowest
/// unit that is still to be tested.
const COMMAND_AGE_S: f64 = 0.020;
/// Stretches that this time is kept in, one more than it has: a tick must not go through all of its commands.
const STRETCHES: usize = 11;
/// Share of the largest torque that must be missing.
const MISSING_SHARE: f64 = 0.05;
/// Less than this is noise and ripple of the current on any motor.
const FLOOR_NM: f64 = 2.0;
/// Share of the largest torque by which what is shown may lie outside what was asked for.
const UNCOMMANDED_SHARE: f64 = 0.1;
/// For how long it must be missing.
const LASTING_S: f64 = 0.010;

#[derive(Clone, Debug)]
pub(super) struct Deficit {
    /// Least and largest torque sent in each of the last stretches, the oldest at `next`: 20 ms and the one under way.
    told_nm: [[f64; 2]; STRETCHES],
    next: usize,
    /// Ticks of a stretch, and those that the present one has had.
    stretch_ticks: u32,
    ticks: u32,
    /// The command that the drive acts on until the next frame.
    last_nm: f64,
    missing: Spell,
    /// Largest torque shown in the present spell.
    largest_nm: f64,
    /// Smallest of those of all spells that are over.
    gave_nm: Option<f64>,
    /// Torque that nobody asked for.
    uncommanded: Spell,
}

impl Deficit {
    pub(super) fn new(period_s: f64) -> Self {
        let stretch_s = COMMAND_AGE_S / (STRETCHES - 1) as f64;
        Self {
            told_nm: [[0.0; 2]; STRETCHES],
            next: 0,
            stretch_ticks: (stretch_s / period_s).ceil().max(1.0) as u32,
            ticks: 0,
            last_nm: 0.0,
            missing: Spell::new(period_s),
            largest_nm: 0.0,
            gave_nm: None,
            uncommanded: Spell::new(period_s),
        }
    }

    /// Once a tick, so many periods after the one before, the command that went out with it: in the periods that were
    /// missed the drive went on with the command before.
    pub(super) fn told(&mut self, sent_nm: f64, periods: u32) {
        for _ in 1..periods.min(STRETCHES as u32 * self.stretch_ticks) {
            self.take_command(self.last_nm);
        }
        self.take_command(sent_nm);
        self.last_nm = sent_nm;
    }

    /// Takes a command into the stretch under way, or begins the next one with it.
    fn take_command(&mut self, sent_nm: f64) {
        if self.ticks == self.stretch_ticks {
            self.next = (self.next + 1) % STRETCHES;
            self.ticks = 0;
        }
        let [low, high] = if self.ticks == 0 { [sent_nm; 2] } else { self.told_nm[self.next] };
        self.told_nm[self.next] = [low.min(sent_nm), high.max(sent_nm)];
        self.ticks += 1;
    }

    /// Least and largest of all that was sent in that time.
    fn range_nm(&self) -> [f64; 2] {
        let wider = |[low, high]: [f64; 2], told: &[f64; 2]| [low.min(told[0]), high.max(told[1])];
        self.told_nm.iter().fold([f64::INFINITY, f64::NEG_INFINITY], wider)
    }

    /// A fresh sample, `span_s` after the one before.
    pub(super) fn take(&mut self, seen: &Seen<'_>, operates: bool, span_s: f64) {
        self.uncommanded.take(operates && self.is_uncommanded(seen), span_s);
        let told_nm = self.least_told_nm();
        let given_nm = seen.actuals.torque_nm * told_nm.signum();
        let missing_nm = (MISSING_SHARE * seen.guard.max_torque_nm).max(FLOOR_NM);
        // Commands of both signs, or none, say nothing about what the motor gives.
        if !(operates && told_nm != 0.0 && told_nm.abs() - given_nm > missing_nm) {
            self.gave_nm = self.gives_nm();
            self.missing.take(false, span_s);
            self.largest_nm = 0.0;
            return;
        }
        self.missing.take(true, span_s);
        self.largest_nm = self.largest_nm.max(given_nm);
    }

    /// Whether the drive shows torque outside everything that was asked for in the last 20 ms, zero included: less than
    /// asked for is another matter.
    fn is_uncommanded(&self, seen: &Seen<'_>) -> bool {
        let margin_nm = (UNCOMMANDED_SHARE * seen.guard.max_torque_nm).max(FLOOR_NM);
        let [low_nm, high_nm] = self.range_nm();
        let low_nm = low_nm.min(0.0);
        let high_nm = high_nm.max(0.0);
        let shown_nm = seen.actuals.torque_nm;
        shown_nm > high_nm + margin_nm || shown_nm < low_nm - margin_nm
    }

    /// How long there has been torque that nobody asked for.
    pub(super) fn uncommanded_s(&self) -> f64 {
        self.uncommanded.lasted_s()
    }

    /// What the motor gives at the most, where it has shown that. Within a spell it may still be rising.
    fn gives_nm(&self) -> Option<f64> {
        let now_nm = (self.missing.lasted_s() >= LASTING_S).then_some(self.largest_nm);
        match (self.gave_nm, now_nm) {
            (Some(gave), Some(now)) => Some(gave.min(now)),
            (gave, now) => gave.or(now),
        }
    }

    /// What every command of the last 20 ms asked for at the least: whatever acts now was one of them.
    fn least_told_nm(&self) -> f64 {
        let [low, high] = self.range_nm();
        if low > 0.0 {
            low
        } else if high < 0.0 {
            high
        } else {
            0.0
        }
    }

    pub(super) fn deceleration_rad_per_s2(&self, guard: &AxisGuard) -> f64 {
        let stated = guard.stop.deceleration_rad_per_s2;
        self.gives_nm().map_or(stated, |gives_nm| guard.deceleration_with_rad_per_s2(gives_nm))
    }
}
