//! The bytes of one drive in one exchange, in raw counts.

use super::objects::{self, Object};
use super::pdo::{RX, RX_BYTES, TX, offset_of};

/// What a drive sends (mapping [`TX`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Inputs {
    /// 6041h.
    pub(super) statusword: u16,
    /// 603Fh.
    pub(super) error_code: u16,
    /// 6061h.
    pub(super) mode: i8,
    /// 6064h, counts.
    pub(super) position_counts: i32,
    /// 606Ch, counts/s.
    pub(super) velocity_counts_per_s: i32,
    /// 6077h, ‰ of the rated torque.
    pub(super) torque_permille: i16,
    /// 6078h, ‰ of the rated current.
    pub(super) current_permille: i16,
    /// 6079h, mV.
    pub(super) dc_link_mv: u32,
    /// 22A3h, 0.1 °C.
    pub(super) heat_sink_tenths_degc: i16,
    /// 60FDh.
    pub(super) digital_inputs: u32,
}

/// What a drive is sent (mapping [`RX`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Outputs {
    /// 6040h.
    pub(super) controlword: u16,
    /// 6071h, ‰ of the rated torque.
    pub(super) torque_permille: i16,
    /// 60FFh, counts/s.
    pub(super) velocity_counts_per_s: i32,
    /// 6060h.
    pub(super) mode: i8,
}

impl Inputs {
    /// Decodes the drive's slot; `None` if it is too short.
    pub(super) fn read(slot: &[u8]) -> Option<Self> {
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
            digital_inputs: u32::from_le_bytes(field(slot, const { tx(objects::DIGITAL_INPUTS) })?),
        })
    }
}

impl Outputs {
    /// Encodes into the drive's slot; `None`, and nothing written, if it is too short.
    pub(super) fn write(&self, slot: &mut [u8]) -> Option<()> {
        let slot = slot.get_mut(..RX_BYTES)?;
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
