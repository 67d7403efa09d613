//! What a machine can do: the loop's thread without devices, at several rates, idle and with the work of a tick.

use std::time::Duration;

use procedures::log::LatenessHistogram;
use reports::record::Grant;
use serde::Serialize;

use super::facts::{Facts, processors_text};
use super::{Rights, wake};
use crate::clock::{self, Clock};

/// Rates that are measured whatever was asked for, Hz.
pub const RATES_HZ: [f64; 4] = [1000.0, 2000.0, 4000.0, 8000.0];
/// Largest share of missed periods at which a rate is held: that of `dropped-cycles` in the shipped procedures.
pub const MISSED_RATIO: f64 = 1e-3;
/// Every stall is shorter where a rate is held, s.
pub const LONGEST_S: f64 = 5e-3;
/// Computing in each tick of a loaded loop: some times what devices, interlocks, controllers and rows take of a tick.
pub const WORK: Duration = Duration::from_micros(50);

/// A loop to be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Rate of the loop.
    pub rate_hz: f64,
    /// Whether each tick computes for [`WORK`].
    pub loaded: bool,
    /// How long it is measured.
    pub lasts: Duration,
}

/// A loop that was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Rate of the loop.
    pub rate_hz: f64,
    /// Whether each tick computed for [`WORK`].
    pub loaded: bool,
    /// How late its ticks came.
    pub histogram: LatenessHistogram,
}

impl Measured {
    /// Whether few enough periods were missed, and no stall was too long.
    pub fn holds(&self) -> bool {
        self.histogram.missed_ratio() < MISSED_RATIO && self.histogram.longest_stall_s() < LONGEST_S
    }
}

/// What a check of a machine found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The rate that was asked for.
    pub asked_hz: f64,
    /// What the loop's thread was granted.
    pub grants: Vec<Grant>,
    /// What the machine says of itself.
    pub facts: Facts,
    /// Loops in order of their rates, idle before loaded.
    pub measured: Vec<Measured>,
}

impl Report {
    /// Rates in order.
    pub fn rates_hz(&self) -> Vec<f64> {
        let mut rates_hz: Vec<f64> = self.measured.iter().map(|m| m.rate_hz).collect();
        rates_hz.dedup();
        rates_hz
    }

    /// Whether a rate is held, idle and loaded.
    pub fn holds(&self, rate_hz: f64) -> bool {
        let mut own = self.measured.iter().filter(|m| m.rate_hz == rate_hz).peekable();
        own.peek().is_some() && own.all(Measured::holds)
    }

    /// The loaded loop of the asked rate: what a run is like.
    pub fn asked(&self) -> Option<&Measured> {
        self.measured.iter().find(|m| m.rate_hz == self.asked_hz && m.loaded)
    }

    /// The longest stall of all loops, s.
    pub fn longest_stall_s(&self) -> f64 {
        self.measured.iter().map(|m| m.histogram.longest_stall_s()).fold(0.0, f64::max)
    }
}

/// Loops for a check: all rates, the asked one among them. Each rate lasts for `each`, half of it loaded.
pub fn rounds(asked_hz: f64, each: Duration) -> Vec<Round> {
    let mut rates_hz = RATES_HZ.to_vec();
    rates_hz.push(asked_hz);
    rates_hz.sort_by(f64::total_cmp);
    rates_hz.dedup();
    let round = |rate_hz: f64| move |loaded| Round { rate_hz, loaded, lasts: each / 2 };
    rates_hz.into_iter().flat_map(|rate_hz| [false, true].map(round(rate_hz))).collect()
}

/// Measures loops one after the other, in a thread like that of a session.
///
/// # Errors
/// When no thread can be started.
pub fn measure(rounds: Vec<Round>) -> std::io::Result<(Vec<Grant>, Vec<Measured>)> {
    let work = move || {
        let rights = Rights::ask();
        let measured = rounds.iter().map(one).collect();
        (rights.grants.clone(), measured)
    };
    let thread = std::thread::Builder::new().name("tick".to_owned()).spawn(work)?;
    thread.join().map_err(|_| std::io::Error::other("internal error: the measuring thread panicked"))
}

fn one(round: &Round) -> Measured {
    let Round { rate_hz, loaded, lasts } = *round;
    let period = Duration::from_secs_f64(1.0 / rate_hz);
    let clock = Clock::real();
    let mut histogram = LatenessHistogram::default();
    let mut due = period;
    while due < lasts {
        let woken = wake(&clock, due, period);
        histogram.count(woken.late, woken.missed_periods);
        if loaded {
            clock::work(WORK);
        }
        due = woken.due + period;
    }
    Measured { rate_hz, loaded, histogram }
}

/// What to change on a machine, in order of effect; empty where there is nothing left to change.
pub fn advice(grants: &[Grant], facts: &Facts) -> Vec<String> {
    let refused = |what: &str| grants.iter().find(|g| !g.granted && g.what.starts_with(what));
    let mut all = Vec::new();
    let own = facts.isolated.last().or(facts.online.last()).copied().unwrap_or(0);
    if let Some(Grant { remedy: Some(remedy), .. }) = refused("real-time priority") {
        all.push(format!("real-time priority: {remedy}"));
    }
    if facts.is_virtual_machine {
        all.push("hypervisor: this is a virtual machine, which its host may stop at any time; measure on the computer itself".to_owned());
    }
    if facts.online.len() < 2 {
        all.push("processors: use two or more, so that one is free for the loop".to_owned());
    }
    if !facts.is_realtime {
        all.push(
            "kernel: boot one with PREEMPT_RT (part of Linux since 6.12; `linux-image-rt-amd64` on Debian)"
                .to_owned(),
        );
    }
    if facts.isolated.is_empty() && facts.online.len() > 1 {
        all.push(format!(
            "kernel command line: isolcpus=managed_irq,domain,{own} nohz_full={own} rcu_nocbs={own} irqaffinity=0"
        ));
    } else if facts.without_tick.is_empty() && !facts.isolated.is_empty() {
        let isolated = processors_text(&facts.isolated);
        all.push(format!("kernel command line: nohz_full={isolated} rcu_nocbs={isolated}"));
    }
    if facts.wakes_within_us.is_some_and(|latency_us| latency_us > 50)
        && let Some(Grant { remedy: Some(remedy), .. }) = refused("processors that wake")
    {
        all.push(format!("idle states: {remedy}"));
    }
    if facts.governors.iter().any(|governor| governor != "performance") {
        all.push("governor: `cpupower frequency-set --governor performance`".to_owned());
    }
    if let Some(interface) = &facts.interface {
        all.extend(interrupts(interface, own));
    }
    if let Some(Grant { remedy: Some(remedy), .. }) = refused("locked memory") {
        all.push(format!("locked memory: {remedy}"));
    }
    if facts.clocksource.as_deref().is_some_and(|source| ["hpet", "acpi_pm", "jiffies"].contains(&source)) {
        all.push(
            "clocksource: boot with clocksource=tsc tsc=reliable, if the processor's counter is steady"
                .to_owned(),
        );
    }
    all
}

fn interrupts(interface: &super::facts::Interface, own: usize) -> Option<String> {
    let name = &interface.name;
    if !interface.exists {
        return Some(format!("interface: there is no `{name}`; `ip link` lists what there is"));
    }
    let here = interface.handled_by(own);
    (!here.is_empty()).then(|| {
        let numbers = here.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        format!(
            "interrupts of {name}: {numbers} interrupt the loop on processor {own}; stop irqbalance and write \
             another processor to /proc/irq/NUMBER/smp_affinity_list"
        )
    })
}

#[cfg(test)]
mod tests;
