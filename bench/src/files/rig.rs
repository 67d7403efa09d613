//! Rig files: which devices there are, and the limits that the bench relies on.

use drivers::cia402::{DriveSettings, check_cycle};
use procedures::axis::AxisLimits;
use procedures::device::DeviceRole;
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::quantity::QuantityKind as K;
use procedures::table::{TableReader, read_file};

use super::profile;
use crate::model::axis::{AxisGuard, RigAxis, VelocityFeedback};
use crate::model::device::DeviceEntry;
use crate::model::rig::{Gimbal, Rig, Tier};
use crate::model::safety::Safety;
use crate::model::stopping::{Loads, StopModel};
use crate::rig::FEEDBACK_AGE_TICKS;
use crate::rig::devices::inertial::DATA_RATE;
use crate::rig::devices::{driver, reference};

mod axes;
mod can;
mod connections;
mod device;
mod drive;
mod fields;
mod instrument;
mod safety;
mod terminal;
mod unsafe_settings;

use connections::Connections;
pub use device::DEVICE_FIELDS;
use drive::Drives;
pub use fields::{AXIS_FIELDS, FIELDS};
pub(in crate::files) use instrument::day;
pub use safety::SAFETY_FIELDS;

/// Command-to-feedback latency that the requirement LAT-RT allows: what is seen is that old when the answer acts.
const TRANSPORT_LATENCY_S: f64 = 3.5e-3;

/// Rates of the tick that make sense: below it a stop begins late, above it no fieldbus cycle is as short.
const LOOP_RATES_HZ: [f64; 2] = [250.0, 20_000.0];

/// Reads a rig file.
///
/// # Errors
/// All mistakes at once.
pub fn read_rig(source: SourceFile) -> Result<Rig, Vec<Diagnostic>> {
    let mut drives = Drives::default();
    let read = read_file(&source, FIELDS, |t| read(t, &mut drives));
    let mut mistakes = drives.mistakes;
    match read {
        Ok(rig) if mistakes.is_empty() => Ok(Rig { source, ..rig }),
        Ok(_) => Err(mistakes),
        Err(own) => {
            mistakes.splice(..0, own);
            Err(mistakes)
        }
    }
}

fn read(t: &mut TableReader<'_>, drives: &mut Drives) -> Option<Rig> {
    let id = t.text("id");
    let title = t.text("title");
    let tier = t.text("tier").map(|tier| read_tier(&tier));
    let loop_rate_hz = t.positive("loop-rate");
    let missed = t.integer("max-missed-periods", 1);
    let law_deadline = t.positive("law-deadline");
    let parameters = t.text("parameters");
    let cycle_s = loop_rate_hz.map(|hz| 1.0 / hz);
    let bits = bits(t);
    let whole = cycle_s.zip(missed).map(|(cycle_s, missed)| Loop { cycle_s, missed: missed as f64, bits });
    let mut connections = Connections::new(tier);
    let mut axes = axes::read(t, |t, name| {
        let station = connections.station(t);
        read_axis(t, name, cycle_s, whole, |t, safety| drives.read(t, name, tier, cycle_s, safety, station))
    });
    check_rate(t, loop_rate_hz, cycle_s);
    check_law_deadline(t, law_deadline, whole.as_ref());
    let devices = device::read_all(t, &mut drives.mistakes);
    if let (Some(devices), Some(axes)) = (&devices, &mut axes) {
        attach_references(axes, devices);
    }
    let terminals = if t.has("terminal") { t.tables("terminal", terminal::read) } else { Some(Vec::new()) };
    let input = terminal::read_input(t);
    connections.check_terminals(t, terminals.as_deref().unwrap_or_default(), input.as_ref());
    let can = can::read(t, connections.is_can(), axes.as_deref(), cycle_s);
    let wires = connections.interface(t, devices.as_deref().unwrap_or_default());
    let instruments =
        if t.has("instrument") { t.tables("instrument", instrument::read) } else { Some(Vec::new()) };
    check_gyros(t, axes.as_deref(), devices.as_deref());
    if let (Some(axes), Some(devices), Some(rate_hz)) = (&axes, &devices, loop_rate_hz) {
        check_gyro_type(t, axes, devices, rate_hz);
    }
    Some(Rig {
        id: id?,
        title: title?,
        tier: tier?,
        follows_sync0: can.is_none() && wires.as_ref()?.is_some() && axes.as_ref()?.iter().all(has_sync0),
        interface: wires?,
        can,
        loop_rate_hz: loop_rate_hz?,
        max_missed_periods: u32::try_from(missed?).ok()?,
        law_deadline_s: law_deadline?,
        parameters: parameters?,
        axes: axes?,
        emergency_stop_bit: bits.0,
        emergency_stop_input: input.map(|input| input.what),
        enabling_switch_bit: bits.1,
        devices: devices?,
        terminals: terminals?.into_iter().map(|terminal| terminal.what).collect(),
        instruments: instruments?,
        source: SourceFile { name: String::new(), text: String::new() },
    })
}

/// A rate of the tick that a drive can be commanded at.
fn check_rate(t: &mut TableReader<'_>, loop_rate_hz: Option<f64>, cycle_s: Option<f64>) {
    if loop_rate_hz.is_some_and(|hz| !(LOOP_RATES_HZ[0]..=LOOP_RATES_HZ[1]).contains(&hz)) {
        let help = format!(
            "choose one from {} Hz to {} Hz; the director's own is 4 kHz",
            LOOP_RATES_HZ[0], LOOP_RATES_HZ[1]
        );
        t.mistake("loop-rate", "no drive of this rig can be commanded at this rate", Some(help));
    } else if let Some(Err(error)) = cycle_s.map(check_cycle) {
        let help =
            "choose a rate whose period is such a number, as 4 kHz (25e-5 s), 2 kHz, 1 kHz, 500 Hz or 250 Hz";
        t.mistake("loop-rate", format!("no drive accepts this period: {error}"), Some(help.to_owned()));
    }
}

/// While a law is waited for, no frame is sent.
fn check_law_deadline(t: &mut TableReader<'_>, deadline_s: Option<f64>, whole: Option<&Loop>) {
    let Some((deadline_s, whole)) = deadline_s.zip(whole) else { return };
    let longest_s = whole.missed * whole.cycle_s;
    // Periods of a rate in hertz are rounded.
    if deadline_s > longest_s * (1.0 + 1e-12) {
        let longest = K::Time.format(longest_s);
        t.mistake(
            "law-deadline",
            format!("expected at most {longest}, the time of `max-missed-periods`: no frame is sent while a law is waited for"),
            Some("shorten it, or allow more missed periods".to_owned()),
        );
    }
}

fn has_sync0(axis: &RigAxis) -> bool {
    axis.drive.profile.clock.has_sync0
}

/// A velocity loop on the gyro needs an inertial unit.
fn check_gyros(t: &mut TableReader<'_>, axes: Option<&[RigAxis]>, devices: Option<&[DeviceEntry]>) {
    let by_gyro = |axes: &[RigAxis]| axes.iter().any(|a| a.velocity_feedback == VelocityFeedback::Gyro);
    let has_gyro = |devices: &[DeviceEntry]| devices.iter().any(|d| d.role == Some(DeviceRole::InertialUnit));
    if axes.is_some_and(by_gyro) && !devices.is_none_or(has_gyro) {
        let help = "add an inertial unit as a `[[device]]`, or close the loop on the encoder".to_owned();
        t.mistake("axis", "a velocity loop uses the gyro, but the rig has no inertial unit", Some(help));
    }
}

/// Velocity loops on the gyro ask for messages that are often enough and for rates that the gyros measure.
fn check_gyro_type(t: &mut TableReader<'_>, axes: &[RigAxis], devices: &[DeviceEntry], loop_rate_hz: f64) {
    let unit = devices.iter().find(|entry| entry.role == Some(DeviceRole::InertialUnit));
    let mut by_gyro = axes.iter().filter(|axis| axis.velocity_feedback == VelocityFeedback::Gyro).peekable();
    let (Some(unit), Some(_)) = (unit, by_gyro.peek()) else { return };
    let least_hz = loop_rate_hz / f64::from(FEEDBACK_AGE_TICKS);
    if let Some(rate_hz) = unit.optional_number(DATA_RATE).filter(|rate_hz| *rate_hz < least_hz) {
        let message = format!(
            "`{}` sends {rate_hz} messages a second, its velocity loops need at least {least_hz}",
            unit.name
        );
        let help = format!(
            "raise `{DATA_RATE}`, lower `loop-rate`, or close the loops on the encoders: a message that is older than \
             {FEEDBACK_AGE_TICKS} periods is not used"
        );
        t.mistake("device", message, Some(help));
    }
    let range = driver(unit.driver).and_then(|driver| driver.rate_range_rad_per_s);
    let fastest = by_gyro.find(|axis| range.is_some_and(|r| axis.guard.safety.trip_velocity_rad_per_s > r));
    if let (Some(axis), Some(range)) = (fastest, range) {
        let text = |rad_per_s| procedures::quantity::QuantityKind::AngularVelocity.format(rad_per_s);
        let message = format!(
            "axis `{}` trips at {}, the gyros of `{}` measure up to {}",
            axis.name,
            text(axis.guard.safety.trip_velocity_rad_per_s),
            unit.name,
            text(range)
        );
        t.mistake("axis", message, Some("lower `trip-velocity`, or take another inertial unit".to_owned()));
    }
}

/// The tier of one of the words that its field allows.
fn read_tier(word: &str) -> Tier {
    match word {
        "paced" => Tier::Paced,
        "wired" => Tier::Wired,
        "hardware" => Tier::Hardware,
        _ => Tier::Virtual,
    }
}

/// Gives outer and inner axis what measures them from outside, or the first two axes of a rig without gimbal.
fn attach_references(axes: &mut [RigAxis], devices: &[DeviceEntry]) {
    let Some(entry) = devices.iter().find(|entry| entry.role == Some(DeviceRole::AngleReference)) else {
        return;
    };
    let pair = Gimbal::of(axes).map_or([0, 1], Gimbal::both);
    for (axis, reference) in pair.into_iter().zip(reference::angle_references(entry)) {
        if let Some(axis) = axes.get_mut(axis) {
            axis.limits.reference = reference;
        }
    }
}

/// Bits of 60FDh: emergency stop, enabling switch.
type Bits = (Option<u32>, Option<u32>);

/// What an axis must know of the whole rig.
#[derive(Clone, Copy)]
struct Loop {
    cycle_s: f64,
    /// Longest run of missed periods.
    missed: f64,
    bits: Bits,
}

fn bits(t: &mut TableReader<'_>) -> Bits {
    let bits = (bit(t, "emergency-stop-bit"), bit(t, "enabling-switch-bit"));
    if bits.0.is_some() && bits.0 == bits.1 {
        let help =
            "one input cannot signal both an open chain and a held switch: give each its own bit".to_owned();
        t.mistake(
            "enabling-switch-bit",
            "`emergency-stop-bit` and `enabling-switch-bit` are the same",
            Some(help),
        );
    }
    bits
}

fn bit(t: &mut TableReader<'_>, key: &'static str) -> Option<u32> {
    let bit = t.integer(key, 0)?;
    let fitting = u32::try_from(bit).ok().filter(|bit| *bit < 32);
    if fitting.is_none() {
        t.mistake(key, format!("`{key}`: 60FDh has no bit {bit}"), Some("bits 0 to 31".to_owned()));
    }
    fitting
}

fn read_axis(
    t: &mut TableReader<'_>,
    name: &str,
    cycle_s: Option<f64>,
    whole: Option<Loop>,
    read_drive: impl FnOnce(&mut TableReader<'_>, Option<&Safety>) -> Option<DriveSettings>,
) -> Option<RigAxis> {
    let carried_by = t.has("carried-by").then(|| t.text("carried-by")).flatten();
    let gains = t.has("gains").then(|| t.text("gains")).flatten();
    let written = t.table("safety", safety::read);
    let safety = written.as_ref().map(|written| &written.safety);
    let limits = read_limits(t, safety, cycle_s);
    let drive = read_drive(t, safety);
    let serial = profile::number(t, "serial");
    let velocity_feedback = match t.text("velocity-feedback").as_deref() {
        Some("gyro") => VelocityFeedback::Gyro,
        _ => VelocityFeedback::Encoder,
    };
    let written = written?;
    let drive = drive?;
    let whole = whole?;
    let limits = AxisLimits { torque_quantum_nm: drive.torque_quantum_nm(), ..limits? };
    let mut guard = guard(&limits, &written.safety, &whole);
    guard.watches_heat_sink = drive.profile.heat_sink.is_some();
    let settings = unsafe_settings::Settings {
        limits: &limits,
        safety: &written.safety,
        written: &written,
        guard: &guard,
        feedback: velocity_feedback,
        cycle_s: whole.cycle_s,
        max_missed_periods: whole.missed,
    };
    unsafe_settings::refuse(t, &settings);
    Some(RigAxis {
        name: name.to_owned(),
        carried_by,
        gains: gains.unwrap_or_else(|| name.to_owned()),
        limits,
        guard,
        drive,
        serial,
        velocity_feedback,
    })
}

fn read_limits(t: &mut TableReader<'_>, safety: Option<&Safety>, cycle_s: Option<f64>) -> Option<AxisLimits> {
    let travel = t.range("travel");
    let soft = t.range("soft-limits");
    let v = t.positive("max-velocity");
    let a = t.positive("max-acceleration");
    let j = t.positive("max-jerk");
    let torque = t.positive("max-torque");
    let kt = t.positive("torque-constant");
    let kt_u = t.quantity("torque-constant-uncertainty");
    let inertia = t.positive("inertia");
    let inertia_u = t.quantity("inertia-uncertainty");
    let friction = t.positive("expected-static-friction");
    let order = t.positive("cogging-order");
    let rated = t.positive("rated-torque");
    let bits = t.integer("encoder-bits", 8);
    Some(AxisLimits {
        travel_rad: travel?,
        soft_limits_rad: soft?,
        max_velocity_rad_per_s: v?,
        max_acceleration_rad_per_s2: a?,
        max_jerk_rad_per_s3: j?,
        max_torque_nm: torque?,
        torque_constant_nm_per_a: Some(kt?),
        torque_constant_u_ratio: kt_u?,
        measured_constant: None,
        inertia_kg_m2: inertia?,
        inertia_u_ratio: inertia_u?,
        torque_quantum_nm: rated? / 1000.0,
        encoder_quantum_rad: std::f64::consts::TAU / f64::from(counts_per_rev(bits?)),
        expected_static_friction_nm: friction?,
        expected_presliding_stiffness_nm_per_rad: safety?.presliding_stiffness_nm_per_rad,
        polarity_torque_nm: safety?.polarity_torque_nm,
        zero_tolerance_rad: safety?.zero_tolerance_rad,
        loop_rate_hz: 1.0 / cycle_s?,
        log_rate_hz: 0.0,
        cogging_orders_per_rev: order?,
        reference: None,
    })
}

fn guard(limits: &AxisLimits, safety: &Safety, whole: &Loop) -> AxisGuard {
    AxisGuard {
        safety: safety.clone(),
        stop: StopModel {
            travel_rad: limits.travel_rad,
            soft_limits_rad: limits.soft_limits_rad,
            inertia_kg_m2: limits.inertia_kg_m2,
            deceleration_rad_per_s2: safety.braking_deceleration_rad_per_s2,
            jerk_rad_per_s3: safety.stop_jerk_rad_per_s3,
            reaction_s: TRANSPORT_LATENCY_S + 4.0 * whole.cycle_s,
            blind_s: TRANSPORT_LATENCY_S + safety.watchdog_s,
            loads: safety.loads,
            friction: safety.friction,
            relaxation_rad: limits.expected_static_friction_nm / safety.presliding_stiffness_nm_per_rad,
            brake_nm: safety.brake_nm,
            end_stop_energy_j: safety.end_stop_energy_j,
        },
        max_torque_nm: limits.max_torque_nm,
        encoder_quantum_rad: limits.encoder_quantum_rad,
        worst_load_nm: worst_load_nm(&safety.loads, limits.travel_rad),
        emergency_stop_bit: whole.bits.0,
        enabling_switch_bit: whole.bits.1,
        watches_heat_sink: true,
    }
}

/// Largest torque that the loads have anywhere in the travel, found on a grid.
fn worst_load_nm(loads: &Loads, [low, high]: [f64; 2]) -> f64 {
    const STEPS: u32 = 360;
    let load_nm = |step: u32| loads.at(low + (high - low) * f64::from(step) / f64::from(STEPS)).abs();
    (0..=STEPS).map(load_nm).fold(0.0, f64::max)
}

fn counts_per_rev(bits: i64) -> u32 {
    1 << bits.clamp(8, 30)
}

#[cfg(test)]
pub(in crate::files) mod tests;
