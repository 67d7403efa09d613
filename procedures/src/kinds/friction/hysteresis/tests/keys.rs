//! Keys, plan and refusals.

use insta::assert_snapshot;

use super::synthetic_axis::{azimuth, elevation, rig};
use super::*;
use crate::case::Case;
use crate::procedure::Procedure;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::Stimulus;

fn all(mistakes: &[Diagnostic]) -> String {
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn refused(text: &str) -> String {
    let az = azimuth();
    let el = elevation();
    all(&read(text)
        .expect("the keys are right")
        .plan("el", &rig(&[&az, &el]))
        .expect_err("the axis cannot do it"))
}

#[test]
fn velocities_ascend_and_every_point_starts_where_the_one_before_ends() {
    let sweep =
        read("[sweep]\nvelocity = [\"60 deg/s\", \"2 deg/s\"]\nspan = \"-8 deg .. 88 deg\"\ncycles = 1\n")
            .expect("the keys are right");
    let az = azimuth();
    let el = elevation();
    let cases = sweep.plan("el", &rig(&[&az, &el])).expect("the axis can do it");
    let plan: Vec<String> = cases
        .iter()
        .map(|c| {
            let segments: Vec<String> =
                c.segments.iter().map(|s| format!("{} at most {:.2} s", s.label, s.at_most_s)).collect();
            let start: Vec<String> =
                c.start_pose_rad.iter().map(|(a, p)| format!("{a} {}", Q::Angle.format(*p))).collect();
            format!("{} | from {} | {}", c.point, start.join(", "), segments.join(", "))
        })
        .collect();
    assert_snapshot!(plan.join("\n"), @r#"
velocity=2 deg/s | from az 0 deg, el 0 deg | approach at most 1.74 s, strokes at most 102.00 s
velocity=60 deg/s | from az 0 deg, el -8 deg | approach at most 1.00 s, strokes at most 5.97 s
"#);
}

#[test]
fn periods_that_the_travel_has_no_room_for_are_named() {
    let axes = rig(&[&elevation()]);
    let cuts = |periods: u32| {
        let text = format!("[sweep]\nvelocity = [\"2 deg/s\", \"60 deg/s\"]\nperiods = {periods}\n");
        read(&text).expect("the keys are right").cuts("el", &axes)
    };
    assert_snapshot!(cuts(6).join("\n"), @"velocity 60 deg/s: 6 periods need 126 deg, the soft limits leave 98.8 deg: fewer periods are measured");
    let at_two = |velocity: &str| {
        let text = format!("[sweep]\nvelocity = [\"{velocity}\"]\nperiods = 2\n");
        read(&text).expect("the keys are right").cuts("el", &axes)
    };
    assert_eq!([at_two("40 deg/s").len(), at_two("60 deg/s").len()], [0, 1]);
}

#[test]
fn periods_give_each_velocity_the_span_it_needs_inside_soft_limits() {
    let sweep = read(
        "[sweep]\nfrom = \"0.4 deg/s\"\nto = \"60 deg/s\"\ncount = 4\nperiods = 2\ncentre = \"80 deg\"\n",
    )
    .expect("the keys are right");
    let cases = sweep.plan("el", &rig(&[&elevation()])).expect("the axis can do it");
    let ends: Vec<String> = cases
        .iter()
        .filter_map(|c| match &c.segments[1].stimulus {
            Stimulus::Reversals { from_rad, to_rad, .. } => {
                Some(format!("{}: {} .. {}", c.point, Q::Angle.format(*from_rad), Q::Angle.format(*to_rad)))
            }
            _ => None,
        })
        .collect();
    assert_snapshot!(ends.join("\n"), @r#"
velocity=0.4 deg/s: 73.3249 deg .. 86.6751 deg
velocity=2.12532 deg/s: 73.2301 deg .. 86.7699 deg
velocity=11.2924 deg/s: 68.8948 deg .. 89.4 deg
velocity=60 deg/s: -9.4 deg .. 89.4 deg
"#);
}

#[test]
fn limits_of_the_axis_are_kept() {
    let text =
        "[sweep]\nvelocity = [\"70 deg/s\"]\nspan = \"-8 deg .. 95 deg\"\nacceleration = \"200 deg/s^2\"\n";
    assert_snapshot!(refused(text), @r#"
error: velocity 70 deg/s is above the axis' 60 deg/s
  = help: use at most 60 deg/s
error: acceleration 200 deg/s^2 is above the axis' 90 deg/s^2
  = help: use at most 90 deg/s^2
error: span -8 deg .. 95 deg exceeds the axis' soft limits -9.5 deg .. 89.5 deg
  = help: stay inside -9.5 deg .. 89.5 deg
"#);
    assert_snapshot!(refused(""), @r#"
error: the procedure has no `[sweep]`: it judges imported records only
  = help: add `[sweep]` with velocities and a span to run it
"#);
    let mut coarse = elevation();
    coarse.torque_quantum_nm = 1.0;
    let sweep =
        read("[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"0 deg .. 80 deg\"\n").expect("the keys are right");
    assert_snapshot!(all(&sweep.plan("el", &rig(&[&coarse])).expect_err("too coarse")), @r#"
error: torque quantum 1 N*m is coarser than 1/300 of the expected static friction, 0.14375 N*m
  = help: reduce the drive's rated torque (6076h)
"#);
    assert_snapshot!(all(&sweep.plan("elevation", &rig(&[&coarse])).expect_err("no such axis")), @r#"
error: the rig has no axis `elevation`
  = help: it has el
"#);
}

#[test]
fn mistakes_in_keys_say_what_to_write() {
    let wrong = |text: &str| all(&read(text).expect_err("mistakes"));
    assert_snapshot!(wrong("[sweep]\nvelocity = [\"2 deg/s\", \"-2 deg/s\"]\ncycles = 0\n"), @r#"
error: neither `span` nor `periods`
 --> procedure.toml:1:1
  |
1 | [sweep]
  | ^^^^^^^
  = help: give `span = "-60 deg .. 60 deg"`, or `periods = 2` for the span that each velocity needs
error: expected velocities above 0
 --> procedure.toml:2:12
  |
2 | velocity = ["2 deg/s", "-2 deg/s"]
  |            ^^^^^^^^^^^^^^^^^^^^^^^
  = help: give a positive velocity; every velocity is run in both directions
error: `cycles` must be at least 1, found 0
 --> procedure.toml:3:10
  |
3 | cycles = 0
  |          ^
"#);
    assert_snapshot!(wrong("[sweep]\nfrom = \"2 deg/s\"\ncount = 3\nspan = \"0 deg .. 9 deg\"\nperiods = 2\n"), @r#"
error: `to` is missing
 --> procedure.toml:2:8
  |
2 | from = "2 deg/s"
  |        ^^^^^^^^^
  = help: log-spaced velocities need `from`, `to`, `count`
error: both `span` and `periods`
 --> procedure.toml:5:11
  |
5 | periods = 2
  |           ^
  = help: give `span = "-60 deg .. 60 deg"`, or `periods = 2` for the span that each velocity needs
"#);
    assert_snapshot!(
        wrong("[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\nopposite-span = \"100 deg .. 160 deg\"\n"),
        @r#"
error: must be half a turn from `span`
 --> procedure.toml:4:17
  |
4 | opposite-span = "100 deg .. 160 deg"
  |                 ^^^^^^^^^^^^^^^^^^^^
  = help: shift both limits of `span` by 180 deg, so that only A_u·cos θ changes its sign
"#
    );
}

#[test]
fn what_a_sweep_yields_follows_its_keys() {
    let yields = |text: &str| {
        let experiment = read(text).expect("the keys are right");
        experiment.yields().expect("a sweep says what it yields").join(" ")
    };
    let friction = yields(
        "[sweep]\nvelocity = [\"2 deg/s\", \"10 deg/s\", \"20 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\n",
    );
    assert_snapshot!(friction, @r#"friction-torque friction-difference friction-unevenness coulomb-torque viscous-coefficient unbalance-torque spring-torque spring-stiffness cogging-order cogging-amplitude cogging-harmonic cogging-phase cogging-peak"#);
    let stribeck = yields("[sweep]\nfrom = \"0.4 deg/s\"\nto = \"60 deg/s\"\ncount = 30\nperiods = 2\n");
    assert_snapshot!(stribeck, @r#"friction-torque friction-difference friction-unevenness coulomb-torque viscous-coefficient static-torque stribeck-velocity stribeck-shape"#);
    let fast = yields("[sweep]\nvelocity = [\"20 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\n");
    assert!(!fast.contains("unbalance"));
    for name in yields("").split(' ').chain(friction.split(' ')).chain(stribeck.split(' ')) {
        assert!(KIND.measurands.iter().any(|m| m.name == name), "{name}");
    }
}

#[test]
fn shipped_procedures_plan_on_their_axes_in_the_time_they_promise() {
    let files = [
        include_str!("../../../../../fat/az-friction.toml"),
        include_str!("../../../../../fat/el-friction.toml"),
        include_str!("../../../../../fat/az-stribeck.toml"),
        include_str!("../../../../../fat/el-stribeck.toml"),
        include_str!("../../../../../fat/az-cogging.toml"),
        include_str!("../../../../../fat/el-cogging.toml"),
        include_str!("../../../../../quick/az-friction.toml"),
        include_str!("../../../../../quick/el-friction.toml"),
    ];
    let az = azimuth();
    let el = elevation();
    let axes = rig(&[&az, &el]);
    let plans: Vec<String> = files
        .iter()
        .map(|text| {
            let source = SourceFile { name: "shipped.toml".to_owned(), text: (*text).to_owned() };
            let procedure = Procedure::parse(source).expect("a shipped file has no mistakes");
            let cases = procedure.plan(&axes, &[]).expect("the director can do it");
            let planned_s: f64 = cases.iter().map(Case::planned_s).sum();
            format!("{} ({}): {} points, {:.0} s", procedure.id, procedure.title, cases.len(), planned_s)
        })
        .collect();
    assert_snapshot!(plans.join("\n"), @r#"
AZ-FRICTION (Friction hysteresis, azimuth): 5 points, 1642 s
EL-FRICTION (Friction hysteresis, elevation): 5 points, 1302 s
AZ-STRIBECK (Friction over velocity (Stribeck curve), azimuth): 30 points, 488 s
EL-STRIBECK (Friction over velocity (Stribeck curve), elevation): 20 points, 2572 s
AZ-COGGING (Cogging, azimuth): 1 points, 1078 s
EL-COGGING (Cogging, elevation): 1 points, 1459 s
AZ-FRICTION (Friction hysteresis, azimuth (quick)): 5 points, 194 s
EL-FRICTION (Friction hysteresis, elevation (quick)): 5 points, 94 s
"#);
}
