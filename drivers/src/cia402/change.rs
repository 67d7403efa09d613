//! Other limits for a drive that is in operation: written and read back over SDO, a step a tick.

use std::time::Duration;

use super::objects::Object;
use super::scale::Scale;
use super::sdo::{Transfer, aborted, mismatch, number, with_unit};
use super::{Cia402, DriveSettings, configure};
use crate::device::DeviceError;
use crate::wire::{SdoRequest, SdoWire};

/// Limits that a drive may be given while it is in operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveLimits {
    /// Torque limit (6072h).
    pub max_torque_nm: f64,
    /// Soft limits, lower and upper (607Dh).
    pub soft_limits_rad: [f64; 2],
}

/// Limits that are being written.
#[derive(Clone, Debug)]
pub(super) struct Change {
    settings: DriveSettings,
    scale: Scale,
    values: Vec<(Object, i64)>,
    /// Steps that are done: a value is written, then read back.
    done: usize,
    transfer: Transfer,
    is_under_way: bool,
}

impl Cia402 {
    /// The limits that the drive has.
    pub fn limits(&self) -> DriveLimits {
        let DriveSettings { max_torque_nm, soft_limits_rad, .. } = self.settings;
        DriveLimits { max_torque_nm, soft_limits_rad }
    }

    /// Begins to give the drive other limits; [`Cia402::poll_change`] goes on with it. Until that is done the driver keeps
    /// to the old ones.
    ///
    /// # Errors
    /// Limits that the drive cannot be given.
    pub fn change_limits(&mut self, limits: DriveLimits) -> Result<(), DeviceError> {
        let DriveLimits { max_torque_nm, soft_limits_rad } = limits;
        let settings = DriveSettings { max_torque_nm, soft_limits_rad, ..self.settings.clone() };
        let scale = Scale::new(&settings)?;
        let values = configure::limits(&settings, &scale)?;
        let done = 0;
        let transfer = Transfer::default();
        let is_under_way = false;
        self.change = Some(Change { settings, scale, values, done, transfer, is_under_way });
        Ok(())
    }

    /// Goes on with [`Cia402::change_limits`] as far as it gets without waiting; whether nothing is left of it. Several
    /// drives on one bus do it one after the other.
    ///
    /// # Errors
    /// An object that the drive refuses, or that reads back as something else; its limits are then not known.
    pub fn poll_change(&mut self, wire: &mut dyn SdoWire, now: Duration) -> Result<bool, DeviceError> {
        while let Some(change) = &mut self.change {
            if change.done == 2 * change.values.len() {
                let change = self.change.take().expect("looked at just now");
                (self.settings, self.scale) = (change.settings, change.scale);
                break;
            }
            if !change.step(wire, now)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl Change {
    /// Goes on with one transfer; whether it is over.
    fn step(&mut self, wire: &mut dyn SdoWire, now: Duration) -> Result<bool, DeviceError> {
        let (object, value) = self.values[self.done / 2];
        let writes = self.done.is_multiple_of(2);
        let device = self.settings.name.as_str();
        if !self.is_under_way {
            let bytes = value.to_le_bytes();
            let write = writes.then(|| &bytes[..object.data_type.bytes().unwrap_or(0)]);
            let station = self.settings.station;
            let index = object.index;
            let sub = object.sub;
            self.transfer.start(wire, now, &SdoRequest { station, index, sub, write });
            self.is_under_way = true;
        }
        let answer = self.transfer.poll(wire, now).map_err(|abort| aborted(device, object, abort))?;
        let Some(answer) = answer else { return Ok(false) };
        let found = number(object.data_type, answer);
        if !writes && found != Some(value) {
            let found = found.map_or_else(|| format!("{answer:02X?}"), |found| with_unit(found, object));
            let help = "the drive did not accept the written value: check its parameter locks and limits";
            return Err(mismatch(device, object, [with_unit(value, object), found], help));
        }
        (self.done, self.is_under_way) = (self.done + 1, false);
        Ok(true)
    }
}
