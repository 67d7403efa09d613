//! An instrument on a line of its own: what it takes for any driver that speaks SCPI.

use std::sync::Arc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::scpi;
use procedures::device::Task;

use crate::model::device::DeviceEntry;
use crate::rig::device::Group;
use crate::rig::instruments::{Instrument, Measuring};
use crate::rig::wires::Ports;

/// Time allowed for an answer of an instrument on the network.
pub(super) const ANSWER_TIMEOUT_S: f64 = 2.0;

/// A driver as the bench uses it.
pub(super) trait LineDriver: scpi::Instrument + Clone + Send + 'static {
    /// What it must know of the instrument.
    type Settings: Clone + Send;

    /// What it adds to the log.
    const GROUP: Group;

    /// A driver that has not spoken to its instrument yet.
    fn with(settings: Self::Settings) -> Result<Self, DeviceError>;

    /// Readies it for a task on an axis; `false` where the task is for another sort of instrument.
    fn prepare_for(&mut self, task: &Task, axis: usize) -> Result<bool, DeviceError>;

    /// Whether it waits for the edge of the synchronisation signal.
    fn awaits_edge(&self) -> bool {
        false
    }

    /// Rows that it measured.
    fn rows_count(&self) -> usize;

    /// Hands a row on; a hole is passed over.
    fn row_to(&self, row: usize, each: &mut dyn FnMut(&[f64]));

    /// What to say of it when its time is over.
    fn when_late(&self) -> &'static str;
}

/// An instrument on its line.
#[derive(Clone)]
pub(super) struct OnLine<D: LineDriver> {
    /// Shared with the copies that measure: every point takes one.
    name: Arc<str>,
    settings: D::Settings,
    port: Arc<str>,
    line: usize,
    driver: Option<D>,
}

impl<D: LineDriver> OnLine<D> {
    /// The instrument of this entry, before anything was said to it.
    pub(super) fn closed(entry: &DeviceEntry, settings: D::Settings) -> Self {
        let (name, port) = (entry.name.as_str().into(), entry.port("line").into());
        Self { name, settings, port, line: 0, driver: None }
    }

    fn driver(&mut self) -> Result<&mut D, DeviceError> {
        if self.driver.is_none() {
            self.driver = Some(D::with(self.settings.clone())?);
        }
        Ok(self.driver.as_mut().expect("made just now"))
    }
}

impl<D: LineDriver> Instrument for OnLine<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn group(&self) -> Group {
        D::GROUP
    }

    fn identify(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<String>, DeviceError> {
        self.line = ports.find_line(&self.name, &self.port)?;
        let line = self.line;
        let identity = self.driver()?.identify(ports.line(line), now)?;
        Ok(identity.map(|identity| identity.to_string()))
    }

    fn ready(&self, task: &Task, axis: usize) -> Result<Option<Box<dyn Measuring + Send>>, DeviceError> {
        let mut own = self.clone();
        Ok(if own.driver()?.prepare_for(task, axis)? { Some(Box::new(own)) } else { None })
    }

    fn copy(&self) -> Box<dyn Instrument + Send> {
        Box::new(self.clone())
    }
}

impl<D: LineDriver> Measuring for OnLine<D> {
    fn start(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let line = self.line;
        self.driver()?.start(ports.line(line), now)
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<bool, DeviceError> {
        let line = self.line;
        self.driver()?.poll(ports.line(line), now)
    }

    fn abort(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let line = self.line;
        self.driver()?.abort(ports.line(line), now)
    }

    fn awaits_edge(&self) -> bool {
        self.driver.as_ref().is_some_and(D::awaits_edge)
    }

    fn rows_count(&self) -> usize {
        self.driver.as_ref().map_or(0, D::rows_count)
    }

    fn row(&self, row: usize, each: &mut dyn FnMut(&[f64])) {
        if let Some(driver) = &self.driver {
            driver.row_to(row, each);
        }
    }

    fn when_late(&self) -> &'static str {
        self.driver.as_ref().map_or("it was not started", D::when_late)
    }
}
