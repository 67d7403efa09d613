//! The thread of a session: opens the rig, carries out orders, and ticks all the time so that the rig is never unwatched.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::wire::BusState;
use rtrb::{Consumer, Producer};

use super::{Arming, Closed, Closing, Done, Job, LOOK, Opened, Opening, Order, Report};
use crate::clock::Clock;
use crate::cycle::recorder::Recorder;
use crate::cycle::run::{Between, PointError, PointOutcome};
use crate::cycle::safe::{Exit, Safe, make_safe};
use crate::cycle::sequence::HOMED_RAD;
use crate::cycle::stops::Stops;
use crate::realtime::{Rights, privileges};
use crate::rig::{ArmedRig, PointSettings};
use crate::site::{Contact, Surroundings};

/// Serves a session until it is closed, or until nobody is left to close it.
pub(super) fn serve<'a>(
    opening: &Opening<'a>,
    mut orders: Consumer<Order<'a>>,
    reports: &mut Producer<Report<'a>>,
) {
    privileges::raise();
    let opened = match opening.site.open(opening.rig, &opening.gains, &opening.purpose) {
        Ok(opened) => opened,
        Err(error) => return report(reports, Report::Failed(error)),
    };
    let devices = crate::rig::identities::records(opening.rig, &opened.rig, &opened.grounds);
    let preparer = opened.rig.instruments().preparer();
    // Kept until the session ends. Virtual time needs no rights.
    let rights = (!opened.clock.is_virtual()).then(Rights::ask);
    let given_up = privileges::give_up();
    let grants =
        rights.iter().flat_map(|rights| rights.grants.iter().cloned().chain([given_up.clone()])).collect();
    let processor = rights.as_ref().and_then(|rights| rights.processor);
    let locks_memory = rights.as_ref().is_some_and(Rights::locks_memory);
    let clock = opened.clock.clone();
    let opened_by = Opened { bus: opened.bus, devices, preparer, clock, grants, processor, locks_memory };
    report(reports, Report::Opened(Box::new(opened_by)));
    let Some(arming) = armed_by(&mut orders) else { return };
    let rig = match opened.rig.arm(&opened.clock) {
        Ok(rig) => rig,
        Err(error) => return report(reports, Report::Failed(error)),
    };
    let own = PointSettings::own(opening.rig);
    let ticking = Ticking::begin(rig, *arming, own, opened.surroundings, opened.clock);
    let closing = ticking.serve(&mut orders, reports);
    report(reports, Report::Closed(Box::new(closing)));
}

/// Sends a report. If the ring is full, nobody reads it any more, and the report is dropped.
fn report<'a>(reports: &mut Producer<Report<'a>>, what: Report<'a>) {
    let _ = reports.push(what);
}

/// Waits for the order to arm. `None` if the session is closed or abandoned before that.
fn armed_by<'a>(orders: &mut Consumer<Order<'a>>) -> Option<Box<Arming<'a>>> {
    loop {
        // Asked before the pop, so that an order that was sent before the other end left is still taken.
        let is_abandoned = orders.is_abandoned();
        match orders.pop() {
            Ok(Order::Arm(arming)) => return Some(arming),
            Ok(_) => return None,
            Err(_) if is_abandoned => return None,
            Err(_) => crate::clock::rest(LOOK),
        }
    }
}

/// A session with an armed rig.
struct Ticking<'a> {
    rig: ArmedRig,
    /// The loop that runs between points.
    between: Between<'a>,
    /// The session's own log, for everything outside points.
    recorder: Recorder,
    /// Settings of the rig file, which are restored after every point.
    own: PointSettings,
    surroundings: Box<dyn Surroundings>,
    clock: Clock,
    /// Of the loop.
    period: Duration,
    /// Number of contacts with end stops that were reported so far.
    contacts_told: usize,
    /// What tripped between points, in words.
    trips: Vec<String>,
    /// Names of the axes by index.
    names: Vec<String>,
    /// Whether the last point ran without closed loops: its axes have no torque.
    open_loop: bool,
}

impl<'a> Ticking<'a> {
    fn begin(
        rig: ArmedRig,
        arming: Arming<'a>,
        own: PointSettings,
        surroundings: Box<dyn Surroundings>,
        clock: Clock,
    ) -> Self {
        let Arming { between, mut recorder } = arming;
        let period = Duration::from_secs_f64(1.0 / between.loop_rate_hz);
        let names = rig.axes().iter().map(|axis| axis.name.clone()).collect();
        let between = Between::begin(between, &rig, &mut recorder);
        let contacts_told = 0;
        let trips = Vec::new();
        let open_loop = false;
        Self {
            rig,
            between,
            recorder,
            own,
            surroundings,
            clock,
            period,
            contacts_told,
            trips,
            names,
            open_loop,
        }
    }

    /// Ticks and carries out orders until the session is closed or abandoned.
    fn serve(mut self, orders: &mut Consumer<Order<'a>>, reports: &mut Producer<Report<'a>>) -> Closing {
        loop {
            self.between.tick(&mut self.rig, &mut self.recorder);
            // Asked before the pop, as in `armed_by`.
            let is_abandoned = orders.is_abandoned();
            match orders.pop() {
                Ok(Order::Point(job)) => {
                    let done = self.run(job);
                    let is_closing = done.is_closing;
                    report(reports, Report::Done(Box::new(done)));
                    if is_closing {
                        return self.close();
                    }
                }
                Ok(Order::Close) => return self.close(),
                Ok(Order::Arm(_)) => {}
                Err(_) if is_abandoned => return self.close(),
                Err(_) => {}
            }
        }
    }

    /// Runs a point, then restores the rig's own settings. The session closes itself where that fails, because the next point
    /// must not run with the settings of this one, and where stations have lost their configuration with their supply: whoever
    /// has looked at the rig opens it anew.
    fn run(&mut self, mut job: Box<Job<'a>>) -> Done<'a> {
        let outcome = self.run_job(&mut job);
        let own = self.own.clone();
        let restored = self.change(&own);
        let is_closing = restored.is_err() || self.rig.bus_state() < BusState::SafeOp;
        let outcome = match (outcome, restored) {
            (Ok(mut outcome), Err(error)) => {
                let reason = format!("settings cannot be restored: {error}");
                outcome.error.get_or_insert(PointError::Bench(reason));
                outcome.status = procedures::log::PointStatus::Errored;
                Ok(outcome)
            }
            (outcome, _) => outcome,
        };
        Done { outcome, contacts: self.contacts(), job, is_closing }
    }

    /// Brings the axes to the start pose, sets the surroundings and the settings of the point, and runs it.
    ///
    /// A transfer that did not end normally is the outcome: the point itself is then not run.
    fn run_job(&mut self, job: &mut Job<'a>) -> Result<PointOutcome, DeviceError> {
        // After a trip between points nothing moves before somebody has looked at the rig.
        if let Some(trip) = self.between.trip().filter(|_| !job.looked_at) {
            let reason = format!("tripped while no axis was to move: {}", trip.reason(&self.names));
            return Err(DeviceError::Bus { device: "session".to_owned(), reason });
        }
        self.note_trip();
        if let Some(transfer) = job.transfer.as_mut().filter(|_| is_away(&self.rig, job.case)) {
            let moved = self.point(transfer, None, false);
            if moved.trip.is_some()
                || moved.error.is_some()
                || moved.signal.is_some()
                || moved.refused.is_some()
            {
                return Ok(moved);
            }
        }
        self.surroundings.bring(job.case);
        self.change(&job.settings)?;
        Ok(self.point(&mut job.run, Some(&mut job.recorder), job.case.open_loop))
    }

    /// Runs a point or a transfer in place of the loop between points. Without a `recorder` it is recorded in the session's
    /// own log.
    fn point(
        &mut self,
        run: &mut crate::cycle::run::PointRun<'a>,
        recorder: Option<&mut Recorder>,
        open_loop: bool,
    ) -> PointOutcome {
        let start = self.between.next_due();
        self.between.pause(&self.rig, &mut self.recorder);
        self.rig.trust_again();
        run.set_log_start(self.between.log_time_ns(start));
        let outcome = run.run(&mut self.rig, start, recorder.unwrap_or(&mut self.recorder));
        self.open_loop = open_loop;
        self.between.resume(&self.rig, run.next_due(), open_loop);
        outcome
    }

    /// Gives the rig other settings and keeps ticking until all devices have taken them.
    fn change(&mut self, settings: &PointSettings) -> Result<(), DeviceError> {
        self.rig.change(settings)?;
        loop {
            // Deadlines of transfers count from a tick of now, not from the last one before a point.
            self.between.tick(&mut self.rig, &mut self.recorder);
            if self.rig.poll_change(self.between.now())? {
                return Ok(());
            }
        }
    }

    /// Notes what tripped between points: it belongs to no point, so it is reported when the session closes.
    fn note_trip(&mut self) {
        if let Some(trip) = self.between.trip() {
            self.trips.push(trip.reason(&self.names));
        }
    }

    /// Contacts with end stops that were not reported yet; they count as reported from now on.
    fn contacts(&mut self) -> Vec<Contact> {
        let all = self.surroundings.contacts();
        let new = all[self.contacts_told.min(all.len())..].to_vec();
        self.contacts_told = all.len();
        new
    }

    /// Makes the rig safe, whatever state it is in, and writes how it was left into the session's own log.
    fn close(mut self) -> Closing {
        self.note_trip();
        let from = self.between.next_due();
        let exit = Exit { clock: &self.clock, from, period: self.period, open_loop: self.open_loop };
        let mut stops = Stops::new(self.rig.axes().len());
        let between = &mut self.between;
        let safe: Safe = make_safe(&mut self.rig, &exit, &mut stops, |_, woken| between.note(woken));
        self.between.end(&safe, &mut self.recorder);
        let log_time_ns =
            self.between.log_time_ns(from + self.period * u32::try_from(safe.ticks).unwrap_or(0));
        let contacts = self.contacts();
        let closed = Closed { safe, contacts, trips: self.trips, log_time_ns };
        Closing { closed, recorder: Some(self.recorder) }
    }
}

/// Whether any axis is so far from the start pose of a point that it needs a transfer.
fn is_away(rig: &ArmedRig, case: &procedures::case::Case) -> bool {
    rig.axes().iter().enumerate().any(|(index, axis)| {
        let start_rad = case.start_pose_rad.get(&axis.name);
        start_rad.is_some_and(|start_rad| (start_rad - rig.actuals(index).position_rad).abs() > HOMED_RAD)
    })
}
