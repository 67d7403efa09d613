//! The bytes of one drive in one exchange, in raw counts.

use super::objects::{self, DataType, Object};
use super::pdo::Layout;
use super::profile::{DriveProfile, OUTPUTS, ReadBy, TorqueScale};
use super::sdo::{Dictionary, number};
use crate::device::DeviceError;

/// What a drive sends.
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
    /// 6078h, ‰ of the rated current; of a drive that does not send it 6077h, which is the same there.
    pub(super) current_permille: i16,
    /// 6079h, mV.
    pub(super) dc_link_mv: u32,
    /// Counts of the heat sink's temperature; `None` where it is not in the process data.
    pub(super) heat_sink_counts: Option<i64>,
    /// 60FDh; 0 where it is not in the process data.
    pub(super) digital_inputs: u32,
}

/// What a drive is sent.
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

/// First bytes of the inputs within the slot of a drive, and the length of that slot.
#[derive(Clone, Copy, Debug)]
pub(super) struct InputPlaces {
    bytes: usize,
    statusword: usize,
    error_code: usize,
    mode: usize,
    position: usize,
    velocity: usize,
    torque: usize,
    current: usize,
    dc_link: usize,
    heat_sink: Option<(usize, DataType)>,
    digital_inputs: Option<usize>,
}

/// First bytes of the outputs within the slot of a drive, and the length of that slot.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutputPlaces {
    bytes: usize,
    controlword: usize,
    torque: usize,
    velocity: usize,
    mode: usize,
}

const NOT_MAPPED: &str =
    "correct the process data in the profile of the drive, or choose another profile in the rig file";

impl InputPlaces {
    /// Where the inputs lie in a layout.
    ///
    /// # Errors
    /// The first object that every drive must send and this one does not.
    pub(super) fn new(
        drive: &Dictionary<'_, '_>,
        layout: &Layout,
        profile: &DriveProfile,
    ) -> Result<Self, DeviceError> {
        let place = |object: Object| layout.find(object).ok_or_else(|| missing(drive, object, "inputs"));
        let torque = place(objects::TORQUE)?;
        let current = match (layout.find(objects::CURRENT), profile.torque_scale) {
            (Some(current), _) => current,
            (None, TorqueScale::RatedCurrent) => torque,
            (None, TorqueScale::RatedTorque) => return Err(missing(drive, objects::CURRENT, "inputs")),
        };
        let heat_sink = match profile.heat_sink.filter(|own| own.by == ReadBy::ProcessData) {
            Some(own) => {
                let object = own.place.object(super::HEAT_SINK, own.data_type, "");
                Some((place(object)?, own.data_type))
            }
            None => None,
        };
        Ok(Self {
            bytes: layout.bytes(),
            statusword: place(objects::STATUSWORD)?,
            error_code: place(objects::ERROR_CODE)?,
            mode: place(objects::MODE_DISPLAY)?,
            position: place(objects::POSITION)?,
            velocity: place(objects::VELOCITY)?,
            torque,
            current,
            dc_link: place(objects::DC_LINK)?,
            heat_sink,
            digital_inputs: layout.find(objects::DIGITAL_INPUTS),
        })
    }

    /// Whether 60FDh is among them.
    pub(super) fn sends_digital_inputs(&self) -> bool {
        self.digital_inputs.is_some()
    }
}

impl OutputPlaces {
    /// Where the outputs lie in a layout.
    ///
    /// # Errors
    /// The first object that every drive must be sent and this one is not, or one that nobody knows what to send for.
    pub(super) fn new(drive: &Dictionary<'_, '_>, layout: &Layout) -> Result<Self, DeviceError> {
        let place = |object: Object| layout.find(object).ok_or_else(|| missing(drive, object, "outputs"));
        let places = Self {
            bytes: layout.bytes(),
            controlword: place(objects::CONTROLWORD)?,
            torque: place(objects::TARGET_TORQUE)?,
            velocity: place(objects::TARGET_VELOCITY)?,
            mode: place(objects::MODE)?,
        };
        let is_known = |index: u16, sub: u8| OUTPUTS.iter().any(|own| (own.index, own.sub) == (index, sub));
        match layout.entries().find(|entry| !is_known(entry.index, entry.sub)) {
            None => Ok(places),
            Some(entry) => Err(DeviceError::Mismatch {
                device: drive.device.to_owned(),
                index: entry.index,
                sub: entry.sub,
                name: "mapped output",
                expected: "outputs 6040h, 6060h, 6071h and 60FFh alone".to_owned(),
                found: format!("an output of {} bits that would always be sent as 0", entry.bits),
                help: NOT_MAPPED,
            }),
        }
    }
}

fn missing(drive: &Dictionary<'_, '_>, object: Object, direction: &str) -> DeviceError {
    let bits = object.data_type.bytes().map_or(0, |bytes| 8 * bytes);
    let expected = format!("{bits} bits among the {direction}, on a byte boundary");
    drive.mismatch(object, expected, "none".to_owned(), NOT_MAPPED)
}

impl Inputs {
    /// Decodes the drive's slot; `None` unless it has the length of the mapping.
    pub(super) fn read(slot: &[u8], at: &InputPlaces) -> Option<Self> {
        if slot.len() != at.bytes {
            return None;
        }
        let heat_sink = at
            .heat_sink
            .map(|(offset, data_type)| number(data_type, slot.get(offset..offset + data_type.bytes()?)?));
        Some(Self {
            statusword: u16::from_le_bytes(field(slot, at.statusword)?),
            error_code: u16::from_le_bytes(field(slot, at.error_code)?),
            mode: i8::from_le_bytes(field(slot, at.mode)?),
            position_counts: i32::from_le_bytes(field(slot, at.position)?),
            velocity_counts_per_s: i32::from_le_bytes(field(slot, at.velocity)?),
            torque_permille: i16::from_le_bytes(field(slot, at.torque)?),
            current_permille: i16::from_le_bytes(field(slot, at.current)?),
            dc_link_mv: u32::from_le_bytes(field(slot, at.dc_link)?),
            heat_sink_counts: heat_sink.flatten(),
            digital_inputs: match at.digital_inputs {
                Some(offset) => u32::from_le_bytes(field(slot, offset)?),
                None => 0,
            },
        })
    }
}

impl Outputs {
    /// Encodes into the drive's slot; `None`, and nothing written, unless it has the length of the mapping.
    pub(super) fn write(&self, slot: &mut [u8], at: &OutputPlaces) -> Option<()> {
        if slot.len() != at.bytes {
            return None;
        }
        slot.fill(0);
        put(slot, at.controlword, self.controlword.to_le_bytes())?;
        put(slot, at.torque, self.torque_permille.to_le_bytes())?;
        put(slot, at.velocity, self.velocity_counts_per_s.to_le_bytes())?;
        put(slot, at.mode, self.mode.to_le_bytes())
    }
}

fn field<const N: usize>(slot: &[u8], offset: usize) -> Option<[u8; N]> {
    slot.get(offset..offset + N)?.try_into().ok()
}

fn put<const N: usize>(slot: &mut [u8], offset: usize, bytes: [u8; N]) -> Option<()> {
    slot.get_mut(offset..offset + N)?.copy_from_slice(&bytes);
    Some(())
}
