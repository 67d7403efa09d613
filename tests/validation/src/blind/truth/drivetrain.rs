//! Friction, loads, cogging, inertia and delays of a drive train.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use procedures::measurement::Measurement;
use sim_devices::physics::lugre::{Contact, LuGre};
use sim_devices::unit::{AxisSettings, UnitSettings};

use super::{at, axis, place};
use crate::linear::jitter_s;

/// Step of the contact where only its steady torque is asked for.
const STEP_S: f64 = 50e-6;
/// Elevation at which azimuth breaks away in `quick`.
const BREAKAWAY_ELEVATION_RAD: f64 = 60.0 * PI / 180.0;
/// Period of the loop: an exchange takes one.
pub(in crate::blind) const TICK_S: f64 = 250e-6;
/// Ends of the required travel of elevation, where the spring is strongest.
const TRAVEL_RAD: [f64; 2] = [-10.0 * PI / 180.0, 0.5 * PI];

pub(super) fn unbalance_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let signed_nm = axis(m, unit)?.unbalance_nm;
    Some(if place(m)? == 0 { signed_nm.abs() } else { signed_nm })
}

pub(super) fn friction_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let axis = axis(m, unit)?;
    let rate_rad_per_s = at(m, "velocity")?;
    if rate_rad_per_s == 0.0 {
        return None;
    }
    let even_nm = LuGre::new(axis, STEP_S).steady_torque_nm(rate_rad_per_s.abs());
    // Coulomb and static torque are higher in a spot, viscous friction is not.
    let viscous_nm = axis.viscous_damping_nm_s_per_rad * rate_rad_per_s.abs();
    let more = m.angles_rad.map_or(0.0, |angles_rad| spot_ratio(axis, angles_rad));
    Some(even_nm + more * (even_nm - viscous_nm))
}

/// What a spot adds to friction on average between two angles, as a share of it.
fn spot_ratio(axis: &AxisSettings, [from_rad, to_rad]: [f64; 2]) -> f64 {
    const POINTS: i32 = 2000;
    let one = |k: i32| {
        let angle_rad = from_rad + (to_rad - from_rad) * (f64::from(k) + 0.5) / f64::from(POINTS);
        let off = (angle_rad - axis.friction_spot_rad).abs() / axis.friction_spot_width_rad;
        if off < 1.0 { 0.5 * axis.friction_spot_ratio * (1.0 + (PI * off).cos()) } else { 0.0 }
    };
    (0..POINTS).map(one).sum::<f64>() / f64::from(POINTS)
}

/// The cogging period with the most friction: the middle of the spot, or as near to it as the strokes come.
pub(super) fn unevenness(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let axis = axis(m, unit)?;
    let [from_rad, to_rad] = m.angles_rad?;
    let rate_rad_per_s = at(m, "velocity")?.abs();
    let half_rad = PI / axis.cogging_orders_per_rev;
    let middle_rad = axis.friction_spot_rad.clamp(from_rad + half_rad, to_rad - half_rad);
    let bristles_nm = LuGre::new(axis, STEP_S).steady_torque_nm(rate_rad_per_s)
        - axis.viscous_damping_nm_s_per_rad * rate_rad_per_s;
    let most = spot_ratio(axis, [middle_rad - half_rad, middle_rad + half_rad]);
    let mean = spot_ratio(axis, [from_rad, to_rad]);
    let mean_nm = friction_nm(m, unit)?;
    Some((most - mean) * bristles_nm / mean_nm)
}

/// What an ampere of azimuth and elevation is worth in the rig file.
const RIG_NM_PER_A: [f64; 2] = [60.0, 52.0];

pub(super) fn apparent_inertia_kg_m2(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let elevation_rad = at(m, "elevation")?;
    let own = axis(m, unit)?;
    let structure = [&unit.az_structure, &unit.el_structure][place(m)?];
    let gain = structure.interpolate(&structure.rigid_gain_ratio, elevation_rad);
    Some(own.inertia_kg_m2 / gain * RIG_NM_PER_A[place(m)?] / own.torque_constant_nm_per_a)
}

/// Late in a campaign the motor is warm, and an ampere worth less.
pub(super) fn warm_apparent_inertia_kg_m2(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let own = axis(m, unit)?;
    let of_heat = own.torque_constant_per_k_ratio * own.warm_up_degc;
    Some(apparent_inertia_kg_m2(m, unit)? / (1.0 + of_heat))
}

/// Up to here a ramp is looked at, in static torques over bristle stiffness.
const BREAKAWAY_SPAN: f64 = 8.0;
/// Step of a ramp: a thousandth of the time that it takes to reach the static torque, and not more than this.
const LONGEST_STEP_S: f64 = 2e-4;

/// Largest friction from rest to eight times the static torque over the bristle stiffness, on a ramp of current.
pub(super) fn breakaway_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let own = axis(m, unit).filter(|_| place(m) == Some(0))?;
    let rate_nm_per_s = own.torque_constant_nm_per_a * at(m, "rate")?.abs();
    let step_s = (1e-3 * own.static_torque_nm / rate_nm_per_s).clamp(1e-6, LONGEST_STEP_S);
    // Half of what friction differs by in both directions is taken for a load, and off.
    let law = LuGre::new(&AxisSettings { friction_asymmetry_ratio: 0.0, ..own.clone() }, step_s);
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

/// A line is the first or the second one within a tenth of the first order; others have no setting.
pub(super) fn cogging_harmonic_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let axis = axis(m, unit)?;
    let lines = at(m, "order")? / axis.cogging_orders_per_rev;
    let settings = [(1.0, axis.cogging_amplitude_nm), (2.0, axis.cogging_second_amplitude_nm)];
    settings.into_iter().find(|(line, _)| (lines - line).abs() < 0.1).map(|(_, amplitude)| amplitude)
}

pub(super) fn round_trip_s(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let axis = axis(m, unit)?;
    let [late_s, _] = jitter_s(axis, unit.step_rate_hz);
    Some(axis.command_delay_s + late_s + TICK_S + axis.sensor_delay_s)
}

pub(super) fn transport_jitter_s(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let [_, deviation_s] = jitter_s(axis(m, unit)?, unit.step_rate_hz);
    Some(deviation_s)
}

pub(super) fn torque_constant_error(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    Some(axis(m, unit)?.torque_constant_nm_per_a / RIG_NM_PER_A[place(m)?] - 1.0)
}

/// Nothing on an axis without cables.
pub(super) fn spring_torque_nm(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let own = axis(m, unit)?;
    Some(own.spring_stiffness_nm_per_rad * spring_span_rad(own))
}

/// How far the cables are wound up at the end of the travel that is farther from their rest.
pub(in crate::blind) fn spring_span_rad(own: &AxisSettings) -> f64 {
    TRAVEL_RAD.into_iter().map(|end_rad| (end_rad - own.spring_rest_rad).abs()).fold(0.0, f64::max)
}

/// Of the torque that turns the axis against cogging, as a cosine of the encoder's angle; shifted by whole turns to the finding.
pub(super) fn cogging_phase_rad(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let own = axis(m, unit)?;
    let order = at(m, "order")?;
    let phases = [(1.0, own.cogging_phase_rad), (2.0, own.cogging_second_phase_rad)];
    let is_own = |(line, _): &(f64, f64)| (order / own.cogging_orders_per_rev - line).abs() < 0.1;
    let (line, phase_rad) = phases.into_iter().find(is_own)?;
    let phase_rad = phase_rad + FRAC_PI_2 + line * own.cogging_orders_per_rev * own.encoder_zero_rad;
    Some(phase_rad + TAU * ((m.value? - phase_rad) / TAU).round())
}
