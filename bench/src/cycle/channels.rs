//! What a row holds: the one place where channels of devices become channels of the log.

use crate::rig::device::Group;
use drivers::cia402::Cia402;
use drivers::device;
use procedures::log::{Channel, STOP_SUFFIX, Topic, Width};

/// Channels that the bench adds to a drive's own, as name, unit, width. Angles keep every bit of their counts; a torque or a
/// velocity of 24 bits is finer than any drive's 16 of torque or its counts per second, and a mean of doubles does not
/// compress.
const COMMANDS: &[(&str, &str, Width)] = &[
    ("torque_command_nm", "N*m", Width::F32),
    ("position_setpoint_rad", "rad", Width::F64),
    ("velocity_setpoint_rad_per_s", "rad/s", Width::F32),
    ("velocity_command_rad_per_s", "rad/s", Width::F32),
    ("velocity_feedback_rad_per_s", "rad/s", Width::F32),
    ("excitation", "1", Width::F32),
    ("controlword", "1", Width::U16),
    ("age_ticks", "1", Width::U16),
];

/// Channels of the loop itself.
const LOOP: &[(&str, &str, Width)] = &[
    ("tick", "1", Width::U32),
    ("lateness_s", "s", Width::F32),
    ("missed_periods", "1", Width::U16),
    ("working_counter", "1", Width::U16),
    ("state", "1", Width::U16),
];

/// Topics of a rig: one per axis, the loop's own, then one per device on the gimbal, then one per axis for the ticks of stops.
pub(crate) fn topics(axes: &[String], payload: &[Group]) -> Vec<Topic> {
    let mut topics: Vec<Topic> = axes.iter().map(|axis| axis_topic(axis)).collect();
    let channels = LOOP.iter().map(own).collect();
    topics.push(Topic { name: "/bench".to_owned(), message: "bench_msgs/msg/Loop".to_owned(), channels });
    topics.extend(payload.iter().map(|group| Topic {
        name: format!("/{}", group.topic),
        message: format!("bench_msgs/msg/{}", group.message),
        channels: group.channels.iter().map(logged).collect(),
    }));
    topics.extend(axes.iter().map(|axis| axis_topic(&format!("{axis}{STOP_SUFFIX}"))));
    topics
}

/// Channels of an axis.
pub(crate) fn of_axis() -> impl Iterator<Item = Channel> {
    Cia402::CHANNELS.iter().map(logged).chain(COMMANDS.iter().map(own))
}

/// Which channels of an axis are analog quantities, in the order of [`of_axis`]; allocates nothing.
pub(crate) fn analog_of_axis() -> impl Iterator<Item = bool> {
    let devices = Cia402::CHANNELS.iter().map(|c| matches!(c.width, device::Width::F64 | device::Width::F32));
    devices.chain(COMMANDS.iter().map(|(_, _, width)| matches!(width, Width::F64 | Width::F32)))
}

/// Where the statusword of a drive is among them.
pub(crate) fn statusword_of_axis() -> Option<usize> {
    Cia402::CHANNELS.iter().position(|channel| channel.name == "statusword")
}

fn axis_topic(axis: &str) -> Topic {
    let channels = of_axis().collect();
    Topic { name: format!("/{axis}"), message: "bench_msgs/msg/Axis".to_owned(), channels }
}

fn own(&(name, unit, width): &(&str, &str, Width)) -> Channel {
    Channel { name: name.to_owned(), unit: unit.to_owned(), width }
}

fn logged(channel: &device::Channel) -> Channel {
    let width = match channel.width {
        device::Width::F64 => Width::F64,
        device::Width::F32 => Width::F32,
        device::Width::I32 => Width::I32,
        device::Width::U32 => Width::U32,
        device::Width::U16 => Width::U16,
        device::Width::I8 => Width::I8,
    };
    own(&(channel.name, channel.unit, width))
}
