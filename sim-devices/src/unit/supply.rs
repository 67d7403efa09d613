//! DC link and power supply of both drives.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// DC link and power supply of both drives.
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
    /// Capacitance of the DC links of both drives, connected.
    pub capacitance_f: f64,
    /// Voltage at which the shunt switches on.
    pub shunt_on_v: f64,
    /// Voltage at which it switches off.
    pub shunt_off_v: f64,
    /// Resistance of the shunt.
    pub shunt_resistance_ohm: f64,
    /// Winding resistance of azimuth, for the current that the torque constant refers to.
    pub az_winding_resistance_ohm: f64,
    /// Winding resistance of elevation, likewise.
    pub el_winding_resistance_ohm: f64,
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
            az_winding_resistance_ohm: 1.0,
            el_winding_resistance_ohm: 1.0,
        }
    }
}

pub(super) const SUPPLY: &[Parameter<UnitSettings>] = &[
    Parameter {
        key: "supply.open-voltage",
        quantity: "voltage",
        min_si: 0.0,
        max_si: 1000.0,
        default: "560 V",
        doc: "Voltage of the rectified supply without load.",
        source: "study 2.3.2: 560 V bus; 380 V three-phase rectified gives 540 V",
        set: |unit, value| unit.supply.open_voltage_v = value,
        get: |unit| unit.supply.open_voltage_v,
    },
    Parameter {
        key: "supply.source-resistance",
        quantity: "resistance",
        min_si: 0.001,
        max_si: 100.0,
        default: "0.4 ohm",
        doc: "Resistance of supply and rectifier.",
        source: "ours: 24 V less at the peak current",
        set: |unit, value| unit.supply.source_resistance_ohm = value,
        get: |unit| unit.supply.source_resistance_ohm,
    },
    Parameter {
        key: "supply.continuous-current",
        quantity: "current",
        min_si: 0.0,
        max_si: 1000.0,
        default: "30 A",
        doc: "Current that the supply gives without end.",
        source: "study 2.3.2",
        set: |unit, value| unit.supply.continuous_current_a = value,
        get: |unit| unit.supply.continuous_current_a,
    },
    Parameter {
        key: "supply.peak-current",
        quantity: "current",
        min_si: 0.0,
        max_si: 1000.0,
        default: "60 A",
        doc: "Largest current of the supply.",
        source: "study 2.3.2",
        set: |unit, value| unit.supply.peak_current_a = value,
        get: |unit| unit.supply.peak_current_a,
    },
    Parameter {
        key: "supply.peak-time",
        quantity: "time",
        min_si: 0.01,
        max_si: 1000.0,
        default: "3 s",
        doc: "How long a rested supply gives its peak current before it falls back to the continuous one.",
        source: "ours",
        set: |unit, value| unit.supply.peak_time_s = value,
        get: |unit| unit.supply.peak_time_s,
    },
    Parameter {
        key: "supply.capacitance",
        quantity: "capacitance",
        min_si: 1.0e-5,
        max_si: 10.0,
        default: "0.0047 F",
        doc: "Capacitance of the DC links of both drives, connected.",
        source: "ours: usual for two drives of this class",
        set: |unit, value| unit.supply.capacitance_f = value,
        get: |unit| unit.supply.capacitance_f,
    },
    Parameter {
        key: "supply.shunt-on",
        quantity: "voltage",
        min_si: 0.0,
        max_si: 1200.0,
        default: "610 V",
        doc: "Voltage of the DC link at which the shunt switches on.",
        source: "ours: inside the band of PWR-BUS",
        set: |unit, value| unit.supply.shunt_on_v = value,
        get: |unit| unit.supply.shunt_on_v,
    },
    Parameter {
        key: "supply.shunt-off",
        quantity: "voltage",
        min_si: 0.0,
        max_si: 1200.0,
        default: "595 V",
        doc: "Voltage of the DC link at which the shunt switches off.",
        source: "ours: above the open voltage of the supply",
        set: |unit, value| unit.supply.shunt_off_v = value,
        get: |unit| unit.supply.shunt_off_v,
    },
    Parameter {
        key: "supply.shunt-resistance",
        quantity: "resistance",
        min_si: 0.1,
        max_si: 1.0e6,
        default: "58 ohm",
        doc: "Resistance of the shunt.",
        source: "study 2.3.2: 6.7 kW, reached at 623 V",
        set: |unit, value| unit.supply.shunt_resistance_ohm = value,
        get: |unit| unit.supply.shunt_resistance_ohm,
    },
    Parameter {
        key: "supply.az-winding-resistance",
        quantity: "resistance",
        min_si: 0.0,
        max_si: 100.0,
        default: "1 ohm",
        doc: "Winding resistance of azimuth, for the current that the torque constant refers to.",
        source: "ours: 200 W of copper losses at the continuous current",
        set: |unit, value| unit.supply.az_winding_resistance_ohm = value,
        get: |unit| unit.supply.az_winding_resistance_ohm,
    },
    Parameter {
        key: "supply.el-winding-resistance",
        quantity: "resistance",
        min_si: 0.0,
        max_si: 100.0,
        default: "1 ohm",
        doc: "Winding resistance of elevation, for the current that the torque constant refers to.",
        source: "ours: 280 W of copper losses at the continuous current",
        set: |unit, value| unit.supply.el_winding_resistance_ohm = value,
        get: |unit| unit.supply.el_winding_resistance_ohm,
    },
];
