//! The closed velocity loop: commanded rate to angle, by the encoder and by the integrated gyro.

use analysis::estimate::Estimate;
use analysis::frf::{Frf, Line};
use analysis::margins::{self, MarginError};
use analysis::periodic::times_jw;

use super::honest::{self, Judged};
use super::pictures;
use super::point::Point;
use crate::kinds::response::excited::Channel;
use crate::measurement::{Measurement, PointResult};
use crate::quantity::QuantityKind as Q;

pub(super) const NAMES: &[&str] = &[
    "closed-velocity-bandwidth",
    "closed-velocity-peak",
    "closed-velocity-bandwidth-gyro",
    "closed-velocity-peak-gyro",
];
const ESTIMATOR: &str = "closed-velocity-loop/2";
/// The controller integrates: at the lowest frequencies the rate is the commanded one.
const STATIC_GAIN: f64 = 1.0;

/// The peak is read from lines up to here, below the first mode of the frame (10 Hz) and of the shaft (17 Hz).
const STIFF_HZ: f64 = 8.0;

/// A sensor that shows the angle: name, channel, how often that is to be integrated, and its measurands.
const SENSORS: [(&str, Channel, i32, [&str; 2]); 2] =
    [("encoder", Channel::Angle, 0, [NAMES[0], NAMES[1]]), ("gyro", Channel::Rate, 1, [NAMES[2], NAMES[3]])];

pub(super) fn evaluate(point: &Point<'_>, result: &mut PointResult) {
    for (sensor, channel, integrals, names) in SENSORS {
        let closed = read(point, sensor, channel, integrals, result);
        let kinds = [Q::Frequency, Q::Decibel];
        for (k, (name, kind)) in names.into_iter().zip(kinds).enumerate() {
            let found = closed.as_deref().map_err(Clone::clone).and_then(|lines| {
                let found = if k == 0 { bandwidth(lines) } else { peak(lines) };
                found.map_err(|e| e.to_string())
            });
            let axis = &point.case.axis;
            let measurement = match found {
                Ok((estimate, flags)) => {
                    Measurement { flags, ..Measurement::new(name, axis, kind, Some(estimate), ESTIMATOR) }
                }
                Err(reason) => Measurement::inconclusive(name, axis, kind, ESTIMATOR, reason),
            };
            result.measurements.push(point.measurement(measurement));
        }
    }
}

/// Lines of the closed loop that count; pictures show the response to the angle itself.
fn read(
    point: &Point<'_>,
    sensor: &str,
    channel: Channel,
    integrals: i32,
    result: &mut PointResult,
) -> Result<Frf, String> {
    let judged = point.response(Channel::Commanded, channel)?;
    let times = |lines: &Frf, n| times_jw(lines, n).map_err(|e| e.to_string());
    let angle = Judged {
        lines: times(&judged.lines, -integrals)?,
        hollow: times(&judged.hollow, -integrals)?,
        ..judged.clone()
    };
    let id = format!("velocity-command-to-angle-{sensor}-{}", point.slug());
    let title = format!("Velocity command to angle by the {sensor}, {}", point.case.point);
    result.plots.extend(pictures::bode(&id, &title, "s", &angle));
    result.excluded.extend(judged.excluded);
    match judged.presliding_below_hz {
        Some(corner_hz) => Err(honest::presliding(&point.measured, corner_hz)),
        None => times(&angle.lines, 1),
    }
}

fn bandwidth(lines: &[Line]) -> Result<(Estimate, Vec<String>), MarginError> {
    let found = margins::bandwidth(lines, Some(STATIC_GAIN))?;
    let value = found.frequency_hz;
    let u = found.u_hz;
    Ok((Estimate { value, u, dof: honest::freedom(lines), n: lines.len() }, Vec::new()))
}

fn peak(lines: &[Line]) -> Result<(Estimate, Vec<String>), MarginError> {
    let found = margins::peak(lines, STIFF_HZ)?;
    let value = found.gain_db;
    let u = found.gain_u_db;
    let estimate = Estimate { value, u, dof: honest::freedom(lines), n: lines.len() };
    let flags =
        vec![format!("at {:.2} Hz", found.frequency_hz), format!("chi2/dof {:.1}", found.misfit_ratio)];
    Ok((estimate, flags))
}
