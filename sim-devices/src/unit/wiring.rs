//! How the unit is put together: what an electrician or a commissioning engineer can get wrong.

use super::UnitSettings;
use drivers::parameter::Parameter;

/// How the unit is put together. Yes and no are 1 and 0, so that they are settings like all others.
#[derive(Clone, Debug, PartialEq)]
pub struct WiringSettings {
    /// 1: each drive turns the other axis, as with two motor and encoder cables exchanged.
    pub axes_swapped_flag: f64,
    /// Share of the frames that the bus loses, each by its own draw.
    pub dropped_cycles_ratio: f64,
    /// Vendor id (1018h:1) that the drives claim; 0: the simulator's mark.
    pub vendor_count: f64,
}

impl Default for WiringSettings {
    fn default() -> Self {
        Self { axes_swapped_flag: 0.0, dropped_cycles_ratio: 0.0, vendor_count: 0.0 }
    }
}

impl WiringSettings {
    /// Whether each drive turns the other axis.
    pub fn axes_swapped(&self) -> bool {
        self.axes_swapped_flag >= 0.5
    }

    /// The vendor id that the drives claim instead of the simulator's mark.
    pub fn claimed_vendor(&self) -> Option<u32> {
        claimed_vendor(self.vendor_count)
    }
}

/// The vendor id of a setting in which 0 is the simulator's mark.
pub(super) fn claimed_vendor(vendor_count: f64) -> Option<u32> {
    (vendor_count >= 1.0).then_some(vendor_count as u32)
}

pub(super) const WIRING: &[Parameter<UnitSettings>] = &[
    Parameter {
        key: "wiring.axes-swapped",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1.0,
        default: "0",
        doc: "1: each drive turns the other axis, as with two motor and encoder cables exchanged.",
        source: "ours",
        set: |unit, value| unit.wiring.axes_swapped_flag = value,
        get: |unit| unit.wiring.axes_swapped_flag,
    },
    Parameter {
        key: "wiring.dropped-cycles",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1.0,
        default: "0 %",
        doc: "Share of the frames that the bus loses, each by its own draw.",
        source: "ours",
        set: |unit, value| unit.wiring.dropped_cycles_ratio = value,
        get: |unit| unit.wiring.dropped_cycles_ratio,
    },
    Parameter {
        key: "wiring.az-soft-limits-enforced",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1.0,
        default: "1",
        doc: "1: the azimuth drive keeps the soft limits that it was given (607Dh).",
        source: "study 2.1.4",
        set: |unit, value| unit.az.soft_limits_enforced_flag = value,
        get: |unit| unit.az.soft_limits_enforced_flag,
    },
    Parameter {
        key: "wiring.el-soft-limits-enforced",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1.0,
        default: "1",
        doc: "1: the elevation drive keeps the soft limits that it was given (607Dh).",
        source: "study 2.1.4",
        set: |unit, value| unit.el.soft_limits_enforced_flag = value,
        get: |unit| unit.el.soft_limits_enforced_flag,
    },
    Parameter {
        key: "wiring.vendor",
        quantity: "count",
        min_si: 0.0,
        max_si: 4_294_967_295.0,
        default: "0",
        doc: "Vendor id (1018h:1) that the drives claim, so that the bench takes them for real; 0: the simulator's mark.",
        source: "ours: refusals with real devices",
        set: |unit, value| unit.wiring.vendor_count = value,
        get: |unit| unit.wiring.vendor_count,
    },
];
