//! How the unit is put together: what an electrician or a commissioning engineer can get wrong.

use super::row::Row;

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

pub(super) const WIRING: &[Row] = &[
    Row {
        keys: &["wiring.axes-swapped"],
        quantity: "ratio",
        range_si: [0.0, 1.0],
        defaults: &["0"],
        docs: &["1: each drive turns the other axis, as with two motor and encoder cables exchanged."],
        sources: &["ours"],
        field: |unit, _| &mut unit.wiring.axes_swapped_flag,
    },
    Row {
        keys: &["wiring.dropped-cycles"],
        quantity: "ratio",
        range_si: [0.0, 1.0],
        defaults: &["0 %"],
        docs: &["Probability that the bus loses a frame, independent for each frame."],
        sources: &["ours"],
        field: |unit, _| &mut unit.wiring.dropped_cycles_ratio,
    },
    Row {
        keys: &["wiring.az-soft-limits-enforced", "wiring.el-soft-limits-enforced"],
        quantity: "ratio",
        range_si: [0.0, 1.0],
        defaults: &["1"],
        docs: &[
            "1: the azimuth drive enforces its soft limits (607Dh).",
            "1: the elevation drive enforces its soft limits (607Dh).",
        ],
        sources: &["study 2.1.4"],
        field: |unit, k| &mut unit.axis_mut(k).soft_limits_enforced_flag,
    },
    Row {
        keys: &["wiring.vendor"],
        quantity: "count",
        range_si: [0.0, 4_294_967_295.0],
        defaults: &["0"],
        docs: &["Vendor id (1018h:1) that the drives claim, so that the bench treats them as real; 0: the \
                 simulator's mark."],
        sources: &["ours: refusals with real devices"],
        field: |unit, _| &mut unit.wiring.vendor_count,
    },
];
