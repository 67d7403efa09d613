//! Topics as ROS 2 message definitions (`.msg`) and back.
//!
//! A channel is a line `float64 position_rad # rad`: type, field name, unit. The definition stands in the file as the
//! topic's schema, so that any ROS 2 tool decodes the rows and the reader knows the channels without the writer.

use super::broken::Broken;
use super::{Channel, Topic, Width};

/// Topic of the events.
pub(super) const EVENTS_TOPIC: &str = "/events";

const WIDTHS: [(Width, &str); 6] = [
    (Width::F64, "float64"),
    (Width::F32, "float32"),
    (Width::I32, "int32"),
    (Width::U32, "uint32"),
    (Width::U16, "uint16"),
    (Width::I8, "int8"),
];

fn type_name(width: Width) -> &'static str {
    WIDTHS.iter().find(|w| w.0 == width).map(|w| w.1).expect("the table lists every width")
}

/// The definition of a topic's message.
pub(super) fn definition(topic: &Topic) -> String {
    let line = |c: &Channel| format!("{} {} # {}\n", type_name(c.width), c.name, c.unit);
    topic.channels.iter().map(line).collect()
}

/// The channels of a definition, or `None` where it has other fields than our scalars.
pub(super) fn channels(definition: &str) -> Option<Vec<Channel>> {
    let mut channels = Vec::new();
    for line in definition.lines() {
        let (field, unit) = line.split_once('#').unwrap_or((line, ""));
        let mut words = field.split_whitespace();
        let Some(type_word) = words.next() else { continue };
        let width = WIDTHS.iter().find(|w| w.1 == type_word)?.0;
        let name = words.next()?.to_owned();
        if words.next().is_some() || !is_field_name(&name) {
            return None;
        }
        channels.push(Channel { name, unit: unit.trim().to_owned(), width });
    }
    (!channels.is_empty()).then_some(channels)
}

/// Whether a topic can be written so that [`channels`] and ROS 2 tools read it back.
///
/// # Errors
/// What is wrong with the topic.
pub(super) fn check(topic: &Topic) -> Result<(), Broken> {
    let name = &topic.name;
    if !name.starts_with('/') || name.len() < 2 || name == EVENTS_TOPIC {
        return Err(Broken::TopicName { name: name.clone(), taken: EVENTS_TOPIC });
    }
    if !matches!(topic.message.split('/').collect::<Vec<_>>()[..], [package, "msg", kind] if !package.is_empty() && !kind.is_empty())
    {
        return Err(Broken::MessageName { topic: name.clone(), found: topic.message.clone() });
    }
    if topic.channels.is_empty() {
        return Err(Broken::NoChannels { topic: name.clone() });
    }
    for (k, channel) in topic.channels.iter().enumerate() {
        if !is_field_name(&channel.name) {
            return Err(Broken::FieldName { topic: name.clone(), channel: channel.name.clone() });
        }
        if topic.channels[..k].iter().any(|c| c.name == channel.name) {
            return Err(Broken::ChannelTwice { topic: name.clone(), channel: channel.name.clone() });
        }
        if channel.unit.trim() != channel.unit || channel.unit.contains(char::is_control) {
            return Err(Broken::Unit { topic: name.clone(), unit: channel.unit.clone() });
        }
    }
    Ok(())
}

/// ROS 2 field names: lower case, digits and single underscores, a letter first, no underscore last.
fn is_field_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn topic(name: &str, message: &str, channels: &[(&str, &str, Width)]) -> Topic {
        let channel = |&(name, unit, width): &(&str, &str, Width)| Channel {
            name: name.to_owned(),
            unit: unit.to_owned(),
            width,
        };
        let channels = channels.iter().map(channel).collect();
        Topic { name: name.to_owned(), message: message.to_owned(), channels }
    }

    #[test]
    fn a_topic_is_a_message_definition_with_units_as_comments() {
        let az = topic(
            "/az",
            "bench_msgs/msg/Axis",
            &[
                ("position_rad", "rad", Width::F64),
                ("status_word", "", Width::U16),
                ("mode", "count", Width::I8),
            ],
        );
        insta::assert_snapshot!(definition(&az), @r"
        float64 position_rad # rad
        uint16 status_word # 
        int8 mode # count
        ");
        assert_eq!(channels(&definition(&az)), Some(az.channels));
    }

    #[test]
    fn definitions_of_others_are_not_ours() {
        assert_eq!(channels("std_msgs/Header header\nfloat64 x"), None);
        assert_eq!(channels("float64[3] x"), None);
        assert_eq!(channels("float64 x 1.0"), None);
        assert_eq!(channels("# only a comment\n\n"), None);
    }

    #[test]
    fn topics_that_ros_2_could_not_read_are_refused() {
        let rad = [("x_rad", "rad", Width::F64)];
        let refused = |t: &Topic| check(t).expect_err("this topic has a mistake").to_string();
        let messages = [
            refused(&topic("az", "m/msg/A", &rad)),
            refused(&topic("/events", "m/msg/A", &rad)),
            refused(&topic("/az", "m/A", &rad)),
            refused(&topic("/az", "m/msg/A", &[])),
            refused(&topic("/az", "m/msg/A", &[("Position", "rad", Width::F64)])),
            refused(&topic("/az", "m/msg/A", &[rad[0], rad[0]])),
            refused(&topic("/az", "m/msg/A", &[("x", "a\nb", Width::F64)])),
        ];
        insta::assert_snapshot!(messages.join("\n"), @r#"
        topic `az`: expected a name like `/az` (`/events` is taken)
        topic `/events`: expected a name like `/az` (`/events` is taken)
        topic `/az`: expected a message like `bench_msgs/msg/Axis`, found `m/A`
        topic `/az` has no channels
        topic `/az`: `Position` is not a ROS 2 field name
        topic `/az` has two channels `x_rad`
        topic `/az`: unit "a\nb" does not fit on a line
        "#);
    }

    proptest! {
        #[test]
        fn any_text_is_channels_or_foreign(text in ".{0,200}") {
            prop_assert!(channels(&text).is_none_or(|c| c.iter().all(|c| is_field_name(&c.name))));
        }

        #[test]
        fn what_passes_the_check_reads_back(name in "[a-z][a-z0-9_]{0,8}", unit in "[ -~]{0,6}", width in 0_usize..6) {
            let one = topic("/t", "m/msg/T", &[(&name, &unit, WIDTHS[width].0)]);
            if check(&one).is_ok() {
                prop_assert_eq!(channels(&definition(&one)), Some(one.channels));
            }
        }
    }
}
