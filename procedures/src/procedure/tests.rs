use super::sample::{Mean, SAMPLE_KINDS, sample_axes, sample_case};
use super::*;
use crate::log::{Channel, PointStatus, Rows, Topic, Width};
use crate::reason::Reason;

const RIGHT: &str = r#"
schema = 1
id = "AZ-FRICTION"
title = "Friction, azimuth"
kind = "sample"
axis = "az"
log-rate = "1 kHz"
[sweep]
velocity = ["2 deg/s", "10 deg/s", "60 deg/s"]
[gate]
heat-sink = "< 60 degC"
bus-voltage = "480 V .. 620 V"
[valid-if]
velocity = "within 5 % of requested"
dropped-cycles = "< 0.1 %, longest < 5 ms"
"#;

fn read(text: &str) -> Result<Procedure, Vec<Diagnostic>> {
    Procedure::parse_with(SourceFile::new("fat/az-friction.toml", text.trim_start()), SAMPLE_KINDS)
}

fn printed(mistakes: &[Diagnostic]) -> String {
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn right() -> Procedure {
    read(RIGHT).expect("the file is right")
}

fn window(status: PointStatus, missed: &[f64]) -> Window {
    let channel = Channel { name: "missed_periods".into(), unit: "1".into(), width: Width::U32 };
    let topic =
        Topic { name: "/bench".into(), message: "bench_msgs/msg/Bench".into(), channels: vec![channel] };
    // 4 kHz loop, every fourth row logged.
    let time_s = (0..missed.len()).map(|row| row as f64 * 1e-3).collect();
    let rows = Rows { topic, time_s, columns: vec![missed.to_vec()] };
    Window {
        point: 0,
        status,
        segments: Vec::new(),
        trips: Vec::new(),
        stops: Vec::new(),
        left: Vec::new(),
        stalls: Vec::new(),
        notices: Vec::new(),
        lateness: None,
        topics: vec![rows],
    }
}

/// The reason why the point gives no numbers, if it gives none, after checking that then there are none.
fn reason(procedure: &Procedure, window: &Window) -> Option<String> {
    let case = sample_case("az", 10f64.to_radians(), [-1.0, 1.0]);
    let result = procedure.analyse(&case, window, &sample_axes(), 4000.0);
    let measurement = &result.measurements[0];
    assert_eq!(result.inconclusive.is_some(), measurement.value.is_none());
    assert_eq!(result.inconclusive.is_some(), result.reduced.get::<Mean>().map(|mean| mean.nm).is_none());
    let told = result.inconclusive.as_ref().map(Reason::to_string);
    assert_eq!(told, measurement.inconclusive);
    told
}

#[test]
fn a_procedure_file_gives_gates_conditions_and_the_kinds_own_keys() {
    let procedure = right();
    assert_eq!(
        (procedure.id.as_str(), procedure.kind, procedure.axis.as_str()),
        ("AZ-FRICTION", "sample", "az")
    );
    assert_eq!(procedure.log_rate_hz, Some(1000.0));
    assert_eq!(procedure.gates.len(), 2);
    assert!(procedure.gates[0].0 == "heat-sink" && procedure.gates[0].1.high == Some(60.0));
    let near = ValidIf::Near { condition: "velocity".into(), ratio: 0.05 };
    assert_eq!(procedure.valid_if, [near, ValidIf::DroppedCycles { ratio: 0.001, longest_s: 0.005 }]);
    assert!(procedure.source.text.contains("AZ-FRICTION"), "kept verbatim for the log");
    assert_eq!(procedure.plan(&sample_axes(), &[]).expect("inside all limits").len(), 3);
}

#[test]
fn unknown_kind_gate_and_condition_name_the_nearest_and_spare_the_kinds_keys() {
    let text = RIGHT
        .replace("sample", "smaple")
        .replace("heat-sink", "heatsink")
        .replace("velocity = \"w", "velocty = \"w");
    insta::assert_snapshot!(printed(&read(&text).expect_err("three mistakes")));
}

#[test]
fn mistakes_of_common_keys_and_of_the_kinds_keys_come_together() {
    let text = RIGHT
        .replace("AZ-FRICTION", "../etc/x")
        .replace("1 kHz", "0 Hz")
        .replace("\"10 deg/s\"", "\"10 Hz\"")
        .replace("within 5 %", "about 5 %")
        .replace("longest < 5 ms", "longest 5 ms");
    insta::assert_snapshot!(printed(&read(&text).expect_err("five mistakes")));
}

#[test]
fn an_axis_that_the_rig_lacks_is_shown_where_it_is_named() {
    let procedure = read(&RIGHT.replace("\"az\"", "\"azz\"")).expect("the file itself is right");
    insta::assert_snapshot!(printed(&procedure.plan(&sample_axes(), &[]).expect_err("no such axis")));
}

#[test]
fn crossed_limits_name_point_limit_and_value_asked() {
    let text = RIGHT.replace("\"60 deg/s\"]", "\"61 deg/s\"]\nspan = \"-159 deg .. 160 deg\"");
    let procedure = read(&text).expect("the file itself is right");
    insta::assert_snapshot!(printed(&procedure.plan(&sample_axes(), &[]).expect_err("beyond the rig")));
}

#[test]
fn a_value_on_the_limit_up_to_rounding_is_allowed_and_a_microradian_more_is_not() {
    let mut axes = sample_axes();
    let limits = axes.get_mut("az").expect("it has an azimuth");
    limits.soft_limits_rad = [-1.0, 1.0];
    let on = sample_case("az", limits.max_velocity_rad_per_s * (1.0 + 1e-12), [-1.0 - 1e-12, 1.0 + 1e-12]);
    assert_eq!(reach::excesses(&on, &axes), []);
    let beyond = sample_case("az", 0.1, [-1.0, 1.0 + 1e-6]);
    assert_eq!(reach::excesses(&beyond, &axes).len(), 1);
}

#[test]
fn a_start_pose_of_another_axis_is_checked_too() {
    let axes = sample_axes();
    let mut case = sample_case("az", 0.1, [-1.0, 1.0]);
    case.start_pose_rad.insert("el".into(), 0.0);
    let mistakes = printed(&reach::excesses(&case, &axes));
    assert!(mistakes.contains("needs axis `el`, which the rig does not have"), "{mistakes}");
}

fn subset(values_deg: &[f64]) -> Subset {
    let values = values_deg.iter().map(|v| v.to_radians()).collect();
    Subset { condition: "velocity".into(), values }
}

#[test]
fn a_subset_keeps_the_points_it_names_in_plan_order() {
    let cases = right().plan(&sample_axes(), &[subset(&[60.0, 2.0])]).expect("both are in the sweep");
    let points: Vec<_> = cases.iter().map(|case| case.point.as_str()).collect();
    assert_eq!(points, ["velocity=2 deg/s", "velocity=60 deg/s"]);
}

#[test]
fn a_subset_value_that_the_sweep_lacks_lists_what_it_has() {
    let mistakes = right().plan(&sample_axes(), &[subset(&[10.0, 15.0])]).expect_err("15 deg/s is not swept");
    insta::assert_snapshot!(printed(&mistakes), @r#"
    error: there is no point with `velocity` = 15 deg/s
     --> fat/az-friction.toml:8:12
      |
    8 | velocity = ["2 deg/s", "10 deg/s", "60 deg/s"]
      |            ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
      = help: the sweep has 2 deg/s, 10 deg/s, 60 deg/s
    "#);
    let dwell = Subset { condition: "dwell".into(), values: vec![1.0] };
    let mistakes = right().plan(&sample_axes(), &[dwell]).expect_err("nothing is swept over dwell");
    assert!(printed(&mistakes).contains("the procedure has no sweep over `dwell`"));
}

#[test]
fn subsets_that_leave_nothing_together_are_refused() {
    let mistakes =
        right().plan(&sample_axes(), &[subset(&[2.0]), subset(&[60.0])]).expect_err("nothing is left");
    assert!(printed(&mistakes).contains("no point is left"), "{}", printed(&mistakes));
}

#[test]
fn the_same_point_twice_is_refused() {
    let procedure = read(&RIGHT.replace("\"2 deg/s\"", "\"10 deg/s\"")).expect("the file itself is right");
    let mistakes = printed(&procedure.plan(&sample_axes(), &[]).expect_err("10 deg/s stands twice"));
    assert!(mistakes.contains("point `velocity=10 deg/s` is planned more than once"), "{mistakes}");
}

#[test]
fn a_whole_point_inside_its_conditions_keeps_its_numbers() {
    let mut missed = vec![0.0; 20_000];
    missed[7] = 19.0;
    assert_eq!(reason(&right(), &window(PointStatus::Completed, &missed)), None);
}

#[test]
fn a_velocity_further_off_than_allowed_takes_the_points_numbers() {
    let procedure = read(&RIGHT.replace("within 5 %", "within 3 %")).expect("the file is right");
    let reason = reason(&procedure, &window(PointStatus::Completed, &[0.0; 100]));
    insta::assert_snapshot!(reason.expect("4 % off"), @"velocity: 10 deg/s requested, 9.6 deg/s achieved, 3 % allowed");
}

#[test]
fn a_condition_that_no_measurement_reports_does_not_hold_by_itself() {
    let procedure =
        read(&RIGHT.replace("velocity = \"within", "dwell = \"within")).expect("the file is right");
    let mut case = sample_case("az", 10f64.to_radians(), [-1.0, 1.0]);
    let whole = window(PointStatus::Completed, &[0.0; 100]);
    let reason = |case: &Case| procedure.analyse(case, &whole, &sample_axes(), 4000.0).inconclusive;
    assert_eq!(reason(&case), None, "nobody asked for a dwell time");
    case.requested.push(crate::case::Request { name: "dwell".into(), value: 1.0, kind: QuantityKind::Time });
    assert_eq!(reason(&case), Some(Reason::NotReported { condition: "dwell".to_owned() }));
}

#[test]
fn missed_periods_count_by_share_and_by_longest_gap() {
    // 20 s at 4 kHz are 80000 periods: 0.1 % are 80.
    let mut missed = vec![0.0; 20_001];
    missed[7] = 20.0;
    let longest = reason(&right(), &window(PointStatus::Completed, &missed));
    insta::assert_snapshot!(longest.expect("5 ms"), @"dropped-cycles: longest gap 0.005 s, less than 0.005 s allowed");
    missed[7] = 0.0;
    (0..80).for_each(|row| missed[10 * row] = 1.0);
    let share = reason(&right(), &window(PointStatus::Completed, &missed));
    insta::assert_snapshot!(share.expect("80 of 80000"), @"dropped-cycles: 0.1 % of the periods missed, less than 0.1 % is allowed");
}

#[test]
fn a_log_that_does_not_count_missed_periods_is_not_judged_by_them() {
    let mut foreign = window(PointStatus::Completed, &[1.0; 10]);
    foreign.topics.clear();
    assert_eq!(reason(&right(), &foreign), None);
}

#[test]
fn a_point_that_did_not_complete_has_no_numbers_and_names_the_trip() {
    let mut aborted = window(PointStatus::Aborted, &[0.0; 100]);
    aborted.trips = vec!["velocity: 61 deg/s > 60 deg/s".into()];
    let reason = reason(&right(), &aborted);
    assert_eq!(reason.as_deref(), Some("the point was aborted (velocity: 61 deg/s > 60 deg/s)"));
}

#[test]
fn cooling_down_is_planned_into_every_point_and_wants_a_gate_to_wait_for() {
    let with = |more: &str| read(&RIGHT.replacen("log-rate", &format!("{more}log-rate"), 1));
    let waits = with("cool-down = \"20 min\"\n").expect("right");
    let cases = waits.plan(&sample_axes(), &[]).expect("it plans");
    assert!(cases.iter().all(|case| case.cool_down_s == Some(1200.0)));
    let at_once = right().plan(&sample_axes(), &[]).expect("it plans");
    assert!(at_once.iter().all(|case| case.cool_down_s.is_none()));
    let without = RIGHT.replacen("log-rate", "cool-down = \"20 min\"\nlog-rate", 1).replacen(
        "heat-sink = \"< 60 degC\"\n",
        "",
        1,
    );
    let found = printed(&read(&without).expect_err("nothing to wait for"));
    assert!(found.contains("`cool-down` waits for the gate `heat-sink`, which is not given"), "{found}");
}
