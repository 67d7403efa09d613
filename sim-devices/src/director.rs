//! The director as the plant of its bus: both axes and their structure, payload, supply and instruments.

mod card;

use std::time::Duration;

use crate::analog_card::AnalogChannels;
use crate::analyser::Analyser;
use crate::bus::{BusSettings, DcLink, Plant, Station, VirtualBus};
use crate::cia402::Drive;
use crate::operator::{Operator, PullSettings};
use crate::payload::{DeviceTypes, Imu, Payload};
use crate::physics::noise::SeedAddress;
use crate::scene::SceneTruth;
use crate::scope::Scope;
use crate::supply::Supply;
use crate::unit::UnitSettings;
use crate::world::{AXIS_NAMES, AxesTruth, StartState, World, WorldRecord};

/// Instruments on the bench.
#[derive(Debug)]
pub(crate) struct Instruments {
    pub(crate) analyser: Analyser,
    pub(crate) scope: Scope,
    pub(crate) supply: Supply,
    pub(crate) channels: AnalogChannels,
}

/// World, payload, supply and instruments.
#[derive(Debug)]
pub(crate) struct Director {
    world: World,
    pub(crate) payload: Payload,
    pub(crate) instruments: Instruments,
    /// Somebody who pulls at an axis.
    operator: Option<Operator>,
    dc_link: DcLink,
    /// Which axis each drive turns.
    axis_of_drive: [usize; 2],
    step_rate_hz: f64,
}

/// The bus of both drives: station 1 azimuth, station 2 elevation.
pub(crate) type DirectorBus = VirtualBus<Director>;

impl DirectorBus {
    /// A unit at rest, both drives switched on but not enabled, exchanged with at `sync_rate_hz`.
    pub(crate) fn of_director(
        unit: &UnitSettings,
        address: &SeedAddress,
        start: StartState,
        sync_rate_hz: f64,
        types: DeviceTypes,
    ) -> Self {
        let step_s = 1.0 / unit.step_rate_hz;
        let world = World::new(unit, start);
        let axis_of_drive = if unit.wiring.axes_swapped() { [1, 0] } else { [0, 1] };
        let mut stations = [0, 1].map(|k| {
            let settings = [&unit.az, &unit.el][k];
            let serial = [1001, 1002][k];
            let angle_rad = world.axes[axis_of_drive[k]].angle_rad();
            let heat_sink_degc = start.heat_sink_degc + settings.warmed_degc(unit.planned_s);
            let drive =
                Drive::new(AXIS_NAMES[k], serial, settings, address, angle_rad, heat_sink_degc, step_s);
            Station::new(drive, settings, unit.wiring.claimed_vendor())
        });
        let payload = Payload::new(types, unit, address, world.frame(), sync_rate_hz);
        let plant = Director {
            instruments: Instruments {
                analyser: Analyser::new(&unit.instruments, address, payload.mirror.mirror()),
                scope: Scope::new(unit, address),
                supply: Supply::new(&unit.instruments, address),
                channels: AnalogChannels::new(&unit.instruments, address, sync_rate_hz),
            },
            payload,
            world,
            operator: unit.pull.map(Operator::new),
            dc_link: DcLink::new(&unit.supply, step_s, &mut stations),
            axis_of_drive,
            step_rate_hz: unit.step_rate_hz,
        };
        let settings = BusSettings {
            step_rate_hz: unit.step_rate_hz,
            dropped_cycles_ratio: unit.wiring.dropped_cycles_ratio,
        };
        Self::new(plant, stations, settings, address)
    }

    /// What the cameras look at as it really is, and the true angles of the mirror, at the last instant.
    pub(crate) fn truth(&mut self) -> (SceneTruth, [f64; 2]) {
        let now = self.now();
        let director = &mut self.plant;
        let motion = director.world.motion();
        let mirror_rad = director.payload.mirror.mirror().angle_rad();
        (director.payload.scene.truth(now, &motion, mirror_rad), mirror_rad)
    }
}

impl Director {
    pub(crate) fn record(&self) -> WorldRecord {
        self.world.record()
    }

    /// See [`crate::rig::SimulatedRig::bring`].
    pub(crate) fn bring(&mut self, unit: &UnitSettings, address: &SeedAddress, now: Duration) {
        let begins_s =
            |pull: PullSettings| PullSettings { begins_s: now.as_secs_f64() + pull.begins_s, ..pull };
        self.operator = unit.pull.map(begins_s).map(Operator::new);
        self.payload.scene.bring(unit, address, now);
    }

    /// Where both axes really are, at the last instant.
    pub(crate) fn truth_of_axes(&self) -> AxesTruth {
        self.world.truth()
    }

    /// Currents in the leads of the DC link over the last step of the supply: supply, shunt.
    pub(crate) fn dc_link_a(&self) -> [f64; 2] {
        self.dc_link.currents_a()
    }

    /// Torque with which somebody pulls now.
    pub(crate) fn pulled_nm(&self) -> f64 {
        self.operator.as_ref().map_or(0.0, Operator::torque_nm)
    }
}

impl Plant for Director {
    type Stations = [Station; 2];

    #[inline]
    fn step(&mut self, step: u64, stations: &mut [Station; 2]) {
        let mut motor_nm = [0.0; 2];
        for (k, station) in stations.iter_mut().enumerate() {
            let axis = self.axis_of_drive[k];
            let turning = &self.world.axes[axis];
            let effort = station.work(step, turning.angle_rad(), turning.velocity_rad_per_s());
            motor_nm[axis] = effort.torque_nm;
            self.dc_link.draw(effort.drawn_w);
        }
        if self.instruments.scope.observes() {
            self.instruments.scope.observe(step, [0, 1].map(|k| stations[k].drive.current_course()));
        }
        if let Some(operator) = &mut self.operator {
            let axis = operator.axis();
            let turning = &self.world.axes[axis];
            let now_s = step as f64 / self.step_rate_hz;
            motor_nm[axis] += operator.pull_nm(now_s, turning.angle_rad(), turning.velocity_rad_per_s());
        }
        self.world.step(motor_nm);
        self.payload.step(step, self.world.frame());
        self.dc_link.end_step(step, stations);
    }

    #[inline]
    fn shaft_rad(&self, drive: usize) -> f64 {
        self.world.axes[self.axis_of_drive[drive]].angle_rad()
    }

    fn reach(&mut self, now: Duration) {
        self.payload.look(now);
    }

    fn pulse(&mut self, now: Duration) {
        self.payload.pulse(now);
    }

    fn trigger(&mut self, now: Duration) {
        self.payload.trigger(now);
    }

    fn lose_mains(&mut self) {
        self.dc_link.lose_mains();
    }

    fn imu(&mut self) -> Option<&mut Imu> {
        Some(&mut self.payload.imu)
    }

    fn write_v(&mut self, now: Duration, output: usize, volts: f64) -> bool {
        self.take_v(now, output, volts)
    }

    fn read_v(&mut self, now: Duration, input: usize) -> Option<f64> {
        self.give_v(now, input)
    }
}
