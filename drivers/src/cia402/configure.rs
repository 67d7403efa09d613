//! Identify, check, configure, read back: all of it over SDO, in PRE-OP, before anything can move.

use super::frames::{self, Direction};
use super::objects::{self, Access, DataType, Object};
use super::pdo::{Entry, Layout};
use super::profile::{DriveProfile, ProcessData, StartUp, TorqueScale};
use super::scale::Scale;
use super::sdo::{Dictionary, Waiting};
use super::{CyclicMode, DriveSettings, Identity};
use crate::device::DeviceError;
use crate::identity_range::IdentityRange;
use crate::wire::{PdoTransport, SdoWire};

/// Device profile number of CiA 402 in the low word of 1000h.
const PROFILE_402: i64 = 402;
/// Supported modes (6502h): CSV bit 8, CST bit 9.
const CYCLIC_MODES: i64 = 0x300;
/// Switches the drive's following error supervision off: in CSV and CST there is no position demand to follow.
const NO_FOLLOWING_ERROR: i64 = u32::MAX as i64;

/// Reads who the drive is and refuses one that is not a CiA 402 drive with both cyclic modes, or not of the type that its
/// profile describes.
pub(super) fn identify(
    drive: &mut Dictionary<'_, '_>,
    profile: &DriveProfile,
) -> Result<Identity, DeviceError> {
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
    let identity = Identity {
        device_name: text(drive, objects::DEVICE_NAME, profile)?,
        vendor: drive.read_u32(objects::VENDOR)?,
        product: drive.read_u32(objects::PRODUCT)?,
        revision: drive.read_u32(objects::REVISION)?,
        serial: drive.read_u32(objects::SERIAL)?,
        firmware: text(drive, objects::FIRMWARE, profile)?,
    };
    check_type(drive, &identity, profile)?;
    Ok(identity)
}

/// Whether a station is a CiA 402 drive, by its device type (1000h). One without mailbox or dictionary is none.
pub fn is_drive(wire: &mut dyn SdoWire, station: u16, waiting: &mut Waiting<'_>) -> bool {
    let mut dictionary = Dictionary { wire, waiting, device: "", station };
    dictionary.read(objects::DEVICE_TYPE).is_ok_and(|device_type| device_type & 0xFFFF == PROFILE_402)
}

/// A text of the drive, or `unknown` for a type that lacks it.
fn text(
    drive: &mut Dictionary<'_, '_>,
    object: Object,
    profile: &DriveProfile,
) -> Result<String, DeviceError> {
    if profile.lacks(object) { Ok("unknown".to_owned()) } else { drive.read_text(object) }
}

/// Refuses a drive of another type than the profile is for.
fn check_type(
    drive: &Dictionary<'_, '_>,
    identity: &Identity,
    profile: &DriveProfile,
) -> Result<(), DeviceError> {
    let id = &profile.id;
    let rows = [
        (objects::VENDOR, profile.identity.vendor.map(IdentityRange::one), identity.vendor),
        (objects::PRODUCT, profile.identity.product.map(IdentityRange::one), identity.product),
        (objects::REVISION, profile.identity.revisions.map(IdentityRange), identity.revision),
    ];
    for (object, allowed, found) in rows {
        let Some(allowed) = allowed.filter(|allowed| !allowed.contains(found)) else { continue };
        let expected = format!("{allowed} (profile `{id}`)");
        let help = "the drive is of another type: correct `profile` in the rig file, or check the wiring";
        return Err(drive.mismatch(object, expected, format!("{found:08X}h"), help));
    }
    Ok(())
}

/// Writes the start-up list of a profile in its order; each value is read back.
pub(super) fn start_up(drive: &mut Dictionary<'_, '_>, list: &[StartUp]) -> Result<(), DeviceError> {
    list.iter().try_for_each(|entry| {
        let object = entry.place.object("start-up list", entry.data_type, "");
        drive.write_checked(object, entry.value)
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
        // Where torque objects are currents, nothing is scaled by the rated torque.
        let is_used =
            object != objects::RATED_TORQUE || settings.profile.torque_scale == TorqueScale::RatedTorque;
        if is_used && !settings.profile.lacks(object) {
            drive.expect(object, value as i64, help)?;
        }
    }
    Ok(())
}

/// Reads the current limit that the drive was commissioned to, in A; `None` for a type that lacks it. The bench does not write
/// it: who commissioned the drive knows what motor and cables bear.
pub(super) fn commissioned_current_a(
    drive: &mut Dictionary<'_, '_>,
    settings: &DriveSettings,
) -> Result<Option<f64>, DeviceError> {
    if settings.profile.lacks(objects::MAX_CURRENT) {
        return Ok(None);
    }
    let permille = drive.read(objects::MAX_CURRENT)?;
    Ok(Some(permille as f64 / 1e3 * settings.rated_current_a))
}

/// Sets the process data of one direction as its profile has it; gives the layout that the drive reads back.
pub(super) fn map(
    drive: &mut Dictionary<'_, '_>,
    process_data: &ProcessData,
    [assignment, mapping]: [Object; 2],
) -> Result<Layout, DeviceError> {
    match (process_data, drive.wire.pdo_transport()) {
        (ProcessData::Mapped(entries), PdoTransport::Assigned) => {
            write_mapping(drive, entries, assignment, mapping)
        }
        (ProcessData::Assigned(pdos), PdoTransport::Assigned) => assign(drive, pdos, assignment),
        (ProcessData::Mapped(entries), PdoTransport::Frames) => {
            let is_received = mapping == objects::RX_MAPPING;
            let direction = if is_received { Direction::Receive } else { Direction::Transmit };
            frames::map(drive, direction, entries)?;
            let mut layout = Layout::default();
            entries.iter().for_each(|entry| layout.push(*entry));
            Ok(layout)
        }
        (ProcessData::Assigned(_), PdoTransport::Frames) => {
            let expected = "entries that can be mapped into PDOs of 8 bytes".to_owned();
            let help = "choose a profile with a mapping for a drive on CAN";
            Err(drive.mismatch(mapping, expected, "PDOs with fixed mappings".to_owned(), help))
        }
    }
}

/// Writes a mapping: counts to 0, entries, counts, assignment; each is read back.
fn write_mapping(
    drive: &mut Dictionary<'_, '_>,
    entries: &[Entry],
    assignment: Object,
    mapping: Object,
) -> Result<Layout, DeviceError> {
    let mut layout = Layout::default();
    drive.write_checked(assignment, 0)?;
    drive.write_checked(mapping, 0)?;
    for (sub, entry) in (1..).zip(entries) {
        drive.write_checked(list_entry(mapping, sub), i64::from(entry.word()))?;
        layout.push(*entry);
    }
    drive.write_checked(mapping, entries.len() as i64)?;
    drive.write_checked(list_entry(assignment, 1), i64::from(mapping.index))?;
    drive.write_checked(assignment, 1)?;
    Ok(layout)
}

/// Assigns PDOs with fixed mappings: count to 0, entries, count, each read back. Then reads what each of the PDOs holds.
fn assign(drive: &mut Dictionary<'_, '_>, pdos: &[u16], assignment: Object) -> Result<Layout, DeviceError> {
    drive.write_checked(assignment, 0)?;
    for (sub, &pdo) in (1..).zip(pdos) {
        drive.write_checked(list_entry(assignment, sub), i64::from(pdo))?;
    }
    drive.write_checked(assignment, pdos.len() as i64)?;
    let mut layout = Layout::default();
    for &pdo in pdos {
        let mapping = list(pdo, 0, DataType::U8);
        let count = drive.read(mapping)?;
        let subs = u8::try_from(count).ok().filter(|count| (1..=MOST_ENTRIES).contains(count));
        let Some(last) = subs else {
            let help = "the PDO has no fixed mapping: correct the process data in the profile of the drive";
            return Err(drive.mismatch(
                mapping,
                format!("1 to {MOST_ENTRIES} entries"),
                count.to_string(),
                help,
            ));
        };
        for sub in 1..=last {
            layout.push(Entry::of_word(drive.read_u32(list_entry(mapping, sub))?));
        }
    }
    Ok(layout)
}

/// Largest number of entries of a PDO (ETG.1000.6: sub-index FEh is the last one).
const MOST_ENTRIES: u8 = 0xFE;

/// An entry of a list whose sub-index 0 is its count.
fn list_entry(of: Object, sub: u8) -> Object {
    let data_type = if matches!(of.index, 0x1C12 | 0x1C13) { DataType::U16 } else { DataType::U32 };
    list(of.index, sub, data_type)
}

/// An object of a PDO list: as the table has it, else without a name of its own.
fn list(index: u16, sub: u8, data_type: DataType) -> Object {
    let unnamed =
        Object { index, sub, name: "PDO list", data_type, access: Access::ReadWrite, unit: "", doc: "" };
    objects::find(index, sub).unwrap_or(unnamed)
}

/// Writes mode, limits, reactions, watchdog and cycle time; each is read back.
pub(super) fn configure(
    drive: &mut Dictionary<'_, '_>,
    settings: &DriveSettings,
    scale: &Scale,
) -> Result<(), DeviceError> {
    check_watchdog(drive, settings)?;
    for (object, value) in values(settings, scale)? {
        drive.write_checked(object, value)?;
    }
    Ok(())
}

/// Refuses a drive without a watchdog of its own where the bus has none either: it would go on with its last command when the bench
/// falls silent.
fn check_watchdog(drive: &mut Dictionary<'_, '_>, settings: &DriveSettings) -> Result<(), DeviceError> {
    let profile = &settings.profile;
    let needed = "an object that takes the torque away when process data stay out";
    let Some(watchdog) = profile.watchdog else {
        if drive.wire.pdo_transport() == PdoTransport::Assigned {
            return Ok(());
        }
        return Err(DeviceError::Field {
            device: settings.name.clone(),
            field: "process data watchdog",
            expected: needed.to_owned(),
            found: format!("none in profile `{}`", profile.id),
            help: "a CAN bus has no watchdog: name the object of the drive in `[watchdog]` of a profile of its own",
        });
    };
    let object = watchdog.place.object("process data watchdog", watchdog.data_type, "steps");
    match drive.read(object) {
        Err(DeviceError::Abort { code: frames::NO_OBJECT, .. }) => {
            let help = "correct `[watchdog]` in the profile of the drive; without it the drive would go on with its last command \
                        when the bench falls silent";
            Err(drive.mismatch(object, needed.to_owned(), "no such object".to_owned(), help))
        }
        other => other.map(|_| ()),
    }
}

/// Object and value of the limits that a drive may be given in operation, without those that its type lacks.
pub(super) fn limits(settings: &DriveSettings, scale: &Scale) -> Result<Vec<(Object, i64)>, DeviceError> {
    let [low, high] = soft_limits(settings, scale)?;
    let max_torque = fit(settings, objects::MAX_TORQUE, "max_torque_nm", scale.max_torque_permille())?;
    let all = [max_torque, (objects::SOFT_LIMIT_MIN, low), (objects::SOFT_LIMIT_MAX, high)];
    Ok(all.into_iter().filter(|(object, _)| !settings.profile.lacks(*object)).collect())
}

/// Object and value of every setting, in the order of writing, without those that the type lacks.
fn values(settings: &DriveSettings, scale: &Scale) -> Result<Vec<(Object, i64)>, DeviceError> {
    let fit = |object, setting, counts| fit(settings, object, setting, counts);
    let (period, exponent) = period(settings)?;
    let max_speed = scale.counts(settings.max_velocity_rad_per_s);
    let deceleration = scale.counts(settings.quick_stop_deceleration_rad_per_s2);
    let mut all = vec![
        (objects::MODE, i64::from(CyclicMode::Torque.code())),
        (objects::ABORT_CONNECTION_OPTION, i64::from(settings.abort_connection_option)),
        (objects::QUICK_STOP_OPTION, i64::from(settings.quick_stop_option)),
        (objects::FAULT_REACTION_OPTION, i64::from(settings.fault_reaction_option)),
    ];
    all.extend(limits(settings, scale)?);
    all.extend([
        fit(objects::MAX_SPEED, "max_velocity_rad_per_s", max_speed)?,
        fit(objects::QUICK_STOP_DECELERATION, "quick_stop_deceleration_rad_per_s2", deceleration)?,
        (objects::FOLLOWING_ERROR_WINDOW, NO_FOLLOWING_ERROR),
        (objects::FOLLOWING_ERROR_TIME, 0),
    ]);
    if let Some(watchdog) = settings.profile.watchdog {
        let object = watchdog.place.object("process data watchdog", watchdog.data_type, "steps");
        all.push(fit(object, "watchdog_s", (settings.watchdog_s / watchdog.step_s).round())?);
    }
    all.extend([(objects::INTERPOLATION_PERIOD, period), (objects::INTERPOLATION_EXPONENT, exponent)]);
    all.retain(|(object, _)| !settings.profile.lacks(*object));
    Ok(all)
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
