//! A rotary table: one to four axes that do not act on each other, each a motor drive and its encoder, on one supply.

use std::sync::LazyLock;

use super::parameters::{axis_settings, step_rate};
use super::setting::{Field, FieldOfPart, Setting};
use super::{AxisSetting, AxisSettings, SupplySettings, nominal, supply, wiring};

/// Most axes of a table.
pub const MOST_AXES: usize = 4;

/// An axis of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableAxis {
    /// Name, e.g. `table`.
    pub name: String,
    /// Body, friction, motor, encoder and drive.
    pub settings: AxisSettings,
}

impl TableAxis {
    /// An axis of the table built in, under this name.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), settings: nominal::TABLE }
    }
}

/// A simulated rotary table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableSettings {
    /// Axes, in the order of their stations on the bus.
    pub axes: Vec<TableAxis>,
    /// DC link and power supply of all drives.
    pub supply: SupplySettings,
    /// Share of the frames that the bus loses, each by its own draw.
    pub dropped_cycles_ratio: f64,
    /// Vendor id (1018h:1) that the drives claim; 0: the simulator's mark.
    pub vendor_count: f64,
    /// World sub-step rate.
    pub step_rate_hz: f64,
    /// How long after the beginning of the campaign the point begins, by the plan; a point says so, no unit file.
    pub planned_s: f64,
}

impl TableSettings {
    /// Axes as built in, under these names, on the supply built in.
    pub fn with_axes(names: &[&str]) -> Self {
        Self { axes: names.iter().map(|name| TableAxis::new(name)).collect(), ..Self::without_axes() }
    }

    /// What every table has besides its axes.
    pub fn without_axes() -> Self {
        Self {
            axes: Vec::new(),
            supply: SupplySettings::default(),
            dropped_cycles_ratio: 0.0,
            vendor_count: 0.0,
            step_rate_hz: 20_000.0,
            planned_s: 0.0,
        }
    }

    /// The vendor id that the drives claim instead of the simulator's mark.
    pub fn claimed_vendor(&self) -> Option<u32> {
        wiring::claimed_vendor(self.vendor_count)
    }
}

const OWN: [Setting<Field<TableSettings>>; 3] = [
    step_rate(|table| &mut table.step_rate_hz),
    Setting {
        key: "wiring.dropped-cycles",
        quantity: "ratio",
        range_si: [0.0, 1.0],
        default: "0 %",
        doc: "Probability that the bus loses a frame, independent for each frame.",
        source: "ours",
        field: |table| &mut table.dropped_cycles_ratio,
    },
    Setting {
        key: "wiring.vendor",
        quantity: "count",
        range_si: [0.0, 4_294_967_295.0],
        default: "0",
        doc: "Vendor id (1018h:1) that the drives claim, so that the bench treats them as real; 0: the \
              simulator's mark.",
        source: "ours: refusals with real devices",
        field: |table| &mut table.vendor_count,
    },
];

/// Every setting of a table that belongs to none of its axes; files are read, checked and documented from this list.
pub static TABLE_PARAMETERS: LazyLock<Vec<Setting<FieldOfPart<TableSettings>>>> = LazyLock::new(|| {
    let of_supply =
        supply::SUPPLY.iter().map(|setting| setting.of_part(|table: &mut TableSettings| &mut table.supply));
    OWN.iter().map(Setting::of_unit).chain(of_supply).collect()
});

/// What the director's files give elsewhere than in the tables of its axes.
const MORE_OF_AXIS: [Setting<Field<AxisSettings>>; 2] = [
    Setting {
        key: "winding-resistance",
        quantity: "resistance",
        range_si: [0.0, 100.0],
        default: "2 ohm",
        doc: "Winding resistance of the motor, for the current that the torque constant refers to.",
        source: "ours: 50 W of copper losses at 5 A",
        field: |axis| &mut axis.winding_resistance_ohm,
    },
    Setting {
        key: "soft-limits-enforced",
        quantity: "ratio",
        range_si: [0.0, 1.0],
        default: "1",
        doc: "1: the drive enforces its soft limits (607Dh).",
        source: "ours",
        field: |axis| &mut axis.soft_limits_enforced_flag,
    },
];

/// Every setting of one axis of a table; keys are those of its own table in the file, e.g. `inertia`.
pub static AXIS_PARAMETERS: LazyLock<Vec<Setting<Field<AxisSettings>>>> =
    LazyLock::new(|| axis_settings().map(AxisSetting::of_table).chain(MORE_OF_AXIS).collect());
