//! One flat list of all settings of the director.

use super::setting::{Lens, Setting};
use super::wiring;
use super::{AxisSetting, AxisSettings, SupplySettings, UnitSettings};
use super::{atmosphere, body, drive, friction, imu, instruments, mirror, motor, supply, target, tracker};
use drivers::parameter::Parameter;

/// Settings of an axis, theme by theme.
pub(super) const THEMES: [&[AxisSetting]; 4] = [body::BODY, friction::FRICTION, motor::MOTOR, drive::DRIVE];

/// Settings that belong to neither axis, section by section, up to the supply.
const BEFORE_SUPPLY: [&[Parameter<UnitSettings>]; 7] = [
    imu::IMU,
    mirror::MIRROR,
    tracker::COARSE,
    tracker::FINE,
    tracker::OPTICS,
    target::TARGET,
    atmosphere::ATMOSPHERE,
];

/// Settings that belong to neither axis, section by section, from the supply on.
const AFTER_SUPPLY: [&[Parameter<UnitSettings>]; 3] = [WINDINGS, instruments::INSTRUMENTS, wiring::WIRING];

/// Windings of the motors; a file gives them beside the supply that feeds them.
const WINDINGS: &[Parameter<UnitSettings>] = &[
    Parameter {
        key: "supply.az-winding-resistance",
        quantity: "resistance",
        min_si: 0.0,
        max_si: 100.0,
        default: "1 ohm",
        doc: "Winding resistance of azimuth, for the current that the torque constant refers to.",
        source: "ours: 200 W of copper losses at the continuous current",
        set: |unit, value| unit.az.winding_resistance_ohm = value,
        get: |unit| unit.az.winding_resistance_ohm,
    },
    Parameter {
        key: "supply.el-winding-resistance",
        quantity: "resistance",
        min_si: 0.0,
        max_si: 100.0,
        default: "1 ohm",
        doc: "Winding resistance of elevation, for the current that the torque constant refers to.",
        source: "ours: 280 W of copper losses at the continuous current",
        set: |unit, value| unit.el.winding_resistance_ohm = value,
        get: |unit| unit.el.winding_resistance_ohm,
    },
];

const AZIMUTH: Lens<UnitSettings, AxisSettings> =
    Lens { part: |unit| &unit.az, part_mut: |unit| &mut unit.az };
const ELEVATION: Lens<UnitSettings, AxisSettings> =
    Lens { part: |unit| &unit.el, part_mut: |unit| &mut unit.el };
const OWN_SUPPLY: Lens<UnitSettings, SupplySettings> =
    Lens { part: |unit| &unit.supply, part_mut: |unit| &mut unit.supply };

const STEP_RATE: Parameter<UnitSettings> = Parameter {
    key: "step-rate",
    quantity: "frequency",
    min_si: 10_000.0,
    max_si: 1.0e6,
    default: "20 kHz",
    doc: "Rate of the world's steps.",
    source: "ours",
    set: |unit, value| unit.step_rate_hz = value,
    get: |unit| unit.step_rate_hz,
};

const CROSS_COUPLING: Parameter<UnitSettings> = Parameter {
    key: "cross-coupling",
    quantity: "ratio",
    min_si: -1.0,
    max_si: 1.0,
    default: "0.5 %",
    doc: "How much of azimuth's flexible modes shows in the elevation rate of the frame.",
    source: "ours: none was visible up to 10 Hz (study 3.1.1.2)",
    set: |unit, value| unit.cross_coupling_ratio = value,
    get: |unit| unit.cross_coupling_ratio,
};

/// Number of settings in these sections.
pub(super) const fn count_of<S>(sections: &[&[Parameter<S>]]) -> usize {
    let mut count = 0;
    let mut section = 0;
    while section < sections.len() {
        count += sections[section].len();
        section += 1;
    }
    count
}

/// Number of settings that every axis has.
pub(super) const AXIS_COUNT: usize = {
    let mut count = 0;
    let mut theme = 0;
    while theme < THEMES.len() {
        count += THEMES[theme].len();
        theme += 1;
    }
    count
};

const COUNT: usize =
    2 + 2 * AXIS_COUNT + count_of(&BEFORE_SUPPLY) + supply::SUPPLY.len() + count_of(&AFTER_SUPPLY);

/// A list that is being filled.
struct Filling {
    all: [Setting<UnitSettings>; COUNT],
    filled: usize,
}

impl Filling {
    const fn push(&mut self, setting: Setting<UnitSettings>) {
        self.all[self.filled] = setting;
        self.filled += 1;
    }

    const fn push_axis(&mut self, axis: usize) {
        let mut theme = 0;
        while theme < THEMES.len() {
            let mut row = 0;
            while row < THEMES[theme].len() {
                let parameter = THEMES[theme][row].of_director(axis);
                self.push(Setting::of_axis(&parameter, if axis == 0 { AZIMUTH } else { ELEVATION }));
                row += 1;
            }
            theme += 1;
        }
    }

    const fn push_sections(&mut self, sections: &[&[Parameter<UnitSettings>]]) {
        let mut section = 0;
        while section < sections.len() {
            let mut row = 0;
            while row < sections[section].len() {
                self.push(Setting::of_unit(&sections[section][row]));
                row += 1;
            }
            section += 1;
        }
    }

    const fn push_supply(&mut self) {
        let mut row = 0;
        while row < supply::SUPPLY.len() {
            self.push(Setting::of_supply(&supply::SUPPLY[row], OWN_SUPPLY));
            row += 1;
        }
    }
}

/// All settings: those of the unit, then azimuth, then elevation, then everything that is on neither axis.
pub(super) static ALL: [Setting<UnitSettings>; COUNT] = {
    let mut list = Filling { all: [const { Setting::of_unit(&STEP_RATE) }; COUNT], filled: 0 };
    list.push(Setting::of_unit(&STEP_RATE));
    list.push(Setting::of_unit(&CROSS_COUPLING));
    list.push_axis(0);
    list.push_axis(1);
    list.push_sections(&BEFORE_SUPPLY);
    list.push_supply();
    list.push_sections(&AFTER_SUPPLY);
    list.all
};
