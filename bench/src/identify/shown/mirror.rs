//! Mirror, cameras and optics.

use std::f64::consts::TAU;

use sim_devices::physics::piezo::{Circuit, CircuitValues};

use super::Shown;

/// Where the capacitance of the mirror is stated.
const CAPACITANCE_HZ: f64 = 20.0;

fn circuit(s: &Shown<'_>) -> Option<CircuitValues> {
    let mirror = &s.unit.mirror;
    Some(CircuitValues {
        capacitance_f: mirror.capacitance_f,
        coupling_ratio: mirror.coupling_ratio,
        loss_tangent_ratio: mirror.loss_tangent_ratio,
        frequency_hz: mirror.frequency_hz[s.place()?],
        damping_ratio: mirror.bare_damping_ratio,
        series_ohm: mirror.series_resistance_ohm,
        leak_ohm: mirror.leak_resistance_ohm,
    })
}

/// −1/(ωX) at the terminals.
pub(in crate::identify) fn capacitance_f(s: &Shown<'_>) -> Option<f64> {
    let circuit = Circuit::new(&circuit(s)?);
    Some(-1.0 / (TAU * CAPACITANCE_HZ * circuit.impedance(CAPACITANCE_HZ).reactance_ohm))
}

/// C_1/(C_0 + C_1) with the clamped capacitance C_0 at the series resonance: the circuit without its motion.
pub(in crate::identify) fn coupling_ratio(s: &Shown<'_>) -> Option<f64> {
    let values = circuit(s)?;
    let motional_f = values.coupling_ratio * values.capacitance_f;
    let clamped = CircuitValues {
        capacitance_f: values.capacitance_f - motional_f,
        coupling_ratio: 0.0,
        series_ohm: 0.0,
        ..values
    };
    let there = Circuit::new(&clamped).impedance(values.frequency_hz);
    let squared = there.resistance_ohm.powi(2) + there.reactance_ohm.powi(2);
    let clamped_f = -there.reactance_ohm / squared / (TAU * values.frequency_hz);
    Some(motional_f / (clamped_f + motional_f))
}

/// Of the camera that the point names, on average over its messages.
pub(in crate::identify) fn tracker_latency_s(s: &Shown<'_>) -> Option<f64> {
    let camera = match s.finding.measurement.point.as_deref()? {
        "coarse tracker" => &s.unit.trackers.coarse,
        "fine tracker" => &s.unit.trackers.fine,
        _ => return None,
    };
    Some(camera.mean_latency_s())
}

/// Azimuth's is that across elevation.
pub(in crate::identify) fn optical_gain_ratio(s: &Shown<'_>) -> Option<f64> {
    let trackers = &s.unit.trackers;
    Some([trackers.optical_gain_cross_elevation_ratio, trackers.optical_gain_elevation_ratio][s.place()?])
}
