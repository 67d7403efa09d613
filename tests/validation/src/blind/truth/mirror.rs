//! Mirror, cameras and the fine loop.

use std::f64::consts::TAU;

use num_complex::Complex64;
use procedures::measurement::Measurement;
use sim_devices::physics::piezo::{Circuit, CircuitValues};
use sim_devices::unit::{CameraSettings, UnitSettings};

use super::{at, place};
use crate::prediction;

/// Where the capacitance of the mirror is stated.
const CAPACITANCE_HZ: f64 = 20.0;

pub(super) fn mode_departure(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let own = place(m)?;
    Some(unit.mirror.frequency_hz[own] / prediction::MIRROR_MODES_HZ[own] - 1.0)
}

pub(super) fn stroke_rad(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    Some(prediction::mirror_stroke_rad(&unit.mirror, place(m)?))
}

/// What the mirror makes of the command counts as optics.
pub(super) fn optical_gain_departure(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    Some(prediction::optical_gain_departure(unit, place(m)?, at(m, "amplitude")?))
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
pub(super) fn capacitance_f(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    let circuit = Circuit::new(&circuit(m, unit)?);
    Some(-1.0 / (TAU * CAPACITANCE_HZ * circuit.impedance(CAPACITANCE_HZ).reactance_ohm))
}

/// C_1/(C_0 + C_1) with the clamped capacitance C_0 at the series resonance: the circuit without its motion.
pub(super) fn coupling_ratio(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
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

/// The point's name says which tracker it was.
pub(super) fn tracker_latency_s(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    camera(m, unit).map(CameraSettings::mean_latency_s)
}

pub(super) fn tracker_jitter_s(m: &Measurement, unit: &UnitSettings) -> Option<f64> {
    camera(m, unit).map(|camera| camera.latency_spread_s / 12.0_f64.sqrt())
}

/// The camera that the point names.
fn camera<'a>(m: &Measurement, unit: &'a UnitSettings) -> Option<&'a CameraSettings> {
    let point = m.point.as_deref()?;
    let cameras = [("coarse tracker", &unit.trackers.coarse), ("fine tracker", &unit.trackers.fine)];
    cameras.into_iter().find(|(name, _)| *name == point).map(|(_, camera)| camera)
}
