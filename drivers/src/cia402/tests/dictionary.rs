//! The far end of the SDO wire: an object dictionary of bytes with the manners of a drive.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use crate::cia402::DriveSettings;
use crate::cia402::objects::{self, Access, DataType, OBJECTS, Object};
use crate::cia402::pdo::Entry;
use crate::cia402::profile::*;
use crate::wire::{PdoTransport, SdoAbort, SdoRequest, SdoWire};

/// Objects of the maker of this drive.
pub(super) const VENDOR_OBJECTS: [Object; 2] = [
    Object {
        index: 0x22A3,
        sub: 0,
        name: "heat sink temperature",
        data_type: DataType::I16,
        access: Access::ReadOnly,
        unit: "",
        doc: "",
    },
    Object {
        index: 0x2F00,
        sub: 0,
        name: "process data watchdog",
        data_type: DataType::U16,
        access: Access::ReadWrite,
        unit: "steps",
        doc: "",
    },
];

/// A type of drive with a mapping that can be written, a watchdog of its own and a temperature among its inputs.
pub(in crate::cia402) fn profile() -> DriveProfile {
    let entry = |object| Entry::of(object).expect("a number");
    let place = |index| ObjectPlace { index, sub: 0 };
    let heat_sink = Entry { index: 0x22A3, sub: 0, bits: 16 };
    DriveProfile {
        id: "twin".to_owned(),
        identity: ProfileIdentity::default(),
        outputs: ProcessData::Mapped(vec![
            entry(objects::CONTROLWORD),
            entry(objects::TARGET_TORQUE),
            entry(objects::TARGET_VELOCITY),
            entry(objects::MODE),
            Entry::PADDING,
        ]),
        inputs: ProcessData::Mapped(vec![
            entry(objects::STATUSWORD),
            entry(objects::ERROR_CODE),
            entry(objects::MODE_DISPLAY),
            Entry::PADDING,
            entry(objects::POSITION),
            entry(objects::VELOCITY),
            entry(objects::TORQUE),
            entry(objects::CURRENT),
            entry(objects::DC_LINK),
            heat_sink,
            entry(objects::DIGITAL_INPUTS),
        ]),
        torque_scale: TorqueScale::RatedTorque,
        clock: DriveClock { has_sync0: true, sync0_shift_s: None, shortest_cycle_s: None },
        heat_sink: Some(HeatSink {
            place: place(0x22A3),
            data_type: DataType::I16,
            counts_per_degc: 10.0,
            by: ReadBy::ProcessData,
        }),
        watchdog: Some(WatchdogObject { place: place(0x2F00), data_type: DataType::U16, step_s: 100e-6 }),
        lacks: Vec::new(),
        start_up: Vec::new(),
    }
}

/// Settings for a drive of another type.
pub(super) fn of_type(change: impl FnOnce(&mut DriveProfile)) -> DriveSettings {
    let mut profile = profile();
    change(&mut profile);
    DriveSettings { profile: Arc::new(profile), ..azimuth() }
}

/// The azimuth drive of the simulated unit.
pub(super) fn azimuth() -> DriveSettings {
    DriveSettings {
        name: "az".to_owned(),
        station: 1,
        profile: Arc::new(profile()),
        torque_constant_nm_per_a: 60.0,
        rated_current_a: 2.0,
        rated_torque_nm: 120.0,
        max_torque_nm: 2556.0,
        encoder_counts_per_rev: 1 << 26,
        encoder_offset_rad: 0.0,
        encoder_sign: 1.0,
        soft_limits_rad: [-2.79, 2.79],
        max_velocity_rad_per_s: 1.2,
        quick_stop_deceleration_rad_per_s2: 1.5,
        quick_stop_option: 6,
        fault_reaction_option: 2,
        abort_connection_option: 3,
        watchdog_s: 0.02,
        cycle_s: 250e-6,
        transition_timeout_s: 2.0,
    }
}

/// Objects as bytes, and what this drive does wrong.
#[derive(Default)]
pub(super) struct Dictionary {
    pub(super) bytes: BTreeMap<(u16, u8), Vec<u8>>,
    /// Downloads in order of arrival.
    pub(super) written: Vec<(u16, u8, Vec<u8>)>,
    /// Objects that acknowledge a download and keep their value.
    pub(super) deaf: Vec<(u16, u8)>,
    /// Objects that refuse every access.
    pub(super) aborting: Vec<((u16, u8), u32)>,
    /// How long it takes to answer.
    pub(super) answers_after: Duration,
    /// Answer to the transfer that was begun last, and when it is there.
    pub(super) answer: Option<(Duration, Result<Vec<u8>, SdoAbort>)>,
}

impl Dictionary {
    /// A commissioned drive that fits the settings; what is configurable holds other values yet.
    pub(super) fn of(settings: &DriveSettings) -> Self {
        let mut far_end = Self::default();
        for object in OBJECTS.iter().chain(&VENDOR_OBJECTS) {
            let bytes = vec![0x5A; object.data_type.bytes().unwrap_or(0)];
            far_end.bytes.insert((object.index, object.sub), bytes);
        }
        far_end.put(0x1000, 0, &0x0002_0192_u32.to_le_bytes());
        far_end.put(0x1008, 0, b"Twin Drive 100\0\0");
        far_end.put(0x100A, 0, b"1.16.5");
        far_end.put(0x1018, 1, &0x9A_u32.to_le_bytes());
        far_end.put(0x1018, 2, &0x0003_0924_u32.to_le_bytes());
        far_end.put(0x1018, 3, &0x0001_0420_u32.to_le_bytes());
        far_end.put(0x1018, 4, &4_000_000_001_u32.to_le_bytes());
        let most_a = settings.max_torque_nm / settings.torque_constant_nm_per_a;
        let permille = (most_a / settings.rated_current_a * 1e3).round() as u16;
        far_end.put(0x6073, 0, &permille.to_le_bytes());
        far_end.put(0x6075, 0, &((settings.rated_current_a * 1e3) as u32).to_le_bytes());
        far_end.put(0x6076, 0, &((settings.rated_torque_nm * 1e3) as u32).to_le_bytes());
        far_end.put(0x608F, 1, &settings.encoder_counts_per_rev.to_le_bytes());
        far_end.put(0x608F, 2, &1_u32.to_le_bytes());
        far_end.put(0x6502, 0, &0x000F_03E5_u32.to_le_bytes());
        far_end
    }

    pub(super) fn put(&mut self, index: u16, sub: u8, bytes: &[u8]) {
        self.bytes.insert((index, sub), bytes.to_vec());
    }

    pub(super) fn get(&self, index: u16, sub: u8) -> &[u8] {
        &self.bytes[&(index, sub)]
    }

    fn object(index: u16, sub: u8) -> Option<&'static Object> {
        // Lists of assigned PDOs have room for eight.
        let sub = if matches!(index, 0x1C12 | 0x1C13) && (2..=8).contains(&sub) { 1 } else { sub };
        OBJECTS.iter().chain(&VENDOR_OBJECTS).find(|object| (object.index, object.sub) == (index, sub))
    }

    fn refuse(&self, index: u16, sub: u8) -> Result<(), SdoAbort> {
        match self.aborting.iter().find(|(at, _)| *at == (index, sub)) {
            Some((_, code)) => Err(SdoAbort(*code)),
            None => Ok(()),
        }
    }

    /// Lists take entries only while their count is 0, and mappings only while unassigned.
    fn check_list(&self, index: u16, sub: u8, data: &[u8]) -> Result<(), SdoAbort> {
        let in_state = match index {
            0x1600 | 0x1A00 => self.get(if index == 0x1600 { 0x1C12 } else { 0x1C13 }, 0) == [0],
            0x1C12 | 0x1C13 => true,
            _ => return Ok(()),
        };
        if !in_state || (sub > 0 && self.get(index, 0) != [0]) {
            return Err(SdoAbort(0x0800_0022));
        }
        if matches!(index, 0x1600 | 0x1A00) && sub > 0 {
            return Self::check_mapped(data);
        }
        Ok(())
    }

    /// A mapped width must be the object's.
    fn check_mapped(data: &[u8]) -> Result<(), SdoAbort> {
        let word = u32::from_le_bytes(data.try_into().map_err(|_| SdoAbort(0x0607_0010))?);
        let index = (word >> 16) as u16;
        let sub = (word >> 8) as u8;
        let bits = word & 0xFF;
        let width = Self::object(index, sub).and_then(|object| object.data_type.bytes());
        let padding = index == 0 && sub == 0;
        if padding || width.is_some_and(|bytes| bytes as u32 * 8 == bits) {
            Ok(())
        } else {
            Err(SdoAbort(0x0604_0041))
        }
    }
}

impl Dictionary {
    fn upload(&mut self, station: u16, index: u16, sub: u8) -> Result<Vec<u8>, SdoAbort> {
        assert_eq!(station, 1);
        self.refuse(index, sub)?;
        self.bytes.get(&(index, sub)).cloned().ok_or(SdoAbort(0x0602_0000))
    }

    fn download(&mut self, station: u16, index: u16, sub: u8, data: &[u8]) -> Result<(), SdoAbort> {
        assert_eq!(station, 1);
        self.refuse(index, sub)?;
        let object = Self::object(index, sub).ok_or(SdoAbort(0x0602_0000))?;
        if object.access == Access::ReadOnly {
            return Err(SdoAbort(0x0601_0002));
        }
        if Some(data.len()) != object.data_type.bytes() {
            return Err(SdoAbort(0x0607_0010));
        }
        self.check_list(index, sub, data)?;
        self.written.push((index, sub, data.to_vec()));
        if !self.deaf.contains(&(index, sub)) {
            self.put(index, sub, data);
        }
        Ok(())
    }
}

impl SdoWire for Dictionary {
    fn pdo_transport(&self) -> PdoTransport {
        PdoTransport::Assigned
    }

    fn start(&mut self, now: Duration, request: &SdoRequest<'_>) {
        let SdoRequest { station, index, sub, write } = *request;
        let answer = match write {
            None => self.upload(station, index, sub),
            Some(data) => self.download(station, index, sub, data).map(|()| Vec::new()),
        };
        self.answer = Some((now + self.answers_after, answer));
    }

    fn poll(&mut self, now: Duration, into: &mut Vec<u8>) -> Result<bool, SdoAbort> {
        let Some((_, answer)) = self.answer.take_if(|(due, _)| *due <= now) else { return Ok(false) };
        into.extend(answer?);
        Ok(true)
    }
}
