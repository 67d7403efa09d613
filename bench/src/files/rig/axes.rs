//! The axes of a rig file: how many, in which order, and which carries which.

use std::ops::Range;

use procedures::axis::MAX_AXES;
use procedures::table::{TableReader, suggestion};

use crate::model::axis::{RigAxis, VelocityFeedback};
use crate::model::rig::Gimbal;

/// Names of other topics in a log, which no axis may have.
const TAKEN: [&str; 12] = [
    "analyser",
    "bench",
    "coarse",
    "events",
    "fine",
    "force",
    "fsm",
    "imu",
    "reference",
    "scope",
    "supply",
    "track",
];

/// An axis with the places at which mistakes about it are shown.
struct Written {
    axis: RigAxis,
    station: Range<usize>,
    carried_by: Range<usize>,
    gains: Range<usize>,
    feedback: Range<usize>,
}

/// Reads all tables `[axis.<name>]`, each with `read`, in the order written.
pub(super) fn read(
    t: &mut TableReader<'_>,
    mut read: impl FnMut(&mut TableReader<'_>, &str) -> Option<RigAxis>,
) -> Option<Vec<RigAxis>> {
    let mut names = 0;
    let written = t.named_tables("axis", |t, name, name_span| {
        names += 1;
        if !is_kebab_case(name) {
            let help = "lower-case letters, digits and `-`, a letter first, e.g. `az`".to_owned();
            t.mistake_at(name_span, format!("`{name}` cannot be the name of an axis"), Some(help));
        } else if TAKEN.contains(&name) {
            let help = "the log already has a topic of this name".to_owned();
            t.mistake_at(name_span, format!("an axis cannot be called `{name}`"), Some(help));
        }
        let axis = read(t, name)?;
        let [station, carried_by, gains, feedback] =
            ["station", "carried-by", "gains", "velocity-feedback"].map(|key| t.span(key));
        Some(Written { axis, station, carried_by, gains, feedback })
    })?;
    if names == 0 || names > MAX_AXES {
        let message = format!("a rig has 1 to {MAX_AXES} axes, found {names}");
        t.mistake("axis", message, Some("each is a table `[axis.<name>]`".to_owned()));
    }
    if written.len() == names {
        let before = t.mistakes();
        check_geometry(t, &written);
        if t.mistakes() == before {
            check_gyros(t, &written);
        }
    }
    check_shared(t, &written);
    (written.len() == names).then(|| written.into_iter().map(|written| written.axis).collect())
}

/// Whether a name can stand in rig, procedures and topics of a log.
fn is_kebab_case(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(allowed) && !name.ends_with('-')
}

/// Every axis carries one other at the most, none is carried by itself, and all stand on the ground in the end.
fn check_geometry(t: &mut TableReader<'_>, all: &[Written]) {
    for (index, written) in all.iter().enumerate() {
        let Some(carrier) = written.axis.carried_by.as_deref() else { continue };
        let at = written.carried_by.clone();
        let name = &written.axis.name;
        if !all.iter().any(|other| other.axis.name == carrier) {
            let help = suggestion(carrier, all.iter().map(|other| other.axis.name.as_str()));
            t.mistake_at(
                at,
                format!("`carried-by` of `{name}` names axis `{carrier}`, which the rig does not have"),
                Some(help),
            );
        } else if circle(all, index) {
            let help = "leave out `carried-by` on the axis that stands on the ground".to_owned();
            t.mistake_at(at, format!("axis `{name}` would carry itself through `{carrier}`"), Some(help));
        } else if let Some(first) =
            all[..index].iter().find(|other| other.axis.carried_by.as_deref() == Some(carrier))
        {
            let message =
                format!("axis `{carrier}` carries `{}` and `{name}`: expected one", first.axis.name);
            t.mistake_at(
                at,
                message,
                Some("an axis can carry at most one other: correct `carried-by`".to_owned()),
            );
        }
    }
}

/// Gyros see outer and inner axis of a gimbal, and no other one.
fn check_gyros(t: &mut TableReader<'_>, all: &[Written]) {
    let axes: Vec<RigAxis> = all.iter().map(|written| written.axis.clone()).collect();
    let gimbal = Gimbal::of(&axes);
    for (index, written) in all.iter().enumerate() {
        let by_gyro = written.axis.velocity_feedback == VelocityFeedback::Gyro;
        if by_gyro && gimbal.and_then(|gimbal| gimbal.place_of(index)).is_none() {
            let message = format!("the gyros do not measure the rate of axis `{}`", written.axis.name);
            let help = "they are mounted on the carried axis: add `carried-by` to it, or close this loop \
                        on the encoder";
            t.mistake_at(written.feedback.clone(), message, Some(help.to_owned()));
        }
    }
}

/// Whether the chain of carriers of an axis comes back to it.
fn circle(all: &[Written], index: usize) -> bool {
    let carrier = |at: usize| {
        let name = all[at].axis.carried_by.as_deref()?;
        all.iter().position(|other| other.axis.name == name)
    };
    let mut at = index;
    for _ in 0..all.len() {
        match carrier(at) {
            Some(next) if next == index => return true,
            Some(next) => at = next,
            None => return false,
        }
    }
    false
}

/// No two axes share a drive or a section of gains.
fn check_shared(t: &mut TableReader<'_>, all: &[Written]) {
    for (index, written) in all.iter().enumerate() {
        let before = || all[..index].iter().map(|other| &other.axis);
        let own = &written.axis;
        let name = &written.axis.name;
        if let Some(other) = before().find(|other| other.drive.station == own.drive.station) {
            let message = format!("axes `{}` and `{name}` have the same station", other.name);
            let help = "both would command the same drive: give each its own station".to_owned();
            t.mistake_at(written.station.clone(), message, Some(help));
        }
        if let Some(other) = before().find(|other| other.gains == own.gains) {
            let message = format!("axes `{}` and `{name}` use the same gains `{}`", other.name, own.gains);
            let help = "gains depend on the inertia of the axis: give each axis its own section".to_owned();
            t.mistake_at(written.gains.clone(), message, Some(help));
        }
    }
}

#[cfg(test)]
mod tests;
