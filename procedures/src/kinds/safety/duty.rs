//! Kind `duty`: currents, heat and DC link under the duty cycle, each axis alone and both at once.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod measure;
mod pictures;
mod plan;
#[cfg(test)]
mod tests;

use plan::Keys;

/// Per axis: root mean square and peak of its current.
const CURRENTS: [[&str; 2]; 2] =
    [["rms-current-az", "peak-current-az"], ["rms-current-el", "peak-current-el"]];
const ABOVE: &str = "time-above-continuous";
const SINK_END: &str = "heat-sink-end";
const SINK_TIME: &str = "heat-sink-time";
const BUS_LOW: &str = "bus-voltage-low";
const BUS_HIGH: &str = "bus-voltage-high";
const SUPPLY_RMS: &str = "supply-current-rms";
const SUPPLY_PEAK: &str = "supply-current-peak";
const SHUNT: &str = "shunt-power";

const MEASURANDS: &[Measurand] = &[
    Measurand::new(
        CURRENTS[0][0],
        Q::Current,
        "Root mean square of the azimuth drive's current over whole cycles.",
    ),
    Measurand::new(CURRENTS[0][1], Q::Current, "Largest current of the azimuth drive."),
    Measurand::new(
        CURRENTS[1][0],
        Q::Current,
        "Root mean square of the elevation drive's current over whole cycles.",
    ),
    Measurand::new(CURRENTS[1][1], Q::Current, "Largest current of the elevation drive."),
    Measurand::new(
        ABOVE,
        Q::Time,
        "Longest time for which a drive's current stays above its continuous current.",
    ),
    Measurand::new(
        SINK_END,
        Q::Temperature,
        "Final temperature of a drive's heat sink if the cycle repeats indefinitely.",
    ),
    Measurand::new(SINK_TIME, Q::Time, "Time constant of a drive's heat sink."),
    Measurand::new(BUS_LOW, Q::Voltage, "Lowest voltage of the DC link."),
    Measurand::new(BUS_HIGH, Q::Voltage, "Highest voltage of the DC link."),
    Measurand::new(SUPPLY_RMS, Q::Current, "Root mean square of the supply's current over whole cycles."),
    Measurand::new(SUPPLY_PEAK, Q::Current, "Largest current of the supply."),
    Measurand::new(SHUNT, Q::Power, "Largest power in the shunt."),
];

pub(in crate::kinds) const KIND: Kind =
    Kind::new::<Keys>("duty", include_str!("duty/doc.md"), plan::FIELDS, MEASURANDS);

impl Experiment for Keys {
    fn yields(&self) -> Option<Vec<&'static str>> {
        let currents = self.axes().flat_map(|axis| CURRENTS[axis]);
        let others = [ABOVE, SINK_END, SINK_TIME, BUS_LOW, BUS_HIGH, SUPPLY_RMS, SUPPLY_PEAK, SHUNT];
        Some(currents.chain(others).collect())
    }

    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>> {
        plan::plan(self, axis, axes)
    }

    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult {
        measure::analyse(self, case, window, axes)
    }

    /// What went beyond a limit before a trip stays beyond it.
    fn reads_broken_off(&self) -> bool {
        true
    }
}
