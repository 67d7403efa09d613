use super::*;
use crate::kinds::KINDS;
use crate::measurement::Condition;
use crate::procedure::sample::SAMPLE_MEASURANDS;
use crate::quantity::{Comparator, QuantityKind};

fn read(text: &str) -> Result<Requirements, Vec<Diagnostic>> {
    read::requirements(&SourceFile::new("requirements.toml", text), SAMPLE_MEASURANDS)
}

pub(super) fn requirement(keys: &str) -> String {
    format!("[[requirement]]\nid = 'X'\ntext = 't'\nsource = '1'\nmethod = 'test'\n{keys}\n")
}

pub(super) fn one(keys: &str) -> Requirement {
    let read = read(&format!("schema = 1\n{}", requirement(keys)));
    read.expect("the file is right").all.pop().expect("one requirement")
}

pub(super) fn messages(text: &str) -> String {
    let mistakes = read(text).expect_err("the file is wrong");
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

pub(super) fn velocity(deg_per_s: f64) -> Condition {
    let kind = QuantityKind::AngularVelocity;
    Condition { name: "velocity".into(), requested: deg_per_s.to_radians(), achieved: None, kind }
}

#[test]
fn a_limit_takes_the_quantity_of_its_measurand_and_the_rule_is_guarded_u_by_default() {
    let it = one("measurand = ['friction-torque']\naxis = 'az'\nlimit = '≤ 0.26 kN*m'\ngoal = '<= 210 N*m'");
    let judged = it.judged("friction-torque").expect("it judges friction");
    assert_eq!(judged.limit.as_ref().and_then(|limit| limit.high), Some(260.0));
    assert_eq!(judged.goal.as_ref().and_then(|goal| goal.high), Some(210.0));
    assert_eq!((judged.rule, it.limit_text.as_str()), (Rule::GuardedU, "≤ 0.26 kN*m"));
    assert_eq!(it.goal_text.as_deref(), Some("<= 210 N*m"));
}

#[test]
fn one_requirement_judges_two_measurands_by_limits_of_their_own() {
    let it = one(concat!(
        "rule = 'simple'\njudge = [{ measurand = 'cogging-order', limit = '143.5 .. 144.5 1/rev' },\n",
        "{ measurand = 'cogging-amplitude', limit = '<= 12 N*m', rule = 'guarded-1.65u' }]"
    ));
    let order = it.judged("cogging-order").expect("order");
    let bounds = order.limit.as_ref().map(|limit| (limit.comparator, limit.low, limit.high));
    assert_eq!(bounds, Some((Comparator::Within, Some(143.5), Some(144.5))));
    assert_eq!(order.rule, Rule::Simple, "the requirement's own rule");
    assert_eq!(it.judged("cogging-amplitude").map(|j| j.rule), Some(Rule::GuardedNinetyFive));
    assert_eq!(it.limit_text, "cogging-order 143.5 .. 144.5 1/rev; cogging-amplitude <= 12 N*m");
}

#[test]
fn a_limit_is_met_by_what_is_nearer_to_it_than_its_allowance_and_reads_as_it_was_written() {
    let it = one(
        "measurand = ['friction-torque']\nlimit = '<= 260 N*m'\nallowance = '2 N*m'\ngoal = '<= 210 N*m'",
    );
    let judged = it.judged("friction-torque").expect("it judges friction");
    let limit = judged.limit.as_ref().expect("a limit");
    assert!(limit.holds(262.0) && !limit.holds(262.1));
    assert_eq!((limit.text.as_str(), it.limit_text.as_str()), ("<= 260 N*m", "<= 260 N*m"));
    assert_eq!(judged.goal.as_ref().and_then(|goal| goal.high), Some(210.0), "a goal has none");
    let wrong = [
        "measurand = ['friction-torque']\nlimit = '<= 260 N*m'\nallowance = '-2 N*m'",
        "measurand = ['friction-torque']\nlimit = '<= 260 N*m'\nallowance = '2 deg'",
        "limit = '<= 260 N*m'\nallowance = '2 N*m'",
    ];
    let told = wrong.map(|keys| messages(&format!("schema = 1\n{}", requirement(keys))));
    insta::assert_snapshot!(told.join("\n"));
}

#[test]
fn where_takes_a_limit_a_range_or_a_list_of_values() {
    let holds = |keys: &str, deg_per_s: f64| one(keys).conditions[0].meets.holds(&velocity(deg_per_s));
    let limit = "where = { velocity = '<= 10 deg/s' }";
    assert!(holds(limit, 10.0) && holds(limit, -2.0) && !holds(limit, 10.1));
    assert!(!holds(limit, -60.0), "a limit on velocity is one on speed");
    assert!(holds(limit, 10.0 * (1.0 + 1e-12)), "equal up to rounding counts as equal");
    assert!(!holds("where = { velocity = '< 10 deg/s' }", 10.0 * (1.0 - 1e-12)));
    assert!(holds("where = { velocity = '5 .. 10 deg/s' }", 7.0));
    let list = "where = { velocity = ['10 deg/s', '60 deg/s'] }";
    assert!(holds(list, 60.0) && !holds(list, 20.0));
    assert_eq!(one(list).conditions[0].meets.text(), "10 deg/s, 60 deg/s");
    assert!(holds("where = { velocity = '10 deg/s' }", 10.0));
}

#[test]
fn a_requirement_that_nothing_measures_may_have_a_limit_in_words() {
    assert_eq!(one("limit-text = 'none entered'").limit_text, "none entered");
    assert_eq!(one("limit = '>= 90 deg/s^2'").limit_text, ">= 90 deg/s^2");
    assert!(one("limit = '>= 90 deg/s^2'").judges.is_empty());
    assert_eq!(one("").limit_text, "", "report only");
}

#[test]
fn wrong_requirements_are_all_reported_with_what_to_do() {
    let wrong = [
        "measurand = ['friction-torqe']\nlimit = '<= 1 N*m'",
        "measurand = ['friction-torque']\nlimit = '<= 1 deg/s'\nrule = 'guarded'",
        "measurand = ['friction-torque']\nlimit-text = 'low'",
        "limit = 'low'\nmethod = 'look'",
        "where = { velocty = '1 deg/s', pose = '1 s', dwell = [] }",
        "measurand = ['friction-torque']\njudge = [{ measurand = 'cogging-order' }]",
        "judge = [{ measurand = 'cogging-order' }, { measurand = 'cogging-order' }]",
    ];
    let text: String = wrong.iter().map(|keys| requirement(keys)).collect();
    let text = text.replacen("'X'", "'Y'", 1).replace("method = 'test'\nlimit = 'low'\n", "limit = 'low'\n");
    insta::assert_snapshot!(messages(&format!("schema = 1\n{text}")));
}

fn shipped() -> Requirements {
    let source = SourceFile::new("requirements.toml", include_str!("../../requirements.toml"));
    Requirements::parse(&source).unwrap_or_else(|all| panic!("{}", all[0]))
}

#[test]
fn every_shipped_requirement_is_measured_or_declared_and_has_its_limit() {
    let shipped = shipped();
    assert!(shipped.all.iter().all(|r| r.is_declared() || !r.judges.is_empty()));
    let held = shipped.all.iter().filter(|r| r.id != "TRK-RMS-F");
    let judges_all = held.flat_map(|r| &r.judges).all(|j| j.is_limited());
    assert!(judges_all, "every measured requirement has its limit, but the one that is only reported");
    let claims_nothing = |r: &&Requirement| !r.covers.is_empty() && !r.judges.iter().any(Judged::is_limited);
    assert_eq!(shipped.all.iter().find(claims_nothing), None, "nothing looks at a claim without a limit");
}

#[test]
fn a_measurand_is_yielded_by_one_kind_only() {
    let mut names: Vec<&str> = KINDS.iter().flat_map(|k| k.measurands).map(|m| m.name).collect();
    names.sort_unstable();
    let twice: Vec<_> = names.windows(2).filter(|pair| pair[0] == pair[1]).collect();
    assert!(twice.is_empty(), "{twice:?}");
}

#[test]
fn evidence_belongs_to_analysis_and_inspection() {
    let text = requirement("evidence = 'report 12, section 4'").replacen("'test'", "'analysis'", 1);
    let it = read(&format!("schema = 1\n{text}")).expect("the file is right");
    assert!(it.all[0].is_declared());
    let measured = format!("schema = 1\n{}", requirement("evidence = 'report 12, section 4'"));
    assert!(messages(&measured).contains("`evidence` for a requirement that is measured"));
}

#[test]
fn claims_name_axes_and_stretches_and_their_mistakes_are_pointed_at() {
    let right = one("measurand = ['friction-torque']\nlimit = '<= 260 N*m'\naxes = ['az', 'el']\n\
         covers = [{ condition = 'velocity', range = '0.5 deg/s .. 10 deg/s', gap = '5 deg/s', ends = '0.1 deg/s' }]");
    assert_eq!(right.claims(), ["axes az, el", "velocity 0.5 deg/s .. 10 deg/s, gaps up to 5 deg/s"]);
    let travel = one("measurand = ['friction-torque']\nlimit = '<= 260 N*m'\n\
         covers = [{ condition = 'angle', range = '-150 deg .. 150 deg', gap = '0 deg', ends = '5 deg' }]");
    assert_eq!(travel.claims(), ["angle -150 deg .. 150 deg, gaps up to 0 deg"]);
    let wrong = |covers: &str| {
        let keys =
            format!("measurand = ['friction-torque']\nlimit = '<= 260 N*m'\ncovers = [{{ {covers} }}]");
        messages(&format!("schema = 1\n{}", requirement(&keys)))
    };
    let rest = "gap = '5 deg', ends = '1 deg'";
    assert!(
        wrong(&format!("condition = 'height', range = '1 deg .. 2 deg', {rest}"))
            .contains("unknown condition `height`")
    );
    assert!(
        wrong(&format!("condition = 'elevation', range = '<= 2 deg', {rest}"))
            .contains("a range needs two ends")
    );
    let negative = wrong("condition = 'elevation', range = '1 deg .. 2 deg', gap = '-1 deg', ends = '1 deg'");
    assert!(negative.contains("must not be negative"), "{negative}");
    let other =
        wrong(&format!("measurand = 'gap', condition = 'elevation', range = '1 deg .. 2 deg', {rest}"));
    assert!(other.contains("the requirement does not judge the measurand `gap`"), "{other}");
    for keys in [
        ", at = '1 deg', range = '1 deg .. 2 deg', gap = '1 deg'",
        ", at = '1 deg', gap = '1 deg'",
        "",
        ", range = '1 deg .. 2 deg'",
        ", gap = '1 deg'",
    ] {
        let both = wrong(&format!("condition = 'elevation', ends = '1 deg'{keys}"));
        assert!(both.contains("either a range with its largest gap or a single value"), "{keys}: {both}");
    }
    let single = one("measurand = ['friction-torque']\nlimit = '<= 260 N*m'\n\
         covers = [{ axis = 'az', condition = 'elevation', at = '20 deg', ends = '5 deg' }]");
    assert_eq!(single.claims(), ["az: elevation 20 deg"]);
}
