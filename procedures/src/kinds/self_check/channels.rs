//! What is looked at: one line a channel.

use crate::kinds::Measurand;
use crate::quantity::QuantityKind as Q;

/// A channel at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Watched {
    pub(super) topic: &'static str,
    pub(super) channel: &'static str,
    /// What its measurements are said to belong to.
    pub(super) axis: &'static str,
    pub(super) kind: Q,
    /// Measurand of its mean.
    pub(super) offset: Option<&'static str>,
    /// Measurand of its noise.
    pub(super) noise: Option<&'static str>,
    /// Channel that tells that the device speaks or sees, and how.
    pub(super) alive: Option<Alive>,
    /// Topic and channel that is taken off.
    pub(super) less: Option<(&'static str, &'static str)>,
}

/// How a device shows that its rows mean something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Alive {
    /// This counter of its topic goes on.
    Counts(&'static str),
    /// This flag of its topic is 1 in every row.
    Is(&'static str),
}

/// A single number over all rows of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Clock {
    /// Periods that were missed.
    Missed,
    /// Worst lateness.
    Lateness,
}

pub(super) const MISSED: &str = "missed-periods";
pub(super) const LATENESS: &str = "lateness";

const fn measurand(name: &'static str, kind: Q, doc: &'static str) -> Measurand {
    Measurand { name, kind, doc }
}

/// All measurands of the kind.
pub(super) const MEASURANDS: &[Measurand] = &[
    measurand("encoder-noise", Q::Angle, "Noise of an encoder while its axis rests."),
    measurand("current-offset", Q::Current, "Mean motor current that a drive shows at zero torque."),
    measurand("current-noise", Q::Current, "Noise of the motor current that a drive shows at zero torque."),
    measurand("bus-voltage-at-rest", Q::Voltage, "Mean voltage of the DC link."),
    measurand("heat-sink-at-rest", Q::Temperature, "Mean temperature of a drive's heat sink."),
    measurand("gyro-offset", Q::AngularVelocity, "Mean rate of a gyro at rest, that of the Earth included."),
    measurand("gyro-noise", Q::AngularVelocity, "Noise of a gyro at rest, in its logged rows."),
    measurand("accelerometer-offset", Q::Acceleration, "Mean of an accelerometer at rest, gravity included."),
    measurand("accelerometer-noise", Q::Acceleration, "Noise of an accelerometer at rest."),
    measurand("imu-temperature", Q::Temperature, "Mean temperature of the inertial unit."),
    measurand("mirror-gauge-offset", Q::Angle, "Mean tilt of the mirror by its strain gauges, command zero."),
    measurand("mirror-gauge-noise", Q::Angle, "Noise of the strain gauges of the mirror."),
    measurand("mirror-reference-offset", Q::Angle, "Mean tilt of the mirror by its autocollimator."),
    measurand("mirror-reference-noise", Q::Angle, "Noise of the autocollimator of the mirror."),
    measurand("autocollimator-offset", Q::Angle, "Mean of an axis' autocollimator less its encoder."),
    measurand("autocollimator-noise", Q::Angle, "Noise of an axis' autocollimator less its encoder."),
    measurand("analog-offset", Q::Voltage, "Mean of the looped-back analog input."),
    measurand("analog-noise", Q::Voltage, "Noise of the looped-back analog input."),
    measurand("clamp-offset", Q::Current, "Mean of a current clamp on the DC link."),
    measurand("clamp-noise", Q::Current, "Noise of a current clamp on the DC link."),
    measurand("force-gauge-offset", Q::Force, "Mean of the force gauge while nobody pulls."),
    measurand("force-gauge-noise", Q::Force, "Noise of the force gauge."),
    measurand(MISSED, Q::Count, "Periods of the loop that were missed."),
    measurand(LATENESS, Q::Time, "Worst lateness of a tick of the loop."),
];

/// A channel with the names of its mean and its noise.
const fn watched(
    [topic, channel, axis]: [&'static str; 3],
    kind: Q,
    offset: Option<&'static str>,
    noise: Option<&'static str>,
) -> Watched {
    Watched { topic, channel, axis, kind, offset, noise, alive: None, less: None }
}

const fn both(place: [&'static str; 3], kind: Q, offset: &'static str, noise: &'static str) -> Watched {
    watched(place, kind, Some(offset), Some(noise))
}

const fn gyro(channel: &'static str, axis: &'static str) -> Watched {
    let own = both(["/imu", channel, axis], Q::AngularVelocity, "gyro-offset", "gyro-noise");
    Watched { alive: Some(Alive::Counts("sequence")), ..own }
}

const fn accelerometer(channel: &'static str, axis: &'static str) -> Watched {
    let own = both(["/imu", channel, axis], Q::Acceleration, "accelerometer-offset", "accelerometer-noise");
    Watched { alive: Some(Alive::Counts("sequence")), ..own }
}

const fn autocollimator(
    channel: &'static str,
    axis: &'static str,
    sees: &'static str,
    topic: &'static str,
) -> Watched {
    let own = both(["/reference", channel, axis], Q::Angle, "autocollimator-offset", "autocollimator-noise");
    Watched { alive: Some(Alive::Is(sees)), less: Some((topic, "position_rad")), ..own }
}

/// Every channel, in the order of the report.
pub(super) const CHANNELS: &[Watched] = &[
    watched(["/az", "position_rad", "az"], Q::Angle, None, Some("encoder-noise")),
    watched(["/el", "position_rad", "el"], Q::Angle, None, Some("encoder-noise")),
    both(["/az", "current_a", "az"], Q::Current, "current-offset", "current-noise"),
    both(["/el", "current_a", "el"], Q::Current, "current-offset", "current-noise"),
    watched(["/az", "bus_v", "az"], Q::Voltage, Some("bus-voltage-at-rest"), None),
    watched(["/el", "bus_v", "el"], Q::Voltage, Some("bus-voltage-at-rest"), None),
    watched(["/az", "heat_sink_degc", "az"], Q::Temperature, Some("heat-sink-at-rest"), None),
    watched(["/el", "heat_sink_degc", "el"], Q::Temperature, Some("heat-sink-at-rest"), None),
    gyro("rate_x_rad_per_s", "x"),
    gyro("rate_y_rad_per_s", "y"),
    gyro("rate_z_rad_per_s", "z"),
    accelerometer("acceleration_x_m_per_s2", "x"),
    accelerometer("acceleration_y_m_per_s2", "y"),
    accelerometer("acceleration_z_m_per_s2", "z"),
    watched(["/imu", "temperature_degc", "imu"], Q::Temperature, Some("imu-temperature"), None),
    both(["/fsm", "angle_az_rad", "az"], Q::Angle, "mirror-gauge-offset", "mirror-gauge-noise"),
    both(["/fsm", "angle_el_rad", "el"], Q::Angle, "mirror-gauge-offset", "mirror-gauge-noise"),
    both(["/fsm", "reference_az_rad", "az"], Q::Angle, "mirror-reference-offset", "mirror-reference-noise"),
    both(["/fsm", "reference_el_rad", "el"], Q::Angle, "mirror-reference-offset", "mirror-reference-noise"),
    both(["/fsm", "echo_in_v", "echo"], Q::Voltage, "analog-offset", "analog-noise"),
    autocollimator("deviation_az_rad", "az", "sees_face_az", "/az"),
    autocollimator("deviation_el_rad", "el", "sees_face_el", "/el"),
    both(["/supply", "supply_a", "supply"], Q::Current, "clamp-offset", "clamp-noise"),
    both(["/supply", "shunt_a", "shunt"], Q::Current, "clamp-offset", "clamp-noise"),
    both(["/force", "force_n", "force"], Q::Force, "force-gauge-offset", "force-gauge-noise"),
];

/// What is said of the loop's clock.
pub(super) const CLOCK: &[(Clock, &str, Q, &str)] = &[
    (Clock::Missed, MISSED, Q::Count, "missed_periods"),
    (Clock::Lateness, LATENESS, Q::Time, "lateness_s"),
];
