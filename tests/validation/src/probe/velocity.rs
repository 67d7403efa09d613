//! The velocity loop on the gyro, closed by the production controller around the simulated plant.

use controllers::AxisGains;
use sim_devices::unit::UnitSettings;

use super::closed_loop::{ClosedLoop, TICK_RATE_HZ, bare};
use super::{Multisine, Response, UNLIMITED};

/// What the axis does while it is excited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// It slides at this rate, and the excitation never reverses it.
    Sliding(f64),
    /// It stands: the contact stays in presliding.
    Rest,
}

/// Time to reach the background rate and to forget the start.
const SETTLING_S: f64 = 4.0;
const PERIOD_S: f64 = 10.0;

/// Open velocity loop of an axis at an elevation, as measured: sensed rate over error while the command is excited.
///
/// The structure is frozen at that elevation and the loads (cogging, unbalance, spring) are switched off, so what
/// remains is what the linear model holds, plus friction and everything in the time domain.
pub fn measured_velocity_loop(
    unit: &UnitSettings,
    axis: usize,
    elevation_rad: f64,
    gains: &AxisGains,
    background: Background,
) -> Response {
    let unit = bare(unit, elevation_rad);
    let mut closed = ClosedLoop::new(&unit, axis, elevation_rad, gains, UNLIMITED);
    let (bias, peak) = match background {
        Background::Sliding(rate) => (rate, 0.1 * rate),
        Background::Rest => (0.0, 1e-4),
    };
    let signal = Multisine::new(0.5, 120.0, PERIOD_S, TICK_RATE_HZ, peak);
    let settling = (SETTLING_S * signal.period() as f64 / PERIOD_S) as usize;
    let mut error = Vec::new();
    let mut sensed = Vec::new();
    for k in 0..settling + signal.period() {
        let command = bias + signal.at(k);
        let rate = closed.tick(command);
        if k >= settling {
            error.push(command - rate);
            sensed.push(rate);
        }
    }
    let errors = signal.spectrum(&error);
    let rates = signal.spectrum(&sensed);
    let value = rates.iter().zip(&errors).map(|(rate, error)| rate / error).collect();
    Response { frequency_hz: signal.frequencies_hz(), value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::{Sensor, VelocityLoop, margins};
    use crate::probe::study_gains;

    #[test]
    fn sliding_the_loop_shows_the_margins_of_the_linear_model() {
        let unit = UnitSettings::default();
        for (axis, gains, rate, el_deg) in
            [(0, study_gains(0), 0.3, 20.0_f64), (1, study_gains(1), 0.06, 45.0)]
        {
            let elevation_rad = el_deg.to_radians();
            let seen = measured_velocity_loop(&unit, axis, elevation_rad, &gains, Background::Sliding(rate));
            let seen = margins(|hz| seen.at(hz), 0.6, 110.0).expect("it crosses 0 dB");
            let model = VelocityLoop::new(&unit, axis, elevation_rad, Sensor::Gyro, &gains, 4000.0);
            let model = margins(|hz| model.open(hz), 0.6, 110.0).expect("it crosses 0 dB");
            assert!((seen.bandwidth_hz - model.bandwidth_hz).abs() < 0.03, "{seen:?} {model:?}");
            assert!((seen.phase_margin_deg - model.phase_margin_deg).abs() < 0.3, "{seen:?} {model:?}");
            assert!((seen.gain_margin_db - model.gain_margin_db).abs() < 0.1, "{seen:?} {model:?}");
        }
    }

    /// modes.md §4: at rest the same loops at 0° show 66.7° (elevation) and 82.6° (azimuth).
    #[test]
    fn from_rest_the_same_loops_show_a_much_larger_phase_margin() {
        let unit = UnitSettings::default();
        for (axis, gains, expected_deg) in [(0, study_gains(0), 82.6), (1, study_gains(1), 66.7)] {
            let seen = measured_velocity_loop(&unit, axis, 0.0, &gains, Background::Rest);
            let seen = margins(|hz| seen.at(hz), 0.6, 110.0).expect("it crosses 0 dB");
            assert!((seen.phase_margin_deg - expected_deg).abs() < 3.0, "{seen:?}");
        }
    }
}
