//! A session: one rig, opened once and ticked from arming to teardown, in a thread of its own.
//!
//! The thread builds the rig (whose world, if it is simulated, cannot leave it), takes points over a ring and gives back
//! what they came to. Between points it keeps ticking: nothing moves, every interlock watches.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::Duration;

use controllers::DirectorGains;
use drivers::device::DeviceError;
use procedures::case::Case;
use reports::record::{DeviceRecord, Grant};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::clock::{self, Clock};
use crate::cycle::recorder::Recorder;
use crate::cycle::run::{Conditions, PointOutcome, PointRun};
use crate::cycle::safe::Safe;
use crate::model::rig::Rig;
use crate::realtime::lock_present_memory;
use crate::rig::PointSettings;
use crate::rig::instruments::TaskPreparer;
use crate::site::{Contact, Purpose, Site};

mod thread;

/// Orders and reports that may be under way.
const RING: usize = 4;

/// A point for an open session: all that it needs is allocated.
pub(crate) struct Job<'a> {
    /// The point.
    pub run: PointRun<'a>,
    /// Plan of the point.
    pub case: &'a Case,
    /// Log of the point's procedure.
    pub recorder: Recorder,
    /// What it changes on the rig.
    pub settings: PointSettings,
    /// Somebody has looked at the rig since it tripped.
    pub looked_at: bool,
    /// Brings the axes to where it begins, if they stand elsewhere; `None` for a point without closed loops.
    pub transfer: Option<PointRun<'a>>,
}

/// What a point came to.
pub(crate) struct Done<'a> {
    /// The outcome, or why the point was not run.
    pub outcome: Result<PointOutcome, DeviceError>,
    /// End stops that were met since the point before.
    pub contacts: Vec<Contact>,
    /// The point itself, with its log.
    pub job: Box<Job<'a>>,
    /// The session closes itself: the rig's own settings could not be restored, or stations have lost their configuration.
    pub is_closing: bool,
}

/// How a session ended.
#[derive(Clone, Debug)]
pub(crate) struct Closed {
    /// How the axes were left.
    pub safe: Safe,
    /// End stops that were met since the last point.
    pub contacts: Vec<Contact>,
    /// What tripped between points, in words.
    pub trips: Vec<String>,
    /// Log time of the end.
    pub log_time_ns: u64,
}

/// What a session needs to tick between points.
pub(crate) struct Arming<'a> {
    /// Conditions of the time between points.
    pub between: Conditions<'a>,
    /// The session's own log.
    pub recorder: Recorder,
}

enum Order<'a> {
    Arm(Box<Arming<'a>>),
    Point(Box<Job<'a>>),
    Close,
}

enum Report<'a> {
    Opened(Box<Opened>),
    Failed(DeviceError),
    Done(Box<Done<'a>>),
    Closed(Box<Closing>),
}

/// The end of a session, with the log to be closed.
struct Closing {
    closed: Closed,
    recorder: Option<Recorder>,
}

/// Who is there.
struct Opened {
    bus: String,
    devices: Vec<DeviceRecord>,
    preparer: TaskPreparer,
    clock: Clock,
    /// What the thread asked of the operating system.
    grants: Vec<Grant>,
    /// The processor that the thread is bound to.
    processor: Option<usize>,
    locks_memory: bool,
}

/// The campaign's end of a session.
pub(crate) struct Session<'scope, 'a> {
    orders: Producer<Order<'a>>,
    reports: Consumer<Report<'a>>,
    opened: Opened,
    thread: ScopedJoinHandle<'scope, ()>,
}

/// What a session is opened with.
#[derive(Clone)]
pub(crate) struct Opening<'a> {
    /// Where.
    pub site: &'a dyn Site,
    /// Which rig.
    pub rig: &'a Rig,
    /// Gains of its loops.
    pub gains: DirectorGains,
    /// What for.
    pub purpose: Purpose<'a>,
}

impl<'scope, 'a: 'scope> Session<'scope, 'a> {
    /// Opens a rig in a thread of its own and waits until every device has said who it is. Nothing can move yet.
    ///
    /// # Errors
    /// The first device that is missing, does not answer or is not what it must be; no thread.
    pub(crate) fn open(scope: &'scope Scope<'scope, '_>, opening: Opening<'a>) -> Result<Self, DeviceError> {
        let (orders, ordered) = RingBuffer::new(RING);
        let (mut reported, mut reports) = RingBuffer::new(RING);
        let rig = opening.rig.id.clone();
        let work = move || {
            // Whatever panics here, no frame is sent any more: the drives stop by their watchdogs.
            let _ = catch_unwind(AssertUnwindSafe(|| thread::serve(&opening, ordered, &mut reported)));
        };
        let spawned = std::thread::Builder::new().name("tick".to_owned()).spawn_scoped(scope, work);
        let thread = spawned.map_err(|source| DeviceError::Bus {
            device: rig.clone(),
            reason: format!("cannot start a thread: {source}; raise the limit of processes (`ulimit -u`)"),
        })?;
        match wait(&mut reports, || {}) {
            Some(Report::Opened(opened)) => Ok(Self { orders, reports, opened: *opened, thread }),
            Some(Report::Failed(error)) => Err(error),
            _ => Err(gone(&rig)),
        }
    }

    /// Name of the bus of its drives.
    pub(crate) fn bus(&self) -> &str {
        &self.opened.bus
    }

    /// Who is there.
    pub(crate) fn devices(&self) -> &[DeviceRecord] {
        &self.opened.devices
    }

    /// The clock that it is ticked by.
    pub(crate) fn clock(&self) -> Clock {
        self.opened.clock.clone()
    }

    /// What its thread asked of the operating system; empty where time is virtual.
    pub(crate) fn grants(&self) -> &[Grant] {
        &self.opened.grants
    }

    /// The processor that its thread is bound to.
    pub(crate) fn processor(&self) -> Option<usize> {
        self.opened.processor
    }

    /// Readies tasks for its instruments.
    pub(crate) fn preparer(&self) -> &TaskPreparer {
        &self.opened.preparer
    }

    /// Maps the process data and begins to tick; from now on the rig is watched until the session is closed.
    pub(crate) fn arm(&mut self, arming: Arming<'a>) {
        self.order(Order::Arm(Box::new(arming)));
    }

    /// Runs a point and waits for what it comes to.
    ///
    /// # Errors
    /// When the session is gone.
    pub(crate) fn run(&mut self, job: Job<'a>) -> Result<Done<'a>, DeviceError> {
        if self.opened.locks_memory {
            // The ring of a log was made after the memory of the process was locked. Refused, it is only not locked.
            let _ = lock_present_memory();
        }
        self.order(Order::Point(Box::new(job)));
        match wait(&mut self.reports, || {}) {
            Some(Report::Done(done)) => Ok(*done),
            Some(Report::Failed(error)) => Err(error),
            _ => Err(gone(&self.opened.bus)),
        }
    }

    /// Brings every axis to its final state, ends the tick and lets go of the rig.
    ///
    /// # Errors
    /// When the session is gone, or its log cannot be closed; nobody knows then how the axes stand.
    pub(crate) fn close(mut self) -> Result<Closed, String> {
        self.order(Order::Close);
        let closing = match wait(&mut self.reports, || {}) {
            Some(Report::Closed(closing)) => Ok(*closing),
            Some(Report::Failed(error)) => Err(error.to_string()),
            _ => Err(gone(&self.opened.bus).to_string()),
        };
        let Self { orders, thread, .. } = self;
        drop(orders);
        let _ = thread.join();
        let Closing { closed, recorder } = closing?;
        match recorder.map(Recorder::finish) {
            Some(Err(error)) => Err(error.to_string()),
            _ => Ok(closed),
        }
    }

    /// An order that finds no room finds no thread either: it takes each before it reports.
    fn order(&mut self, order: Order<'a>) {
        let _ = self.orders.push(order);
    }
}

/// The next report; `None` where nobody is left to send one.
fn wait<'a>(reports: &mut Consumer<Report<'a>>, mut meanwhile: impl FnMut()) -> Option<Report<'a>> {
    loop {
        // Asked before the pop: what was sent before the other end left is still taken.
        let is_abandoned = reports.is_abandoned();
        match reports.pop() {
            Ok(report) => return Some(report),
            Err(_) if is_abandoned => return None,
            Err(_) => {
                meanwhile();
                clock::nap();
            }
        }
    }
}

fn gone(device: &str) -> DeviceError {
    let reason =
        "internal error: the control thread of this rig has ended; the drives' watchdogs stop the axes";
    DeviceError::Bus { device: device.to_owned(), reason: reason.to_owned() }
}

/// Longest wait of a thread for an order before it looks again.
const LOOK: Duration = Duration::from_millis(1);
