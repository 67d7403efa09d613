//! DC link and power supply of the drives.

use super::setting::{Field, Setting};

/// DC link and power supply of the drives.
#[derive(Clone, Debug, PartialEq)]
pub struct SupplySettings {
    /// Voltage of the rectified supply without load.
    pub open_voltage_v: f64,
    /// Resistance of supply and rectifier.
    pub source_resistance_ohm: f64,
    /// Current that the supply gives without end.
    pub continuous_current_a: f64,
    /// Largest current.
    pub peak_current_a: f64,
    /// How long a rested supply gives its peak current before it falls back to the continuous one.
    pub peak_time_s: f64,
    /// Capacitance of the DC links of all drives, connected.
    pub capacitance_f: f64,
    /// Voltage at which the shunt switches on.
    pub shunt_on_v: f64,
    /// Voltage at which it switches off.
    pub shunt_off_v: f64,
    /// Resistance of the shunt.
    pub shunt_resistance_ohm: f64,
}

impl Default for SupplySettings {
    fn default() -> Self {
        Self {
            open_voltage_v: 560.0,
            source_resistance_ohm: 0.4,
            continuous_current_a: 30.0,
            peak_current_a: 60.0,
            peak_time_s: 3.0,
            capacitance_f: 0.0047,
            shunt_on_v: 610.0,
            shunt_off_v: 595.0,
            shunt_resistance_ohm: 58.0,
        }
    }
}

pub(super) const SUPPLY: &[Setting<Field<SupplySettings>>] = &[
    Setting {
        key: "supply.open-voltage",
        quantity: "voltage",
        range_si: [0.0, 1000.0],
        default: "560 V",
        doc: "Voltage of the rectified supply without load.",
        source: "study 2.3.2: 560 V bus; 380 V three-phase rectified gives 540 V",
        field: |supply| &mut supply.open_voltage_v,
    },
    Setting {
        key: "supply.source-resistance",
        quantity: "resistance",
        range_si: [0.001, 100.0],
        default: "0.4 ohm",
        doc: "Resistance of supply and rectifier.",
        source: "ours: 24 V less at the peak current",
        field: |supply| &mut supply.source_resistance_ohm,
    },
    Setting {
        key: "supply.continuous-current",
        quantity: "current",
        range_si: [0.0, 1000.0],
        default: "30 A",
        doc: "Continuous current of the supply.",
        source: "study 2.3.2",
        field: |supply| &mut supply.continuous_current_a,
    },
    Setting {
        key: "supply.peak-current",
        quantity: "current",
        range_si: [0.0, 1000.0],
        default: "60 A",
        doc: "Largest current of the supply.",
        source: "study 2.3.2",
        field: |supply| &mut supply.peak_current_a,
    },
    Setting {
        key: "supply.peak-time",
        quantity: "time",
        range_si: [0.01, 1000.0],
        default: "3 s",
        doc: "Time for which a rested supply delivers its peak current before it falls back to the continuous one.",
        source: "ours",
        field: |supply| &mut supply.peak_time_s,
    },
    Setting {
        key: "supply.capacitance",
        quantity: "capacitance",
        range_si: [1.0e-5, 10.0],
        default: "0.0047 F",
        doc: "Capacitance of the DC links of both drives, connected.",
        source: "ours: usual for two drives of this class",
        field: |supply| &mut supply.capacitance_f,
    },
    Setting {
        key: "supply.shunt-on",
        quantity: "voltage",
        range_si: [0.0, 1200.0],
        default: "610 V",
        doc: "Voltage of the DC link at which the shunt switches on.",
        source: "ours: inside the band of PWR-BUS",
        field: |supply| &mut supply.shunt_on_v,
    },
    Setting {
        key: "supply.shunt-off",
        quantity: "voltage",
        range_si: [0.0, 1200.0],
        default: "595 V",
        doc: "Voltage of the DC link at which the shunt switches off.",
        source: "ours: above the open voltage of the supply",
        field: |supply| &mut supply.shunt_off_v,
    },
    Setting {
        key: "supply.shunt-resistance",
        quantity: "resistance",
        range_si: [0.1, 1.0e6],
        default: "58 ohm",
        doc: "Resistance of the shunt.",
        source: "study 2.3.2: 6.7 kW, reached at 623 V",
        field: |supply| &mut supply.shunt_resistance_ohm,
    },
];
