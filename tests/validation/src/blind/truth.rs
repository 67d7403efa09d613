//! What is true of a drawn unit: findings whose truth is a setting, or a closed function of settings.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use num_complex::Complex64;
use procedures::measurement::Measurement;
use sim_devices::physics::lugre::{Contact, LuGre};
use sim_devices::physics::piezo::{Circuit, CircuitValues};
use sim_devices::unit::{AxisSettings, UnitSettings};

/// Step of the contact where only its steady torque is asked for.
const STEP_S: f64 = 50e-6;
/// Elevation at which azimuth breaks away in `quick`.
const BREAKAWAY_ELEVATION_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// Period of the loop: an exchange takes one.
const TICK_S: f64 = 250e-6;
/// Where the capacitance of the mirror is stated.
const CAPACITANCE_HZ: f64 = 20.0;

/// A measurand with a truth.
#[derive(Clone, Copy)]
pub struct Known {
    /// The measurand.
    pub measurand: &'static str,
    /// What it is true for.
    truth: fn(&Measurement, &UnitSettings) -> Option<f64>,
    /// Where that comes from.
    pub why: &'static str,
}

const fn known(
    measurand: &'static str,
    truth: fn(&Measurement, &UnitSettings) -> Option<f64>,
    why: &'static str,
) -> Known {
    Known { measurand, truth, why }
}

/// Every measurand that is scored.
#[rustfmt::skip]
pub const KNOWN: &[Known] = &[
    known("friction-torque", |m, unit| friction_nm(axis(m, unit)?, at(m, "velocity")?), "steady torque of the contact at the rate that was reached"),
    known("viscous-coefficient", |m, unit| Some(axis(m, unit)?.viscous_damping_nm_s_per_rad), "setting"),
    known("torque-constant", |m, unit| Some(axis(m, unit)?.torque_constant_nm_per_a), "setting"),
    known("unbalance-torque", unbalance_nm, "setting; of an axis that turns all around, its amplitude"),
    known("spring-stiffness", |m, unit| Some(axis(m, unit)?.spring_stiffness_nm_per_rad), "setting"),
    known("cogging-amplitude", |m, unit| Some(axis(m, unit)?.cogging_amplitude_nm), "setting of the strongest line"),
    known("cogging-harmonic", cogging_harmonic_nm, "setting of the line of that order"),
    known("cogging-order", |m, unit| Some(axis(m, unit)?.cogging_orders_per_rev), "setting"),
    known("bristle-stiffness", |m, unit| Some(axis(m, unit)?.bristle_stiffness_nm_per_rad), "setting"),
    known("presliding-damping", |m, unit| axis(m, unit).map(|axis| axis.bristle_damping_nm_s_per_rad + axis.viscous_damping_nm_s_per_rad), "sum of two settings, as the measurand is"),
    known("angle-random-walk", |_, unit| Some(unit.imu.gyro_random_walk_rad_per_sqrt_s * unit.imu.gyro_noise_factor), "setting"),
    known("current-bandwidth", |m, unit| Some(axis(m, unit)?.current_bandwidth_hz), "setting"),
    known("transport-round-trip", |m, unit| Some(round_trip_s(axis(m, unit)?)), "delays of the drive and one exchange"),
    known("gyro-encoder-delay", |m, unit| Some(unit.imu.delay_s + TICK_S - axis(m, unit)?.sensor_delay_s), "delays of both, and the exchange after which a message of the gyros is read"),
    known("gyro-scale-error", gyro_scale_error, "settings of scale and lean, along the axis that turned"),
    known("tracker-latency", tracker_latency_s, "setting of the tracker that was looked at"),
    known("optical-gain", |m, unit| Some([unit.trackers.optical_gain_cross_elevation_ratio, unit.trackers.optical_gain_elevation_ratio][place(m)?]), "setting"),
    known("apparent-inertia", |m, unit| apparent_inertia_kg_m2(m, unit, at(m, "elevation")?), "inertia over the rigid gain at the elevation, by what an ampere is worth in the rig file"),
    known("small-motion-inertia", |m, unit| apparent_inertia_kg_m2(m, unit, at(m, "elevation")?), "as for apparent-inertia"),
    known("breakaway-torque", breakaway_nm, "largest torque of the contact on a ramp of this rate, axis rigid, azimuth alone: elevation has a load"),
    known("encoder-pitch-error", |m, unit| Some(axis(m, unit)?.encoder_interpolation_rad), "setting"),
    known("elevation-zero-error", |_, unit| Some(elevation_zero_rad(unit)), "zero of the encoder and lean of the inertial unit"),
    known("accelerometer-bias", accelerometer_bias_m_per_s2, "settings, along the directions"),
    known("tracker-scale-error", |_, unit| Some(unit.trackers.coarse.scale_ratio - 1.0), "setting"),
    known("mirror-mode", |m, unit| Some(unit.mirror.frequency_hz[place(m)?]), "setting"),
    known("mirror-mode-damping", |_, unit| Some(unit.mirror.bare_damping_ratio), "setting"),
    known("mirror-coupling", coupling_ratio, "motional over whole capacitance at the series resonance, the dielectric as it is there"),
    known("mirror-capacitance", |m, unit| Some(whole_capacitance_f(&circuit(m, unit)?, CAPACITANCE_HZ)), "reactance of the circuit at 20 Hz"),
];

/// Truth of a finding; `None` where no setting says it.
pub fn of(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let known = KNOWN.iter().find(|known| known.measurand == m.measurand)?;
    (known.truth)(m, unit).filter(|truth| truth.is_finite())
}

/// 0 azimuth, 1 elevation.
fn place(m: &Measurement) -> Option<usize> {
    ["az", "el"].iter().position(|name| *name == m.axis)
}

fn axis<'a>(m: &Measurement, unit: &'a UnitSettings) -> Option<&'a AxisSettings> {
    Some([&unit.az, &unit.el][place(m)?])
}

/// A condition as it was reached.
fn at(m: &Measurement, name: &str) -> Option<f64> {
    let condition = m.conditions.iter().find(|condition| condition.name == name)?;
    Some(condition.achieved.unwrap_or(condition.requested))
}

fn unbalance_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let signed_nm = axis(m, unit)?.unbalance_nm;
    Some(if place(m)? == 0 { signed_nm.abs() } else { signed_nm })
}

fn friction_nm(axis: &AxisSettings, rate_rad_per_s: f64) -> Option<f64> {
    (rate_rad_per_s != 0.0).then(|| LuGre::new(axis, STEP_S).steady_torque_nm(rate_rad_per_s.abs()))
}

/// What an ampere of azimuth and elevation is worth in the rig file.
const RIG_NM_PER_A: [f64; 2] = [60.0, 52.0];

fn apparent_inertia_kg_m2(m: &Measurement, unit: &UnitSettings, elevation_rad: f64) -> Option<f64> {
    let own = axis(m, unit)?;
    let structure = [&unit.az_structure, &unit.el_structure][place(m)?];
    let gain = structure.interpolate(&structure.rigid_gain_ratio, elevation_rad);
    Some(own.inertia_kg_m2 / gain * RIG_NM_PER_A[place(m)?] / own.torque_constant_nm_per_a)
}

/// Up to here a ramp is looked at, in static torques over bristle stiffness.
const BREAKAWAY_SPAN: f64 = 8.0;
/// Step of a ramp: a thousandth of the time that it takes to reach the static torque, and not more than this.
const LONGEST_STEP_S: f64 = 2e-4;

/// Largest friction from rest to eight times the static torque over the bristle stiffness, on a ramp of current.
fn breakaway_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let own = axis(m, unit).filter(|_| place(m) == Some(0))?;
    let rate_nm_per_s = own.torque_constant_nm_per_a * at(m, "rate")?.abs();
    let step_s = (1e-3 * own.static_torque_nm / rate_nm_per_s).clamp(1e-6, LONGEST_STEP_S);
    let law = LuGre::new(own, step_s);
    let structure = &unit.az_structure;
    let elevation_rad = BREAKAWAY_ELEVATION_RAD;
    let gain = structure.interpolate(&structure.rigid_gain_ratio, elevation_rad);
    let inertia_kg_m2 = own.inertia_kg_m2 / gain;
    let mut contact = Contact { age_s: at(m, "dwell").unwrap_or(0.0), ..Contact::default() };
    let end_rad = BREAKAWAY_SPAN * own.static_torque_nm / own.bristle_stiffness_nm_per_rad;
    let mut angle_rad = 0.0;
    let mut rate_rad_per_s = 0.0;
    let mut largest_nm = 0.0_f64;
    let mut steps = 0.0;
    while angle_rad < end_rad {
        let friction_nm = law.advance(&mut contact, rate_rad_per_s);
        largest_nm = largest_nm.max(friction_nm);
        steps += 1.0;
        rate_rad_per_s += (rate_nm_per_s * steps * step_s - friction_nm) / inertia_kg_m2 * step_s;
        angle_rad += rate_rad_per_s * step_s;
    }
    Some(largest_nm)
}

/// What the encoder shows more than gravity: its zero, and how the unit leans about the elevation axis, (1, -1, 0)/√2 in its own
/// axes. Of accelerometers that lean against each other one half shows along the line of sight as an angle would.
fn elevation_zero_rad(unit: &UnitSettings) -> f64 {
    let [x, y, _] = unit.imu.misalignment_rad;
    let [_, zx, zy] = unit.imu.nonorthogonality_rad;
    FRAC_1_SQRT_2 * (x - y - 0.5 * (zx + zy)) - unit.el.encoder_zero_rad
}

fn accelerometer_bias_m_per_s2(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let [x, y, z] = unit.imu.accelerometer_bias_m_per_s2;
    match m.axis.as_str() {
        "up" => Some(FRAC_1_SQRT_2 * (x + y)),
        "ahead" => Some(z),
        _ => None,
    }
}

/// A line is the first or the second one within a tenth of the first order; others have no setting.
fn cogging_harmonic_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let axis = axis(m, unit)?;
    let lines = at(m, "order")? / axis.cogging_orders_per_rev;
    let settings = [(1.0, axis.cogging_amplitude_nm), (2.0, axis.cogging_second_amplitude_nm)];
    settings.into_iter().find(|(line, _)| (lines - line).abs() < 0.1).map(|(_, amplitude)| amplitude)
}

fn circuit(m: &Measurement, unit: &UnitSettings) -> Option<CircuitValues> {
    let mirror = &unit.mirror;
    Some(CircuitValues {
        capacitance_f: mirror.capacitance_f,
        coupling_ratio: mirror.coupling_ratio,
        loss_tangent_ratio: mirror.loss_tangent_ratio,
        frequency_hz: mirror.frequency_hz[place(m)?],
        damping_ratio: mirror.bare_damping_ratio,
        series_ohm: mirror.series_resistance_ohm,
        leak_ohm: mirror.leak_resistance_ohm,
    })
}

/// −1/(ωX) at the terminals.
fn whole_capacitance_f(values: &CircuitValues, frequency_hz: f64) -> f64 {
    -1.0 / (TAU * frequency_hz * Circuit::new(values).impedance(frequency_hz).reactance_ohm)
}

/// C_1/(C_0 + C_1) with the clamped capacitance C_0 at the series resonance: the circuit without its motion.
fn coupling_ratio(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let values = circuit(m, unit)?;
    let motional_f = values.coupling_ratio * values.capacitance_f;
    let clamped = CircuitValues {
        capacitance_f: values.capacitance_f - motional_f,
        coupling_ratio: 0.0,
        series_ohm: 0.0,
        ..values
    };
    let there = Circuit::new(&clamped).impedance(values.frequency_hz);
    let admittance = Complex64::new(there.resistance_ohm, there.reactance_ohm).inv();
    let clamped_f = admittance.im / (TAU * values.frequency_hz);
    Some(motional_f / (clamped_f + motional_f))
}

fn round_trip_s(axis: &AxisSettings) -> f64 {
    axis.command_delay_s + 0.5 * axis.delay_jitter_s + TICK_S + axis.sensor_delay_s
}

/// Size of the rate that the gyros show over the rate of the axis, less 1, to first order: scale errors and the leans of the
/// gyros; the rotation of the mount changes no size.
fn gyro_scale_error(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let direction = match place(m)? {
        0 => {
            let (sin, cos) = at(m, "elevation")?.sin_cos();
            [cos * FRAC_1_SQRT_2, cos * FRAC_1_SQRT_2, sin]
        }
        _ => [-FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0],
    };
    let [x, y, z] = direction;
    let imu = &unit.imu;
    let scale: f64 = imu.gyro_scale_error_ratio.iter().zip(direction).map(|(e, d)| e * d * d).sum();
    let [yx, zx, zy] = imu.nonorthogonality_rad;
    Some(scale + yx * x * y + zx * x * z + zy * y * z)
}

/// The point's name says which tracker it was.
fn tracker_latency_s(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let point = m.point.as_deref()?;
    let cameras = [("coarse tracker", &unit.trackers.coarse), ("fine tracker", &unit.trackers.fine)];
    cameras.iter().find(|(name, _)| *name == point).map(|(_, camera)| camera.latency_s)
}
