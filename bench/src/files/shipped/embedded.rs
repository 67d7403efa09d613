//! The list of embedded files: one line a file.

use super::Embedded;
use super::Folder::{Parameters, Procedures, Rigs, Units};

const fn file(folder: super::Folder, path: &'static str, text: &'static str) -> Embedded {
    Embedded { folder, path, text }
}

/// Every file that comes with the program.
pub const EMBEDDED: &[Embedded] = &[
    file(Procedures, "requirements.toml", include_str!("../../../../procedures/requirements.toml")),
    file(Procedures, "quick.toml", include_str!("../../../../procedures/quick.toml")),
    file(Procedures, "fat.toml", include_str!("../../../../procedures/fat.toml")),
    file(Procedures, "polarity.toml", include_str!("../../../../procedures/polarity.toml")),
    file(Procedures, "quick/az-friction.toml", include_str!("../../../../procedures/quick/az-friction.toml")),
    file(Procedures, "quick/el-friction.toml", include_str!("../../../../procedures/quick/el-friction.toml")),
    file(
        Procedures,
        "quick/az-breakaway.toml",
        include_str!("../../../../procedures/quick/az-breakaway.toml"),
    ),
    file(
        Procedures,
        "quick/el-breakaway.toml",
        include_str!("../../../../procedures/quick/el-breakaway.toml"),
    ),
    file(Procedures, "fat/az-friction.toml", include_str!("../../../../procedures/fat/az-friction.toml")),
    file(Procedures, "fat/el-friction.toml", include_str!("../../../../procedures/fat/el-friction.toml")),
    file(Procedures, "fat/az-stribeck.toml", include_str!("../../../../procedures/fat/az-stribeck.toml")),
    file(Procedures, "fat/el-stribeck.toml", include_str!("../../../../procedures/fat/el-stribeck.toml")),
    file(Procedures, "fat/az-cogging.toml", include_str!("../../../../procedures/fat/az-cogging.toml")),
    file(Procedures, "fat/el-cogging.toml", include_str!("../../../../procedures/fat/el-cogging.toml")),
    file(Procedures, "fat/az-breakaway.toml", include_str!("../../../../procedures/fat/az-breakaway.toml")),
    file(Procedures, "fat/el-breakaway.toml", include_str!("../../../../procedures/fat/el-breakaway.toml")),
    file(Procedures, "fat/el-hold.toml", include_str!("../../../../procedures/fat/el-hold.toml")),
    file(Procedures, "fat/az-current.toml", include_str!("../../../../procedures/fat/az-current.toml")),
    file(Procedures, "fat/az-from-rest.toml", include_str!("../../../../procedures/fat/az-from-rest.toml")),
    file(
        Procedures,
        "fat/az-open-elevations.toml",
        include_str!("../../../../procedures/fat/az-open-elevations.toml"),
    ),
    file(Procedures, "fat/az-open.toml", include_str!("../../../../procedures/fat/az-open.toml")),
    file(
        Procedures,
        "fat/az-velocity-levels.toml",
        include_str!("../../../../procedures/fat/az-velocity-levels.toml"),
    ),
    file(
        Procedures,
        "fat/az-velocity-loop.toml",
        include_str!("../../../../procedures/fat/az-velocity-loop.toml"),
    ),
    file(Procedures, "fat/el-current.toml", include_str!("../../../../procedures/fat/el-current.toml")),
    file(Procedures, "fat/el-open.toml", include_str!("../../../../procedures/fat/el-open.toml")),
    file(
        Procedures,
        "fat/el-velocity-levels.toml",
        include_str!("../../../../procedures/fat/el-velocity-levels.toml"),
    ),
    file(
        Procedures,
        "fat/el-velocity-loop.toml",
        include_str!("../../../../procedures/fat/el-velocity-loop.toml"),
    ),
    file(Procedures, "quick/az-current.toml", include_str!("../../../../procedures/quick/az-current.toml")),
    file(
        Procedures,
        "quick/az-velocity-loop.toml",
        include_str!("../../../../procedures/quick/az-velocity-loop.toml"),
    ),
    file(Procedures, "quick/el-current.toml", include_str!("../../../../procedures/quick/el-current.toml")),
    file(
        Procedures,
        "quick/el-velocity-loop.toml",
        include_str!("../../../../procedures/quick/el-velocity-loop.toml"),
    ),
    file(Procedures, "fat/az-range.toml", include_str!("../../../../procedures/fat/az-range.toml")),
    file(Procedures, "fat/el-range.toml", include_str!("../../../../procedures/fat/el-range.toml")),
    file(Procedures, "quick/az-range.toml", include_str!("../../../../procedures/quick/az-range.toml")),
    file(Procedures, "quick/el-range.toml", include_str!("../../../../procedures/quick/el-range.toml")),
    file(Procedures, "fat/az-stop.toml", include_str!("../../../../procedures/fat/az-stop.toml")),
    file(Procedures, "fat/el-stop.toml", include_str!("../../../../procedures/fat/el-stop.toml")),
    file(Procedures, "quick/az-stop.toml", include_str!("../../../../procedures/quick/az-stop.toml")),
    file(Procedures, "fat/az-duty.toml", include_str!("../../../../procedures/fat/az-duty.toml")),
    file(Procedures, "fat/el-duty.toml", include_str!("../../../../procedures/fat/el-duty.toml")),
    file(Procedures, "fat/both-duty.toml", include_str!("../../../../procedures/fat/both-duty.toml")),
    file(Procedures, "quick/both-duty.toml", include_str!("../../../../procedures/quick/both-duty.toml")),
    file(Procedures, "fat/az-latency.toml", include_str!("../../../../procedures/fat/az-latency.toml")),
    file(Procedures, "fat/el-latency.toml", include_str!("../../../../procedures/fat/el-latency.toml")),
    file(Procedures, "quick/az-latency.toml", include_str!("../../../../procedures/quick/az-latency.toml")),
    file(Procedures, "fat/az-modes.toml", include_str!("../../../../procedures/fat/az-modes.toml")),
    file(Procedures, "fat/el-modes.toml", include_str!("../../../../procedures/fat/el-modes.toml")),
    file(Procedures, "quick/el-modes.toml", include_str!("../../../../procedures/quick/el-modes.toml")),
    file(Procedures, "fat/fsm-impedance.toml", include_str!("../../../../procedures/fat/fsm-impedance.toml")),
    file(Procedures, "fat/fsm-response.toml", include_str!("../../../../procedures/fat/fsm-response.toml")),
    file(
        Procedures,
        "quick/fsm-impedance.toml",
        include_str!("../../../../procedures/quick/fsm-impedance.toml"),
    ),
    file(
        Procedures,
        "quick/fsm-response.toml",
        include_str!("../../../../procedures/quick/fsm-response.toml"),
    ),
    file(Procedures, "quick/az-modes.toml", include_str!("../../../../procedures/quick/az-modes.toml")),
    file(Rigs, "sim.toml", include_str!("../../../rigs/sim.toml")),
    file(Units, "nominal.toml", include_str!("../../../../sim-devices/units/nominal.toml")),
    file(Units, "as-measured.toml", include_str!("../../../../sim-devices/units/as-measured.toml")),
    file(
        Units,
        "defects/axes-swapped.toml",
        include_str!("../../../../sim-devices/units/defects/axes-swapped.toml"),
    ),
    file(
        Units,
        "defects/azimuth-retainer.toml",
        include_str!("../../../../sim-devices/units/defects/azimuth-retainer.toml"),
    ),
    file(Units, "defects/cogging.toml", include_str!("../../../../sim-devices/units/defects/cogging.toml")),
    file(
        Units,
        "defects/current-limit-low.toml",
        include_str!("../../../../sim-devices/units/defects/current-limit-low.toml"),
    ),
    file(
        Units,
        "defects/dropped-cycles.toml",
        include_str!("../../../../sim-devices/units/defects/dropped-cycles.toml"),
    ),
    file(
        Units,
        "defects/dropped-frames.toml",
        include_str!("../../../../sim-devices/units/defects/dropped-frames.toml"),
    ),
    file(
        Units,
        "defects/encoder-eccentricity.toml",
        include_str!("../../../../sim-devices/units/defects/encoder-eccentricity.toml"),
    ),
    file(
        Units,
        "defects/encoder-modulus.toml",
        include_str!("../../../../sim-devices/units/defects/encoder-modulus.toml"),
    ),
    file(
        Units,
        "defects/encoder-sign.toml",
        include_str!("../../../../sim-devices/units/defects/encoder-sign.toml"),
    ),
    file(
        Units,
        "defects/extra-latency-small.toml",
        include_str!("../../../../sim-devices/units/defects/extra-latency-small.toml"),
    ),
    file(
        Units,
        "defects/extra-latency.toml",
        include_str!("../../../../sim-devices/units/defects/extra-latency.toml"),
    ),
    file(
        Units,
        "defects/friction-az.toml",
        include_str!("../../../../sim-devices/units/defects/friction-az.toml"),
    ),
    file(
        Units,
        "defects/friction-el.toml",
        include_str!("../../../../sim-devices/units/defects/friction-el.toml"),
    ),
    file(
        Units,
        "defects/gyro-noise.toml",
        include_str!("../../../../sim-devices/units/defects/gyro-noise.toml"),
    ),
    file(
        Units,
        "defects/gyro-sign.toml",
        include_str!("../../../../sim-devices/units/defects/gyro-sign.toml"),
    ),
    file(
        Units,
        "defects/heat-sink-blocked.toml",
        include_str!("../../../../sim-devices/units/defects/heat-sink-blocked.toml"),
    ),
    file(
        Units,
        "defects/loop-gain-low.toml",
        include_str!("../../../../sim-devices/units/defects/loop-gain-low.toml"),
    ),
    file(
        Units,
        "defects/mirror-hysteresis.toml",
        include_str!("../../../../sim-devices/units/defects/mirror-hysteresis.toml"),
    ),
    file(
        Units,
        "defects/mirror-notch-off.toml",
        include_str!("../../../../sim-devices/units/defects/mirror-notch-off.toml"),
    ),
    file(
        Units,
        "defects/mirror-serial-slow.toml",
        include_str!("../../../../sim-devices/units/defects/mirror-serial-slow.toml"),
    ),
    file(
        Units,
        "defects/mirror-stroke-short.toml",
        include_str!("../../../../sim-devices/units/defects/mirror-stroke-short.toml"),
    ),
    file(Units, "defects/mode-low.toml", include_str!("../../../../sim-devices/units/defects/mode-low.toml")),
    file(
        Units,
        "defects/mode-underdamped.toml",
        include_str!("../../../../sim-devices/units/defects/mode-underdamped.toml"),
    ),
    file(
        Units,
        "defects/motor-undersized.toml",
        include_str!("../../../../sim-devices/units/defects/motor-undersized.toml"),
    ),
    file(
        Units,
        "defects/optical-gain-sign.toml",
        include_str!("../../../../sim-devices/units/defects/optical-gain-sign.toml"),
    ),
    file(
        Units,
        "defects/optical-gain-size.toml",
        include_str!("../../../../sim-devices/units/defects/optical-gain-size.toml"),
    ),
    file(
        Units,
        "defects/shunt-open.toml",
        include_str!("../../../../sim-devices/units/defects/shunt-open.toml"),
    ),
    file(
        Units,
        "defects/soft-limit-missing.toml",
        include_str!("../../../../sim-devices/units/defects/soft-limit-missing.toml"),
    ),
    file(Units, "defects/spring.toml", include_str!("../../../../sim-devices/units/defects/spring.toml")),
    file(
        Units,
        "defects/torque-scale-ten.toml",
        include_str!("../../../../sim-devices/units/defects/torque-scale-ten.toml"),
    ),
    file(
        Units,
        "defects/torque-scale.toml",
        include_str!("../../../../sim-devices/units/defects/torque-scale.toml"),
    ),
    file(
        Units,
        "defects/torque-sign.toml",
        include_str!("../../../../sim-devices/units/defects/torque-sign.toml"),
    ),
    file(
        Units,
        "defects/tracker-latency.toml",
        include_str!("../../../../sim-devices/units/defects/tracker-latency.toml"),
    ),
    file(
        Units,
        "defects/unbalance.toml",
        include_str!("../../../../sim-devices/units/defects/unbalance.toml"),
    ),
    file(Parameters, "director.toml", include_str!("../../../../controllers/params/director.toml")),
];
