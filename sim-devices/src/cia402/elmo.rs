//! What a drive as an Elmo Gold has that the simulator's own has not, as far as a host sees it: identity, fixed PDOs, temperature.
//!
//! PDOs, widths, access and identity are those of a Gold Twitter whose dictionary was read out with SOEM's `slaveinfo`
//! (firmware 01.01.15.00; file `elmo_twitter_sdos` in github.com/leggedrobotics/elmo_ethercat_sdk, commit 99a724f). PDOs with
//! objects that the simulator lacks are left out. Torque objects count in 0.1 % of the rated current, as those of every drive
//! here do.

use super::dictionary::{Pdo, abort, at};
use super::{Drive, DriveType, Mapping, limits};

const VENDOR: i64 = 0x9A;
const PRODUCT: i64 = 0x0003_0924;
const REVISION: i64 = 0x0001_0420;

const OUTPUTS: [(u16, &[u32]); 7] = [
    (0x1602, &[0x6071_0010, 0x6040_0010]),
    (0x160A, &[0x6040_0010]),
    (0x160B, &[0x6060_0008, 0x0000_0008]),
    (0x160C, &[0x6071_0010]),
    (0x1617, &[0x60B1_0020]),
    (0x1618, &[0x60B2_0010]),
    (0x161C, &[0x60FF_0020]),
];

const INPUTS: [(u16, &[u32]); 13] = [
    (0x1A02, &[0x6064_0020, 0x6077_0010, 0x6041_0010, 0x6061_0008, 0x0000_0008]),
    (0x1A03, &[0x6064_0020, 0x60FD_0020, 0x606C_0020, 0x6041_0010]),
    (0x1A0A, &[0x6041_0010]),
    (0x1A0B, &[0x6061_0008, 0x0000_0008]),
    (0x1A0D, &[0x6063_0020]),
    (0x1A0E, &[0x6064_0020]),
    (0x1A11, &[0x606C_0020]),
    (0x1A12, &[0x6074_0010]),
    (0x1A13, &[0x6077_0010]),
    (0x1A18, &[0x6079_0020]),
    (0x1A1C, &[0x60FD_0020]),
    (0x1A1F, &[0x6078_0010]),
    (0x1A26, &[0x603F_0010]),
];

/// Entries of 22A3h: Celsius, Fahrenheit, a sensor that is not there.
const TEMPERATURES: u8 = 3;

impl Drive {
    pub(super) fn become_elmo_gold(&mut self) {
        self.outputs = Mapping::fixed(Pdo::Output, 0x1C12, &OUTPUTS);
        self.inputs = Mapping::fixed(Pdo::Input, 0x1C13, &INPUTS);
        // Only the sync manager has a watchdog.
        for (slot, value) in
            [(at::VENDOR, VENDOR), (at::PRODUCT, PRODUCT), (at::REVISION, REVISION), (at::WATCHDOG, 0)]
        {
            self.dictionary.put(slot, value);
        }
        self.limits = limits(&self.dictionary, &self.settings, &self.encoder, self.step_s);
    }

    /// Objects of the maker; `None` where the dictionary of every drive has the answer.
    pub(super) fn vendor_upload(&self, index: u16, sub: u8) -> Option<Result<Vec<u8>, u32>> {
        if self.drive_type == DriveType::Simulated {
            return None;
        }
        let celsius = self.heat_sink_degc();
        let degrees = |value: f64| Ok((value.round() as i16).to_le_bytes().to_vec());
        match (index, sub) {
            (0x22A3, 0) => Some(Ok(vec![TEMPERATURES])),
            (0x22A3, 1) => Some(degrees(celsius)),
            (0x22A3, 2) => Some(degrees(celsius * 1.8 + 32.0)),
            (0x22A3, 3) => Some(degrees(0.0)),
            (0x22A3, _) => Some(Err(abort::NO_SUB_INDEX)),
            // The watchdog object of the simulator's own drives.
            (0x2F00, _) => Some(Err(abort::NO_OBJECT)),
            _ => None,
        }
    }
}
