//! The temperature of a heat sink that a drive tells by SDO alone: read once a second while the drive is in operation.

use std::time::Duration;

use super::objects::Object;
use super::profile::HeatSink;
use super::sdo::{Dictionary, Transfer, number};
use super::{Cia402, HEAT_SINK};
use crate::device::DeviceError;
use crate::wire::{SdoRequest, SdoWire};

/// From one reading to the next: a heat sink has time constants of minutes.
const PERIOD: Duration = Duration::from_secs(1);
/// After so long without an answer the temperature is not known.
const STALE: Duration = Duration::from_secs(10);

/// A temperature that is read by SDO.
#[derive(Clone, Debug)]
pub(super) struct SdoHeatSink {
    object: Object,
    counts_per_degc: f64,
    degc: f64,
    read_at: Duration,
    next_at: Duration,
    transfer: Transfer,
    is_under_way: bool,
}

impl SdoHeatSink {
    /// Reads it for the first time.
    ///
    /// # Errors
    /// When the drive lacks the object, or has it in another width.
    pub(super) fn read(drive: &mut Dictionary<'_, '_>, from: HeatSink) -> Result<Self, DeviceError> {
        let object = from.place.object(HEAT_SINK, from.data_type, "");
        let counts_per_degc = from.counts_per_degc;
        let degc = drive.read(object)? as f64 / counts_per_degc;
        let read_at = drive.waiting.now;
        let next_at = read_at + PERIOD;
        let transfer = Transfer::default();
        Ok(Self { object, counts_per_degc, degc, read_at, next_at, transfer, is_under_way: false })
    }

    /// The last reading; not a number where that is too old.
    pub(super) fn degc(&self) -> f64 {
        self.degc
    }

    fn poll(&mut self, wire: &mut dyn SdoWire, now: Duration) {
        match self.transfer.poll(wire, now) {
            Ok(None) => return,
            Ok(Some(answer)) => {
                if let Some(counts) = number(self.object.data_type, answer) {
                    self.degc = counts as f64 / self.counts_per_degc;
                    self.read_at = now;
                }
            }
            // The next reading may succeed; until then the age of the last one counts.
            Err(_) => {}
        }
        self.is_under_way = false;
    }

    fn start(&mut self, station: u16, wire: &mut dyn SdoWire, now: Duration) {
        let Object { index, sub, .. } = self.object;
        self.transfer.start(wire, now, &SdoRequest { station, index, sub, write: None });
        self.is_under_way = true;
        self.next_at = now + PERIOD;
    }
}

impl Cia402 {
    /// Goes on with a reading of the heat sink that is under way, or begins one that is due where it `may_start`; whether one
    /// is under way now. Several drives on one bus do it one after the other, and nothing else is transferred meanwhile.
    ///
    /// After 10 s without an answer [`Actuals::heat_sink_degc`](super::Actuals::heat_sink_degc) is not a number. A drive
    /// whose process data hold the temperature has nothing to read.
    pub fn poll_heat_sink(&mut self, wire: &mut dyn SdoWire, now: Duration, may_start: bool) -> bool {
        let station = self.settings.station;
        let Some(own) = &mut self.heat_sink else { return false };
        if own.is_under_way {
            own.poll(wire, now);
        } else if may_start && now >= own.next_at {
            own.start(station, wire, now);
        }
        if now.saturating_sub(own.read_at) > STALE {
            own.degc = f64::NAN;
        }
        own.is_under_way
    }
}
