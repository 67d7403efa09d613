//! The blocks: both sides in turn, at the same rate, on the same interface.

use std::time::Duration;

use super::Plan;
use super::bare::Bare;
use super::clock;
use super::figures::{self, BlockFigures, Taken};
use super::meter::Meter;
use super::ours::Ours;

/// Longest wait for a reply, on both sides: below the time after which ethercrab would send a frame again.
pub(crate) const REPLY_LIMIT: Duration = Duration::from_millis(20);
/// After a change from one side to the other, nothing counts for so long.
const SETTLING: Duration = Duration::from_millis(100);
/// Longer exchanges are stalls of the computer.
const STALL: Duration = Duration::from_millis(1);

/// What became of an exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Every station took part.
    Complete,
    /// Not every station took part.
    Short,
    /// No reply.
    Lost,
}

/// Both sides; the one whose turn it is has the interface.
struct Sides {
    bare: Bare,
    ours: Ours,
}

/// Opens both sides, passes all blocks and prints their figures.
pub(crate) fn blocks(plan: &Plan) -> Result<Vec<BlockFigures>, String> {
    let cycle = Duration::from_secs(1) / plan.rate_hz;
    let bare = Bare::open(&plan.interface, cycle)?;
    let ours = Ours::open(&plan.interface, cycle)?;
    let mut sides = Sides { bare, ours };
    println!(
        "{} at {} Hz, {} blocks of {} s each side; {}; load {}",
        plan.interface,
        plan.rate_hz,
        plan.blocks,
        plan.seconds,
        scheduling(),
        load()
    );
    figures::print_head();
    let room = plan.rate_hz as usize * plan.seconds as usize + 1;
    let mut found = Vec::new();
    for number in 1..=plan.blocks {
        let (mut bare, mut ours) = (Taken::with_room(room), Taken::with_room(room));
        for is_ours in if number % 2 == 1 { [false, true] } else { [true, false] } {
            let taken = if is_ours { &mut ours } else { &mut bare };
            sides.pass(is_ours, plan, cycle, taken)?;
        }
        let block = BlockFigures::of(&mut bare, &mut ours)
            .ok_or_else(|| format!("block {number} has no complete exchanges on one side"))?;
        block.print(number);
        found.push(block);
    }
    println!("load {}", load());
    if let Err(reason) = sides.ours.close() {
        eprintln!("exchange_cost: the stations stay as they are: {reason}");
    }
    Ok(found)
}

impl Sides {
    /// One side's part of a block.
    fn pass(&mut self, is_ours: bool, plan: &Plan, cycle: Duration, taken: &mut Taken) -> Result<(), String> {
        if is_ours { self.ours.connect() } else { self.bare.connect() }?;
        let begun = clock::now();
        let counts_from = begun + SETTLING;
        let end = counts_from + Duration::from_secs(plan.seconds.into());
        let mut next = begun + cycle;
        while next < end {
            clock::rest_until(next);
            let before = clock::now();
            let outcome =
                if is_ours { self.ours.exchange() } else { self.bare.exchange(self.ours.expected) }?;
            let after = clock::now();
            if before >= counts_from {
                let meter = if is_ours { self.ours.meter() } else { self.bare.meter() };
                take(taken, outcome, after.saturating_sub(before), meter);
            }
            next += cycle;
            while next < after {
                next += cycle;
            }
        }
        if is_ours {
            self.ours.disconnect();
        } else {
            self.bare.disconnect();
        }
        Ok(())
    }
}

fn take(taken: &mut Taken, outcome: Outcome, took: Duration, meter: &Meter) {
    match outcome {
        Outcome::Lost => taken.lost_count += 1,
        Outcome::Short => taken.short_count += 1,
        Outcome::Complete if took > STALL => taken.stalls_count += 1,
        Outcome::Complete => {
            let own_part = took.saturating_sub(meter.waited.get());
            taken.exchanges_us.push(us(took));
            taken.own_parts_us.push(us(own_part));
            taken.code_us.push(us(own_part.saturating_sub(meter.called.get())));
        }
    }
}

fn us(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}

/// Scheduling policy and priority of this process.
fn scheduling() -> String {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    match (fields.get(37), fields.get(38)) {
        (Some(priority), Some(&"1")) => format!("SCHED_FIFO {priority}"),
        (Some(priority), Some(&"2")) => format!("SCHED_RR {priority}"),
        _ => "usual priority: percentiles tell more about the computer than about the code".to_owned(),
    }
}

/// Load of the computer over the last 1, 5 and 15 minutes.
fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().take(3).collect::<Vec<_>>().join(" ")
}
