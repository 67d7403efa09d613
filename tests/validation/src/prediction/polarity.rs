//! What the checks before motion will see: signs and sizes of every path from torque to sensor, and the bus. The
//! trackers' signs are seen later, with the axes at rest (OPT-GAIN).

use sim_devices::unit::UnitSettings;

/// The check of torque scale before motion stops a run beyond this departure.
const SCALE_RATIO: f64 = 0.2;
/// The check of counts per turn against the gyro stops a run beyond this departure.
const MODULUS_RATIO: f64 = 0.02;
/// Elevation at which signs are checked, with all torque off.
const POSE_RAD: f64 = 40.0 * std::f64::consts::PI / 180.0;
/// Torque of the pulses over the static one.
const PULSE_RATIO: f64 = 0.2;
/// A rate that belongs to the other axis.
const OTHER_AXIS_RATIO: f64 = 0.5;
/// Share of lost frames that the interlock on the bus allows.
const LOST_RATIO: f64 = 0.04;

/// Whether signs and scales are those that the loops rely on.
///
/// # Errors
/// The first path that is not: what a small pulse of torque shows.
pub fn polarity(unit: &UnitSettings) -> Result<(), String> {
    if unit.wiring.axes_swapped() {
        return Err("a pulse on the azimuth drive turns elevation".into());
    }
    for (name, axis) in [("azimuth", &unit.az), ("elevation", &unit.el)] {
        if axis.encoder_sign_factor < 0.0 {
            return Err(format!("positive torque makes negative counts on {name}"));
        }
        if axis.motor_sign_factor < 0.0 {
            return Err(format!("positive torque turns {name} backwards"));
        }
        if (axis.encoder_modulus_ratio - 1.0).abs() > MODULUS_RATIO {
            let found = axis.encoder_modulus_ratio;
            return Err(format!(
                "the {name} encoder counts {found:.2} of the counts per turn that it should"
            ));
        }
        let scale = super::torque_ratio(axis);
        if (scale - 1.0).abs() > SCALE_RATIO {
            return Err(format!("the {name} motor gives {scale:.2} of the torque that it should"));
        }
    }
    for (name, axis) in [("azimuth", &unit.az), ("elevation", &unit.el)] {
        let pulse_rad = PULSE_RATIO * axis.static_torque_nm / axis.bristle_stiffness_nm_per_rad;
        if axis.encoder_backlash_rad > SCALE_RATIO * pulse_rad {
            return Err(format!(
                "the {name} encoder does not follow a pulse that bends the bristles by {pulse_rad:.1e} rad"
            ));
        }
    }
    gyros(unit)?;
    let el = &unit.el;
    let pulls_nm =
        el.unbalance_nm * POSE_RAD.cos() - el.spring_stiffness_nm_per_rad * (POSE_RAD - el.spring_rest_rad);
    if pulls_nm.abs() > el.static_torque_nm {
        return Err(format!(
            "elevation does not hold itself: {pulls_nm:.0} N*m against {:.0} N*m",
            el.static_torque_nm
        ));
    }
    Ok(())
}

/// Rates about both axes through the published mapping, at elevation 0: rows `0.7071·[1, −1]` and `0.7071·[1, 1]` of
/// gyros that stand at the mounting angle.
fn gyros(unit: &UnitSettings) -> Result<(), String> {
    let (sine, cosine) = unit.imu.mounting_angle_rad.sin_cos();
    let [x, y, _] = unit.imu.gyro_sign_factor.map(f64::signum);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Columns: a rate about the elevation axis, a rate about the vertical.
    let seen = [
        [half * (x * cosine + y * sine), half * (x * sine - y * cosine)],
        [half * (x * cosine - y * sine), half * (x * sine + y * cosine)],
    ];
    for (axis, name) in [(0, "elevation"), (1, "azimuth")] {
        if (seen[axis][axis] - 1.0).abs() > SCALE_RATIO {
            return Err(format!("the gyros show {:.2} of the rate of {name}", seen[axis][axis]));
        }
        if seen[axis][1 - axis].abs() > OTHER_AXIS_RATIO {
            return Err(format!("the gyros show the other axis as {name}"));
        }
    }
    Ok(())
}

/// Whether the bus carries the traffic.
///
/// # Errors
/// The share of frames that it loses, where the interlock trips.
pub fn bus(unit: &UnitSettings) -> Result<(), String> {
    let lost = unit.wiring.dropped_cycles_ratio;
    if lost > LOST_RATIO { Err(format!("the bus loses {:.0} % of its frames", 100.0 * lost)) } else { Ok(()) }
}
