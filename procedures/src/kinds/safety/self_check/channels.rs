//! What is looked at: one line a channel.

use crate::axis::{Axes, Axis};
use crate::device::MIRROR_AXES;
use crate::kinds::Measurand;
use crate::quantity::QuantityKind as Q;

/// A channel at rest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Watched {
    pub(super) topic: String,
    pub(super) channel: &'static str,
    /// What its measurements are said to belong to.
    pub(super) axis: String,
    pub(super) kind: Q,
    /// Measurand of its mean.
    pub(super) offset: Option<&'static str>,
    /// Measurand of its noise.
    pub(super) noise: Option<&'static str>,
    /// Channel that tells that the device speaks or sees, and how.
    pub(super) alive: Option<Alive>,
    /// Topic whose channel `position_rad` is taken off.
    pub(super) less: Option<String>,
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

/// All measurands of the kind.
pub(super) const MEASURANDS: &[Measurand] = &[
    Measurand::new("encoder-noise", Q::Angle, "Noise of an encoder while its axis rests."),
    Measurand::new("current-offset", Q::Current, "Mean motor current that a drive reports at zero torque."),
    Measurand::new(
        "current-noise",
        Q::Current,
        "Noise of the motor current that a drive reports at zero torque.",
    ),
    Measurand::new("bus-voltage-at-rest", Q::Voltage, "Mean voltage of the DC link."),
    Measurand::new("heat-sink-at-rest", Q::Temperature, "Mean temperature of a drive's heat sink."),
    Measurand::new(
        "gyro-offset",
        Q::AngularVelocity,
        "Mean rate of a gyro at rest, that of the Earth included.",
    ),
    Measurand::new("gyro-noise", Q::AngularVelocity, "Noise of a gyro at rest, in its logged rows."),
    Measurand::new(
        "accelerometer-offset",
        Q::Acceleration,
        "Mean of an accelerometer at rest, gravity included.",
    ),
    Measurand::new("accelerometer-noise", Q::Acceleration, "Noise of an accelerometer at rest."),
    Measurand::new("imu-temperature", Q::Temperature, "Mean temperature of the inertial unit."),
    Measurand::new(
        "mirror-gauge-offset",
        Q::Angle,
        "Mean tilt of the mirror by its strain gauges, command zero.",
    ),
    Measurand::new("mirror-gauge-noise", Q::Angle, "Noise of the strain gauges of the mirror."),
    Measurand::new("mirror-reference-offset", Q::Angle, "Mean tilt of the mirror by its autocollimator."),
    Measurand::new("mirror-reference-noise", Q::Angle, "Noise of the autocollimator of the mirror."),
    Measurand::new(
        "autocollimator-offset",
        Q::Angle,
        "Mean difference between an axis' autocollimator and its encoder.",
    ),
    Measurand::new(
        "autocollimator-noise",
        Q::Angle,
        "Noise of the difference between an axis' autocollimator and its encoder.",
    ),
    Measurand::new("analog-offset", Q::Voltage, "Mean of the looped-back analog input."),
    Measurand::new("analog-noise", Q::Voltage, "Noise of the looped-back analog input."),
    Measurand::new("clamp-offset", Q::Current, "Mean of a current clamp on the DC link."),
    Measurand::new("clamp-noise", Q::Current, "Noise of a current clamp on the DC link."),
    Measurand::new("force-gauge-offset", Q::Force, "Mean of the force gauge without a pull."),
    Measurand::new("force-gauge-noise", Q::Force, "Noise of the force gauge."),
    Measurand::new(MISSED, Q::Count, "Periods of the loop that were missed."),
    Measurand::new(LATENESS, Q::Time, "Worst lateness of a tick of the loop."),
];

impl Watched {
    /// A channel of a topic, with what its measurements belong to.
    fn new(topic: &str, channel: &'static str, axis: &str, kind: Q) -> Self {
        let topic = topic.to_owned();
        let axis = axis.to_owned();
        Self { topic, channel, axis, kind, offset: None, noise: None, alive: None, less: None }
    }

    /// The channel, with the measurand of its mean.
    fn mean(self, offset: &'static str) -> Self {
        Self { offset: Some(offset), ..self }
    }

    /// The channel, with the measurand of its noise.
    fn noise(self, noise: &'static str) -> Self {
        Self { noise: Some(noise), ..self }
    }

    fn alive(self, alive: Alive) -> Self {
        Self { alive: Some(alive), ..self }
    }

    /// Less the angle by the encoder of an axis.
    fn less_encoder(self, axis: &str) -> Self {
        Self { less: Some(topic_of(axis)), ..self }
    }
}

fn topic_of(axis: &str) -> String {
    format!("/{axis}")
}

/// Every channel of a rig with these axes, in the order of the report.
pub(super) fn channels(axes: &Axes) -> Vec<Watched> {
    let gimbal = axes.gimbal().map(|gimbal| gimbal.names()).unwrap_or(MIRROR_AXES);
    let mut all = of_drives(axes);
    all.extend(of_inertial_unit());
    all.extend(of_mirror(gimbal));
    all.extend(of_autocollimators(axes));
    all.extend(of_bench());
    all
}

fn of_drives(axes: &Axes) -> Vec<Watched> {
    let each =
        |channel, kind| axes.names().map(move |name| Watched::new(&topic_of(name), channel, name, kind));
    let encoders = each("position_rad", Q::Angle).map(|own| own.noise("encoder-noise"));
    let currents = each("current_a", Q::Current).map(|own| own.mean("current-offset").noise("current-noise"));
    let links = each("bus_v", Q::Voltage).map(|own| own.mean("bus-voltage-at-rest"));
    let sinks = each("heat_sink_degc", Q::Temperature).map(|own| own.mean("heat-sink-at-rest"));
    encoders.chain(currents).chain(links).chain(sinks).collect()
}

fn of_inertial_unit() -> Vec<Watched> {
    let gyro = |channel, axis| {
        let own = Watched::new("/imu", channel, axis, Q::AngularVelocity);
        own.mean("gyro-offset").noise("gyro-noise").alive(Alive::Counts("sequence"))
    };
    let accelerometer = |channel, axis| {
        let own = Watched::new("/imu", channel, axis, Q::Acceleration);
        own.mean("accelerometer-offset").noise("accelerometer-noise").alive(Alive::Counts("sequence"))
    };
    vec![
        gyro("rate_x_rad_per_s", "x"),
        gyro("rate_y_rad_per_s", "y"),
        gyro("rate_z_rad_per_s", "z"),
        accelerometer("acceleration_x_m_per_s2", "x"),
        accelerometer("acceleration_y_m_per_s2", "y"),
        accelerometer("acceleration_z_m_per_s2", "z"),
        Watched::new("/imu", "temperature_degc", "imu", Q::Temperature).mean("imu-temperature"),
    ]
}

/// The mirror turns the line of sight about these axes.
fn of_mirror([azimuth, elevation]: [&str; 2]) -> Vec<Watched> {
    let gauge = |channel, axis| {
        let own = Watched::new("/fsm", channel, axis, Q::Angle);
        own.mean("mirror-gauge-offset").noise("mirror-gauge-noise")
    };
    let reference = |channel, axis| {
        let own = Watched::new("/fsm", channel, axis, Q::Angle);
        own.mean("mirror-reference-offset").noise("mirror-reference-noise")
    };
    let echo = Watched::new("/fsm", "echo_in_v", "echo", Q::Voltage);
    vec![
        gauge("angle_az_rad", azimuth),
        gauge("angle_el_rad", elevation),
        reference("reference_az_rad", azimuth),
        reference("reference_el_rad", elevation),
        echo.mean("analog-offset").noise("analog-noise"),
    ]
}

fn of_autocollimators(axes: &Axes) -> Vec<Watched> {
    let [azimuth, elevation] = axes.pair();
    let autocollimator = |channel, sees, axis: Option<&Axis>| {
        let axis = axis?.name.as_str();
        let own = Watched::new("/reference", channel, axis, Q::Angle);
        let own = own.mean("autocollimator-offset").noise("autocollimator-noise");
        Some(own.alive(Alive::Is(sees)).less_encoder(axis))
    };
    let both = [
        autocollimator("deviation_az_rad", "sees_face_az", azimuth),
        autocollimator("deviation_el_rad", "sees_face_el", elevation),
    ];
    both.into_iter().flatten().collect()
}

fn of_bench() -> Vec<Watched> {
    let clamp = |channel, axis| {
        let own = Watched::new("/supply", channel, axis, Q::Current);
        own.mean("clamp-offset").noise("clamp-noise")
    };
    let force = Watched::new("/force", "force_n", "force", Q::Force);
    vec![
        clamp("supply_a", "supply"),
        clamp("shunt_a", "shunt"),
        force.mean("force-gauge-offset").noise("force-gauge-noise"),
    ]
}

/// What is said of the loop's clock.
pub(super) const CLOCK: &[(Clock, &str, Q, &str)] = &[
    (Clock::Missed, MISSED, Q::Count, "missed_periods"),
    (Clock::Lateness, LATENESS, Q::Time, "lateness_s"),
];
