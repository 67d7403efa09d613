//! A CiA 402 drive that is enabled with a setpoint of 0.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::time::Duration;

use drivers::cia402::objects::{self as known, Object};
use drivers::cia402::pdo::Entry;
use drivers::cia402::profile::{DriveClock, DriveProfile, ProcessData, ProfileIdentity, TorqueScale};
use drivers::cia402::{
    Cia402, CyclicMode, DriveCommand, DriveSettings, PowerRules, PowerSequence, PowerState, PowerTarget,
    Waiting,
};
use drivers::wire::ethercat::EtherCatBus;
use drivers::wire::{ProcessImage, SdoRequest, Slot};

use super::arguments::Place;
use super::mapping::{self, Layout};
use super::{clock, objects};

/// Time allowed for each step of the power state machine.
const TRANSITION_S: f64 = 2.0;
/// 60C2h, 605Ah and so on are the drive's own; this option code lets a quick stop end as the drive does it.
const QUICK_STOP_OPTION: i16 = 2;
/// Watchdog of the bus; the drive's own object for it is not known.
const WATCHDOG_S: f64 = 0.02;
const MODE: u16 = 0x6060;
const CONTROLWORD: u16 = 0x6040;
const STATUSWORD: u16 = 0x6041;
const ERROR_CODE: u16 = 0x603F;
const POSITION: u16 = 0x6064;
const TARGET_POSITION: u16 = 0x607A;
const TARGET_TORQUE: u16 = 0x6071;
const TARGET_VELOCITY: u16 = 0x60FF;

/// A drive on its way to "operation enabled" or from there.
pub(crate) enum Axis {
    /// With the whole driver.
    Whole(Box<Cia402>, CyclicMode),
    /// With its power state machine on the mapping that the drive has.
    Steps(Box<Steps>),
}

/// A drive whose dictionary lacks what the driver needs.
pub(crate) struct Steps {
    name: String,
    layout: Layout,
    slot: Slot,
    mode: CyclicMode,
    power: PowerSequence,
}

impl Axis {
    /// Opens a drive that has all that the driver needs. It is given the limits that it has.
    pub(crate) fn whole(bus: &mut EtherCatBus, station: u16, cycle_s: f64) -> Result<Self, String> {
        let settings = settings(bus, station, cycle_s)?;
        let mut waiting = Waiting { now: clock::now(), pause: &mut clock::now };
        let opened = Cia402::open(bus, settings, &mut waiting).map_err(|error| error.to_string())?;
        println!("  opened as a whole: firmware \"{}\"", opened.1.firmware);
        Ok(Self::Whole(Box::new(opened.0), CyclicMode::Velocity))
    }

    /// Takes a drive as it is mapped.
    pub(crate) fn steps(bus: &mut EtherCatBus, station: u16, layout: Layout) -> Result<Self, String> {
        let modes = objects::read_u32(bus, station, Place { index: 0x6502, sub: 0 })?;
        let can = |mode: CyclicMode, target| {
            modes >> (mode.code() - 1) & 1 != 0 && mapping::has(&layout.outputs, target)
        };
        let modes_and_targets =
            [(CyclicMode::Velocity, TARGET_VELOCITY), (CyclicMode::Torque, TARGET_TORQUE)];
        let Some((mode, _)) = modes_and_targets.into_iter().find(|(mode, target)| can(*mode, *target)) else {
            return Err(format!(
                "station {station} is mapped for neither of the modes CSV (60FFh) and CST (6071h) that it has (6502h: {modes:X}h)"
            ));
        };
        if !mapping::has(&layout.outputs, CONTROLWORD) || !mapping::has(&layout.inputs, STATUSWORD) {
            return Err(format!(
                "station {station}: controlword (6040h) or statusword (6041h) is not mapped"
            ));
        }
        if !mapping::has(&layout.outputs, MODE) {
            let code = mode.code().to_le_bytes();
            objects::transfer(bus, &SdoRequest { station, index: MODE, sub: 0, write: Some(&code) })
                .map_err(|abort| objects::told(Place { index: MODE, sub: 0 }, abort))?;
        }
        let name = format!("station {station}");
        let (slot, power) = Default::default();
        Ok(Self::Steps(Box::new(Steps { name, layout, slot, mode, power })))
    }

    /// Where its data lie in the process image.
    pub(crate) fn attach(&mut self, slot: Slot) {
        match self {
            Self::Whole(drive, _) => drive.attach(slot),
            Self::Steps(steps) => steps.slot = slot,
        }
    }

    /// Reads the inputs of the last exchange and puts the outputs of the next one; the power state of the drive.
    pub(crate) fn step(
        &mut self,
        target: PowerTarget,
        image: &mut ProcessImage,
        now: Duration,
    ) -> Result<PowerState, String> {
        match self {
            Self::Whole(drive, mode) => {
                let seen = drive.decode(&image.inputs);
                let controlword = drive
                    .controlword(target, seen.statusword, seen.error_code, now)
                    .map_err(|error| error.to_string())?;
                let command =
                    DriveCommand { controlword, mode: *mode, torque_nm: 0.0, velocity_rad_per_s: 0.0 };
                drive.encode(&command, &mut image.outputs);
                Ok(PowerState::of(seen.statusword))
            }
            Self::Steps(steps) => steps.step(target, image, now),
        }
    }
}

impl Steps {
    fn step(
        &mut self,
        target: PowerTarget,
        image: &mut ProcessImage,
        now: Duration,
    ) -> Result<PowerState, String> {
        let inputs = image.inputs.get(self.slot.inputs.clone()).unwrap_or_default();
        let outputs = image.outputs.get_mut(self.slot.outputs.clone()).unwrap_or_default();
        let seen = |index| mapping::get(&self.layout.inputs, index, inputs);
        // Both are 16 bits wide in CiA 402.
        let statusword = seen(STATUSWORD).unwrap_or(0) as u16;
        let error_code = seen(ERROR_CODE).unwrap_or(0) as u16;
        let rules =
            PowerRules { device: &self.name, quick_stop_option: QUICK_STOP_OPTION, timeout_s: TRANSITION_S };
        let controlword = self
            .power
            .controlword(&rules, target, statusword, error_code, now)
            .map_err(|error| error.to_string())?;
        let layout = &self.layout.outputs;
        mapping::put(layout, CONTROLWORD, controlword.into(), outputs);
        mapping::put(layout, MODE, u32::from(self.mode.code().unsigned_abs()), outputs);
        mapping::put(layout, TARGET_VELOCITY, 0, outputs);
        mapping::put(layout, TARGET_TORQUE, 0, outputs);
        // Not in force in these modes; where it stands should a drive take it for a start.
        mapping::put(layout, TARGET_POSITION, seen(POSITION).unwrap_or(0), outputs);
        Ok(PowerState::of(statusword))
    }
}

/// Settings by which the driver opens a drive with the scales, limits and reactions that it has; soft limits within half a
/// turn of count 0.
fn settings(bus: &mut EtherCatBus, station: u16, cycle_s: f64) -> Result<DriveSettings, String> {
    let mut bits =
        |object: Object| objects::read_u32(bus, station, Place { index: object.index, sub: object.sub });
    let rated_current_a = f64::from(bits(known::RATED_CURRENT)?) / 1e3;
    let rated_torque_nm = f64::from(bits(known::RATED_TORQUE)?) / 1e3;
    let encoder_counts_per_rev = bits(known::ENCODER_COUNTS)?;
    let rad_per_count = TAU / f64::from(encoder_counts_per_rev);
    // Wider ones would not tell at which end of its travel a single-turn encoder stands.
    let mut limit_rad =
        |object| bits(object).map(|value| (f64::from(value.cast_signed()) * rad_per_count).clamp(-PI, PI));
    let soft_limits_rad = [limit_rad(known::SOFT_LIMIT_MIN)?, limit_rad(known::SOFT_LIMIT_MAX)?];
    let mut option = |object| bits(object).map(|value| (value as u16).cast_signed());
    let quick_stop_option = option(known::QUICK_STOP_OPTION)?;
    let fault_reaction_option = option(known::FAULT_REACTION_OPTION)?;
    let abort_connection_option = option(known::ABORT_CONNECTION_OPTION)?;
    Ok(DriveSettings {
        name: format!("station {station}"),
        station,
        profile: standard(),
        torque_constant_nm_per_a: rated_torque_nm / rated_current_a,
        rated_current_a,
        rated_torque_nm,
        max_torque_nm: f64::from(bits(known::MAX_TORQUE)?) / 1e3 * rated_torque_nm,
        encoder_counts_per_rev,
        encoder_offset_rad: 0.0,
        encoder_sign: 1.0,
        soft_limits_rad,
        max_velocity_rad_per_s: f64::from(bits(known::MAX_SPEED)?) * rad_per_count,
        quick_stop_deceleration_rad_per_s2: f64::from(bits(known::QUICK_STOP_DECELERATION)?) * rad_per_count,
        quick_stop_option,
        fault_reaction_option,
        abort_connection_option,
        watchdog_s: WATCHDOG_S,
        cycle_s,
        transition_timeout_s: TRANSITION_S,
    })
}

/// A drive of which nothing but the profile CiA 402 is known.
fn standard() -> Arc<DriveProfile> {
    const PADDING: (u16, u8) = (0, 8);
    const OUTPUTS: [(u16, u8); 5] =
        [(CONTROLWORD, 16), (TARGET_TORQUE, 16), (TARGET_VELOCITY, 32), (MODE, 8), PADDING];
    const INPUTS: [(u16, u8); 10] = [
        (STATUSWORD, 16),
        (ERROR_CODE, 16),
        (known::MODE_DISPLAY.index, 8),
        PADDING,
        (POSITION, 32),
        (known::VELOCITY.index, 32),
        (known::TORQUE.index, 16),
        (known::CURRENT.index, 16),
        (known::DC_LINK.index, 32),
        (known::DIGITAL_INPUTS.index, 32),
    ];
    let mapped = |objects: &[(u16, u8)]| {
        ProcessData::Mapped(objects.iter().map(|&(index, bits)| Entry { index, sub: 0, bits }).collect())
    };
    Arc::new(DriveProfile {
        id: "standard".to_owned(),
        identity: ProfileIdentity::default(),
        outputs: mapped(&OUTPUTS),
        inputs: mapped(&INPUTS),
        torque_scale: TorqueScale::RatedTorque,
        clock: DriveClock { has_sync0: true, sync0_shift_s: None, shortest_cycle_s: None },
        heat_sink: None,
        watchdog: None,
        lacks: Vec::new(),
        start_up: Vec::new(),
    })
}
