//! Friction, loads, cogging, inertia and delays of a drive train.

use std::f64::consts::{FRAC_PI_2, TAU};

use procedures::quantity::QuantityKind;
use sim_devices::physics::lugre::{Contact, LuGre};

use super::Shown;

/// Step of the contact where only its steady torque is asked for.
const STEP_S: f64 = 50e-6;

/// Steady torque of the contact at the rate that was reached.
pub(in crate::identify) fn friction_nm(s: &Shown<'_>) -> Option<f64> {
    let rate_rad_per_s = s.condition("velocity")?;
    (rate_rad_per_s != 0.0).then_some(LuGre::new(s.axis()?, STEP_S).steady_torque_nm(rate_rad_per_s.abs()))
}

/// A ramp is looked at up to here, in static torques over bristle stiffness.
const BREAKAWAY_SPAN: f64 = 8.0;
/// Step of a ramp: a thousandth of the time that it takes to reach the static torque, and not more than this.
const LONGEST_STEP_S: f64 = 2e-4;
/// A ramp that has not broken away after so many steps never will.
const MOST_STEPS: usize = 1_000_000;

/// Largest friction from rest to eight times the static torque over the bristle stiffness, on a ramp of torque, the structure
/// rigid and the load subtracted, as the procedure does.
pub(in crate::identify) fn breakaway_nm(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    let rate_nm_per_s = own.torque_constant_nm_per_a * s.condition("rate")?.abs();
    let step_s = (1e-3 * own.static_torque_nm / rate_nm_per_s).clamp(1e-6, LONGEST_STEP_S);
    let law = LuGre::new(own, step_s);
    let mut contact = Contact { age_s: s.condition("dwell").unwrap_or(0.0), ..Contact::default() };
    let end_rad = BREAKAWAY_SPAN * own.static_torque_nm / own.bristle_stiffness_nm_per_rad;
    let mut angle_rad = 0.0;
    let mut rate_rad_per_s = 0.0;
    let mut largest_nm = 0.0_f64;
    for step in 1..=MOST_STEPS {
        let friction_nm = law.advance(&mut contact, rate_rad_per_s);
        largest_nm = largest_nm.max(friction_nm);
        let motor_nm = rate_nm_per_s * step as f64 * step_s;
        rate_rad_per_s += (motor_nm - friction_nm) / own.inertia_kg_m2 * step_s;
        angle_rad += rate_rad_per_s * step_s;
        if angle_rad >= end_rad {
            return Some(largest_nm);
        }
    }
    None
}

/// Inertia over the rigid gain at the elevation, by what an ampere is worth in the rig file.
pub(in crate::identify) fn apparent_inertia_kg_m2(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    let structure = s.structure()?;
    let gain = structure.interpolate(&structure.rigid_gain_ratio, s.condition("elevation")?);
    Some(own.inertia_kg_m2 / gain * s.setup.rig_nm_per_a[s.place()?] / own.torque_constant_nm_per_a)
}

/// At the end of the travel that the flag names; nothing where it is not told from zero.
pub(in crate::identify) fn spring_nm(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    let end_rad = QuantityKind::Angle.parse(s.finding.flag("largest at ")?).ok()?;
    s.above_noise((own.spring_stiffness_nm_per_rad * (end_rad - own.spring_rest_rad)).abs())
}

/// Which of the two lines of the unit a finding is about, 1 or 2; others have no setting.
fn line(s: &Shown<'_>) -> Option<f64> {
    let order = s.condition("order")? / s.axis()?.cogging_orders_per_rev;
    [1.0, 2.0].into_iter().find(|line| (order - line).abs() < 0.1)
}

pub(in crate::identify) fn cogging_nm(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    Some(if line(s)? < 1.5 { own.cogging_amplitude_nm } else { own.cogging_second_amplitude_nm })
}

/// Of the torque that turns the axis against cogging, as a cosine of the encoder's angle; shifted by whole turns to the finding.
pub(in crate::identify) fn cogging_phase_rad(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    let line = line(s)?;
    let phase_rad = if line < 1.5 { own.cogging_phase_rad } else { own.cogging_second_phase_rad };
    let phase_rad = phase_rad + FRAC_PI_2 + line * own.cogging_orders_per_rev * own.encoder_zero_rad;
    Some(phase_rad + TAU * ((s.finding.value - phase_rad) / TAU).round())
}

/// Delays of the drive, and one exchange of the bus.
pub(in crate::identify) fn round_trip_s(s: &Shown<'_>) -> Option<f64> {
    Some(out_s(s)? + s.axis()?.sensor_delay_s)
}

/// The exchange that takes the command to the drive, and the delay there.
pub(in crate::identify) fn out_s(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    Some(s.setup.tick_s + own.command_delay_s + 0.5 * own.delay_jitter_s)
}

/// Standard deviation of a uniform distribution of the setting's width.
pub(in crate::identify) fn jitter_s(s: &Shown<'_>) -> Option<f64> {
    s.above_noise(s.axis()?.delay_jitter_s / 12.0_f64.sqrt())
}

/// The drive counts currents in thousandths of its rated current.
const COUNTS_PER_RATED: f64 = 1000.0;

/// Noise of the measured current, and what rounding to counts adds.
pub(in crate::identify) fn current_noise_a(s: &Shown<'_>) -> Option<f64> {
    let own = s.axis()?;
    let count_a = own.rated_current_a / COUNTS_PER_RATED;
    Some(own.current_noise_a.hypot(count_a / 12.0_f64.sqrt()))
}
