//! One flat table out of the settings of both axes.

use super::{AxisSetting, UnitSettings};
use super::{atmosphere, body, drive, friction, imu, instruments, mirror, motor, supply, target, tracker};
use drivers::parameter::Parameter;

const THEMES: [&[AxisSetting]; 4] = [body::BODY, friction::FRICTION, motor::MOTOR, drive::DRIVE];

/// Settings that belong to neither axis, section by section.
const SECTIONS: [&[Parameter<UnitSettings>]; 9] = [
    imu::IMU,
    mirror::MIRROR,
    tracker::COARSE,
    tracker::FINE,
    tracker::OPTICS,
    target::TARGET,
    atmosphere::ATMOSPHERE,
    supply::SUPPLY,
    instruments::INSTRUMENTS,
];

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

const COUNT: usize = {
    let mut count = 1;
    let mut theme = 0;
    while theme < THEMES.len() {
        count += 2 * THEMES[theme].len();
        theme += 1;
    }
    let mut section = 0;
    while section < SECTIONS.len() {
        count += SECTIONS[section].len();
        section += 1;
    }
    count
};

/// All settings: those of the unit, then azimuth, then elevation, then everything that is on neither axis.
pub(super) static ALL: [Parameter<UnitSettings>; COUNT] = {
    let mut all = [STEP_RATE; COUNT];
    let mut filled = 1;
    let mut axis = 0;
    while axis < 2 {
        let mut theme = 0;
        while theme < THEMES.len() {
            let mut row = 0;
            while row < THEMES[theme].len() {
                all[filled] = of_axis(&THEMES[theme][row], axis);
                filled += 1;
                row += 1;
            }
            theme += 1;
        }
        axis += 1;
    }
    let mut section = 0;
    while section < SECTIONS.len() {
        let mut row = 0;
        while row < SECTIONS[section].len() {
            all[filled] = copy_of(&SECTIONS[section][row]);
            filled += 1;
            row += 1;
        }
        section += 1;
    }
    all
};

const fn copy_of(parameter: &Parameter<UnitSettings>) -> Parameter<UnitSettings> {
    Parameter {
        key: parameter.key,
        quantity: parameter.quantity,
        min_si: parameter.min_si,
        max_si: parameter.max_si,
        default: parameter.default,
        doc: parameter.doc,
        source: parameter.source,
        set: parameter.set,
        get: parameter.get,
    }
}

const fn of_axis(setting: &AxisSetting, axis: usize) -> Parameter<UnitSettings> {
    Parameter {
        key: setting.keys[axis],
        quantity: setting.quantity,
        min_si: setting.range_si[0],
        max_si: setting.range_si[1],
        default: setting.defaults[axis],
        doc: setting.doc,
        source: setting.source,
        set: setting.set[axis],
        get: setting.get[axis],
    }
}
