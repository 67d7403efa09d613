//! Keys, plan and refusals.

use insta::assert_snapshot;

use super::synthetic_axis::{azimuth, elevation, rig};
use super::*;
use crate::quantity::QuantityKind as Q;
use crate::stimulus::Stimulus;

fn all(mistakes: &[Diagnostic]) -> String {
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn refused(text: &str) -> String {
    let (az, el) = (azimuth(), elevation());
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
    let (az, el) = (azimuth(), elevation());
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
    assert_snapshot!(plan.join("\n"), @"");
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
    assert_snapshot!(ends.join("\n"), @"");
}

#[test]
fn limits_of_the_axis_are_kept() {
    let text =
        "[sweep]\nvelocity = [\"70 deg/s\"]\nspan = \"-8 deg .. 95 deg\"\nacceleration = \"200 deg/s^2\"\n";
    assert_snapshot!(refused(text), @"");
    assert_snapshot!(refused(""), @"");
    let mut coarse = elevation();
    coarse.torque_quantum_nm = 1.0;
    let sweep =
        read("[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"0 deg .. 80 deg\"\n").expect("the keys are right");
    assert_snapshot!(all(&sweep.plan("el", &rig(&[&coarse])).expect_err("too coarse")), @"");
    assert_snapshot!(all(&sweep.plan("elevation", &rig(&[&coarse])).expect_err("no such axis")), @"");
}

#[test]
fn mistakes_in_keys_say_what_to_write() {
    let wrong = |text: &str| all(&read(text).expect_err("mistakes"));
    assert_snapshot!(wrong("[sweep]\nvelocity = [\"2 deg/s\", \"-2 deg/s\"]\ncycles = 0\n"), @"");
    assert_snapshot!(wrong("[sweep]\nfrom = \"2 deg/s\"\ncount = 3\nspan = \"0 deg .. 9 deg\"\nperiods = 2\n"), @"");
    assert_snapshot!(
        wrong("[sweep]\nvelocity = [\"2 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\nopposite-span = \"100 deg .. 160 deg\"\n"),
        @""
    );
}

#[test]
fn what_a_sweep_yields_follows_its_keys() {
    let yields = |text: &str| read(text).expect("the keys are right").yields().join(" ");
    let friction = yields(
        "[sweep]\nvelocity = [\"2 deg/s\", \"10 deg/s\", \"20 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\n",
    );
    assert_snapshot!(friction, @"");
    let stribeck = yields("[sweep]\nfrom = \"0.4 deg/s\"\nto = \"60 deg/s\"\ncount = 30\nperiods = 2\n");
    assert_snapshot!(stribeck, @"");
    let fast = yields("[sweep]\nvelocity = [\"20 deg/s\"]\nspan = \"-60 deg .. 60 deg\"\n");
    assert!(!fast.contains("unbalance"));
    for name in yields("").split(' ').chain(friction.split(' ')).chain(stribeck.split(' ')) {
        assert!(Hysteresis.measurands().iter().any(|m| m.name == name), "{name}");
    }
}
