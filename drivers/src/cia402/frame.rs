//! The bytes of one drive in one exchange, in raw counts; both ends of the wire use it.

use super::objects::{self, Object};
use super::pdo::{RX, TX, offset_of};

/// What a drive sends (mapping [`TX`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// 6041h.
    pub statusword: u16,
    /// 603Fh.
    pub error_code: u16,
    /// 6061h.
    pub mode: i8,
    /// 6064h, counts.
    pub position_counts: i32,
    /// 606Ch, counts/s.
    pub velocity_counts_per_s: i32,
    /// 6077h, ‰ of the rated torque.
    pub torque_permille: i16,
    /// 6078h, ‰ of the rated current.
    pub current_permille: i16,
    /// 6079h, mV.
    pub dc_link_mv: u32,
    /// 22A3h, 0.1 °C.
    pub heat_sink_tenths_degc: i16,
}

/// What a drive is sent (mapping [`RX`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// 6040h.
    pub controlword: u16,
    /// 6071h, ‰ of the rated torque.
    pub torque_permille: i16,
    /// 60FFh, counts/s.
    pub velocity_counts_per_s: i32,
    /// 6060h.
    pub mode: i8,
}

impl Inputs {
    /// Decodes the drive's slot; `None` if it is too short.
    pub fn read(slot: &[u8]) -> Option<Self> {
        Some(Self {
            statusword: u16::from_le_bytes(field(slot, const { tx(objects::STATUSWORD) })?),
            error_code: u16::from_le_bytes(field(slot, const { tx(objects::ERROR_CODE) })?),
            mode: i8::from_le_bytes(field(slot, const { tx(objects::MODE_DISPLAY) })?),
            position_counts: i32::from_le_bytes(field(slot, const { tx(objects::POSITION) })?),
            velocity_counts_per_s: i32::from_le_bytes(field(slot, const { tx(objects::VELOCITY) })?),
            torque_permille: i16::from_le_bytes(field(slot, const { tx(objects::TORQUE) })?),
            current_permille: i16::from_le_bytes(field(slot, const { tx(objects::CURRENT) })?),
            dc_link_mv: u32::from_le_bytes(field(slot, const { tx(objects::DC_LINK) })?),
            heat_sink_tenths_degc: i16::from_le_bytes(field(slot, const { tx(objects::HEAT_SINK) })?),
        })
    }

    /// Encodes into the drive's slot; `None`, and nothing written, if it is too short.
    pub fn write(&self, slot: &mut [u8]) -> Option<()> {
        let slot = slot.get_mut(..super::pdo::TX_BYTES)?;
        slot.fill(0);
        put(slot, const { tx(objects::STATUSWORD) }, self.statusword.to_le_bytes())?;
        put(slot, const { tx(objects::ERROR_CODE) }, self.error_code.to_le_bytes())?;
        put(slot, const { tx(objects::MODE_DISPLAY) }, self.mode.to_le_bytes())?;
        put(slot, const { tx(objects::POSITION) }, self.position_counts.to_le_bytes())?;
        put(slot, const { tx(objects::VELOCITY) }, self.velocity_counts_per_s.to_le_bytes())?;
        put(slot, const { tx(objects::TORQUE) }, self.torque_permille.to_le_bytes())?;
        put(slot, const { tx(objects::CURRENT) }, self.current_permille.to_le_bytes())?;
        put(slot, const { tx(objects::DC_LINK) }, self.dc_link_mv.to_le_bytes())?;
        put(slot, const { tx(objects::HEAT_SINK) }, self.heat_sink_tenths_degc.to_le_bytes())
    }
}

impl Outputs {
    /// Decodes the drive's slot; `None` if it is too short.
    pub fn read(slot: &[u8]) -> Option<Self> {
        Some(Self {
            controlword: u16::from_le_bytes(field(slot, const { rx(objects::CONTROLWORD) })?),
            torque_permille: i16::from_le_bytes(field(slot, const { rx(objects::TARGET_TORQUE) })?),
            velocity_counts_per_s: i32::from_le_bytes(field(slot, const { rx(objects::TARGET_VELOCITY) })?),
            mode: i8::from_le_bytes(field(slot, const { rx(objects::MODE) })?),
        })
    }

    /// Encodes into the drive's slot; `None`, and nothing written, if it is too short.
    pub fn write(&self, slot: &mut [u8]) -> Option<()> {
        let slot = slot.get_mut(..super::pdo::RX_BYTES)?;
        slot.fill(0);
        put(slot, const { rx(objects::CONTROLWORD) }, self.controlword.to_le_bytes())?;
        put(slot, const { rx(objects::TARGET_TORQUE) }, self.torque_permille.to_le_bytes())?;
        put(slot, const { rx(objects::TARGET_VELOCITY) }, self.velocity_counts_per_s.to_le_bytes())?;
        put(slot, const { rx(objects::MODE) }, self.mode.to_le_bytes())
    }
}

const fn rx(object: Object) -> usize {
    offset_of(&RX, object)
}

const fn tx(object: Object) -> usize {
    offset_of(&TX, object)
}

fn field<const N: usize>(slot: &[u8], offset: usize) -> Option<[u8; N]> {
    slot.get(offset..offset + N)?.try_into().ok()
}

fn put<const N: usize>(slot: &mut [u8], offset: usize, bytes: [u8; N]) -> Option<()> {
    slot.get_mut(offset..offset + N)?.copy_from_slice(&bytes);
    Some(())
}
