//! One axis of the simulated plant, closed by the production velocity controller on the gyro.

use controllers::AxisGains;
use controllers::velocity::VelocityController;
use sim_devices::motion::Motion;
use sim_devices::physics::current_loop::CurrentLoop;
use sim_devices::physics::delay::{DelayLine, steps};
use sim_devices::unit::{AxisSettings, UnitSettings};
use sim_devices::world::{StartState, World};

/// Rate of the control computer.
pub(super) const TICK_RATE_HZ: f64 = 4000.0;

/// One axis closed by its controller, with the delays and the current loop of the unit.
pub(super) struct ClosedLoop {
    world: World,
    axis: usize,
    controller: VelocityController,
    current: CurrentLoop,
    torque_constant: f64,
    /// Torques under way: in the tick of the loop itself, and in the drive, step by step.
    commands: DelayLine<f64>,
    arriving: DelayLine<f64>,
    rates: DelayLine<f64>,
    angles: DelayLine<f64>,
    steps_per_tick: usize,
}

impl ClosedLoop {
    pub(super) fn new(
        unit: &UnitSettings,
        axis: usize,
        elevation_rad: f64,
        gains: &AxisGains,
        torque_limit_nm: f64,
    ) -> Self {
        let settings = unit.axis(axis);
        let step_s = 1.0 / unit.step_rate_hz;
        let tick_s = 1.0 / TICK_RATE_HZ;
        let angle_rad = if axis == 0 { 0.0 } else { elevation_rad };
        let start = StartState { az_rad: 0.0, el_rad: elevation_rad, heat_sink_degc: 40.0 };
        Self {
            world: World::new(unit, start),
            axis,
            controller: VelocityController::new(gains, torque_limit_nm, tick_s),
            current: CurrentLoop::new(settings.current_bandwidth_hz, step_s),
            torque_constant: settings.torque_constant_nm_per_a,
            commands: DelayLine::new(1, 0.0),
            arriving: DelayLine::new(steps(settings.command_delay_s, step_s), 0.0),
            rates: DelayLine::new(steps(unit.imu.delay_s + 1.5 * tick_s, tick_s), 0.0),
            angles: DelayLine::new(steps(settings.sensor_delay_s, tick_s), angle_rad),
            steps_per_tick: steps(tick_s, step_s),
        }
    }

    /// One tick; the rate that the controller saw.
    pub(super) fn tick(&mut self, command_rad_per_s: f64) -> f64 {
        let sensed = self.sensed_rate();
        self.drive(command_rad_per_s, sensed);
        sensed
    }

    /// First half of a tick: the rate as the controllers see it; called once a tick.
    pub(super) fn sensed_rate(&mut self) -> f64 {
        self.rates.push(self.world.motion().frame_rad_per_s[self.axis])
    }

    /// Second half: the command to that rate, and the world until the next tick.
    pub(super) fn drive(&mut self, command_rad_per_s: f64, sensed_rad_per_s: f64) {
        let torque = self.controller.update(command_rad_per_s, sensed_rad_per_s, 0.0);
        let command_a = self.commands.push(torque) / self.torque_constant;
        for _ in 0..self.steps_per_tick {
            let current_a = self.current.step(self.arriving.push(command_a));
            self.world.axes[self.axis].step(self.torque_constant * current_a);
        }
    }

    /// Angle of the shaft as the controller sees it in the coming tick; called once a tick.
    pub(super) fn sensed_angle_rad(&mut self) -> f64 {
        self.angles.push(self.world.axes[self.axis].angle_rad())
    }

    /// True angles and rates.
    pub(super) fn motion(&self) -> Motion {
        self.world.motion()
    }
}

/// Structure frozen, loads off, stops out of reach.
pub(super) fn bare(unit: &UnitSettings, elevation_rad: f64) -> UnitSettings {
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
