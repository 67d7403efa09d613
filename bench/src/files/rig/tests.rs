use super::*;
use crate::files::shipped::{self, Folder};
use crate::model::safety::SAFETY_PARAMETERS;
use procedures::quantity::QuantityKind;

/// What is said of the shipped rig after these replacements, each of the first place where the text stands.
fn said(edits: &[(&str, &str)]) -> String {
    let mut text = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig").text;
    for (old, new) in edits {
        assert!(text.contains(old), "the rig file no longer says {old}");
        text = text.replacen(old, new, 1);
    }
    told(&read_rig(SourceFile::new("rig.toml", text)).err().unwrap_or_default())
}

/// Mistakes as people read them, without the numbers of lines: a rig file that grows by a key shifts them all.
pub(in crate::files) fn told(mistakes: &[Diagnostic]) -> String {
    let all = mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n");
    all.lines().map(without_number).collect::<Vec<_>>().join("\n")
}

fn without_number(line: &str) -> String {
    if let Some((file, column)) = line.trim_start().strip_prefix("--> ").and_then(|at| at.rsplit_once(':')) {
        let file = file.trim_end_matches(|c: char| c.is_ascii_digit());
        return format!("  --> {file}[line]:{column}");
    }
    let rest = line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit());
    if rest.starts_with(['|', '=']) { format!("  {rest}") } else { line.to_owned() }
}

#[test]
fn the_shipped_rig_is_accepted() {
    assert_eq!(said(&[]), "");
}

/// Two files with the same limits: what is changed in one must be changed in the other.
#[test]
fn the_paced_rig_and_that_of_the_short_base_tick_are_the_shipped_one_but_for_tier_and_tick() {
    let read = |name: &str| {
        let text = shipped::find(Folder::Rigs, name, None).expect("a shipped rig").text;
        let own =
            ["id", "title", "tier", "loop-rate", "max-missed-periods", "law-deadline", "data-rate", "#"];
        let rest = text.lines().filter(|line| !own.iter().any(|key| line.starts_with(key)));
        (
            rest.map(str::to_owned).collect::<Vec<_>>(),
            read_rig(SourceFile::new(name, text)).expect("it parses"),
        )
    };
    let ((of_sim, sim), (of_short, short)) = (read("sim"), read("sim-50us"));
    assert_eq!(of_sim, of_short);
    let (of_paced, paced) = read("paced");
    assert_eq!((of_sim, paced.tier), (of_paced, Tier::Paced));
    // Ticks of the same time without an exchange are tolerated.
    let missed_s = |rig: &Rig| f64::from(rig.max_missed_periods) / rig.loop_rate_hz;
    assert!((missed_s(&sim) - missed_s(&short)).abs() < 1e-12 && short.loop_rate_hz == 20_000.0);
}

#[test]
fn every_recommended_value_and_every_end_of_a_range_parses_and_fits() {
    for p in SAFETY_PARAMETERS {
        let Some(kind) = p.kind() else { continue };
        let [least, most] = [p.least, p.most].map(|text| kind.parse(text).expect(p.key));
        assert!(least < most, "{}", p.key);
        let values = kind.parse_range(p.recommended).map(Vec::from);
        let value = values.or_else(|_| kind.parse(p.recommended).map(|value| vec![value]));
        for value in value.unwrap_or_default() {
            assert!((least..=most).contains(&value), "{}: {}", p.key, p.recommended);
        }
        assert!(!p.doc.is_empty() && !p.reason.is_empty() && !p.recommended.is_empty(), "{}", p.key);
    }
    assert!(QuantityKind::AngularJerk.parse("9000 deg/s^3").is_ok());
}

/// The line of the first axis that holds this key.
fn line_of(key: &str) -> Option<String> {
    let text = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig").text;
    text.lines().find(|line| line.starts_with(&format!("{key} = "))).map(str::to_owned)
}

#[test]
fn a_rig_that_leaves_a_safety_parameter_out_is_told_the_recommended_value_and_the_reason() {
    for p in SAFETY_PARAMETERS.iter().filter(|p| p.key != "safe-pose") {
        let line = line_of(p.key).unwrap_or_else(|| panic!("{} is not in the shipped rig", p.key));
        let told = said(&[(&line, "")]);
        let expected = format!("`{}` is missing; recommended {}: {}", p.key, p.recommended, p.reason);
        assert!(told.contains(&expected), "{}: {told}", p.key);
    }
}

#[test]
fn a_value_out_of_its_range_is_refused_with_range_and_reason() {
    for p in SAFETY_PARAMETERS {
        let Some(kind) = p.kind() else { continue };
        let line = line_of(p.key).unwrap_or_else(|| "polarity-torque = ".to_owned());
        let far = kind.format(2.0 * kind.parse(p.most).expect("a test of its own"));
        let band = p.key == "bus-voltage";
        let value = if band { format!("{} .. {far}", p.least) } else { far };
        let new = format!("{} = \"{value}\"", p.key);
        let new = if p.key == "safe-pose" { format!("{new}\n{line}") } else { new };
        let told = said(&[(&line, &new)]);
        let expected = format!("`{}` must lie in {}, found ", p.key, p.range());
        assert!(told.contains(&expected) && told.contains(p.reason), "{}: {told}", p.key);
    }
}

#[test]
fn the_message_of_an_omitted_key() {
    insta::assert_snapshot!(said(&[("stop-jerk = \"9000 deg/s^3\"", "")]));
}

#[test]
fn the_message_of_a_value_out_of_range() {
    insta::assert_snapshot!(said(&[("max-heat-sink = \"83 degC\"", "max-heat-sink = \"87 degC\"")]));
}

#[test]
fn a_trip_velocity_that_is_not_above_the_largest_rate() {
    insta::assert_snapshot!(said(&[("trip-velocity = \"66 deg/s\"", "trip-velocity = \"62 deg/s\"")]));
}

#[test]
fn soft_limits_at_the_end_of_the_travel() {
    insta::assert_snapshot!(said(&[("\"-159 deg .. 159 deg\"", "\"-160 deg .. 159 deg\"")]));
}

#[test]
fn a_braking_deceleration_that_the_motor_does_not_give() {
    insta::assert_snapshot!(said(&[("max-torque = \"2556 N*m\"", "max-torque = \"1401 N*m\"")]));
}

#[test]
fn a_braking_deceleration_below_that_of_a_planned_move() {
    let edit = ("braking-deceleration = \"100 deg/s^2\"", "braking-deceleration = \"80 deg/s^2\"");
    insta::assert_snapshot!(said(&[edit]));
}

#[test]
fn a_watchdog_of_less_than_ten_ticks() {
    let edits = [
        ("process-data-watchdog = \"20 ms\"", "process-data-watchdog = \"2 ms\""),
        ("max-missed-periods = 20 ", "max-missed-periods = 4 "),
    ];
    insta::assert_snapshot!(said(&edits));
}

#[test]
fn a_watchdog_of_more_than_fifty_milliseconds() {
    let edit = ("process-data-watchdog = \"20 ms\"", "process-data-watchdog = \"51 ms\"");
    insta::assert_snapshot!(said(&[edit]));
}

#[test]
fn more_missed_periods_than_the_watchdog_of_the_drive_bears() {
    insta::assert_snapshot!(said(&[("max-missed-periods = 20 ", "max-missed-periods = 100 ")]));
}

#[test]
fn a_rig_that_says_nothing_else_waits_a_hundred_microseconds_for_a_law() {
    let sim = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig");
    let waits_s = read_rig(sim).expect("it parses").law_deadline_s;
    assert!((waits_s - 100e-6).abs() < 1e-15, "{waits_s}");
}

#[test]
fn a_law_that_is_waited_for_longer_than_periods_may_be_missed() {
    let edit = ("max-missed-periods = 20 ", "law-deadline = \"6 ms\"\nmax-missed-periods = 20 ");
    insta::assert_snapshot!(said(&[edit]));
}

#[test]
fn a_stop_that_does_not_fit_between_the_soft_limits() {
    let edits = [
        ("trip-velocity = \"66 deg/s\"", "trip-velocity = \"199 deg/s\""),
        ("\"-159 deg .. 159 deg\"", "\"-90 deg .. 90 deg\""),
    ];
    insta::assert_snapshot!(said(&edits));
}

#[test]
fn a_trip_acceleration_that_every_stop_reaches() {
    let edit = ("trip-acceleration = \"200 deg/s^2\"", "trip-acceleration = \"100 deg/s^2\"");
    insta::assert_snapshot!(said(&[edit]));
}

#[test]
fn a_polarity_torque_that_does_not_break_the_axis_away() {
    insta::assert_snapshot!(said(&[("polarity-torque = \"480 N*m\"", "polarity-torque = \"250 N*m\"")]));
}

#[test]
fn a_polarity_torque_beyond_what_the_drive_gives() {
    insta::assert_snapshot!(said(&[("polarity-torque = \"480 N*m\"", "polarity-torque = \"2600 N*m\"")]));
}

#[test]
fn a_released_axis_that_friction_holds_nowhere() {
    let edits = [
        ("unbalance = \"0 N*m\"", "unbalance = \"1000 N*m\""),
        ("spring-rate = \"0 N*m/rad\"", "spring-rate = \"500 N*m/rad\""),
        ("spring-rest = \"0 deg\"", "spring-rest = \"300 deg\""),
        ("braking-deceleration = \"100 deg/s^2\"", "braking-deceleration = \"10 deg/s^2\""),
        ("max-acceleration = \"93 deg/s^2\"", "max-acceleration = \"9 deg/s^2\""),
        ("max-torque = \"2556 N*m\"", "max-torque = \"5000 N*m\""),
        ("safe-state = \"hold\"", "safe-state = \"release\""),
    ];
    insta::assert_snapshot!(said(&edits));
}

#[test]
fn a_released_axis_that_swings_away_from_its_safe_pose() {
    let line = format!("{:<42} # if released at the ends", "safe-state = \"hold\"");
    let edits = [
        ("spring-rest = \"40 deg\"", "spring-rest = \"0 deg\""),
        (line.as_str(), "safe-state = \"release\"\nsafe-pose = \"85 deg\" #"),
    ];
    insta::assert_snapshot!(said(&edits));
}

#[test]
fn a_safe_pose_outside_the_soft_limits() {
    insta::assert_snapshot!(said(&[(
        "safe-state = \"hold\"",
        "safe-state = \"hold\"\nsafe-pose = \"159.5 deg\""
    )]));
}

#[test]
fn a_least_static_friction_above_the_expected() {
    insta::assert_snapshot!(said(&[(
        "least-static-friction = \"190 N*m\"",
        "least-static-friction = \"220 N*m\""
    )]));
}

#[test]
fn a_least_running_friction_above_the_static() {
    insta::assert_snapshot!(said(&[(
        "least-running-friction = \"135 N*m\"",
        "least-running-friction = \"195 N*m\""
    )]));
}

#[test]
fn a_continuous_torque_above_the_largest() {
    insta::assert_snapshot!(said(&[(
        "continuous-torque = \"1278 N*m\"",
        "continuous-torque = \"3000 N*m\""
    )]));
}

#[test]
fn a_loop_on_the_gyro_that_may_not_disagree_at_all() {
    let edit = ("max-rate-disagreement = \"2.3 deg/s\"", "max-rate-disagreement = \"0 deg/s\"");
    insta::assert_snapshot!(said(&[edit]));
}

#[test]
fn one_bit_for_emergency_stop_and_enabling_switch() {
    insta::assert_snapshot!(said(&[(
        "emergency-stop-bit = 3",
        "emergency-stop-bit = 3\nenabling-switch-bit = 3"
    )]));
}

#[test]
fn a_bit_that_60fdh_does_not_have() {
    insta::assert_snapshot!(said(&[("emergency-stop-bit = 3", "emergency-stop-bit = 32")]));
}

#[test]
fn a_device_whose_driver_nobody_knows() {
    insta::assert_snapshot!(said(&[("driver = \"kvh-1775\"", "driver = \"kvh-1750\"")]));
}

#[test]
fn a_device_that_lacks_a_port_of_its_driver_and_has_one_that_it_does_not_know() {
    let edit =
        ("line = \"sim:mirror\", card = \"sim:analog\"", "line = \"sim:mirror\", cord = \"sim:analog\"");
    insta::assert_snapshot!(said(&[edit]));
}

#[test]
fn an_address_that_names_no_sort_of_connection() {
    insta::assert_snapshot!(said(&[("socket = \"sim:coarse\"", "socket = \"239.0.0.1\"")]));
}

#[test]
fn a_key_that_belongs_to_another_driver() {
    insta::assert_snapshot!(said(&[("format = \"A\"", "fromat = \"A\"")]));
}

#[test]
fn two_devices_of_one_name_and_two_of_one_role() {
    let second = "[[device]]\nname = \"imu\"\ndriver = \"kvh-1775\"\nports = { line = \"sim:imu\" }\n\n[[device]]\n\
                  name = \"gyros\"\ndriver = \"kvh-1775\"\nports = { line = \"sim:imu\" }\n\n[[device]]\nname = \"fine\"";
    insta::assert_snapshot!(said(&[("[[device]]\nname = \"fine\"", second)]));
}

#[test]
fn two_signals_on_one_channel_of_a_card() {
    insta::assert_snapshot!(said(&[(
        "clamp-range = \"100 A\" ",
        "supply-input = 4\nclamp-range = \"100 A\" "
    )]));
}

#[test]
fn settings_that_a_driver_refuses() {
    let edits = [
        ("azimuth-relay = 1 ", "azimuth-relay = 256 "),
        ("elevation-channel = 3", "elevation-channel = 1"),
        ("clamp-range = \"100 A\" ", "clamp-range = \"0 A\" "),
        ("baud = 4147200", "baud = 300"),
    ];
    insta::assert_snapshot!(said(&edits));
}

#[test]
fn a_loop_on_the_gyro_of_a_rig_without_an_inertial_unit() {
    let text = shipped::find(Folder::Rigs, "sim", None).expect("a shipped rig").text;
    let from = text.find("[[device]]\nname = \"imu\"").expect("the inertial unit");
    let to = text.find("[[device]]\nname = \"fsm\"").expect("the mirror");
    insta::assert_snapshot!(said(&[(&text[from..to], "")]));
}
