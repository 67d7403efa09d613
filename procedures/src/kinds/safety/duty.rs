//! Kind `duty`: currents, heat and DC link under the duty cycle, each axis alone and both at once.

use crate::axis::Axes;
use crate::case::Case;
use crate::diagnostic::Diagnostic;
use crate::kinds::{Experiment, Kind, Measurand, experiment};
use crate::log::Window;
use crate::measurement::PointResult;
use crate::quantity::QuantityKind as Q;

mod measure;
mod pictures;
mod plan;
#[cfg(test)]
mod tests;

use plan::Keys;

const fn measurand(name: &'static str, kind: Q, doc: &'static str) -> Measurand {
    Measurand { name, kind, doc }
}

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
    measurand(
        CURRENTS[0][0],
        Q::Current,
        "Root mean square of the azimuth drive's current over whole cycles.",
    ),
    measurand(CURRENTS[0][1], Q::Current, "Largest current of the azimuth drive."),
    measurand(
        CURRENTS[1][0],
        Q::Current,
        "Root mean square of the elevation drive's current over whole cycles.",
    ),
    measurand(CURRENTS[1][1], Q::Current, "Largest current of the elevation drive."),
    measurand(ABOVE, Q::Time, "Longest time for which a drive's current stays above its continuous one."),
    measurand(
        SINK_END,
        Q::Temperature,
        "Hottest that a drive's heat sink gets when the cycle repeats without end.",
    ),
    measurand(SINK_TIME, Q::Time, "Time constant of a drive's heat sink."),
    measurand(BUS_LOW, Q::Voltage, "Lowest voltage of the DC link."),
    measurand(BUS_HIGH, Q::Voltage, "Highest voltage of the DC link."),
    measurand(SUPPLY_RMS, Q::Current, "Root mean square of the supply's current over whole cycles."),
    measurand(SUPPLY_PEAK, Q::Current, "Largest current of the supply."),
    measurand(SHUNT, Q::Power, "Largest power in the shunt."),
];

pub(in crate::kinds) const KIND: Kind = Kind {
    name: "duty",
    doc: include_str!("duty/doc.md"),
    fields: plan::FIELDS,
    measurands: MEASURANDS,
    read: |table| experiment(Keys::read(table)),
};

impl Experiment for Keys {
    fn yields(&self) -> Vec<&'static str> {
        let currents = self.axes().flat_map(|axis| CURRENTS[axis]);
        let others = [ABOVE, SINK_END, SINK_TIME, BUS_LOW, BUS_HIGH, SUPPLY_RMS, SUPPLY_PEAK, SHUNT];
        currents.chain(others).collect()
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
