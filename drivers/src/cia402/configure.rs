//! Identify, check, configure, read back: all of it over SDO, in PRE-OP, before anything can move.

use super::frames::{self, Direction};
use super::objects::{self, Object};
use super::pdo::{self, Entry};
use super::scale::Scale;
use super::sdo::Dictionary;
use super::{CyclicMode, DriveSettings, Identity};
use crate::device::DeviceError;
use crate::wire::PdoTransport;

/// Device profile number of CiA 402 in the low word of 1000h.
const PROFILE_402: i64 = 402;
/// Supported modes (6502h): CSV bit 8, CST bit 9.
const CYCLIC_MODES: i64 = 0x300;
/// Switches the drive's following error supervision off: in CSV and CST there is no position demand to follow.
const NO_FOLLOWING_ERROR: i64 = u32::MAX as i64;

/// Reads who the drive is and refuses one that is not a CiA 402 drive with both cyclic modes.
pub(super) fn identify(drive: &mut Dictionary<'_, '_>) -> Result<Identity, DeviceError> {
    let device_type = drive.read(objects::DEVICE_TYPE)?;
    if device_type & 0xFFFF != PROFILE_402 {
        let expected = format!("{PROFILE_402} in the low word");
        let found = format!("{}", device_type & 0xFFFF);
        let help = "the station is not a CiA 402 drive: check station order and wiring";
        return Err(drive.mismatch(objects::DEVICE_TYPE, expected, found, help));
    }
    let modes = drive.read(objects::SUPPORTED_MODES)?;
    if modes & CYCLIC_MODES != CYCLIC_MODES {
        let expected = format!("bits {CYCLIC_MODES:X}h (CSV, CST) set");
        let help = "the drive or its firmware lacks a cyclic mode: update it or take another drive type";
        return Err(drive.mismatch(objects::SUPPORTED_MODES, expected, format!("{modes:X}h"), help));
    }
    Ok(Identity {
        device_name: drive.read_text(objects::DEVICE_NAME)?,
        vendor: drive.read_u32(objects::VENDOR)?,
        product: drive.read_u32(objects::PRODUCT)?,
        revision: drive.read_u32(objects::REVISION)?,
        serial: drive.read_u32(objects::SERIAL)?,
        firmware: drive.read_text(objects::FIRMWARE)?,
    })
}

/// Checks the commissioned scales, which the bench reads but never writes.
pub(super) fn check_scales(
    drive: &mut Dictionary<'_, '_>,
    settings: &DriveSettings,
) -> Result<(), DeviceError> {
    const RATING: &str = "every torque would be scaled wrongly: correct the rig file or commission the drive";
    const ENCODER: &str = "every angle would be scaled wrongly: correct the rig file or commission the drive";
    let expected = [
        (objects::RATED_CURRENT, (settings.rated_current_a * 1e3).round(), RATING),
        (objects::RATED_TORQUE, (settings.rated_torque_nm * 1e3).round(), RATING),
        (objects::ENCODER_COUNTS, f64::from(settings.encoder_counts_per_rev), ENCODER),
        (objects::ENCODER_REVOLUTIONS, 1.0, ENCODER),
    ];
    for (object, value, help) in expected {
        drive.expect(object, value as i64, help)?;
    }
    Ok(())
}

/// Reads the current limit that the drive was commissioned to, in A. The bench does not write it: who commissioned the
/// drive knows what motor and cables bear.
pub(super) fn commissioned_current_a(
    drive: &mut Dictionary<'_, '_>,
    settings: &DriveSettings,
) -> Result<f64, DeviceError> {
    let permille = drive.read(objects::MAX_CURRENT)?;
    Ok(permille as f64 / 1e3 * settings.rated_current_a)
}

/// Sets the process-data mapping as the wire carries it; each object is read back.
pub(super) fn map(drive: &mut Dictionary<'_, '_>) -> Result<(), DeviceError> {
    match drive.wire.pdo_transport() {
        PdoTransport::Assigned => map_assigned(drive),
        PdoTransport::Frames => {
            frames::map(drive, Direction::Receive, &pdo::RX)?;
            frames::map(drive, Direction::Transmit, &pdo::TX)
        }
    }
}

/// One PDO each way: counts to 0, entries, counts, assignment.
fn map_assigned(drive: &mut Dictionary<'_, '_>) -> Result<(), DeviceError> {
    let pdos: [(Object, Object, &[Entry]); 2] = [
        (objects::RX_ASSIGNMENT, objects::RX_MAPPING, &pdo::RX),
        (objects::TX_ASSIGNMENT, objects::TX_MAPPING, &pdo::TX),
    ];
    for (assignment, mapping, entries) in pdos {
        drive.write_checked(assignment, 0)?;
        drive.write_checked(mapping, 0)?;
        for (k, entry) in entries.iter().enumerate() {
            drive.write_checked(entry_object(mapping, k), i64::from(entry.word()))?;
        }
        drive.write_checked(mapping, entries.len() as i64)?;
        drive.write_checked(entry_object(assignment, 0), i64::from(mapping.index))?;
        drive.write_checked(assignment, 1)?;
    }
    Ok(())
}

/// Entry `k` of a list whose sub-index 0 is its count.
fn entry_object(list: Object, k: usize) -> Object {
    let sub = k as u8 + 1;
    objects::find(list.index, sub)
        .expect("the table has a row for each entry of pdo::RX and pdo::TX, as tests show")
}

/// Writes mode, limits, reactions, watchdog and cycle time; each is read back.
pub(super) fn configure(
    drive: &mut Dictionary<'_, '_>,
    settings: &DriveSettings,
    scale: &Scale,
) -> Result<(), DeviceError> {
    for (object, value) in values(settings, scale)? {
        drive.write_checked(object, value)?;
    }
    Ok(())
}

/// Object and value of the limits that a drive may be given in operation.
pub(super) fn limits(settings: &DriveSettings, scale: &Scale) -> Result<[(Object, i64); 3], DeviceError> {
    let [low, high] = soft_limits(settings, scale)?;
    let max_torque = fit(settings, objects::MAX_TORQUE, "max_torque_nm", scale.max_torque_permille())?;
    Ok([max_torque, (objects::SOFT_LIMIT_MIN, low), (objects::SOFT_LIMIT_MAX, high)])
}

/// Object and value of every setting, in the order of writing.
fn values(settings: &DriveSettings, scale: &Scale) -> Result<Vec<(Object, i64)>, DeviceError> {
    let fit = |object, setting, counts| fit(settings, object, setting, counts);
    let [max_torque, soft_limit_min, soft_limit_max] = limits(settings, scale)?;
    let (period, exponent) = period(settings)?;
    let max_speed = scale.counts(settings.max_velocity_rad_per_s);
    let deceleration = scale.counts(settings.quick_stop_deceleration_rad_per_s2);
    let watchdog = (settings.watchdog_s * 1e4).round();
    Ok(vec![
        (objects::MODE, i64::from(CyclicMode::Torque.code())),
        (objects::ABORT_CONNECTION_OPTION, i64::from(settings.abort_connection_option)),
        (objects::QUICK_STOP_OPTION, i64::from(settings.quick_stop_option)),
        (objects::FAULT_REACTION_OPTION, i64::from(settings.fault_reaction_option)),
        max_torque,
        soft_limit_min,
        soft_limit_max,
        fit(objects::MAX_SPEED, "max_velocity_rad_per_s", max_speed)?,
        fit(objects::QUICK_STOP_DECELERATION, "quick_stop_deceleration_rad_per_s2", deceleration)?,
        (objects::FOLLOWING_ERROR_WINDOW, NO_FOLLOWING_ERROR),
        (objects::FOLLOWING_ERROR_TIME, 0),
        fit(objects::WATCHDOG, "watchdog_s", watchdog)?,
        (objects::INTERPOLATION_PERIOD, period),
        (objects::INTERPOLATION_EXPONENT, exponent),
    ])
}

/// A value in counts, refused where the object cannot hold it or where it would round to nothing.
fn fit(
    settings: &DriveSettings,
    object: Object,
    setting: &'static str,
    counts: f64,
) -> Result<(Object, i64), DeviceError> {
    let largest = object.data_type.range().map_or(0, |(_, max)| max);
    if counts >= 1.0 && counts <= largest as f64 {
        return Ok((object, counts as i64));
    }
    let allowed =
        format!("{:04X}h accepts 1 to {largest} ({}), this would be {counts}", object.index, object.unit);
    Err(DeviceError::Setting { device: settings.name.clone(), setting, value: counts, allowed })
}

/// Soft limits in ascending counts. They must lie within half a turn of count 0: beyond it a single-turn encoder
/// cannot tell at which end of the travel the axis stands.
fn soft_limits(settings: &DriveSettings, scale: &Scale) -> Result<[i64; 2], DeviceError> {
    let half_turn = f64::from(settings.encoder_counts_per_rev) / 2.0;
    let mut counts = [0; 2];
    for (count, limit_rad) in counts.iter_mut().zip(settings.soft_limits_rad) {
        let value = scale.position_counts(limit_rad);
        if value.is_nan() || value.abs() > half_turn {
            let allowed = "it must lie within half a turn of encoder_offset_rad, else the single-turn count is ambiguous";
            let device = settings.name.clone();
            let setting = "soft_limits_rad";
            return Err(DeviceError::Setting {
                device,
                setting,
                value: limit_rad,
                allowed: allowed.to_owned(),
            });
        }
        *count = value as i64;
    }
    counts.sort_unstable();
    Ok(counts)
}

/// What 60C2h wants.
const PERIODS: &str = "60C2h needs a whole number from 1 to 255 times a power of ten";

/// Whether a drive can be told this cycle time.
///
/// # Errors
/// What it can be told, in words.
pub fn check_cycle(cycle_s: f64) -> Result<(), String> {
    let told =
        || format!("expected a whole number from 1 to 255 times a power of ten (60C2h), found {cycle_s} s");
    mantissa(cycle_s).map(|_| ()).ok_or_else(told)
}

/// Cycle time as mantissa and power of ten (60C2h), e.g. 250 µs = 25 · 10⁻⁵ s.
fn mantissa(cycle_s: f64) -> Option<(i64, i64)> {
    (-9..=0).rev().find_map(|exponent| {
        let mantissa = cycle_s * 10_f64.powi(-exponent);
        let whole = mantissa.round();
        let fits = (1.0..=255.0).contains(&whole) && (mantissa - whole).abs() < 1e-6;
        fits.then_some((whole as i64, i64::from(exponent)))
    })
}

fn period(settings: &DriveSettings) -> Result<(i64, i64), DeviceError> {
    mantissa(settings.cycle_s).ok_or_else(|| DeviceError::Setting {
        device: settings.name.clone(),
        setting: "cycle_s",
        value: settings.cycle_s,
        allowed: PERIODS.to_owned(),
    })
}
