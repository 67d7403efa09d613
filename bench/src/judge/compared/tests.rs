use procedures::diagnostic::SourceFile;
use procedures::measurement::{Estimate, Evidence, Measurement};
use procedures::quantity::QuantityKind as Q;

use super::*;
use reports::record::PointRow;

const CHANNEL: &str = "/imu rate_x_rad_per_s";

fn requirements() -> Requirements {
    let text = "schema = 1\n[[requirement]]\nid = \"GYR-ARW\"\ntext = \"Gyro angle random walk.\"\nsource = \"2.1.3\"\n\
                method = \"test\"\nmeasurand = [\"angle-random-walk\"]\nlimit = \"<= 0.015 deg/sqrt(h)\"\n";
    let source = SourceFile { name: "requirements.toml".to_owned(), text: text.to_owned() };
    Requirements::parse(&source).expect("requirements of one line")
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
