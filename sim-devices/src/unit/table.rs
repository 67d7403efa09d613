//! A rotary table: one to four axes that do not act on each other, each a motor drive and its encoder, on one supply.

use super::parameters::{AXIS_COUNT, THEMES};
use super::setting::{Lens, Setting};
use super::{AxisSettings, SupplySettings, nominal, supply, wiring};
use drivers::parameter::Parameter;

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
        }
    }

    /// The vendor id that the drives claim instead of the simulator's mark.
    pub fn claimed_vendor(&self) -> Option<u32> {
        wiring::claimed_vendor(self.vendor_count)
    }
}

const OWN_SUPPLY: Lens<TableSettings, SupplySettings> =
    Lens { part: |table| &table.supply, part_mut: |table| &mut table.supply };

const OWN: [Parameter<TableSettings>; 3] = [
    Parameter {
        key: "step-rate",
        quantity: "frequency",
        min_si: 10_000.0,
        max_si: 1.0e6,
        default: "20 kHz",
        doc: "Rate of the world's steps.",
        source: "ours",
        set: |table, value| table.step_rate_hz = value,
        get: |table| table.step_rate_hz,
    },
    Parameter {
        key: "wiring.dropped-cycles",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1.0,
        default: "0 %",
        doc: "Share of the frames that the bus loses, each by its own draw.",
        source: "ours",
        set: |table, value| table.dropped_cycles_ratio = value,
        get: |table| table.dropped_cycles_ratio,
    },
    Parameter {
        key: "wiring.vendor",
        quantity: "count",
        min_si: 0.0,
        max_si: 4_294_967_295.0,
        default: "0",
        doc: "Vendor id (1018h:1) that the drives claim, so that the bench takes them for real; 0: the simulator's mark.",
        source: "ours: refusals with real devices",
        set: |table, value| table.vendor_count = value,
        get: |table| table.vendor_count,
    },
];

static ALL: [Setting<TableSettings>; OWN.len() + supply::SUPPLY.len()] = {
    let mut all = [const { Setting::of_unit(&OWN[0]) }; OWN.len() + supply::SUPPLY.len()];
    let mut row = 0;
    while row < OWN.len() {
        all[row] = Setting::of_unit(&OWN[row]);
        row += 1;
    }
    let mut row = 0;
    while row < supply::SUPPLY.len() {
        all[OWN.len() + row] = Setting::of_supply(&supply::SUPPLY[row], OWN_SUPPLY);
        row += 1;
    }
    all
};

/// Every setting of a table that belongs to none of its axes; files are read, checked and documented from this list.
pub const TABLE_PARAMETERS: &[Setting<TableSettings>] = &ALL;

/// What the director's files give elsewhere than in the tables of its axes.
const MORE_OF_AXIS: [Parameter<AxisSettings>; 2] = [
    Parameter {
        key: "winding-resistance",
        quantity: "resistance",
        min_si: 0.0,
        max_si: 100.0,
        default: "2 ohm",
        doc: "Winding resistance of the motor, for the current that the torque constant refers to.",
        source: "ours: 50 W of copper losses at 5 A",
        set: |axis, value| axis.winding_resistance_ohm = value,
        get: |axis| axis.winding_resistance_ohm,
    },
    Parameter {
        key: "soft-limits-enforced",
        quantity: "ratio",
        min_si: 0.0,
        max_si: 1.0,
        default: "1",
        doc: "1: the drive keeps the soft limits that it was given (607Dh).",
        source: "ours",
        set: |axis, value| axis.soft_limits_enforced_flag = value,
        get: |axis| axis.soft_limits_enforced_flag,
    },
];

static OF_AXIS: [Parameter<AxisSettings>; AXIS_COUNT + MORE_OF_AXIS.len()] = {
    let mut all = [const { THEMES[0][0].of_table() }; AXIS_COUNT + MORE_OF_AXIS.len()];
    let mut filled = 0;
    let mut theme = 0;
    while theme < THEMES.len() {
        let mut row = 0;
        while row < THEMES[theme].len() {
            all[filled] = THEMES[theme][row].of_table();
            filled += 1;
            row += 1;
        }
        theme += 1;
    }
    let mut row = 0;
    while row < MORE_OF_AXIS.len() {
        all[filled + row] = Parameter { ..MORE_OF_AXIS[row] };
        row += 1;
    }
    all
};

/// Every setting of one axis of a table; keys are those of its own table in the file, e.g. `inertia`.
pub const AXIS_PARAMETERS: &[Parameter<AxisSettings>] = &OF_AXIS;
