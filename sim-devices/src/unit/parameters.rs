//! The list of all settings of the director.

use std::sync::LazyLock;

use super::row::Row;
use super::setting::{Field, FieldOfPart, Setting};
use super::{AxisSetting, UnitSettings};
use super::{
    atmosphere, body, drive, friction, imu, instruments, mirror, motor, supply, target, tracker, wiring,
};

/// Settings of an axis, theme by theme.
const THEMES: [&[AxisSetting]; 4] = [body::BODY, friction::FRICTION, motor::MOTOR, drive::DRIVE];

/// Rate of the steps of any world.
pub(super) const fn step_rate<S>(field: Field<S>) -> Setting<Field<S>> {
    Setting {
        key: "step-rate",
        quantity: "frequency",
        range_si: [10_000.0, 1.0e6],
        default: "20 kHz",
        doc: "Rate of the world's steps.",
        source: "ours",
        field,
    }
}

const CROSS_COUPLING: Setting<Field<UnitSettings>> = Setting {
    key: "cross-coupling",
    quantity: "ratio",
    range_si: [-1.0, 1.0],
    default: "0.5 %",
    doc: "Share of azimuth's flexible modes that appears in the elevation rate of the frame.",
    source: "ours: none was visible up to 10 Hz (study 3.1.1.2)",
    field: |unit| &mut unit.cross_coupling_ratio,
};

const CROSS_COUPLING_GROWTH: Setting<Field<UnitSettings>> = Setting {
    key: "cross-coupling-growth",
    quantity: "ratio",
    range_si: [-1.0, 1.0],
    default: "0 %",
    doc: "Additional cross-coupling at the zenith; it grows with the sine of elevation.",
    source: "ours",
    field: |unit| &mut unit.cross_coupling_growth_ratio,
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
    field: |unit, k| &mut unit.axis_mut(k).winding_resistance_ohm,
};

/// Every setting of a director; files are read, checked and documented from this list: those of the unit, then azimuth,
/// then elevation, then everything that is on neither axis.
pub static PARAMETERS: LazyLock<Vec<Setting<FieldOfPart<UnitSettings>>>> = LazyLock::new(|| {
    let mut all = vec![
        step_rate(|unit: &mut UnitSettings| &mut unit.step_rate_hz).of_unit(),
        CROSS_COUPLING.of_unit(),
        CROSS_COUPLING_GROWTH.of_unit(),
    ];
    all.extend(axis_settings().map(|row| row.of_director(0).of_part(|unit: &mut UnitSettings| &mut unit.az)));
    all.extend(axis_settings().map(|row| row.of_director(1).of_part(|unit: &mut UnitSettings| &mut unit.el)));
    all.extend(imu::IMU.iter().flat_map(Row::settings));
    all.extend(mirror::MIRROR.iter().flat_map(Row::settings));
    for camera in 0..2 {
        all.extend(tracker::CAMERAS.iter().map(|row| row.setting(camera)));
    }
    all.extend(tracker::OPTICS.iter().map(Setting::of_unit));
    all.extend(target::TARGET.iter().map(Setting::of_unit));
    all.extend(atmosphere::ATMOSPHERE.iter().map(Setting::of_unit));
    all.extend(
        supply::SUPPLY.iter().map(|setting| setting.of_part(|unit: &mut UnitSettings| &mut unit.supply)),
    );
    all.extend(WINDINGS.settings());
    all.extend(instruments::INSTRUMENTS.iter().map(Setting::of_unit));
    all.extend(wiring::WIRING.iter().flat_map(Row::settings));
    all
});

/// Settings that every axis has.
pub(super) fn axis_settings() -> impl Iterator<Item = &'static AxisSetting> {
    THEMES.into_iter().flatten()
}
