use procedures::diagnostic::SourceFile;
use procedures::measurement::{Estimate, Evidence, Measurement};
use procedures::quantity::QuantityKind as Q;

use super::*;
use reports::record::PointRow;

const CHANNEL: &str = "/imu rate_x_rad_per_s";

fn requirements() -> Requirements {
    let text = "schema = 1\n[[requirement]]\nid = \"GYR-ARW\"\ntext = \"Gyro angle random walk.\"\nsource = \"2.1.3\"\n\
                method = \"test\"\nmeasurand = [\"angle-random-walk\"]\nlimit = \"<= 0.015 deg/sqrt(h)\"\n\
                [[requirement]]\nid = \"FRC\"\ntext = \"Friction.\"\nsource = \"ours\"\nmethod = \"test\"\n\
                measurand = [\"friction-torque\"]\nlimit = \"<= 260 N*m\"\n";
    let source = SourceFile { name: "requirements.toml".to_owned(), text: text.to_owned() };
    Requirements::parse(&source).expect("two requirements")
}

fn procedure(id: &str, kind: &str, measurement: Measurement) -> ProcedureFindings {
    let measurements = vec![Measurement { point: Some("one".to_owned()), ..measurement }];
    let judgements = super::super::judge_all(&measurements, &requirements());
    let points =
        vec![PointRow::collect("one", Status::Completed, Vec::new(), None, &measurements, &judgements)];
    ProcedureFindings {
        id: id.to_owned(),
        kind: kind.to_owned(),
        axis: "az".to_owned(),
        status: Status::Completed,
        verdict: judgements.iter().map(|j| j.verdict).max().unwrap_or(Verdict::None),
        points,
        measurements,
        judgements,
        ..ProcedureFindings::default()
    }
}

fn measured(name: &str, kind: Q, value: f64) -> Measurement {
    let estimate = Estimate { value, u: 1e-3 * value.abs(), dof: f64::INFINITY, n: 100 };
    let channels = vec![CHANNEL.to_owned()];
    let evidence = vec![Evidence { file: String::new(), channels, t0_s: 0.0, t1_s: 1.0 }];
    Measurement { evidence, ..Measurement::new(name, "x", kind, Some(estimate), "test/1") }
}

/// A self-check at which the gyro reads `offset`, and which allows it to change by 1e-4 rad/s.
fn check(id: &str, offset: f64) -> ProcedureFindings {
    let conditions = vec![drift::allowed(1e-4, Q::AngularVelocity)];
    procedure(
        id,
        drift::KIND,
        Measurement { conditions, ..measured("gyro-offset", Q::AngularVelocity, offset) },
    )
}

/// 0.01 deg/sqrt(h): inside its limit.
fn walk(id: &str) -> ProcedureFindings {
    let value = Q::AngleRandomWalk.parse("0.01 deg/sqrt(h)").expect("a quantity");
    procedure(id, "allan", measured("angle-random-walk", Q::AngleRandomWalk, value))
}

#[test]
fn what_lies_between_two_self_checks_that_disagree_is_inconclusive_and_says_why() {
    let mut all =
        vec![walk("BEFORE"), check("OPEN", 5e-5), walk("BETWEEN"), check("CLOSE", 3e-4), walk("AFTER")];
    assert!(all.iter().filter(|p| p.kind == "allan").all(|p| p.verdict == Verdict::Pass));
    hold_together(&mut all, &requirements());
    let verdicts: Vec<Verdict> = [0, 2, 4].map(|i| all[i].verdict).to_vec();
    assert_eq!(verdicts, [Verdict::Pass, Verdict::Inconclusive, Verdict::Pass]);
    assert_eq!(all[2].points[0].verdict, Verdict::Inconclusive);
    let reason = all[2].judgements[0].reason.as_deref().expect("a reason");
    assert!(reason.contains("drifted between the self-checks: gyro-offset went from"), "{reason}");
    assert_eq!(all[3].remarks.len(), 1);
    assert!(all[2].remarks[0].ends_with("between the self-checks: 1."), "{:?}", all[2].remarks);
}

/// What another channel told.
fn told_by(channel: &str, name: &str, kind: Q, value: f64) -> Measurement {
    let mut one = Measurement { axis: "az".to_owned(), ..measured(name, kind, value) };
    one.evidence[0].channels = vec![channel.to_owned()];
    one
}

#[test]
fn a_force_gauge_that_drifted_takes_the_verdict_from_all_torques_that_follow_its_constant() {
    let force = |id: &str, offset_n: f64| {
        let conditions = vec![drift::allowed(5.0, Q::Force)];
        let offset = told_by("/force force_n", "force-offset", Q::Force, offset_n);
        procedure(id, drift::KIND, Measurement { conditions, ..offset })
    };
    let constant = told_by("/force force_n", known::CONSTANT, Q::TorqueConstant, 60.0);
    let friction =
        |id: &str| procedure(id, "hysteresis", told_by("/az current_a", "friction-torque", Q::Torque, 200.0));
    let mut all = vec![
        friction("FRICTION"),
        force("OPEN", 1.0),
        procedure("GAUGE", "torque-constant", constant),
        force("CLOSE", 11.0),
    ];
    hold_together(&mut all, &requirements());
    assert!(all[2].measurements[0].inconclusive.is_some(), "the gauge's own channel drifted");
    doubt_torques(&mut all, &BTreeMap::new(), &requirements());
    assert_eq!(all[0].verdict, Verdict::Pass, "by the constant of the rig file");
    let sources = BTreeMap::from([("az".to_owned(), "GAUGE".to_owned())]);
    doubt_torques(&mut all, &sources, &requirements());
    assert_eq!(all[0].verdict, Verdict::Inconclusive);
    let reason = all[0].judgements[0].reason.as_deref().expect("a reason");
    assert!(
        reason.contains("the torque constant that GAUGE measured, which is in doubt: /force force_n drifted"),
        "{reason}"
    );
}

#[test]
fn a_force_gauge_that_stayed_leaves_the_torques_their_verdict() {
    let constant = told_by("/force force_n", known::CONSTANT, Q::TorqueConstant, 60.0);
    let friction = told_by("/az current_a", "friction-torque", Q::Torque, 200.0);
    let mut all =
        vec![procedure("GAUGE", "torque-constant", constant), procedure("FRICTION", "hysteresis", friction)];
    let before = all.clone();
    let sources = BTreeMap::from([("az".to_owned(), "GAUGE".to_owned())]);
    doubt_torques(&mut all, &sources, &requirements());
    assert_eq!(all, before);
}

/// Two procedures that disagree about one quantity: neither passes, whichever is right.
#[test]
fn estimates_of_one_quantity_that_disagree_pass_nothing_and_both_say_so() {
    let friction = |id: &str, nm: f64| {
        procedure(id, "hysteresis", told_by("/az current_a", "friction-torque", Q::Torque, nm))
    };
    let mut all = vec![friction("FAST", 200.0), friction("SLOW", 202.0)];
    assert!(all.iter().all(|p| p.verdict == Verdict::Pass));
    let told = compare_estimates(&mut all, &requirements());
    assert_eq!(told.len(), 1, "both say the same: {told:?}");
    let verdicts = [all[0].verdict, all[1].verdict];
    assert_eq!(verdicts, [Verdict::Inconclusive; 2], "2 N*m are 7 of their combined standard uncertainties");
    assert!(all.iter().all(|p| p.remarks.len() == 1), "{all:?}");
}

/// No requirement judges the viscous coefficient: no verdict of a procedure could tell of it.
#[test]
fn a_disagreement_about_what_nothing_judges_is_told_of_the_whole_campaign() {
    let friction = |id: &str, value: f64| {
        let viscous = told_by("/az current_a", "viscous-coefficient", Q::Damping, value);
        procedure(id, "hysteresis", viscous)
    };
    let mut all = vec![friction("FAST", 300.0), friction("SLOW", 303.0)];
    let told = compare_all(&mut all, &BTreeMap::new(), &requirements());
    assert!(all.iter().all(|p| p.verdict == Verdict::None), "{all:?}");
    assert!(told.len() == 1 && told[0].starts_with("viscous-coefficient of az"), "{told:?}");
    let mut all = vec![friction("FAST", 300.0), friction("SLOW", 300.5)];
    assert!(compare_all(&mut all, &BTreeMap::new(), &requirements()).is_empty());
}

#[test]
fn self_checks_that_agree_change_nothing_but_their_own_condition() {
    let mut all = vec![check("OPEN", 5e-5), walk("BETWEEN"), check("CLOSE", 6e-5)];
    let before = all.clone();
    hold_together(&mut all, &requirements());
    assert_eq!(all[..2], before[..2]);
    let change = all[2].measurements[0].conditions[0].achieved.expect("compared");
    assert!((change - 1e-5).abs() < 1e-12);
}

#[test]
fn a_self_check_that_did_not_complete_is_not_compared() {
    let mut broken = check("CLOSE", 1.0);
    broken.status = Status::Aborted;
    let mut all = vec![check("OPEN", 5e-5), walk("BETWEEN"), broken];
    hold_together(&mut all, &requirements());
    assert_eq!(all[1].verdict, Verdict::Pass);
}
