//! A rotary table as the plant of its bus: axes that do not act on each other, and the supply that they share.

use std::collections::BTreeMap;

use crate::bus::{BusSettings, DcLink, Plant, Station, VirtualBus};
use crate::cia402::Drive;
use crate::physics::noise::SeedAddress;
use crate::unit::TableSettings;
use crate::world::UncoupledAxes;

/// Serial number of the drive of the first axis; the others follow.
const FIRST_SERIAL: u32 = 2001;

/// Axes and supply.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) world: UncoupledAxes,
    dc_link: DcLink,
}

/// The bus of all drives of a table, station 1 the first axis.
pub(crate) type TableBus = VirtualBus<Table>;

impl TableBus {
    /// A table at rest with its heat sinks as warm as the plan has them, drives switched on but not enabled. An axis that `start_rad` does
    /// not name stands at 0.
    pub(crate) fn of_table(
        table: &TableSettings,
        address: &SeedAddress,
        start_rad: &BTreeMap<String, f64>,
    ) -> Self {
        let step_s = 1.0 / table.step_rate_hz;
        let mut world = UncoupledAxes::new(step_s);
        let mut stations = Vec::with_capacity(table.axes.len());
        for (serial, axis) in (FIRST_SERIAL..).zip(&table.axes) {
            let settings = &axis.settings;
            let angle_rad = start_rad.get(&axis.name).copied().unwrap_or(0.0);
            world.add(&axis.name, settings, angle_rad);
            let heat_sink_degc = settings.ambient_degc + settings.warmed_degc(table.planned_s);
            let drive = Drive::new(&axis.name, serial, settings, address, angle_rad, heat_sink_degc, step_s);
            stations.push(Station::new(drive, settings, table.claimed_vendor()));
        }
        let dc_link = DcLink::new(&table.supply, step_s, &mut stations);
        let settings = BusSettings {
            step_rate_hz: table.step_rate_hz,
            dropped_cycles_ratio: table.dropped_cycles_ratio,
        };
        Self::new(Table { world, dc_link }, stations, settings, address)
    }
}

impl Plant for Table {
    type Stations = Vec<Station>;

    #[inline]
    fn step(&mut self, step: u64, stations: &mut Vec<Station>) {
        for (station, axis) in stations.iter_mut().zip(self.world.axes_mut()) {
            let effort = station.work(step, axis.angle_rad(), axis.velocity_rad_per_s());
            axis.step(effort.torque_nm);
            self.dc_link.draw(effort.drawn_w);
        }
        self.world.end_step();
        self.dc_link.end_step(step, stations);
    }

    #[inline]
    fn shaft_rad(&self, drive: usize) -> f64 {
        self.world.angle_rad(drive)
    }

    fn lose_mains(&mut self) {
        self.dc_link.lose_mains();
    }
}
