//! The DC link that feeds all drives of a bus.

use super::Station;
use crate::physics::supply::Supply;
use crate::unit::SupplySettings;

/// Steps of the world between two looks at the DC link: 5 kHz at 20 kHz, against time constants of milliseconds.
const SUPPLY_STEPS: u64 = 4;

/// Supply, and what the drives drew since the last look at it.
#[derive(Debug)]
pub(crate) struct DcLink {
    supply: Supply,
    drawn_w: f64,
}

impl DcLink {
    /// A charged link in a world with steps of this width; the drives are told its voltage.
    pub(crate) fn new(settings: &SupplySettings, world_step_s: f64, stations: &mut [Station]) -> Self {
        stations.iter_mut().for_each(|station| station.drive.set_dc_link_v(settings.open_voltage_v));
        Self { supply: Supply::new(settings, SUPPLY_STEPS as f64 * world_step_s), drawn_w: 0.0 }
    }

    /// A drive draws this over a step of the world.
    #[inline]
    pub(crate) fn draw(&mut self, power_w: f64) {
        self.drawn_w += power_w;
    }

    /// A step of the world is over.
    #[inline]
    pub(crate) fn end_step(&mut self, step: u64, stations: &mut [Station]) {
        if step % SUPPLY_STEPS == SUPPLY_STEPS - 1 {
            let volts = self.supply.step(self.drawn_w / SUPPLY_STEPS as f64);
            self.drawn_w = 0.0;
            stations.iter_mut().for_each(|station| station.drive.set_dc_link_v(volts));
        }
    }

    /// Currents in the leads of the link over the last step of the supply: supply, shunt.
    pub(crate) fn currents_a(&self) -> [f64; 2] {
        let shunt_a = self.supply.shunt_w() / self.supply.bus_v().max(1.0);
        [self.supply.supply_a(), shunt_a]
    }

    /// The mains are gone.
    pub(crate) fn lose_mains(&mut self) {
        self.supply.lose_mains();
    }
}
