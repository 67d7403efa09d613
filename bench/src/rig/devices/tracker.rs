//! A tracker on its datagram port, and the rows of the loops that are closed on trackers.

use std::time::Duration;

use drivers::device::DeviceError;
use drivers::tracker::{self, Source, TrackerSettings};

use crate::rig::device::{Device, Group, LookedAt, Ports};

/// A tracker and its newest sample.
pub(super) struct Tracker {
    settings: TrackerSettings,
    port: String,
    socket: usize,
    driver: Option<tracker::Tracker>,
    newest: tracker::Actuals,
    start: Duration,
}

impl Tracker {
    /// On a port that is not open yet.
    pub(super) fn closed(settings: TrackerSettings, port: &str) -> Self {
        Self {
            settings,
            port: port.to_owned(),
            socket: 0,
            driver: None,
            newest: tracker::Actuals::default(),
            start: Duration::ZERO,
        }
    }
}

impl Device for Tracker {
    fn name(&self) -> &str {
        &self.settings.name
    }

    fn open(&mut self, ports: &mut Ports, _now: Duration) -> Result<Option<()>, DeviceError> {
        self.socket = ports.find_socket(&self.settings.name, &self.port)?;
        self.driver = Some(tracker::Tracker::new(self.settings.clone())?);
        Ok(Some(()))
    }

    fn start_of_ticks(&mut self, start: Duration) {
        self.start = start;
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        if let Some(driver) = &mut self.driver {
            self.newest = driver.poll(ports.socket(self.socket), now)?.0;
        }
        Ok(())
    }

    fn group(&self) -> Group {
        let topic = match self.settings.source {
            Source::Coarse => "coarse",
            Source::Fine => "fine",
        };
        Group { topic, message: "Tracker", channels: tracker::Tracker::CHANNELS }
    }

    fn is_looked_at(&self, looked_at: LookedAt) -> bool {
        looked_at.trackers
    }

    /// Exposures are told from the start of the loop on, as the log's own time is.
    fn row(&mut self, row: &mut [f64]) {
        let exposure = self.newest.exposure.saturating_sub(self.start);
        let values = tracker::Actuals { exposure, ..self.newest }.row();
        row[..values.len()].copy_from_slice(&values);
    }

    fn tracker(&self) -> Option<(Source, &tracker::Actuals)> {
        Some((self.settings.source, &self.newest))
    }
}
