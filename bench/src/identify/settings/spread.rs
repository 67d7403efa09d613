//! How far a unit may be from its base, and which settings take only some values.
//!
//! Wide on purpose: a finding outweighs it by far. It decides only where the findings say nothing of a setting alone, such as how a
//! sum of two delays is divided between them.

use std::f64::consts::TAU;

use sim_devices::unit::{FieldOfPart, Setting, UnitSettings};

/// Standard uncertainty of a setting of the base as one of another unit.
#[derive(Clone, Copy)]
enum Spread {
    /// As a share of the value.
    Share(f64),
    /// SI.
    Within(f64),
}

use Spread::{Share, Within};

/// By the end of the key; the first that fits counts.
const SPREADS: &[(&str, Spread)] = &[
    (".inertia", Share(0.3)),
    (".torque-constant", Share(0.2)),
    (".coulomb-torque", Share(1.0)),
    (".static-torque", Share(1.0)),
    (".stribeck-velocity", Share(0.5)),
    (".stribeck-shape", Share(0.5)),
    (".viscous-damping", Share(1.0)),
    (".bristle-stiffness", Share(1.0)),
    (".bristle-damping", Share(1.0)),
    (".ageing", Within(0.02)),
    (".unbalance", Within(50.0)),
    (".spring-stiffness", Within(200.0)),
    (".spring-rest", Within(0.7)),
    (".cogging-order", Within(5.0)),
    (".cogging-amplitude", Within(30.0)),
    (".cogging-second-amplitude", Within(10.0)),
    (".cogging-phase", Within(TAU)),
    (".cogging-second-phase", Within(TAU)),
    (".current-bandwidth", Share(0.5)),
    (".current-noise", Within(0.02)),
    (".command-delay", Within(0.5e-3)),
    (".sensor-delay", Within(0.5e-3)),
    (".delay-jitter", Within(0.2e-3)),
    (".encoder-bits", Within(6.0)),
    (".encoder-interpolation", Within(5e-6)),
    (".encoder-backlash", Within(1e-4)),
    (".encoder-slip", Within(1e-4)),
    (".encoder-zero", Within(5e-3)),
    ("imu.delay", Within(0.5e-3)),
    ("imu.gyro-random-walk", Share(1.0)),
    ("imu.gyro-bias-", Within(2e-5)),
    ("imu.gyro-scale-error-", Within(1e-3)),
    ("imu.lean-", Within(1e-4)),
    ("imu.misalignment-", Within(3e-4)),
    ("imu.accelerometer-bias-", Within(0.05)),
    ("mirror.bare-damping", Share(1.0)),
    ("mirror.hysteresis", Share(0.3)),
    ("mirror.capacitance", Share(0.3)),
    ("mirror.coupling", Share(0.5)),
    ("mirror.", Share(0.2)),
    ("-latency", Within(10e-3)),
    (".coarse-scale", Within(0.2)),
    ("-dropped", Within(0.1)),
    (".optical-gain-", Share(0.2)),
];

/// Standard uncertainty of the base's value, SI.
pub(super) fn of(setting: &Setting<FieldOfPart<UnitSettings>>, value_si: f64) -> f64 {
    let spread = SPREADS.iter().find(|(part, _)| setting.key.contains(part)).map(|(_, spread)| *spread);
    match spread.expect("every setting of a relation has a spread") {
        Share(share) => (share * value_si.abs()).max(f64::MIN_POSITIVE),
        Within(u) => u,
    }
}

/// Delays of whole steps of the simulation, in the order in which they are rounded: what follows takes up the rest.
pub(in crate::identify) const IN_STEPS: [&str; 4] =
    ["az.sensor-delay", "el.sensor-delay", "az.command-delay", "el.command-delay"];

/// Whether a setting is one of the delays that make sums with those in steps.
pub(super) fn is_delay(key: &str) -> bool {
    IN_STEPS.contains(&key) || key == "imu.delay"
}

/// Settings that are counted.
fn is_counted(key: &str) -> bool {
    key.ends_with(".encoder-bits")
}

/// The uncertainty with that of rounding: half a step either way, none of what is counted.
pub(in crate::identify) fn with_rounding(key: &str, u: f64, step_rate_hz: f64) -> f64 {
    match (IN_STEPS.contains(&key), is_counted(key)) {
        (true, _) => u.hypot(0.5 / step_rate_hz / 3.0_f64.sqrt()),
        (_, true) => 0.0,
        _ => u,
    }
}

/// The value, whole where the setting is counted.
pub(super) fn as_whole(key: &str, value: f64) -> f64 {
    if is_counted(key) { value.round() } else { value }
}
