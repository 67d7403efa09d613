//! What a ticking thread asks of Linux, and what it gets.

use std::fs::File;
use std::io::Write;
use std::num::NonZeroU64;
use std::path::Path;

use reports::record::Grant;
use rustix::mm::{MlockAllFlags, mlockall, munlockall};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use rustix::thread::{CpuSet, current_timer_slack, sched_setaffinity, set_current_timer_slack};

use super::facts::isolated;
use super::fifo;
use super::processors::{allowed, choice, only};

/// Priority of a ticking thread: above the threads of interrupts (50), below those of the kernel itself (99).
const PRIORITY: u8 = 80;
/// Stack that is touched before the first tick. A tick of all devices and axes takes a tenth of it.
const STACK_BYTES: usize = 256 << 10;

/// Lets the rights of a program be granted once for all users, without root.
const SETCAP: &str = "sudo setcap cap_sys_nice,cap_ipc_lock,cap_sys_resource+ep PATH-OF-BENCH";

/// Rights of a ticking thread. They end with the thread; what belongs to the whole process ends when this is dropped.
#[derive(Debug)]
pub struct Rights {
    /// Everything that was asked for, in order of effect.
    pub grants: Vec<Grant>,
    /// The processor that the thread is bound to.
    pub processor: Option<usize>,
    /// Whether the memory of the process is locked.
    locks_memory: bool,
    /// While it is open, processors do not sleep so deep that waking takes long.
    _awake: Option<File>,
}

impl Rights {
    /// Asks for everything, for the calling thread. What is refused leaves things as they are.
    pub fn ask() -> Self {
        let priority = priority();
        let (bound, processor) = processor(&isolated(Path::new("/")), priority.granted);
        let memory = memory();
        let (awake, _awake) = awake();
        touch_stack();
        let locks_memory = memory.granted;
        let grants = vec![priority, bound, awake, memory, timer_slack()];
        Self { grants, processor, locks_memory, _awake }
    }

    /// Whether memory is locked, so that memory which is mapped later should be locked too.
    pub fn locks_memory(&self) -> bool {
        self.locks_memory
    }
}

impl Drop for Rights {
    fn drop(&mut self) {
        if self.locks_memory {
            // What stays locked is only memory that cannot be swapped out.
            let _ = munlockall();
        }
    }
}

/// Keeps the calling thread off the processor of a ticking thread, where that leaves it another one. A thread of ordinary priority
/// that shares it cannot run while the ticking thread waits for what it makes.
pub(crate) fn keep_off(ticks: usize) {
    let mut others = CpuSet::new();
    for processor in allowed().into_iter().filter(|&processor| processor != ticks) {
        others.set(processor);
    }
    // An empty set is refused, and so is left as it was.
    let _ = sched_setaffinity(None, &others);
}

fn granted(what: &str, found: impl Into<String>) -> Grant {
    Grant { what: what.to_owned(), granted: true, found: found.into(), remedy: None }
}

fn refused(what: &str, found: impl Into<String>, remedy: impl Into<String>) -> Grant {
    Grant { what: what.to_owned(), granted: false, found: found.into(), remedy: Some(remedy.into()) }
}

fn limit_text(limit: Option<u64>) -> String {
    limit.map_or_else(|| "unlimited".to_owned(), |limit| limit.to_string())
}

/// The priority that is wanted, else the highest that the limit allows.
fn priority() -> Grant {
    const WHAT: &str = "real-time priority";
    let limit = getrlimit(Resource::Rtprio).current;
    let most = limit.map_or(PRIORITY, |limit| limit.min(u64::from(PRIORITY)) as u8);
    let mut tried = fifo::take_priority(PRIORITY).map(|()| PRIORITY);
    if tried.is_err() && (1..PRIORITY).contains(&most) {
        tried = fifo::take_priority(most).map(|()| most);
    }
    match tried {
        Ok(priority) => granted(WHAT, format!("SCHED_FIFO {priority}")),
        Err(error) => refused(
            WHAT,
            format!("SCHED_FIFO {PRIORITY}: {error}; limit of priorities `ulimit -r`: {}", limit_text(limit)),
            format!("{SETCAP}, or `@realtime - rtprio {PRIORITY}` in /etc/security/limits.conf"),
        ),
    }
}

/// Only a thread that nothing but the kernel can displace is bound to one processor: another one would wait there for its turn
/// while a second processor is idle.
fn processor(isolated: &[usize], is_prior: bool) -> (Grant, Option<usize>) {
    const WHAT: &str = "processor of its own";
    let isolate = "boot with isolcpus=managed_irq,domain,N for a processor N (docs/realtime.md)";
    let allowed = allowed();
    let chosen = choice(isolated, &allowed);
    let Some(processor) = chosen else {
        let found = "there is only one, and everything else needs it";
        return (refused(WHAT, found, "use two processors or more"), None);
    };
    let is_isolated = isolated.contains(&processor);
    if !is_isolated && !is_prior {
        let found = "not bound to one: without real-time priority it would have to wait there";
        return (refused(WHAT, found, isolate), None);
    }
    let bound = sched_setaffinity(None, &only(processor)).map(|()| processor);
    // A control group may keep the process away from an isolated one.
    let fallback = choice(&[], &allowed);
    let bound = bound.or_else(|error| match fallback {
        Some(other) if other != processor && is_prior => {
            sched_setaffinity(None, &only(other)).map(|()| other)
        }
        _ => Err(error),
    });
    let grant = match &bound {
        Ok(processor) if isolated.contains(processor) => {
            granted(WHAT, format!("processor {processor}, isolated"))
        }
        Ok(processor) => granted(WHAT, format!("processor {processor}, shared: no processor is isolated")),
        Err(error) => refused(WHAT, format!("processor {processor}: {error}"), isolate),
    };
    (grant, bound.ok())
}

/// Locks the memory of the process that is there now, so that none of it is swapped out. Memory that is mapped later, such as that
/// of the judge, is not locked: a limit could refuse it to the program then.
///
/// # Errors
/// What the kernel says.
pub fn lock_present_memory() -> std::io::Result<()> {
    Ok(mlockall(MlockAllFlags::CURRENT | MlockAllFlags::ONFAULT)?)
}

fn memory() -> Grant {
    const WHAT: &str = "locked memory";
    let before = getrlimit(Resource::Memlock);
    for raised in
        [Rlimit { current: None, maximum: None }, Rlimit { current: before.maximum, maximum: before.maximum }]
    {
        if before.current.is_some() && setrlimit(Resource::Memlock, raised).is_ok() {
            break;
        }
    }
    match lock_present_memory() {
        Ok(()) => granted(WHAT, "what the process has mapped before it ticks; later memory is not locked"),
        Err(error) => {
            let limit = limit_text(getrlimit(Resource::Memlock).current);
            refused(
                WHAT,
                format!("{error}; limit `ulimit -l`: {limit} bytes, and all that is mapped counts"),
                format!("{SETCAP}, or `@realtime - memlock unlimited` in /etc/security/limits.conf"),
            )
        }
    }
}

fn timer_slack() -> Grant {
    const WHAT: &str = "timer slack of 1 ns";
    match set_current_timer_slack(NonZeroU64::new(1)).and_then(|()| current_timer_slack()) {
        Ok(1) => granted(WHAT, "1 ns"),
        // The kernel ignores it for threads with real-time priority: theirs is 0.
        Ok(0) => granted(WHAT, "0 ns, because of its priority"),
        Ok(slack_ns) => refused(WHAT, format!("{slack_ns} ns"), "nothing: this kernel rounds timers"),
        Err(error) => refused(WHAT, error.to_string(), "nothing: this kernel refuses it"),
    }
}

/// Keeps the processors out of states from which they wake late.
fn awake() -> (Grant, Option<File>) {
    const WHAT: &str = "processors that wake at once";
    const FILE: &str = "/dev/cpu_dma_latency";
    const ASKED_US: i32 = 0;
    let opened = File::options().write(true).open(FILE);
    match opened.and_then(|mut file| file.write_all(&ASKED_US.to_ne_bytes()).map(|()| file)) {
        Ok(file) => (granted(WHAT, format!("{FILE} at 0 us")), Some(file)),
        Err(error) => {
            let remedy = "a udev rule `KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"`, or \
                          boot with processor.max_cstate=1";
            (refused(WHAT, format!("{FILE}: {error}"), remedy), None)
        }
    }
}

/// Touches as much of the stack as ticks may need: a page that is used for the first time takes its time.
#[inline(never)]
fn touch_stack() {
    let mut pages = [0_u8; STACK_BYTES];
    std::hint::black_box(&mut pages);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_this_machine_refuses_is_named_with_what_was_found_and_what_to_do() {
        // In a thread of its own: the rights end with it.
        let rights = std::thread::spawn(Rights::ask).join().expect("asking panics nowhere");
        assert_eq!(rights.grants.len(), 5);
        for grant in &rights.grants {
            assert!(!grant.what.is_empty() && !grant.found.is_empty(), "{grant:?}");
            assert_eq!(grant.granted, grant.remedy.is_none(), "{grant:?}");
        }
    }

    #[test]
    fn a_thread_that_a_ticking_thread_starts_has_no_priority() {
        let policy_of_child = std::thread::spawn(|| {
            let _rights = Rights::ask();
            std::thread::spawn(|| std::fs::read_to_string("/proc/thread-self/sched")).join()
        });
        let text = policy_of_child.join().expect("no panic").expect("no panic");
        // Not every kernel has the file.
        if let Some(line) =
            text.ok().and_then(|text| text.lines().find(|l| l.starts_with("policy")).map(str::to_owned))
        {
            assert!(line.trim_end().ends_with('0'), "SCHED_OTHER: {line}");
        }
    }
}
