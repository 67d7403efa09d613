//! The session of a run whose site keeps one: opened once, armed once, closed with the run, or where the unit is rebuilt.

use std::sync::Arc;
use std::thread::Scope;

use drivers::device::DeviceError;
use procedures::case::{Case, Segment};
use procedures::log::Plan;
use reports::record::{DeviceRecord, Grant};

use super::point::{self, Ended, LOG_EPOCH_NS, Planned};
use super::procedure::planned_from_s;
use super::{Setup, output};
use crate::clock::Clock;
use crate::cycle::axis_loop::AxisLoop;
use crate::cycle::recorder::{LogHead, Recorder};
use crate::cycle::run::{Conditions, PointRun};
use crate::cycle::session::{Arming, Closed, Done, Job, Opening, Session};
use crate::record::journal::Entry;
use crate::record::log::{self, SESSION, SUFFIX, attachment};
use crate::rig::PointSettings;
use crate::rig::instruments::Tasks;
use crate::site::Purpose;

/// Rows per second of the session's own log: nothing moves in it, but what trips is told tick by tick.
const LOG_HZ: f64 = 100.0;
/// Rows of it for each row of the devices.
const PAYLOAD_EVERY: u64 = 10;
/// A sessions' log begins this long after that of the session before.
const GAP_NS: u64 = 1_000_000_000;

/// Cases that the plan does not have: the time between points, and the ways to where points begin.
pub(super) struct Extras {
    between: Vec<Case>,
    transfers: Vec<Vec<Case>>,
}

impl Extras {
    pub(super) fn new(setup: &Setup<'_>) -> Self {
        let axis = setup.rig.axes.first().map(|axis| axis.name.clone()).unwrap_or_default();
        let between = Case { point: "between points".to_owned(), axis, ..Case::default() };
        let of_procedure =
            |planned: &crate::plan::PlannedProcedure| planned.cases.iter().map(transfer).collect();
        let transfers = setup.plan.procedures.iter().map(of_procedure).collect();
        Self { between: vec![between], transfers }
    }
}

/// The way to where a point begins. The loop moves all axes there slowly before the first segment, which only rests.
fn transfer(case: &Case) -> Case {
    const REST_S: f64 = 0.1;
    Case {
        point: format!("to the start of {}", case.point),
        axis: case.axis.clone(),
        start_pose_rad: case.start_pose_rad.clone(),
        segments: vec![Segment {
            then: procedures::case::Then::Stop,
            ..Segment::hold("rest", procedures::case::Mode::Position, REST_S)
        }],
        ..Case::default()
    }
}

/// A point of a procedure, as a session is to run it.
pub(super) struct PointOf<'a> {
    /// Procedure, by its index in the campaign.
    pub(super) procedure: usize,
    pub(super) plan: &'a Plan,
    /// Index in the plan.
    pub(super) point: usize,
    /// Devices as they were found when the run began.
    pub(super) devices: &'a [DeviceRecord],
}

/// What the workers of a run do with its session.
pub(super) trait KeptSession: Send {
    /// Runs a point in the open session; the log comes back, unless the session is gone.
    fn run(&mut self, of: PointOf<'_>, recorder: Recorder) -> (Result<Ended, DeviceError>, Option<Recorder>);

    /// Somebody has looked at the rig since it tripped.
    fn was_looked_at(&mut self);

    /// Ends the session; why somebody must look at the rig, if anybody must.
    fn close(&mut self) -> Vec<String>;

    /// What the journal does not know yet.
    fn take_news(&mut self) -> Vec<Entry>;

    /// Logs of the sessions so far, by their names in the run folder.
    fn logs(&self) -> Vec<String>;
}

/// The session of a run.
pub(super) struct HeldSession<'scope, 'env, 'a> {
    scope: &'scope Scope<'scope, 'env>,
    setup: &'a Setup<'a>,
    extras: &'a Extras,
    session: Option<Session<'scope, 'a>>,
    /// Procedure whose build state the unit is in.
    built_for: usize,
    /// Log time of the next session's first tick.
    log_start_ns: u64,
    /// Sessions so far.
    count: usize,
    logs: Vec<String>,
    news: Vec<Entry>,
    /// Somebody has looked at the rig since it tripped.
    looked_at: bool,
    /// Why somebody must look at the rig after a session that closed itself.
    left: Vec<String>,
}

impl<'scope, 'env, 'a: 'scope> HeldSession<'scope, 'env, 'a> {
    /// Opens the rig as the first procedure finds it. Nothing can move yet.
    pub(super) fn open(
        scope: &'scope Scope<'scope, 'env>,
        setup: &'a Setup<'a>,
        extras: &'a Extras,
    ) -> Result<Self, DeviceError> {
        let log_start_ns = LOG_EPOCH_NS;
        let count = 0;
        let looked_at = false;
        let mut held = Self {
            scope,
            setup,
            extras,
            session: None,
            built_for: 0,
            log_start_ns,
            count,
            logs: Vec::new(),
            news: Vec::new(),
            looked_at,
            left: Vec::new(),
        };
        held.session = Some(held.opened(0)?);
        Ok(held)
    }

    fn opened(&self, index: usize) -> Result<Session<'scope, 'a>, DeviceError> {
        let setup = self.setup;
        let first = setup.plan.procedures.get(index);
        let purpose = Purpose {
            seed: setup.seed,
            procedure: "session",
            case: None,
            stage: first.and_then(|planned| planned.stage),
            planned_s: if first.is_some() { planned_from_s(setup.plan, index, 0) } else { 0.0 },
            pose_rad: first
                .and_then(|p| p.cases.first())
                .map(|c| c.start_pose_rad.clone())
                .unwrap_or_default(),
        };
        let rig = if first.is_some() { setup.rig_of(index) } else { setup.rig };
        let gains = if first.is_some() { setup.gains_of(index) } else { *setup.gains };
        Session::open(self.scope, Opening { site: setup.site, rig, gains, purpose })
    }

    /// Name of the bus, and who is there.
    pub(super) fn identified(&self) -> Option<(String, Vec<DeviceRecord>)> {
        let session = self.session.as_ref()?;
        Some((session.bus().to_owned(), session.devices().to_vec()))
    }

    /// What the thread that ticks asked of the operating system.
    pub(super) fn grants(&self) -> Vec<Grant> {
        self.session.as_ref().map(|session| session.grants().to_vec()).unwrap_or_default()
    }

    fn clock(&self) -> Clock {
        self.session.as_ref().map_or(Clock::Virtual, |session| session.clock())
    }

    /// Name of the log of the present session.
    fn log_name(&self) -> String {
        match self.count {
            0 => format!("{SESSION}{SUFFIX}"),
            count => format!("{SESSION}-{}{SUFFIX}", count + 1),
        }
    }

    /// Begins to tick.
    pub(super) fn arm(&mut self, devices: &[DeviceRecord]) -> Result<(), super::RunError> {
        let setup = self.setup;
        let name = self.log_name();
        let path = setup.folder.join(&name);
        let rig = setup.rig_of(self.built_for);
        let every = (rig.loop_rate_hz / LOG_HZ).round().max(1.0);
        let plan = Plan {
            schema: 1,
            procedure: name.trim_end_matches(SUFFIX).to_owned(),
            axis: self.extras.between[0].axis.clone(),
            seed: setup.seed,
            loop_rate_hz: rig.loop_rate_hz,
            log_rate_hz: rig.loop_rate_hz / every,
            command_delay_ticks: 1,
            axes: rig.limits(),
            cases: self.extras.between.clone(),
            mode: log::mode_of(log::origin(devices)).to_owned(),
        };
        let identities = serde_json::to_string(devices).expect("names and sentences have a JSON form");
        let attachments =
            [attachment(log::RIG, &setup.rig.source.text), attachment(log::DEVICES, &identities)];
        let recorder =
            Recorder::start(&path, LogHead { attachments: &attachments, ..LogHead::new(&plan, rig) }, false);
        let recorder = recorder.map_err(|e| output(&path, std::io::Error::other(e.to_string())))?;
        let between = Conditions {
            point: 0,
            case: &self.extras.between[0],
            moving: 0,
            log_start_ns: self.log_start_ns,
            loop_rate_hz: rig.loop_rate_hz,
            log_every: every as u64,
            log_payload_every: PAYLOAD_EVERY,
            max_missed_periods: rig.max_missed_periods,
            gates: &[],
            questions: [].into(),
            parks: false,
            stop: &setup.stop,
            clock: self.clock(),
            progress: Arc::default(),
        };
        let devices = devices.iter().map(|d| format!("{}: {}", d.name, d.identity)).collect();
        self.news.push(Entry::SessionOpened { log: name.clone(), devices });
        self.logs.push(name);
        if let Some(session) = &mut self.session {
            session.arm(Arming { between, recorder });
        }
        Ok(())
    }

    /// Opens the rig anew where a procedure finds the unit rebuilt.
    ///
    /// # Errors
    /// When the session cannot be closed in order, or the rig does not open.
    fn rebuilt_for(&mut self, index: usize, devices: &[DeviceRecord]) -> Result<(), DeviceError> {
        let state = |k: usize| {
            let planned = self.setup.plan.procedures.get(k)?;
            self.setup.plan.state_of(planned).map(|state| state.id.clone())
        };
        if self.session.is_some() && state(index) == state(self.built_for) {
            return Ok(());
        }
        let failed = |reason: String| DeviceError::Bus { device: "session".to_owned(), reason };
        if let Some(session) = self.session.take() {
            let closed = session.close().map_err(failed)?;
            self.note_end(&closed);
            self.log_start_ns = closed.log_time_ns + GAP_NS;
            self.count += 1;
        }
        self.session = Some(self.opened(index)?);
        self.built_for = index;
        self.arm(devices).map_err(|error| failed(error.to_string()))
    }

    fn note_end(&mut self, closed: &Closed) {
        let names = self.setup.rig_of(self.built_for).axis_names();
        let log = self.log_name();
        let trips = closed.trips.clone();
        self.news.push(Entry::SessionClosed { log, safe: closed.safe.text(&names), trips });
    }

    fn job(
        &self,
        planned: &Planned<'a>,
        index: usize,
        point: usize,
    ) -> Result<(PointRun<'a>, Option<PointRun<'a>>), DeviceError> {
        let rig = self.setup.rig_of(index);
        let session = self.session.as_ref();
        let probed = rig.pair().map(|axis| axis.map(|axis| axis.name.clone()));
        let tasks =
            session.map_or_else(|| Ok(Tasks::default()), |s| s.preparer().ready(planned.case, &probed));
        let gains = self.setup.gains_of(index);
        let processor = session.and_then(Session::processor);
        let loops = || AxisLoop::of_rig_with(rig, &gains, &self.setup.laws, processor);
        let run = PointRun::new(planned.conditions(), loops()?, planned.dither.clone(), tasks);
        let way = &self.extras.transfers[index][point];
        if planned.case.open_loop {
            return Ok((run, None));
        }
        let conditions = Conditions {
            point: 0,
            case: way,
            log_every: (rig.loop_rate_hz / LOG_HZ).round().max(1.0) as u64,
            log_payload_every: PAYLOAD_EVERY,
            gates: &[],
            parks: false,
            ..planned.conditions()
        };
        let transfer =
            PointRun::new(conditions, loops()?, planned.dither.clone(), Ok(Tasks::default())).untold();
        Ok((run, Some(transfer)))
    }
}

impl<'scope, 'a: 'scope> KeptSession for HeldSession<'scope, '_, 'a> {
    fn run(&mut self, of: PointOf<'_>, recorder: Recorder) -> (Result<Ended, DeviceError>, Option<Recorder>) {
        let PointOf { procedure: index, plan, point, devices } = of;
        if let Err(error) = self.rebuilt_for(index, devices) {
            return (Err(error), Some(recorder));
        }
        let setup = self.setup;
        let clock = self.clock();
        let planned = Planned::new(setup, index, plan, point, clock);
        let job = match planned.and_then(|planned| self.job(&planned, index, point)) {
            Ok((run, transfer)) => {
                let case = &setup.plan.procedures[index].cases[point];
                let settings = PointSettings::for_case(setup.rig_of(index), case);
                let looked_at = std::mem::take(&mut self.looked_at);
                Job { run, case, recorder, settings, looked_at, transfer }
            }
            Err(error) => return (Err(error), Some(recorder)),
        };
        let Some(session) = &mut self.session else {
            let reason = "the session is closed: settings of a point could not be restored".to_owned();
            return (Err(DeviceError::Bus { device: "session".to_owned(), reason }), Some(job.recorder));
        };
        match session.run(job) {
            Err(error) => (Err(error), None),
            Ok(Done { outcome, contacts, job, is_closing }) => {
                if is_closing {
                    self.left = self.close_session();
                }
                let ended = outcome.map(|outcome| point::ended(setup.rig_of(index), outcome, &contacts));
                (ended, Some(job.recorder))
            }
        }
    }

    fn was_looked_at(&mut self) {
        self.looked_at = true;
    }

    fn take_news(&mut self) -> Vec<Entry> {
        std::mem::take(&mut self.news)
    }

    fn logs(&self) -> Vec<String> {
        self.logs.clone()
    }

    fn close(&mut self) -> Vec<String> {
        let left = std::mem::take(&mut self.left);
        left.into_iter().chain(self.close_session()).collect()
    }
}

impl<'scope, 'a: 'scope> HeldSession<'scope, '_, 'a> {
    /// Ends the present session; why somebody must look at the rig, if anybody must.
    fn close_session(&mut self) -> Vec<String> {
        let Some(session) = self.session.take() else { return Vec::new() };
        let rig = self.setup.rig_of(self.built_for);
        match session.close() {
            Err(reason) => vec![format!("the state of the axes is unknown: {reason}")],
            Ok(closed) => {
                self.note_end(&closed);
                // A session that follows has a log of its own.
                self.log_start_ns = closed.log_time_ns + GAP_NS;
                self.count += 1;
                let met = closed.contacts.iter().map(|contact| {
                    let speed = contact.speed_rad_per_s.to_degrees();
                    format!("{} hit its end stop at {:.3} s, at {speed:.2} deg/s", contact.axis, contact.at_s)
                });
                let moves = (!closed.safe.standstill).then(|| closed.safe.text(&rig.axis_names()));
                met.chain(moves).collect()
            }
        }
    }
}
