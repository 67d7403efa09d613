//! Types of drives for tests, as `drivers/profiles/*.toml` describe them.

use std::sync::Arc;

use drivers::cia402::objects::DataType;
use drivers::cia402::pdo::Entry;
use drivers::cia402::profile::{
    DriveClock, DriveProfile, HeatSink, ObjectPlace, ProcessData, ProfileIdentity, ReadBy, TorqueScale,
    WatchdogObject,
};

/// The drives of the simulator as they usually are.
pub(crate) fn simulated() -> Arc<DriveProfile> {
    let entry = |index, bits| Entry { index, sub: 0, bits };
    let outputs = [(0x6040, 16), (0x6071, 16), (0x60FF, 32), (0x6060, 8), (0, 8)];
    let inputs = [
        (0x6041, 16),
        (0x603F, 16),
        (0x6061, 8),
        (0, 8),
        (0x6064, 32),
        (0x606C, 32),
        (0x6077, 16),
        (0x6078, 16),
        (0x6079, 32),
        (0x22A3, 16),
        (0x60FD, 32),
    ];
    let place = |index| ObjectPlace { index, sub: 0 };
    Arc::new(DriveProfile {
        id: "simulated".to_owned(),
        identity: ProfileIdentity::default(),
        outputs: ProcessData::Mapped(outputs.map(|(index, bits)| entry(index, bits)).to_vec()),
        inputs: ProcessData::Mapped(inputs.map(|(index, bits)| entry(index, bits)).to_vec()),
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
    })
}
