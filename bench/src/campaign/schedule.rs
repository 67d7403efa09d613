//! Which procedure comes when: what must be over before it, and who is free.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::procedure_run::note_end;
use super::{Finished, ProcedureRun, Shared, procedure};
use crate::judge::stage::Progress;
use crate::model::signs;
use crate::people::event::{Guarded, RunEvent};
use crate::people::signals;
use crate::plan::CampaignPlan;
use crate::record::journal::Entry;
use crate::record::polarity;

/// What is left to do.
struct Queue {
    /// Indices, in the order in which they are taken where nothing keeps them.
    left: Vec<usize>,
    over: Vec<bool>,
    running: usize,
}

/// Runs all procedures, `jobs` at a time, and hands what happens to the listener. A procedure waits for those that its
/// stage or polarity asks for, and for nothing else. Where fewer threads are to be had than jobs, those do all of it.
///
/// # Errors
/// When not even one can be started; nothing was begun then.
pub(super) fn work(shared: &Shared<'_>, jobs: usize, listener: &mut Guarded<'_>) -> std::io::Result<()> {
    let plan = shared.setup.plan;
    let waits = plan.waits();
    let count = plan.procedures.len();
    let left = order(plan, &waits, shared.real || shared.session.is_some());
    let queue = Mutex::new(Queue { left, over: vec![false; count], running: 0 });
    let changed = Condvar::new();
    let (events, heard) = channel::<RunEvent>();
    std::thread::scope(|scope| {
        for number in 0..jobs.clamp(1, count.max(1)) {
            let events = events.clone();
            let waits = &waits;
            let queue = &queue;
            let changed = &changed;
            let worker = move || {
                while let Some(index) = next(queue, changed, waits) {
                    // A defect in one procedure must not take the others, the journal and the results with it.
                    let run = || carry_out(shared, index, &events);
                    let finished = catch_unwind(AssertUnwindSafe(run));
                    if finished.is_err() {
                        let id = &shared.setup.plan.procedures[index].procedure.id;
                        let why = format!("{id}: its worker panicked: the state of the axes is unknown");
                        shared.ended_badly(why.clone(), vec![why]);
                    }
                    shared.keep(index, finished.unwrap_or_else(|_| procedure::crashed(shared, index)));
                    over(shared, index, queue, &events);
                    changed.notify_all();
                }
                // Whoever still waits must see that nothing is left.
                changed.notify_all();
            };
            match std::thread::Builder::new().name(format!("job {number}")).spawn_scoped(scope, worker) {
                Err(error) if number == 0 => return Err(error),
                Err(_) => break,
                Ok(_) => {}
            }
        }
        drop(events);
        for event in heard {
            listener.hear(&event);
        }
        Ok(())
    })
}

fn lock(queue: &Mutex<Queue>) -> MutexGuard<'_, Queue> {
    queue.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The first procedure that need not wait, as soon as there is one; `None` when all are taken.
fn next(queue: &Mutex<Queue>, changed: &Condvar, waits: &[Vec<usize>]) -> Option<usize> {
    let mut queue = lock(queue);
    loop {
        let ready = queue.left.iter().position(|&index| waits[index].iter().all(|&other| queue.over[other]));
        if let Some(place) = ready {
            queue.running += 1;
            return Some(queue.left.remove(place));
        }
        // A plan has no circles; one that had would leave these as if their worker had vanished.
        if queue.left.is_empty() || queue.running == 0 {
            return None;
        }
        queue = changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
}

/// Takes a procedure as over; the last check of polarity leaves its line in the journal for later runs, which know the unit
/// in its final state only.
fn over(shared: &Shared<'_>, index: usize, queue: &Mutex<Queue>, events: &Sender<RunEvent>) {
    let mut queue = lock(queue);
    queue.over[index] = true;
    queue.running -= 1;
    let planned = &shared.setup.plan.procedures;
    let is_final = |k: usize| shared.page.procedures[k].state.is_none();
    let checks = |&k: &usize| planned[k].procedure.kind == signs::POLARITY && is_final(k);
    if checks(&index) && (0..planned.len()).filter(checks).all(|k| queue.over[k]) {
        note_polarity(shared, events);
    }
}

fn note_polarity(shared: &Shared<'_>, events: &Sender<RunEvent>) {
    let slots = shared.slots.lock().unwrap_or_else(PoisonError::into_inner);
    let gate = polarity::gate_in(None, &shared.page.procedures, |index| {
        let (_, log) = slots[index].as_ref()?;
        log.as_ref().map(|log| (log.findings.status, log.proof.clone()))
    });
    let fault = gate.reason().map(str::to_owned);
    if let Some(fault) = &fault {
        // The gate's own sentence begins with its name.
        let text = format!("not proven, so no closed loop is run: {fault}");
        let _ = events.send(RunEvent::Notice { text });
    }
    let hash = shared.page.polarity.hash();
    let entry = Entry::Polarity { hash, proven: fault.is_none(), fault, from: None };
    // A journal that cannot be written shows itself at the next procedure's end; no motion hangs on this line.
    let _ = shared.journal.lock().unwrap_or_else(PoisonError::into_inner).write(entry);
}

/// Runs a procedure, unless what it relies on is not there.
fn carry_out(shared: &Shared<'_>, index: usize, events: &Sender<RunEvent>) -> Finished {
    let reason = {
        let slots = shared.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let judged: Vec<_> =
            slots.iter().map(|slot| slot.as_ref().and_then(|(_, log)| log.as_ref())).collect();
        let requirements = &shared.setup.plan.requirements;
        Progress { page: &shared.page, requirements, judged: &judged }.held_back(index)
    };
    match reason {
        None => procedure::run_and_judge(shared, index, events),
        Some(reason) => skip(shared, index, reason, events),
    }
}

fn skip(shared: &Shared<'_>, index: usize, reason: String, events: &Sender<RunEvent>) -> Finished {
    let procedure = shared.setup.plan.procedures[index].procedure.id.clone();
    let mut run = match signals::exit_code(&shared.setup.stop) {
        0 => ProcedureRun::held_back(reason.clone()),
        code => ProcedureRun::not_run(code),
    };
    note_end(shared.setup, index, &shared.journal, &mut run, None);
    let status = format!("skipped: {reason}");
    let planned_s = shared.setup.plan.procedures[index].planned_s();
    let _ = events.send(RunEvent::ProcedureEnded { procedure, status, planned_s, verdicts: Vec::new() });
    (run, None)
}

/// On real devices the plan's order. Otherwise whoever begins the longest chain of waiting comes first: that decides how
/// long a run takes, and polarity, which most wait for, comes out in front.
fn order(plan: &CampaignPlan, waits: &[Vec<usize>], real: bool) -> Vec<usize> {
    let mut all: Vec<usize> = (0..plan.procedures.len()).collect();
    if !real {
        let mut chains_s = vec![None; all.len()];
        for index in 0..all.len() {
            chain_s(plan, waits, index, &mut chains_s);
        }
        let chain = |index: usize| chains_s[index].unwrap_or(0.0_f64);
        all.sort_by(|&a, &b| chain(b).total_cmp(&chain(a)).then(a.cmp(&b)));
    }
    all
}

/// Planned time from the beginning of a procedure to the end of the last that waits for it, s.
fn chain_s(plan: &CampaignPlan, waits: &[Vec<usize>], index: usize, known: &mut [Option<f64>]) -> f64 {
    if let Some(known) = known[index] {
        return known;
    }
    let own_s = plan.procedures[index].planned_s();
    let mut after_s = 0.0_f64;
    for waiting in (0..waits.len()).filter(|&other| waits[other].contains(&index)) {
        after_s = after_s.max(chain_s(plan, waits, waiting, known));
    }
    known[index] = Some(own_s + after_s);
    own_s + after_s
}

#[cfg(test)]
mod tests;
