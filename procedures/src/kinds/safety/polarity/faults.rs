//! From numbers to faults: one plain sentence each, with the path, the likely cause, what was expected and found.

use super::conclude::{Axis, ByGyro};
use crate::quantity::QuantityKind as Q;

/// Displacement over what is expected; friction of any size stays inside, a factor of ten does not.
const PRESLIDING: [f64; 2] = [0.25, 4.0];
/// Counts per turn against the gyro integral.
const TURN_RATIO: f64 = 0.02;
/// Torque against inertia and acceleration.
const TORQUE_RATIO: f64 = 0.2;
/// The motion is about the axis that is meant, or about the other one.
const SAME: f64 = 0.9;
/// A number counts where it is this many standard uncertainties from zero.
const SIGNIFICANT: f64 = 5.0;
/// Coverage of expanded uncertainties.
const COVERAGE: f64 = 2.0;
/// Within this of an angle, an encoder shows that angle with a wrong sign or scale, or that of the other axis.
const LIKELY_RAD: f64 = 5.0 * std::f64::consts::TAU / 360.0;
/// Less of the expected displacement than this is none.
const STILL: f64 = 0.02;
/// Less of the motion than this is none.
const SILENT: f64 = 0.1;

/// Every fault of one axis, the cause first.
pub(super) fn faults(axis: &Axis) -> Vec<String> {
    let name = &axis.name;
    let Some(pulses) = &axis.pulses else {
        let unproven = format!("{name} is not proven: {}", axis.why("no pulse was evaluated"));
        return pose(axis).into_iter().chain([unproven]).collect();
    };
    let mut all = Vec::new();
    let moved = pulses.presliding;
    if moved.0.abs() < STILL {
        all.push(format!(
            "no answer of {name}: its encoder shows {:.3} of the expected motion under torque; motor without current, \
             brake or lock engaged, or encoder of another axis",
            moved.0.abs()
        ));
        return all;
    }
    match &pulses.gyro {
        Some(gyro) => {
            if !motion(axis, gyro, &mut all) {
                return all;
            }
            if gyro.own.abs() >= SAME {
                all.extend(sign(name, moved.0, gyro.own));
            }
        }
        None => all.extend(sign_by_encoder(name, moved.0)),
    }
    let miscounts = turns(axis, &mut all);
    scale(axis, moved, if miscounts { axis.turned() } else { 1.0 }, &mut all);
    if all.is_empty() {
        all.extend(pose(axis));
    }
    if let Some(unfinished) = &axis.unfinished {
        all.push(format!("{name} is not proven: {unfinished}"));
    }
    all
}

/// Whether the gyros see the motion about the axis that is meant; false where axes are swapped, which explains all else.
fn motion(axis: &Axis, gyro: &ByGyro, all: &mut Vec<String>) -> bool {
    let name = &axis.name;
    let own = gyro.own;
    let other = gyro.other;
    if gyro.size.0 < SILENT || gyro.size.0 < SIGNIFICANT * gyro.size.1 {
        all.push(format!(
            "gyros silent on {name}: they show {:.2} of the motion of its encoder, expected 1",
            gyro.size.0
        ));
    } else if other.abs() > SAME && own.abs() < 1.0 - SAME {
        all.push(format!(
            "axes swapped: torque on {name} turns {} (gyros see {:.2} of the motion about it, expected 0); motor and encoder \
             cables of the two drives exchanged",
            axis.other,
            other.abs()
        ));
        return false;
    } else if own.abs() < SAME {
        all.push(format!(
            "gyro mounting: motion of {name} shows along [{:.2}, {:.2}, {:.2}] (left, up, ahead), expected [{:.2}, {:.2}, \
             {:.2}]; sign of one gyro or mounting angle wrong, or {name} not at the pose of the plan",
            gyro.along[0], gyro.along[1], gyro.along[2], axis.expected[0], axis.expected[1], axis.expected[2]
        ));
    }
    true
}

/// Without a gyro nobody can tell the sign of the torque from that of the encoder.
fn sign_by_encoder(name: &str, by_torque: f64) -> Option<String> {
    (by_torque < 0.0).then(|| {
        format!(
            "torque or encoder sign of {name}: the encoder goes against the torque (torque to encoder: expected +, found -); \
             motor phases exchanged, or the encoder mounted or set the other way round"
        )
    })
}

/// An encoder that is not where the plan wants its axis, before anything moves: gates refuse an angle outside the travel,
/// and then this is all there is.
fn pose(axis: &Axis) -> Option<String> {
    let [shown, wanted] = axis.rest?;
    let near = |a: f64, b: f64| (a - b).abs() <= LIKELY_RAD;
    if (shown - wanted).abs() <= axis.zero_tolerance_rad {
        return None;
    }
    let turn = std::f64::consts::TAU;
    let crossed = axis
        .other_rest
        .is_some_and(|[other_shown, other_wanted]| near(shown, other_wanted) && near(other_shown, wanted));
    let likely = if near(shown, wanted) {
        format!("encoder zero of {}: ", axis.name)
    } else if crossed {
        "axes swapped: ".to_owned()
    } else if near(shown, -wanted) {
        format!("encoder sign of {}: ", axis.name)
    } else if near(shown, wanted.rem_euclid(turn) / 2.0) {
        format!("encoder modulus of {}: ", axis.name)
    } else {
        format!("pose of {}: ", axis.name)
    };
    Some(format!(
        "{likely}at rest the encoder of {} shows {} where the plan has {} within {} (`zero-tolerance`); sign, zero, counts \
         per turn or cables of the encoder wrong, or the axis was not brought there",
        axis.name,
        Q::Angle.format(shown),
        Q::Angle.format(wanted),
        Q::Angle.format(axis.zero_tolerance_rad)
    ))
}

/// Which of the three is the odd one out.
fn sign(name: &str, by_torque: f64, by_gyro: f64) -> Option<String> {
    let [torque_encoder, encoder_gyro] = [by_torque, by_gyro].map(|v| if v > 0.0 { "+" } else { "-" });
    let (what, why) = match (torque_encoder, encoder_gyro) {
        ("+", "+") => return None,
        ("-", "+") => {
            ("torque sign", "encoder and gyro agree, both go against the torque: motor phases exchanged")
        }
        ("-", _) => (
            "encoder sign",
            "the encoder goes against torque and gyro: it is mounted or set the other way round",
        ),
        _ => ("gyro sign", "the gyro goes against torque and encoder: sign or mounting of the inertial unit"),
    };
    Some(format!(
        "{what} of {name}: {why} (torque to encoder: expected +, found {torque_encoder}; encoder to gyro: expected +, \
         found {encoder_gyro})"
    ))
}

/// Whether gyro and encoder disagree on the angle.
fn turns(axis: &Axis, all: &mut Vec<String>) -> bool {
    let Some((ratio, u)) = axis.best_size() else { return false };
    let wrong = (ratio - 1.0).abs() > TURN_RATIO + COVERAGE * u && ratio > SILENT;
    if wrong {
        all.push(format!(
            "encoder modulus of {}: the gyros turn {ratio:.3} times as far as the encoder (expected 1 within {TURN_RATIO}); \
             real counts per turn are {:.3} of what the drive says (608Fh)",
            axis.name,
            1.0 / ratio
        ));
    }
    wrong
}

/// Torque scale by presliding and by inertia; `turned` makes true angles of encoder angles.
fn scale(axis: &Axis, moved: (f64, f64), turned: f64, all: &mut Vec<String>) {
    let name = &axis.name;
    let ratio = moved.0.abs() * turned;
    if !(PRESLIDING[0]..=PRESLIDING[1]).contains(&ratio) {
        all.push(format!(
            "torque scale of {name}: a small torque moves the axis {ratio:.2} times as far as its bristles let it (expected \
             {} to {}); torque constant or scaling of the drive (6075h, 6076h)",
            PRESLIDING[0], PRESLIDING[1]
        ));
        return;
    }
    let Some((scale, u)) = axis.scale.map(|s| (s.value.abs() * turned, s.u.abs() * turned)) else { return };
    if (scale - 1.0).abs() > TORQUE_RATIO + COVERAGE * u {
        all.push(format!(
            "torque scale of {name}: the axis accelerates as by {scale:.2} of the torque that the drive reports (expected 1 \
             within {TORQUE_RATIO}, U = {:.2}); torque constant, scaling of the drive (6075h, 6076h) or inertia",
            COVERAGE * u
        ));
    }
}
