//! How a point ended: for its procedure, the journal and whoever listens.

use std::sync::mpsc::Sender;

use drivers::device::DeviceError;
use procedures::case::Case;
use procedures::log::PointStatus;
use reports::record::Status;

use super::point::Ended;
use super::procedure_run::{ProcedureRun, keep};
use super::{Setup, Shared};
use crate::cycle::run::{PointError, PointOutcome};
use crate::exit;
use crate::people::event::RunEvent;
use crate::people::signals;
use crate::record::journal::{AxisAngle, Entry};

/// What a point came to: for the run, the journal and whoever listens.
pub(super) fn point_ended(
    shared: &Shared<'_>,
    index: usize,
    case: &Case,
    ended: &Result<Ended, DeviceError>,
    run: &mut ProcedureRun,
    events: &Sender<RunEvent>,
) {
    let Shared { setup, journal, .. } = shared;
    let procedure = setup.plan.procedures[index].procedure.id.clone();
    let axes = setup.rig.axis_names();
    let why = must_look(ended, &axes).into_iter();
    let why: Vec<String> = why.map(|why| format!("{procedure} [{}]: {why}", case.point)).collect();
    let ended = &ended.as_ref().map(|ended| &ended.outcome);
    let reason = note(run, ended, setup);
    if run_badly(ended) {
        let what = reason.as_deref().unwrap_or("it did not end at standstill");
        shared.ended_badly(format!("{procedure} [{}]: {what}", case.point), why);
    }
    let status = Status::from(ended.as_ref().map_or(PointStatus::Errored, |o| o.status)).word().to_owned();
    let point = case.point.clone();
    let planned_s = case.planned_s();
    let entry = Entry::PointEnded {
        procedure: procedure.clone(),
        point: point.clone(),
        status: status.clone(),
        reason: reason.clone(),
        safe: ended.as_ref().map_or(String::new(), |o| o.safe.text(&axes)),
        angles_deg: ended.as_ref().map_or_else(|_| Vec::new(), |o| angles(o, &axes)),
    };
    keep(journal, entry, run);
    let _ = events.send(RunEvent::PointEnded { procedure, point, status, planned_s, reason });
}

/// Takes a point's end into the procedure's; returns the reason where it did not complete.
fn note(
    run: &mut ProcedureRun,
    ended: &Result<&PointOutcome, &DeviceError>,
    setup: &Setup<'_>,
) -> Option<String> {
    let (status, reason, code) = match ended {
        Err(error) => (Status::Errored, error.to_string(), exit::BENCH),
        Ok(outcome) => {
            run.loop_s += outcome.loop_s;
            let reasons = reasons(outcome, setup);
            if reasons.is_empty() {
                return None;
            }
            let code = reasons.iter().fold(exit::PASS, |code, (_, other)| exit::worse(code, *other));
            let texts: Vec<&str> = reasons.iter().map(|(text, _)| text.as_str()).collect();
            (outcome.status.into(), texts.join("; "), code)
        }
    };
    run.status = status;
    run.reason = Some(reason.clone());
    run.exit_code = exit::worse(run.exit_code, code);
    Some(reason)
}

/// Why somebody must look at the rig after a point: end stops that were met, axes that do not stand still.
fn must_look(ended: &Result<Ended, DeviceError>, axes: &[String]) -> Vec<String> {
    match ended {
        Err(error) => vec![format!("the state of the axes is unknown: {error}")],
        Ok(Ended { outcome, contacts }) => {
            let moves = (!outcome.safe.standstill).then(|| outcome.safe.text(axes));
            contacts.iter().cloned().chain(moves).collect()
        }
    }
}

/// Whether a point tripped, failed or did not end at standstill.
fn run_badly(ended: &Result<&PointOutcome, &DeviceError>) -> bool {
    ended.as_ref().map_or(true, |o| o.trip.is_some() || o.error.is_some() || !o.safe.standstill)
}

/// Everything that kept a point from completing, each with what it means for the exit.
fn reasons(outcome: &PointOutcome, setup: &Setup<'_>) -> Vec<(String, u8)> {
    let mut all = Vec::new();
    if let Some(trip) = &outcome.trip {
        let cause = outcome.cause.as_ref().map_or(String::new(), |cause| format!(" ({cause})"));
        all.push((format!("tripped: {}{cause}", trip.reason(&setup.rig.axis_names())), exit::INCONCLUSIVE));
    }
    if let Some(error) = &outcome.error {
        let code = match error {
            PointError::Internal(_) => exit::INTERNAL,
            PointError::Bench(_) => exit::BENCH,
        };
        all.push((error.to_string(), code));
    }
    if let Some(refused) = &outcome.refused {
        all.push((format!("refused before motion: {refused}"), exit::REFUSED));
    }
    all.extend(outcome.signal.map(|code| (signals::cause(code).to_owned(), code)));
    all
}

/// Where the axes were left, for whoever must compare.
fn angles(outcome: &PointOutcome, axes: &[String]) -> Vec<AxisAngle> {
    let known = outcome.safe.axes.iter().filter(|left| left.position_rad.is_finite());
    known
        .filter_map(|left| {
            Some(AxisAngle { axis: axes.get(left.axis)?.clone(), deg: left.position_rad.to_degrees() })
        })
        .collect()
}
