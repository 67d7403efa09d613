//! The judge: logs in, findings out. `run` and `rejudge` call the same functions.

use std::path::Path;

use procedures::case::Case;
use procedures::diagnostic::SourceFile;
use procedures::log::{Attachment, LogError, LogReader, Plan, Window};
use procedures::measurement::{Exclusion, Measurement, PointResult, Proof};
use procedures::procedure::Procedure;
use procedures::requirement::Requirements;
use procedures::verdict::{self, Judgement, Verdict};
use reports::record::{
    DeviceRecord, LatenessRecord, Origin, PointRow, ProcedureFindings, SafetyFindings, Status,
};

use serde::{Deserialize, Serialize};

use crate::files::unit::read_state;
use crate::record::log::{self, COMPUTED, DEVICES, IMPORTED, PROCEDURE, REQUIREMENTS, STATE};

mod aside;
mod attempt;
mod compared;
mod findings;
mod inertia;
mod jitter;
mod known;
mod lateness;
mod limits;
mod points;
mod safety;
pub(crate) mod stage;
#[cfg(test)]
mod tests;

pub use aside::{VERB as ASIDE_VERB, judge_aside, serve as serve_aside};
pub use attempt::{Tried, Trouble, missing, try_log};
pub use findings::{Fold, fold};
pub use known::{HeatSinks, Known};
pub use lateness::lateness_of_log;
use points::{Found, Place, Points};

/// A log, judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JudgedLog {
    /// What it found.
    pub findings: ProcedureFindings,
    /// What is wrong with the file, if anything.
    pub damage: Option<String>,
    /// Length of the log.
    pub size_bytes: u64,
    /// Measurands that its procedure yields.
    pub yields: Vec<String>,
    /// Seed in its plan.
    pub seed: u64,
    /// What its devices make it; simulated where nothing proves more.
    pub origin: Origin,
    /// What its procedure proves for those that come after it.
    pub proof: Option<Proof>,
    /// Temperatures of the heat sinks.
    pub heat_sinks_degc: HeatSinks,
    /// Axis of the rig that carries the other one of its gimbal.
    pub outer_axis: Option<String>,
    /// How late the ticks of its points came; empty where time was virtual. It belongs to the record of a run, not to what
    /// was found.
    pub lateness: Vec<LatenessRecord>,
}

/// What judges a log: path, its name in the run folder, requirements, what other logs of the run found.
pub type JudgeFn = fn(&Path, &str, &Requirements, &Known) -> Result<JudgedLog, JudgeError>;

/// Why a log cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// The file cannot be read as a log of ours.
    #[error(transparent)]
    Log(#[from] LogError),
    /// What is attached to it does not parse.
    #[error("{file}: attached {name}: {mistake}")]
    Attachment {
        /// Log.
        file: String,
        /// Attachment.
        name: String,
        /// First mistake.
        mistake: String,
    },
}

/// Judges one log against requirements, by what other logs of the run found. `file` is its name in the run folder, for
/// evidence.
///
/// # Errors
/// See [`JudgeError`]; a damaged log is judged as far as it is whole.
pub fn judge_log(
    path: &Path,
    file: &str,
    requirements: &Requirements,
    known: &Known,
) -> Result<JudgedLog, JudgeError> {
    let mut reader = LogReader::open(path)?;
    let plan = reader.plan().clone();
    let procedure = attached_procedure(&reader, file)?;
    let state = attached_state(&reader, file)?;
    let mut points = Points::new(&plan.cases);
    let mut safe = SafetyFindings::default();
    let mut heat_sinks_degc = HeatSinks::new();
    let mut lateness = Vec::new();
    while let Some(window) = reader.next_window() {
        known::take_heat(&mut heat_sinks_degc, &plan.axes, &window);
        let Some(case) = points.case_of(&window) else { continue };
        lateness.extend(lateness::of_point(file, &case.point, plan.loop_rate_hz, &window));
        let axes = known.axes_of(&plan.axes, case, state.is_none());
        let mut result = procedure.analyse(case, &window, &axes, plan.loop_rate_hz);
        result.point.clone_from(&case.point);
        safety::take(&mut safe, &case.point, &window);
        let reason = trip_or_reason(&window, &result);
        points.take(window.point, Found { result, status: window.status, reason });
    }
    let (places, faults) = points.finish();
    let damage = damage(&reader, path, &faults);
    let size_bytes = std::fs::metadata(path)
        .map_err(|source| LogError::Io { file: path.display().to_string(), source })?
        .len();
    // What was measured in an earlier build state is reported: no requirement speaks of it.
    let none = Requirements { all: Vec::new() };
    let by = if state.is_some() { &none } else { requirements };
    let (mut findings, proof) = conclude(&procedure, &plan, places, Rules { file, requirements: by, known });
    findings.state = state;
    let unreadable = |name: &str, mistake: serde_json::Error| JudgeError::Attachment {
        file: file.to_owned(),
        name: name.to_owned(),
        mistake: mistake.to_string(),
    };
    safe.computed = safety::computed(reader.attachments()).map_err(|e| unreadable(COMPUTED, e))?;
    let origin = origin(&plan.mode, reader.attachments()).map_err(|e| unreadable(DEVICES, e))?;
    findings.safety = Some(safe).filter(|safe| *safe != SafetyFindings::default());
    let yields = procedure.yields.iter().map(|&name| name.to_owned()).collect();
    let outer_axis = plan.axes.gimbal().ok().map(|gimbal| gimbal.outer.name.clone());
    let seed = plan.seed;
    Ok(JudgedLog {
        findings,
        damage,
        size_bytes,
        yields,
        seed,
        origin,
        proof,
        heat_sinks_degc,
        outer_axis,
        lateness,
    })
}

/// The requirements that are attached to a log.
///
/// # Errors
/// When there are none or they do not parse.
pub fn attached_requirements(path: &Path) -> Result<(Requirements, SourceFile), JudgeError> {
    let reader = LogReader::open(path)?;
    let source = attached(&reader, REQUIREMENTS, path)?;
    let requirements = Requirements::parse(&source).map_err(|m| bad(path, REQUIREMENTS, &m))?;
    Ok((requirements, source))
}

fn attached_procedure(reader: &LogReader, file: &str) -> Result<Procedure, JudgeError> {
    let path = Path::new(file);
    let source = attached(reader, PROCEDURE, path)?;
    Procedure::parse(source).map_err(|mistakes| bad(path, PROCEDURE, &mistakes))
}

/// What the devices of a log make it. A log that does not name its devices is simulated: nothing proves more.
///
/// # Errors
/// The mistake of an attachment that is not what it should be.
fn origin(mode: &str, attachments: &[Attachment]) -> Result<Origin, serde_json::Error> {
    if mode == IMPORTED {
        return Ok(Origin::Imported);
    }
    let attached = attachments.iter().find(|a| a.name == DEVICES);
    let devices: Option<Vec<DeviceRecord>> = attached.map(|a| serde_json::from_str(&a.text)).transpose()?;
    Ok(log::origin(&devices.unwrap_or_default()))
}

/// Id of the build state of the unit; `None` for the final one.
fn attached_state(reader: &LogReader, file: &str) -> Result<Option<String>, JudgeError> {
    let path = Path::new(file);
    if reader.attachments().iter().all(|a| a.name != STATE) {
        return Ok(None);
    }
    let source = attached(reader, STATE, path)?;
    read_state(source).map(|state| Some(state.id)).map_err(|mistakes| bad(path, STATE, &mistakes))
}

fn attached(reader: &LogReader, name: &str, path: &Path) -> Result<SourceFile, JudgeError> {
    let found = reader.attachments().iter().find(|a| a.name == name);
    found.map(|a| SourceFile { name: name.to_owned(), text: a.text.clone() }).ok_or_else(|| {
        JudgeError::Attachment {
            file: path.display().to_string(),
            name: name.to_owned(),
            mistake: "missing: the log was not written by `bench run` or `bench import`".to_owned(),
        }
    })
}

fn bad(path: &Path, name: &str, mistakes: &[procedures::diagnostic::Diagnostic]) -> JudgeError {
    let mistake = mistakes.first().map_or_else(String::new, ToString::to_string);
    JudgeError::Attachment { file: path.display().to_string(), name: name.to_owned(), mistake }
}

fn trip_or_reason(window: &Window, point: &PointResult) -> Option<String> {
    window
        .trips
        .first()
        .map(|t| format!("tripped: {t}"))
        .or_else(|| point.inconclusive.as_ref().map(ToString::to_string))
}

/// All that is wrong with a log: what its reader ran into, and points that do not fit the plan.
fn damage(reader: &LogReader, path: &Path, faults: &[String]) -> Option<String> {
    let misplaced = (!faults.is_empty()).then(|| {
        let file = path.display().to_string();
        let reason = faults.join("; ");
        LogError::Damaged { file, reason }.to_string()
    });
    let all: Vec<String> = reader.damage().map(ToString::to_string).into_iter().chain(misplaced).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// The points that count beside their cases, and how every planned point ended.
struct Sorted {
    cases: Vec<Case>,
    points: Vec<PointResult>,
    ended: Vec<(Status, Vec<Exclusion>, Option<String>)>,
}

fn sorted(plan: &Plan, places: Vec<Place>) -> Sorted {
    let mut sorted = Sorted { cases: Vec::new(), points: Vec::new(), ended: Vec::new() };
    for (case, place) in plan.cases.iter().zip(places) {
        let without = |status, reason: &str| (status, Vec::new(), Some(reason.to_owned()));
        sorted.ended.push(match place {
            Place::Once(found) => {
                let Found { result, status, reason } = *found;
                let excluded = result.excluded.clone();
                sorted.cases.push(case.clone());
                sorted.points.push(result);
                (status.into(), excluded, reason)
            }
            Place::Ambiguous => without(Status::Errored, "in the log more than once: not judged"),
            Place::Gap => without(Status::Lost, "missing in the log"),
            Place::Empty => without(Status::NotRun, "not run: the procedure ended before it"),
        });
    }
    sorted
}

/// By what the points of a log are concluded.
struct Rules<'a> {
    /// Name of the log in the run folder.
    file: &'a str,
    requirements: &'a Requirements,
    known: &'a Known,
}

fn conclude(
    procedure: &Procedure,
    plan: &Plan,
    places: Vec<Place>,
    by: Rules<'_>,
) -> (ProcedureFindings, Option<Proof>) {
    let Rules { file, requirements, known } = by;
    let Sorted { cases, points, ended } = sorted(plan, places);
    let conclusion = procedure.experiment.conclude(&cases, &points, &known.with_constants(&plan.axes));
    let mut measurements = conclusion.measurements;
    measurements.iter_mut().for_each(Measurement::flag_departures);
    for evidence in measurements.iter_mut().flat_map(|m| &mut m.evidence) {
        file.clone_into(&mut evidence.file);
    }
    known.put_in_doubt(&mut measurements);
    let judgements = judge_all(&measurements, requirements);
    let mut plots = conclusion.plots;
    limits::draw(&mut plots, &plan.axis, requirements);
    procedures::trace::condense(&mut plots);
    let named = plan.cases.iter().map(|case| &case.point).zip(ended);
    let rows: Vec<PointRow> = named
        .map(|(point, (status, excluded, reason))| {
            PointRow::collect(point, status, excluded, reason, &measurements, &judgements)
        })
        .collect();
    let found = ProcedureFindings {
        id: procedure.id.clone(),
        title: procedure.title.clone(),
        kind: procedure.kind.to_owned(),
        axis: procedure.axis.clone(),
        method: procedures::kinds::kind(procedure.kind).map_or("", |k| k.doc).to_owned(),
        status: worst_status(&rows),
        verdict: judgements.iter().map(|j| j.verdict).max().unwrap_or(Verdict::None),
        log: Some(file.to_owned()),
        points: rows,
        measurements,
        judgements,
        plots,
        remarks: conclusion.remarks,
        ..ProcedureFindings::default()
    };
    (found, conclusion.proof)
}

fn judge_all(measurements: &[Measurement], requirements: &Requirements) -> Vec<Judgement> {
    let mut judgements = Vec::new();
    for requirement in &requirements.all {
        for (index, measurement) in measurements.iter().enumerate() {
            if verdict::applies(requirement, measurement) {
                judgements.push(verdict::judge(measurement, index, requirement));
            }
        }
    }
    judgements
}

/// A procedure completed if all its points did; otherwise the first that did not says how it ended.
fn worst_status(rows: &[PointRow]) -> Status {
    let broken = |r: &&PointRow| !matches!(r.status, Status::Completed | Status::NotRun);
    match rows.iter().find(broken) {
        Some(row) => row.status,
        None if rows.iter().any(|r| r.status == Status::NotRun) => Status::Aborted,
        None => Status::Completed,
    }
}
