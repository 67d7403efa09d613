//! Looking at a rig after the run on it was lost: what the journal knows, where the axes are now, who looked.
//!
//! Nothing moves: the bus goes no further than SAFE-OP, in which stations ignore their outputs.

use std::path::Path;
use std::time::Duration;

use controllers::DirectorGains;
use drivers::device::DeviceError;
use reports::record::DeviceRecord;

use crate::model::rig::Rig;
use crate::record::journal::{AxisAngle, Entry, Journal, Line};
use crate::site::{Purpose, Site};

#[cfg(test)]
mod tests;

/// Positions agree with the journal within this (safety.md: people).
pub(crate) const TOLERANCE_DEG: f64 = 0.1;
/// Exchanges after which every station has put its inputs into the image.
const EXCHANGES: u32 = 8;

/// What the journal of a run knows that nobody has released the rig from.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LastKnown {
    /// Wall clock of the last entry.
    pub utc: String,
    /// Procedure and point that may have been in motion.
    pub in_motion: Option<(String, String)>,
    /// Where the axes stood when the last point ended; empty if none did.
    pub angles_deg: Vec<AxisAngle>,
    /// Why somebody must look, where the run came to its end and said so.
    pub why: Option<String>,
}

/// From the lines of a journal.
pub(crate) fn last_known(lines: &[Line]) -> LastKnown {
    let mut known = LastKnown::default();
    for line in lines {
        known.utc.clone_from(&line.utc);
        match &line.entry {
            Entry::PointStarted { procedure, point } => {
                known.in_motion = Some((procedure.clone(), point.clone()));
            }
            Entry::PointEnded { angles_deg, .. } => {
                known.in_motion = None;
                if !angles_deg.is_empty() {
                    known.angles_deg.clone_from(angles_deg);
                }
            }
            Entry::MustBeInspected { why } => known.why = Some(why.join("; ")),
            _ => {}
        }
    }
    known
}

/// Whether every axis is where the journal says, and the journal says so of every axis.
pub(crate) fn agrees(before: &[AxisAngle], now: &[AxisAngle]) -> bool {
    now.iter().all(|here| {
        let there = before.iter().find(|there| there.axis == here.axis);
        there.is_some_and(|there| (there.deg - here.deg).abs() <= TOLERANCE_DEG)
    })
}

/// The rig as it stands now.
pub(crate) struct Standing {
    /// Name of its bus.
    pub bus: String,
    /// Who is there.
    pub devices: Vec<DeviceRecord>,
    /// Where the axes are.
    pub angles_deg: Vec<AxisAngle>,
}

/// Opens the rig, reads the angles and lets go of it. A simulated director stands where its run left it.
///
/// # Errors
/// The first device that does not answer.
pub(crate) fn stand(
    site: &dyn Site,
    rig: &Rig,
    gains: &DirectorGains,
    left: &[AxisAngle],
) -> Result<Standing, DeviceError> {
    let pose_rad = left.iter().map(|a| (a.axis.clone(), a.deg.to_radians())).collect();
    let session = site.open(rig, gains, &Purpose { procedure: "inspect", pose_rad, ..Purpose::default() })?;
    let devices = crate::rig::identities::records(rig, &session.rig, &session.grounds);
    let bus = session.bus;
    let mut armed = session.rig.arm(&session.clock)?;
    let mut now = armed.ready();
    let period = Duration::from_secs_f64(1.0 / rig.loop_rate_hz);
    for _ in 0..EXCHANGES {
        now = session.clock.wait_until(now);
        armed.exchange(now);
        now += period;
    }
    let names = rig.axis_names();
    if let Some(silent) = (0..names.len()).find(|&axis| !armed.is_fresh(axis)) {
        let reason = "its position cannot be read: no valid exchange with the drive".to_owned();
        return Err(DeviceError::Bus { device: names[silent].clone(), reason });
    }
    let angle = |(axis, name): (usize, String)| AxisAngle {
        axis: name,
        deg: armed.actuals(axis).position_rad.to_degrees(),
    };
    Ok(Standing { bus, devices, angles_deg: names.into_iter().enumerate().map(angle).collect() })
}

/// Who looked and what was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    /// Who looked.
    pub by: String,
    /// What was found.
    pub found: String,
    /// Positions that do not agree are explained by what was found.
    pub accepts_positions: bool,
}

/// Appends the inspection to the run's journal; gives whether the rig is released.
///
/// # Errors
/// When the journal cannot be written.
pub(crate) fn record(
    mut journal: Journal,
    known: &LastKnown,
    standing: &Standing,
    finding: Finding,
) -> std::io::Result<bool> {
    let agrees = agrees(&known.angles_deg, &standing.angles_deg);
    let released = agrees || finding.accepts_positions;
    journal.write(Entry::Inspected {
        by: finding.by,
        found: finding.found,
        angles_deg: standing.angles_deg.clone(),
        agrees,
        released,
    })?;
    Ok(released)
}

/// The journal of a run that was lost, or left its rig so that somebody must look; to be continued, with what it says.
///
/// # Errors
/// One sentence: the run still goes on, it ended in order, or its journal is not whole.
pub(crate) fn journal_of(run: &Path) -> Result<(Journal, LastKnown), String> {
    let (journal, lines) = Journal::reopen(run)?;
    let known = last_known(&lines);
    let closed = lines.iter().rev().find_map(|line| match line.entry {
        Entry::Closed { exit_code, .. } => Some((exit_code, &line.utc)),
        _ => None,
    });
    match (closed, &known.why) {
        (Some((exit_code, utc)), None) => Err(format!(
            "{}: this run ended normally at {utc} with exit code {exit_code} and its axes at standstill; \
             only a lost run, or one that left an axis moving, needs an inspection",
            run.display()
        )),
        _ => Ok((journal, known)),
    }
}
