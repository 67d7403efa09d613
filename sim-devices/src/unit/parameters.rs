//! The list of all settings of the director.

use std::sync::LazyLock;

use drivers::parameter::Parameter;

use super::row::Row;
use super::setting::{Part, Setting};
use super::{AxisSetting, AxisSettings, SupplySettings, UnitSettings};
use super::{
    atmosphere, body, drive, friction, imu, instruments, mirror, motor, supply, target, tracker, wiring,
};

/// Settings of an axis, theme by theme.
const THEMES: [&[AxisSetting]; 4] = [body::BODY, friction::FRICTION, motor::MOTOR, drive::DRIVE];

const AZIMUTH: Part<UnitSettings, AxisSettings> =
    Part { part: |unit| &unit.az, part_mut: |unit| &mut unit.az };
const ELEVATION: Part<UnitSettings, AxisSettings> =
    Part { part: |unit| &unit.el, part_mut: |unit| &mut unit.el };
const SUPPLY: Part<UnitSettings, SupplySettings> =
    Part { part: |unit| &unit.supply, part_mut: |unit| &mut unit.supply };

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

/// Windings of the motors; a file gives them beside the supply that feeds them.
const WINDINGS: Row = Row {
    keys: &["supply.az-winding-resistance", "supply.el-winding-resistance"],
    quantity: "resistance",
    range_si: [0.0, 100.0],
    defaults: &["1 ohm"],
    docs: &[
        "Winding resistance of azimuth, for the current that the torque constant refers to.",
        "Winding resistance of elevation, for the current that the torque constant refers to.",
    ],
    sources: &[
        "ours: 200 W of copper losses at the continuous current",
        "ours: 280 W of copper losses at the continuous current",
    ],
    set: |unit, k, value| unit.axis_mut(k).winding_resistance_ohm = value,
    get: |unit, k| unit.axis(k).winding_resistance_ohm,
};

/// Every setting of a director; files are read, checked and documented from this list: those of the unit, then azimuth,
/// then elevation, then everything that is on neither axis.
pub static PARAMETERS: LazyLock<Vec<Setting<UnitSettings>>> = LazyLock::new(|| {
    let mut all = vec![Setting::of_unit(&STEP_RATE), Setting::of_unit(&CROSS_COUPLING)];
    all.extend(axis_settings().map(|row| Setting::of_part(&row.of_director(0), &AZIMUTH)));
    all.extend(axis_settings().map(|row| Setting::of_part(&row.of_director(1), &ELEVATION)));
    all.extend(imu::IMU.iter().flat_map(Row::settings));
    all.extend(mirror::MIRROR.iter().flat_map(Row::settings));
    for camera in 0..2 {
        all.extend(tracker::CAMERAS.iter().map(|row| row.setting(camera)));
    }
    all.extend(tracker::OPTICS.iter().map(Setting::of_unit));
    all.extend(target::TARGET.iter().map(Setting::of_unit));
    all.extend(atmosphere::ATMOSPHERE.iter().map(Setting::of_unit));
    all.extend(supply::SUPPLY.iter().map(|parameter| Setting::of_part(parameter, &SUPPLY)));
    all.extend(WINDINGS.settings());
    all.extend(instruments::INSTRUMENTS.iter().map(Setting::of_unit));
    all.extend(wiring::WIRING.iter().flat_map(Row::settings));
    all
});

/// Settings that every axis has.
pub(super) fn axis_settings() -> impl Iterator<Item = &'static AxisSetting> {
    THEMES.into_iter().flatten()
}
