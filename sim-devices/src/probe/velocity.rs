//! The velocity loop on the gyro, closed by the production controller around the simulated plant.

use controllers::AxisGains;
use controllers::velocity::VelocityController;

use super::{Multisine, Response};
use crate::physics::current_loop::CurrentLoop;
use crate::physics::delay::{DelayLine, steps};
use crate::unit::{AxisSettings, UnitSettings};
use crate::world::{StartState, World};

/// What the axis does while it is excited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// It slides at this rate, and the excitation never reverses it.
    Sliding(f64),
    /// It stands: the contact stays in presliding.
    Rest,
}

/// World steps per tick of the controller.
const STEPS_PER_TICK: usize = 5;
/// Time to reach the background rate and to forget the start.
const SETTLING_S: f64 = 4.0;
const PERIOD_S: f64 = 10.0;
/// More torque than any excitation here asks for: the loop stays linear.
const UNLIMITED_NM: f64 = 1e9;

/// One axis closed by its controller, with the delays and the current loop of the unit.
struct ClosedLoop {
    world: World,
    axis: usize,
    controller: VelocityController,
    current: CurrentLoop,
    torque_constant: f64,
    /// Torques under way, one per tick: the tick of the loop itself and the drive's delay.
    commands: DelayLine<f64>,
    rates: DelayLine<f64>,
    commanded_nm: f64,
}

impl ClosedLoop {
    fn new(unit: &UnitSettings, axis: usize, elevation_rad: f64, gains: &AxisGains) -> Self {
        let settings = if axis == 0 { &unit.az } else { &unit.el };
        let step_s = 1.0 / unit.step_rate_hz;
        let tick_s = step_s * STEPS_PER_TICK as f64;
        let start = StartState { az_rad: 0.0, el_rad: elevation_rad, heat_sink_degc: 40.0 };
        Self {
            world: World::new(unit, start),
            axis,
            controller: VelocityController::new(gains, UNLIMITED_NM, tick_s),
            current: CurrentLoop::new(settings.current_bandwidth_hz, step_s),
            torque_constant: settings.torque_constant_nm_per_a,
            commands: DelayLine::new(1 + steps(settings.command_delay_s, tick_s), 0.0),
            rates: DelayLine::new(steps(unit.imu.delay_s, tick_s), 0.0),
            commanded_nm: 0.0,
        }
    }

    /// One tick; the rate that the controller saw.
    fn tick(&mut self, command_rad_per_s: f64) -> f64 {
        let rate = self.world.motion().frame_rad_per_s[self.axis];
        let sensed = self.rates.push(rate);
        let torque = self.controller.update(command_rad_per_s, sensed, 0.0);
        self.commanded_nm = self.commands.push(torque);
        for _ in 0..STEPS_PER_TICK {
            let current_a = self.current.step(self.commanded_nm / self.torque_constant);
            self.world.axes[self.axis].step(self.torque_constant * current_a);
        }
        sensed
    }
}

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
    let mut closed = ClosedLoop::new(&unit, axis, elevation_rad, gains);
    let (bias, peak) = match background {
        Background::Sliding(rate) => (rate, 0.1 * rate),
        Background::Rest => (0.0, 1e-4),
    };
    let signal = Multisine::new(0.5, 120.0, PERIOD_S, unit.step_rate_hz / STEPS_PER_TICK as f64, peak);
    let settling = (SETTLING_S * signal.period() as f64 / PERIOD_S) as usize;
    let (mut error, mut sensed) = (Vec::new(), Vec::new());
    for k in 0..settling + signal.period() {
        let command = bias + signal.at(k);
        let rate = closed.tick(command);
        if k >= settling {
            error.push(command - rate);
            sensed.push(rate);
        }
    }
    let (errors, rates) = (signal.spectrum(&error), signal.spectrum(&sensed));
    let value = rates.iter().zip(&errors).map(|(rate, error)| rate / error).collect();
    Response { frequency_hz: signal.frequencies_hz(), value }
}

/// Structure frozen, loads off, stops out of reach.
fn bare(unit: &UnitSettings, elevation_rad: f64) -> UnitSettings {
    let mut unit = unit.clone();
    unit.az_structure = unit.az_structure.frozen_at(elevation_rad);
    unit.el_structure = unit.el_structure.frozen_at(elevation_rad);
    [&mut unit.az, &mut unit.el].into_iter().for_each(unload);
    unit
}

fn unload(axis: &mut AxisSettings) {
    (axis.unbalance_nm, axis.spring_stiffness_nm_per_rad) = (0.0, 0.0);
    (axis.cogging_amplitude_nm, axis.cogging_second_amplitude_nm) = (0.0, 0.0);
    (axis.lower_stop_rad, axis.upper_stop_rad) = (-100.0, 100.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::{Sensor, VelocityLoop, margins};

    const EL: AxisGains = AxisGains {
        velocity_kp_nm_s_per_rad: 18_250.0,
        velocity_ki_nm_per_rad: 361_400.0,
        position_gain_per_s: 4.5,
    };
    const AZ: AxisGains = AxisGains {
        velocity_kp_nm_s_per_rad: 23_600.0,
        velocity_ki_nm_per_rad: 447_500.0,
        position_gain_per_s: 4.5,
    };

    #[test]
    fn sliding_the_loop_shows_the_margins_of_the_linear_model() {
        let unit = UnitSettings::default();
        for (axis, gains, rate, el_deg) in [(0, AZ, 0.3, 20.0_f64), (1, EL, 0.06, 45.0)] {
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
        for (axis, gains, expected_deg) in [(0, AZ, 82.6), (1, EL, 66.7)] {
            let seen = measured_velocity_loop(&unit, axis, 0.0, &gains, Background::Rest);
            let seen = margins(|hz| seen.at(hz), 0.6, 110.0).expect("it crosses 0 dB");
            assert!((seen.phase_margin_deg - expected_deg).abs() < 3.0, "{seen:?}");
        }
    }
}
