//! Faults that are planted on the wire of a rig whose devices are all simulated.

use std::fmt::Write;
use std::sync::Arc;

use drivers::wire::fault::{FaultControl, FaultCounts, FaultPlan, FaultyLink, FrameFault};
use drivers::wire::{EthernetLink, Way};

/// Faults of a wire. Until they begin every frame passes as it is.
#[derive(Debug, Default)]
pub struct WireFaults {
    asked: Vec<String>,
    plan: FaultPlan,
    control: Arc<FaultControl>,
}

impl WireFaults {
    /// Faults as they were asked for, and what was understood.
    pub fn new(seed: u64, asked: Vec<String>, faults: Vec<FrameFault>) -> Self {
        Self { asked, plan: FaultPlan { seed, faults }, control: Arc::default() }
    }

    /// Each fault as it was asked for.
    pub fn asked(&self) -> &[String] {
        &self.asked
    }

    /// It is known that no device may be real.
    pub fn begin(&self) {
        self.control.begin();
    }

    /// Plants the faults on an interface.
    pub(crate) fn on<L: EthernetLink>(&self, link: L) -> FaultyLink<L> {
        FaultyLink::new(link, self.plan.clone(), Arc::clone(&self.control))
    }

    /// What has befallen the frames so far, in one line.
    pub fn told(&self) -> String {
        let mut text = "wire faults".to_owned();
        for (way, name) in [(Way::Out, "out"), (Way::Back, "back")] {
            let counts = self.control.counts(way);
            let _ = write!(text, "; {name}: {} frames{}", counts.frames, befallen(&counts));
        }
        text
    }
}

/// The counts that are not 0.
fn befallen(counts: &FaultCounts) -> String {
    let FaultCounts { frames: _, dropped, delayed, duplicated, corrupted, truncated, reordered, overflowed } =
        *counts;
    let all = [
        (dropped, "dropped"),
        (delayed, "delayed"),
        (duplicated, "duplicated"),
        (corrupted, "corrupted"),
        (truncated, "truncated"),
        (reordered, "reordered"),
        (overflowed, "dropped because too many waited"),
    ];
    all.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!(", {count} {what}")).collect()
}
