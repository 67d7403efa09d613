//! The fast steering mirror on its serial line and the analog card, and what else is wired to the card with it.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::mirror::{self, MirrorSettings};

use super::bystanders::Bystanders;
use crate::model::device::BystanderSettings;
use crate::rig::device::{Device, Group, Ports, SteeringMirror};

/// The mirror, and the last of what it was told and showed.
pub(super) struct Mirror {
    settings: MirrorSettings,
    port: String,
    card_port: String,
    line: usize,
    card: usize,
    driver: Option<mirror::Mirror>,
    bystanders: Option<Bystanders>,
    command_rad: [f64; 2],
    actuals: mirror::Actuals,
}

impl Mirror {
    /// On ports that are not open yet.
    pub(super) fn closed(
        settings: MirrorSettings,
        bystanders: Option<BystanderSettings>,
        port: &str,
        card_port: &str,
    ) -> Self {
        Self {
            settings,
            port: port.to_owned(),
            card_port: card_port.to_owned(),
            line: 0,
            card: 0,
            driver: None,
            bystanders: bystanders.map(Bystanders::new),
            command_rad: [0.0; 2],
            actuals: mirror::Actuals::default(),
        }
    }
}

impl Device for Mirror {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        let driver = match &mut self.driver {
            Some(driver) => driver,
            None => {
                self.line = ports.find_line(&self.settings.name, &self.port)?;
                self.card = ports.find_card(&self.settings.name, &self.card_port)?;
                self.driver.insert(mirror::Mirror::new(self.settings.clone())?)
            }
        };
        Ok(driver.configure(ports.line(self.line), now)?.map(|_| ()))
    }

    fn identity(&self) -> Option<String> {
        self.driver.as_ref().map(|_| "CCBu40 servo, analog and serial channel".to_owned())
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let Some(driver) = &mut self.driver else { return Ok(()) };
        let (line, card) = ports.line_and_card(self.line, self.card);
        self.actuals = driver.exchange(line, card, self.command_rad, now)?;
        match &mut self.bystanders {
            Some(bystanders) => bystanders.exchange(card, now),
            None => Ok(()),
        }
    }

    fn group(&self) -> Group {
        Group { topic: "fsm", message: "Mirror", channels: Bystanders::MIRROR_CHANNELS }
    }

    fn row(&mut self, row: &mut [f64]) {
        let own = self.actuals.row();
        let seen = self.bystanders.as_ref().map_or([0.0; 4], Bystanders::row);
        row[..own.len()].copy_from_slice(&own);
        row[own.len()..own.len() + seen.len()].copy_from_slice(&seen);
    }

    fn mirror(&mut self) -> Option<&mut dyn SteeringMirror> {
        Some(self)
    }
}

impl SteeringMirror for Mirror {
    fn angle_rad(&self) -> [f64; 2] {
        self.actuals.angle_rad
    }

    fn command(&mut self, command_rad: [f64; 2]) {
        self.command_rad = command_rad;
    }

    fn synchronise(&mut self, ports: &mut Ports, now: Duration, high: bool) -> Result<(), DeviceError> {
        match &mut self.bystanders {
            Some(bystanders) => bystanders.synchronise(ports.card(self.card), now, high),
            None => Ok(()),
        }
    }
}
