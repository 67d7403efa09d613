//! Instruments on the bench in the tick: impedance analyser, oscilloscope.
//!
//! A segment may give one of them a task. Everything is reserved before the first tick; a tick then goes on with the
//! dialogue as far as it gets without waiting. What was measured is handed to the log a few rows a tick; the task is
//! done when the last row is out.

use std::time::Duration;

use drivers::device::DeviceError;
use procedures::case::Case;
use procedures::device::{DeviceRole, Task};
use procedures::table::quoted;

use super::device::Group;
use super::wires::Ports;

/// Rows that a tick hands to the log at most.
const ROWS_PER_TICK: usize = 8;

/// An instrument on the bench that is given tasks. It never blocks, and is handed the ports with each call.
pub trait Instrument {
    /// Name in messages and reports.
    fn name(&self) -> &str;

    /// What it adds to the log.
    fn group(&self) -> Group;

    /// Asks the instrument who it is; `None` until it has said it.
    ///
    /// # Errors
    /// A port that there is not, no answer, a model that the driver does not know.
    fn identify(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<String>, DeviceError>;

    /// Readies a driver for a task on an axis (its place in the pair that the instrument knows), so that nothing is left to be reserved while it runs;
    /// `None` where the task is for another sort of instrument.
    ///
    /// # Errors
    /// A task that the instrument cannot do.
    fn ready(&self, task: &Task, axis: usize) -> Result<Option<Box<dyn Measuring + Send>>, DeviceError>;

    /// Another handle of the instrument, to ready tasks in another thread.
    fn copy(&self) -> Box<dyn Instrument + Send>;
}

/// A task that an instrument was readied for.
pub trait Measuring {
    /// Begins.
    ///
    /// # Errors
    /// When the line is gone.
    fn start(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError>;

    /// Goes on as far as it gets without waiting; whether all is measured.
    ///
    /// # Errors
    /// What the instrument complains of, or that it does not answer.
    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<bool, DeviceError>;

    /// Ends what is under way; what the instrument answers to that is not waited for.
    ///
    /// # Errors
    /// When the line is gone.
    fn abort(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError>;

    /// Whether it waits for the edge of the synchronisation signal.
    fn awaits_edge(&self) -> bool {
        false
    }

    /// Rows that it measured.
    fn rows_count(&self) -> usize;

    /// Hands one of its rows on; a hole is passed over.
    fn row(&self, row: usize, each: &mut dyn FnMut(&[f64]));

    /// What to say of it when its time is over.
    fn when_late(&self) -> &'static str;
}

/// Readies tasks for instruments that are open.
pub struct TaskPreparer {
    list: Vec<Box<dyn Instrument + Send>>,
}

impl TaskPreparer {
    /// Readies every task of a point. `probed` names the axes that devices in pairs belong to, such as current probes.
    ///
    /// # Errors
    /// A task for an instrument that the rig lacks, or that the instrument cannot do.
    pub fn ready(&self, case: &Case, probed: &[Option<String>; 2]) -> Result<Tasks, DeviceError> {
        let mut tasks = Tasks::default();
        for (segment, planned) in case.segments.iter().enumerate() {
            let Some(task) = &planned.task else { continue };
            let axes = task.known_axes(probed);
            let place = axes.iter().position(|name| name.as_deref() == Some(task.axis()));
            let axis = place.ok_or_else(|| unknown_axis(task, probed))?;
            let (instrument, measuring) = self.find(task, axis)?;
            let limit_s = planned.at_most_s;
            let began = Duration::ZERO;
            let progress = Progress::Waiting;
            tasks.0.push(Job { segment, limit_s, instrument, measuring, began, progress });
        }
        Ok(tasks)
    }

    fn find(&self, task: &Task, axis: usize) -> Result<(usize, Box<dyn Measuring + Send>), DeviceError> {
        for (place, instrument) in self.list.iter().enumerate() {
            if let Some(measuring) = instrument.ready(task, axis)? {
                return Ok((place, measuring));
            }
        }
        Err(missing(task.needs()))
    }
}

/// Instruments that were opened, and what they are doing.
#[derive(Default)]
pub struct Instruments {
    list: Vec<Box<dyn Instrument>>,
    identities: Vec<(String, String)>,
    /// Tasks by segment of the point.
    jobs: Tasks,
    /// Place in `jobs` of what was begun last.
    begun: Option<usize>,
    failure: Option<DeviceError>,
}

/// Tasks of a point, each readied.
#[derive(Default)]
pub struct Tasks(Vec<Job>);

/// A task with a driver of its own that was readied for it.
struct Job {
    segment: usize,
    limit_s: f64,
    /// Place of the instrument in the list.
    instrument: usize,
    measuring: Box<dyn Measuring + Send>,
    began: Duration,
    progress: Progress,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    Waiting,
    Measuring,
    /// Next row for the log.
    Telling(usize),
    Done,
}

impl Instruments {
    /// Nothing is open yet.
    pub fn closed(list: Vec<Box<dyn Instrument>>) -> Self {
        Self { list, ..Self::default() }
    }

    /// Asks the instruments who they are; call until it is done.
    ///
    /// # Errors
    /// The first one that does not answer or is another model.
    pub fn identify(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        while let Some(instrument) = self.list.get_mut(self.identities.len()) {
            let identified =
                instrument.identify(ports, now).map_err(|error| error.of_device(instrument.name()))?;
            let Some(identity) = identified else { return Ok(None) };
            self.identities.push((instrument.name().to_owned(), identity));
        }
        Ok(Some(()))
    }

    /// Who they are, as name and identity.
    pub fn identities(&self) -> &[(String, String)] {
        &self.identities
    }

    /// Whoever readies tasks for these instruments, in whatever thread: nothing of that belongs into a tick.
    pub fn preparer(&self) -> TaskPreparer {
        TaskPreparer { list: self.list.iter().map(|instrument| instrument.copy()).collect() }
    }

    /// Takes the tasks of a point; those of the point before go where these were.
    pub fn take(&mut self, tasks: &mut Tasks) {
        std::mem::swap(&mut self.jobs, tasks);
        (self.begun, self.failure) = (None, None);
    }

    /// Begins the task of a segment, unless it has begun or there is none; whether it began now.
    pub fn begin(&mut self, segment: usize, ports: &mut Ports, now: Duration) -> bool {
        let waits = |job: &Job| job.segment == segment && job.progress == Progress::Waiting;
        let Some(place) = self.jobs.0.iter().position(waits) else { return false };
        let job = &mut self.jobs.0[place];
        (job.progress, job.began, self.begun) = (Progress::Measuring, now, Some(place));
        let started = job.measuring.start(ports, now);
        let name = self.list[job.instrument].name();
        let failure = started.err().map(|error| error.of_device(name));
        self.fail(failure);
        true
    }

    /// Once a tick: goes on with what has begun. An instrument that fails, or is not done in the time of its segment, is a
    /// failure.
    pub fn poll(&mut self, ports: &mut Ports, now: Duration) {
        let Some(job) = self.begun.and_then(|place| self.jobs.0.get_mut(place)) else { return };
        if matches!(job.progress, Progress::Waiting | Progress::Done) {
            return;
        }
        let over = now.saturating_sub(job.began).as_secs_f64() >= job.limit_s;
        let mut failure = None;
        if job.progress == Progress::Measuring {
            match job.measuring.poll(ports, now) {
                Ok(true) => job.progress = Progress::Telling(0),
                Ok(false) => {}
                Err(error) => failure = Some(error.of_device(self.list[job.instrument].name())),
            }
        }
        if over && failure.is_none() {
            let found = format!("{} within the {} s of its segment", job.measuring.when_late(), job.limit_s);
            failure = Some(DeviceError::Field {
                device: self.list[job.instrument].name().to_owned(),
                field: "measurement",
                expected: "a whole one".to_owned(),
                found,
                help: "check settings and cables of the instrument",
            });
        }
        self.fail(failure);
    }

    fn fail(&mut self, error: Option<DeviceError>) {
        if let Some(error) = error {
            self.failure.get_or_insert(error);
        }
    }

    /// Whether the instrument that measures waits for its trigger.
    pub fn awaits_edge(&self) -> bool {
        let job = self.begun.and_then(|place| self.jobs.0.get(place));
        job.is_some_and(|job| job.measuring.awaits_edge())
    }

    /// Whether the task of a segment is done and all it measured is in the log; true without one.
    pub fn is_done(&self, segment: usize) -> bool {
        self.jobs.0.iter().find(|job| job.segment == segment).is_none_or(|job| job.progress == Progress::Done)
    }

    /// What went wrong first.
    pub fn failure(&self) -> Option<&DeviceError> {
        self.failure.as_ref()
    }

    /// Whatever is under way ends; what an instrument answers to that is not waited for.
    pub fn stop(&mut self, ports: &mut Ports, now: Duration) {
        let Some(job) = self.begun.take().and_then(|place| self.jobs.0.get_mut(place)) else { return };
        if job.progress == Progress::Measuring {
            // A line that is gone has nothing left to stop.
            let _ = job.measuring.abort(ports, now);
        }
        job.progress = Progress::Done;
    }

    /// Hands at most a few rows on, each with the place of its instrument among the instruments of the rig.
    pub fn rows(&mut self, mut each: impl FnMut(usize, &[f64])) {
        let Some(job) = self.begun.and_then(|place| self.jobs.0.get_mut(place)) else { return };
        let Progress::Telling(first) = job.progress else { return };
        let count = job.measuring.rows_count();
        let next = count.min(first + ROWS_PER_TICK);
        for row in first..next {
            job.measuring.row(row, &mut |values| each(job.instrument, values));
        }
        job.progress = if next == count { Progress::Done } else { Progress::Telling(next) };
    }
}

fn unknown_axis(task: &Task, probed: &[Option<String>; 2]) -> DeviceError {
    let axes = task.known_axes(probed);
    let known: Vec<&str> = axes.iter().flatten().map(String::as_str).collect();
    DeviceError::Bus {
        device: "plan".to_owned(),
        reason: format!("a task for the axis `{}`, expected one of {}", task.axis(), quoted(known)),
    }
}

fn missing(role: DeviceRole) -> DeviceError {
    let reason = format!("the plan has a task for {}, but the rig has none: add a `[[device]]`", role.noun());
    DeviceError::Bus { device: "plan".to_owned(), reason }
}
