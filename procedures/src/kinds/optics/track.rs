//! Kind `track`: what is left while the director follows a target, with the coarse loop, the fine one, or both.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind as Q;

mod axis_errors;
mod keys;
mod point;
mod record;
#[cfg(test)]
mod tests;

use keys::{Keys, Loops};

/// Measurands of a track loop, in the order: outside the windows, whole, inside, share, percentile, largest.
type Names = [&'static str; 6];

const COARSE: Names = [
    "coarse-track-rms",
    "coarse-track-rms-whole",
    "coarse-track-rms-inside",
    "coarse-track-left-out",
    "coarse-track-percentile",
    "coarse-track-peak",
];
const FINE: Names = [
    "fine-track-rms",
    "fine-track-rms-whole",
    "fine-track-rms-inside",
    "fine-track-left-out",
    "fine-track-percentile",
    "fine-track-peak",
];
const LOSSES: &str = "target-losses";
const FINE_LOSSES: &str = "fine-target-losses";
const GAP: &str = "longest-frame-gap";
const DWELL: &str = "fine-dwell";
const MISSING: &str = "coarse-frames-missing";
const FINE_MISSING: &str = "fine-frames-missing";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(COARSE[0], Q::Angle, "Root mean square of the coarse error outside the declared windows."),
    Measurand::new(COARSE[1], Q::Angle, "Root mean square of the coarse error over the whole record."),
    Measurand::new(COARSE[2], Q::Angle, "Root mean square of the coarse error inside the declared windows."),
    Measurand::new(COARSE[3], Q::Ratio, "Share of the coarse frames that lies inside the declared windows."),
    Measurand::new(COARSE[4], Q::Angle, "Coarse error, 99.9 % percentile of its magnitude over all frames."),
    Measurand::new(COARSE[5], Q::Angle, "Largest magnitude of the coarse error in the whole record."),
    Measurand::new(
        FINE[0],
        Q::Angle,
        "Root mean square of the fine error outside the declared windows, without frames in which the \
         mirror was at the end of its stroke.",
    ),
    Measurand::new(
        FINE[1],
        Q::Angle,
        "Root mean square of the fine error over all frames that show the target.",
    ),
    Measurand::new(
        FINE[2],
        Q::Angle,
        "Root mean square of the fine error over the frames that were left out.",
    ),
    Measurand::new(
        FINE[3],
        Q::Ratio,
        "Share of the fine frames in the windows, at the end of the stroke or after a loss.",
    ),
    Measurand::new(FINE[4], Q::Angle, "Fine error, 99.9 % percentile of its magnitude over all frames."),
    Measurand::new(FINE[5], Q::Angle, "Largest magnitude of the fine error in the whole record."),
    Measurand::new(
        LOSSES,
        Q::Count,
        "Number of times the coarse tracker lost its target after the first lock.",
    ),
    Measurand::new(
        FINE_LOSSES,
        Q::Count,
        "Number of times the fine tracker lost its target after the first lock.",
    ),
    Measurand::new(GAP, Q::Time, "Longest time between two coarse frames that show the target."),
    Measurand::new(MISSING, Q::Ratio, "Share of the coarse frames that never arrived, by the frame counter."),
    Measurand::new(
        FINE_MISSING,
        Q::Ratio,
        "Share of the fine frames that never arrived, by the frame counter.",
    ),
    Measurand::new(
        DWELL,
        Q::Time,
        "Longest continuous fine track whose sliding root mean square stays within `dwell-limit` on both axes.",
    ),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("track", include_str!("track/doc.md"), keys::FIELDS, MEASURANDS);

/// What a point with these loops closed yields.
fn names_of(loops: Loops) -> Vec<&'static str> {
    let coarse = COARSE.iter().chain(&[LOSSES, GAP, MISSING]).filter(|_| loops.coarse());
    let fine = FINE.iter().chain(&[FINE_LOSSES, DWELL, FINE_MISSING]).filter(|_| loops.fine());
    coarse.chain(fine).copied().collect()
}

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let any = |name: &&str| self.loops.iter().any(|loops| names_of(*loops).contains(name));
        Some(MEASURANDS.iter().map(|m| m.name).filter(any).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        keys::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        point::analyse(self, case, window, axes)
    }

    /// A target that is lost ends the point, and is what TRK-LOSS asks about.
    fn reads_broken_off(&self) -> bool {
        true
    }

    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        let convention = "Errors of azimuth are given as cross-elevation, as the tracker sees them: \
                          azimuth error times the cosine of elevation.";
        Conclusion { remarks: vec![convention.to_owned()], ..Conclusion::collected(points) }
    }
}
