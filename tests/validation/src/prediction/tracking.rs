//! Tracking: a short engagement of each kind, production laws around the plant, because friction at the reversals and
//! the target's own motion have no formula. The fine error follows from the coarse one by the budget of the fine loop.

mod engagement;

use self::engagement::{DRONE, Engagement, RAIL, ROW_RATE_HZ};
use super::atmosphere::fine_error_rad;
use super::{Expected, Subject, row};
use crate::spectrum::welch;

/// Share of the record that windows around the target's accelerations may take.
const WINDOW_RATIO: f64 = 0.05;
/// Samples of a spectrum: 2.56 s.
const SEGMENT: usize = 1024;
/// The target of a dwell: the drone's heave of 0.5 Hz alone leaves more than a dwell may have behind a loop that rejects
/// it by 24 dB.
const DWELL_ON: &str = "rail";
/// Largest fine error of a dwell.
const DWELL_RAD: f64 = 5e-6;
/// Share of the stroke that a dwell may use.
const STROKE_RATIO: f64 = 0.95;

/// RMS of a record with a correlation of about a second (estimators 1.8: block bootstrap).
const RMS_U: f64 = 0.05;
/// A pixel of the coarse camera in half its field.
const FIELD_U: f64 = 0.01;
const TIME_U_S: f64 = 0.1;

pub(super) fn rows(subject: &Subject<'_>) -> Vec<Expected> {
    let mut rows = Vec::new();
    for (name, kind) in [("rail", RAIL), ("drone", DRONE)] {
        let flown = Engagement::run(subject, kind);
        for axis in 0..2 {
            rows.extend(axis_rows(subject, &flown, axis, name));
        }
    }
    rows
}

fn axis_rows(subject: &Subject<'_>, flown: &Engagement, axis: usize, name: &str) -> Vec<Expected> {
    let coarse_rad = flown.rms_rad(axis, WINDOW_RATIO);
    let quiet = flown.within(axis, STROKE_RATIO * reach_rad(subject, axis));
    let fine_rad = if quiet.len() < SEGMENT {
        f64::NAN
    } else {
        fine_error_rad(subject, axis, &welch(quiet, ROW_RATE_HZ, SEGMENT))
    };
    let mut rows = vec![
        row("TRK-RMS-C", axis, "coarse-rms", name, coarse_rad, RMS_U * coarse_rad),
        row("TRK-RMS-F", axis, "fine-rms", name, fine_rad, RMS_U * fine_rad),
        row("TRK-LOSS", axis, "field-used", name, flown.field_used(axis), FIELD_U),
    ];
    if name == DWELL_ON {
        let dwell_s = if fine_rad <= DWELL_RAD { quiet.len() as f64 / ROW_RATE_HZ } else { 0.0 };
        rows.push(row("ENG-DWELL", axis, "dwell", name, dwell_s, TIME_U_S));
    }
    rows
}

/// Line of sight that the mirror's stroke covers.
fn reach_rad(subject: &Subject<'_>, axis: usize) -> f64 {
    let trackers = &subject.unit.trackers;
    let stroke = subject.unit.mirror.stroke_rad[axis];
    let gain = [trackers.optical_gain_cross_elevation_ratio, trackers.optical_gain_elevation_ratio][axis];
    stroke.min(subject.gains.fine.stroke_rad) / gain.abs()
}
