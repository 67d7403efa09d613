//! Instruments on the bench in the tick: impedance analyser, oscilloscope.
//!
//! A segment may give one of them a task. Everything is reserved before the first tick; a tick then goes on with the
//! dialogue as far as it gets without waiting. What was measured is handed to the log a few rows a tick; the task is
//! done when the last row is out.

use std::time::Duration;

use drivers::analyser::{Analyser, AnalyserSettings, Sweep};
use drivers::device::DeviceError;
use drivers::scope::{Capture, Scope, ScopeSettings};
use procedures::case::Case;
use procedures::table::quoted;
use procedures::task::{MIRROR_AXES, Task};

use crate::model::device::PayloadSettings;
use crate::model::rig::Rig;
use crate::rig::device::Group;
use crate::wires::InstrumentWires;

/// Rows that a tick hands to the log at most.
const ROWS_PER_TICK: usize = 8;

/// Instruments that were opened, their wires, and what they are doing.
pub struct Instruments {
    analyser: Option<Analyser>,
    scope: Option<Scope>,
    lines: InstrumentWires,
    identities: Vec<(String, String)>,
    /// Readied drivers by segment of the point.
    jobs: Vec<Job>,
    /// Place in `jobs` of what was begun last.
    begun: Option<usize>,
    failure: Option<DeviceError>,
    /// Names of the axes that the current probes of the oscilloscope are on.
    probed: [Option<String>; 2],
}

/// A task with a driver of its own that was readied for it.
struct Job {
    segment: usize,
    limit_s: f64,
    instrument: Instrument,
    began: Duration,
    progress: Progress,
}

enum Instrument {
    Analyser(Analyser),
    Scope(Scope),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    Waiting,
    Measuring,
    /// Next row for the log.
    Telling(usize),
    Done,
}

/// What the instruments of a rig add to the log, in the order of their topics.
pub fn groups(settings: &PayloadSettings) -> Vec<Group> {
    let analyser = Group { topic: "analyser", message: "Impedance", channels: Analyser::CHANNELS };
    let scope = Group { topic: "scope", message: "Record", channels: Scope::CHANNELS };
    let there = [(settings.analyser.is_some(), analyser), (settings.scope.is_some(), scope)];
    there.into_iter().filter_map(|(there, group)| there.then_some(group)).collect()
}

impl Instruments {
    /// Nothing is open yet.
    pub fn closed(lines: InstrumentWires) -> Self {
        Self {
            analyser: None,
            scope: None,
            lines,
            identities: Vec::new(),
            jobs: Vec::new(),
            begun: None,
            failure: None,
            probed: [None, None],
        }
    }

    /// Makes the drivers of the instruments that a rig has; [`Instruments::identify`] then asks who they are.
    ///
    /// # Errors
    /// Settings that cannot be.
    pub fn make(&mut self, rig: &Rig) -> Result<(), DeviceError> {
        let settings = &rig.payload;
        self.probed = rig.pair().map(|axis| axis.map(|axis| axis.name.clone()));
        let (analyser, scope): (Option<AnalyserSettings>, Option<ScopeSettings>) =
            (settings.analyser.clone(), settings.scope.clone());
        self.analyser = analyser.map(Analyser::new).transpose()?;
        self.scope = scope.map(Scope::new).transpose()?;
        Ok(())
    }

    /// Asks the instruments who they are; call until it is done.
    ///
    /// # Errors
    /// The first one that does not answer or is another model.
    pub fn identify(&mut self, now: Duration) -> Result<Option<()>, DeviceError> {
        let mut known = Vec::new();
        if let Some(analyser) = &mut self.analyser {
            let Some(identity) = analyser.identify(&mut *self.lines.analyser, now)? else { return Ok(None) };
            known.push((analyser.settings().name.clone(), identity.to_string()));
        }
        if let Some(scope) = &mut self.scope {
            let Some(identity) = scope.identify(&mut *self.lines.scope, now)? else { return Ok(None) };
            known.push((scope.settings().name.clone(), identity.to_string()));
        }
        self.identities = known;
        Ok(Some(()))
    }

    /// Who they are, as name and identity.
    pub fn identities(&self) -> &[(String, String)] {
        &self.identities
    }

    /// Whether there is an impedance analyser.
    pub fn has_analyser(&self) -> bool {
        self.analyser.is_some()
    }

    /// Readies every task of a point.
    ///
    /// # Errors
    /// A task for an instrument that the rig lacks, or that the instrument cannot do.
    pub fn prepare(&mut self, case: &Case) -> Result<(), DeviceError> {
        self.jobs.clear();
        (self.begun, self.failure) = (None, None);
        for (segment, planned) in case.segments.iter().enumerate() {
            if let Some(task) = &planned.task {
                let (instrument, limit_s) = (self.readied(task)?, planned.at_most_s);
                let (began, progress) = (Duration::ZERO, Progress::Waiting);
                self.jobs.push(Job { segment, limit_s, instrument, began, progress });
            }
        }
        Ok(())
    }

    fn readied(&self, task: &Task) -> Result<Instrument, DeviceError> {
        match task {
            Task::Impedance { axis, level_v_ptp, from_hz, to_hz, points } => {
                let mut analyser = self.analyser.clone().ok_or_else(|| missing("analyser"))?;
                let (level_v_ptp, from_hz, to_hz) = (*level_v_ptp, *from_hz, *to_hz);
                let points = usize::try_from(*points).unwrap_or(usize::MAX);
                analyser.prepare(&Sweep { axis: mirror_axis(axis)?, level_v_ptp, from_hz, to_hz, points })?;
                Ok(Instrument::Analyser(analyser))
            }
            Task::Capture { axis, sample_rate_hz, duration_s } => {
                let mut scope = self.scope.clone().ok_or_else(|| missing("scope"))?;
                let (sample_rate_hz, duration_s) = (*sample_rate_hz, *duration_s);
                scope.prepare(&Capture { axis: self.probe(axis)?, sample_rate_hz, duration_s })?;
                Ok(Instrument::Scope(scope))
            }
        }
    }

    /// Index of the current probe on an axis of the rig.
    fn probe(&self, axis: &str) -> Result<usize, DeviceError> {
        let on_it = |probed: &Option<String>| probed.as_deref() == Some(axis);
        let known = || self.probed.iter().flatten().map(String::as_str);
        self.probed.iter().position(on_it).ok_or_else(|| unknown(axis, known()))
    }

    /// Begins the task of a segment, unless it has begun or there is none; whether it began now.
    pub fn begin(&mut self, segment: usize, now: Duration) -> bool {
        let waits = |job: &Job| job.segment == segment && job.progress == Progress::Waiting;
        let Some(place) = self.jobs.iter().position(waits) else { return false };
        let job = &mut self.jobs[place];
        (job.progress, job.began, self.begun) = (Progress::Measuring, now, Some(place));
        let started = match &mut job.instrument {
            Instrument::Analyser(analyser) => analyser.start(&mut *self.lines.analyser, now),
            Instrument::Scope(scope) => scope.start(&mut *self.lines.scope, now),
        };
        self.fail(started.err());
        true
    }

    /// Once a tick: goes on with what has begun. An instrument that fails, or is not done in the time of its segment, is a
    /// failure.
    pub fn poll(&mut self, now: Duration) {
        let Some(job) = self.begun.and_then(|place| self.jobs.get_mut(place)) else { return };
        if matches!(job.progress, Progress::Waiting | Progress::Done) {
            return;
        }
        let over = now.saturating_sub(job.began).as_secs_f64() >= job.limit_s;
        let mut failure = None;
        if job.progress == Progress::Measuring {
            match job.poll(&mut self.lines, now) {
                Ok(true) => job.progress = Progress::Telling(0),
                Ok(false) => {}
                Err(error) => failure = Some(error),
            }
        }
        if over && failure.is_none() {
            failure = Some(job.late());
        }
        self.fail(failure);
    }

    fn fail(&mut self, error: Option<DeviceError>) {
        if let Some(error) = error {
            self.failure.get_or_insert(error);
        }
    }

    /// Whether the oscilloscope waits for its trigger.
    pub fn awaits_edge(&self) -> bool {
        self.begun.and_then(|place| self.jobs.get(place)).is_some_and(
            |job| matches!(&job.instrument, Instrument::Scope(scope) if scope.is_running() && scope.is_armed()),
        )
    }

    /// Whether the task of a segment is done and all it measured is in the log; true without one.
    pub fn is_done(&self, segment: usize) -> bool {
        self.jobs.iter().find(|job| job.segment == segment).is_none_or(|job| job.progress == Progress::Done)
    }

    /// What went wrong first.
    pub fn failure(&self) -> Option<&DeviceError> {
        self.failure.as_ref()
    }

    /// Whatever is under way ends; what an instrument answers to that is not waited for.
    pub fn stop(&mut self, now: Duration) {
        let Some(job) = self.begun.take().and_then(|place| self.jobs.get_mut(place)) else { return };
        if job.progress == Progress::Measuring {
            // A line that is gone has nothing left to stop.
            let _ = match &mut job.instrument {
                Instrument::Analyser(analyser) => analyser.abort(&mut *self.lines.analyser, now),
                Instrument::Scope(scope) => scope.abort(&mut *self.lines.scope, now),
            };
        }
        job.progress = Progress::Done;
    }

    /// Hands at most a few rows on, each with whether it is the oscilloscope's.
    pub fn rows(&mut self, mut each: impl FnMut(bool, &[f64])) {
        let Some(job) = self.begun.and_then(|place| self.jobs.get_mut(place)) else { return };
        let Progress::Telling(first) = job.progress else { return };
        let (count, mut told, mut next) = (job.instrument.rows_count(), 0, first);
        while next < count && told < ROWS_PER_TICK {
            match &job.instrument {
                Instrument::Analyser(analyser) => {
                    analyser.row(next).inspect(|row| each(false, row));
                }
                // A hole is passed over.
                Instrument::Scope(scope) => {
                    scope.row(next).inspect(|row| each(true, row));
                }
            }
            (next, told) = (next + 1, told + 1);
        }
        job.progress = if next == count { Progress::Done } else { Progress::Telling(next) };
    }
}

impl Job {
    fn poll(&mut self, lines: &mut InstrumentWires, now: Duration) -> Result<bool, DeviceError> {
        match &mut self.instrument {
            Instrument::Analyser(analyser) => analyser.poll(&mut *lines.analyser, now),
            Instrument::Scope(scope) => scope.poll(&mut *lines.scope, now),
        }
    }

    fn late(&self) -> DeviceError {
        let (device, what) = match &self.instrument {
            Instrument::Analyser(analyser) => (&analyser.settings().name, "the sweep is not done"),
            Instrument::Scope(scope) if scope.is_armed() => (
                &scope.settings().name,
                "no trigger: the excitation did not change, or the cable is missing;",
            ),
            Instrument::Scope(scope) => (&scope.settings().name, "the record is not done"),
        };
        let reason = format!("{what} within the {} s of its segment", self.limit_s);
        DeviceError::Bus { device: device.clone(), reason }
    }
}

impl Instrument {
    fn rows_count(&self) -> usize {
        match self {
            Self::Analyser(analyser) => analyser.points().len(),
            Self::Scope(scope) => scope.samples_count(),
        }
    }
}

/// Index of an axis of the mirror.
fn mirror_axis(name: &str) -> Result<usize, DeviceError> {
    MIRROR_AXES.iter().position(|word| *word == name).ok_or_else(|| unknown(name, MIRROR_AXES))
}

fn unknown<'a>(axis: &str, known: impl IntoIterator<Item = &'a str>) -> DeviceError {
    let known = quoted(known);
    DeviceError::Bus {
        device: "plan".to_owned(),
        reason: format!("a task for the axis `{axis}`, expected one of {known}"),
    }
}

fn missing(table: &str) -> DeviceError {
    let reason = format!("the plan has a task for it, but the rig has none: add the table `[{table}]`");
    DeviceError::Bus { device: table.to_owned(), reason }
}
