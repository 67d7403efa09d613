use analysis::estimate::Estimate;

use super::super::tests::{messages, one, requirement, velocity};
use crate::measurement::{Condition, Measurement};
use crate::quantity::QuantityKind as K;
use crate::requirement::Requirement;
use crate::verdict::{Verdict, judge};

const BANDS: &str = "judge = [{ measurand = 'friction-torque', limit = '<= 260 N*m', bands = [
    { where = { velocity = '<= 2 deg/s' }, limit = '<= 210 N*m' },
    { where = { velocity = '> 20 deg/s' }, limit = '<= 500 N*m' }] }]";

const MASK: &str = "judge = [{ measurand = 'friction-torque',
    mask = { over = 'frequency', at = ['1 Hz', '10 Hz'], limit = ['<= 100 N*m', '<= 300 N*m'] } }]";

fn verdict(
    requirement: &Requirement,
    torque_nm: f64,
    condition: Option<Condition>,
) -> (Verdict, Option<f64>) {
    let estimate = Estimate { value: torque_nm, u: 0.1, dof: f64::INFINITY, n: 1 };
    let mut m = Measurement::new("friction-torque", "az", K::Torque, Some(estimate), "test/1");
    m.conditions.extend(condition);
    let judgement = judge(&m, 0, requirement);
    (judgement.verdict, judgement.limit.and_then(|limit| limit.high))
}

fn frequency(hz: f64) -> Option<Condition> {
    Some(Condition { name: "frequency".into(), requested: hz, achieved: None, kind: K::Frequency })
}

#[test]
fn the_band_of_the_velocity_decides_and_the_limit_for_all_holds_between() {
    let it = one(BANDS);
    assert_eq!(verdict(&it, 240.0, Some(velocity(2.0))), (Verdict::Fail, Some(210.0)));
    assert_eq!(verdict(&it, 240.0, Some(velocity(10.0))), (Verdict::Pass, None));
    assert_eq!(verdict(&it, 480.0, Some(velocity(-60.0))), (Verdict::Pass, Some(500.0)));
    assert_eq!(verdict(&it, 240.0, None), (Verdict::Pass, None), "no band without its condition");
    assert_eq!(
        it.limit_text,
        "friction-torque <= 260 N*m; friction-torque <= 210 N*m where velocity <= 2 deg/s; \
         friction-torque <= 500 N*m where velocity > 20 deg/s"
    );
}

#[test]
fn a_mask_runs_straight_over_the_logarithm_and_judges_nothing_outside() {
    let it = one(MASK);
    let (_, high) = verdict(&it, 0.0, frequency(10_f64.sqrt()));
    assert!(high.is_some_and(|high| (high - 200.0).abs() < 1e-9), "{high:?}");
    assert_eq!(verdict(&it, 150.0, frequency(1.0)), (Verdict::Fail, Some(100.0)));
    assert_eq!(verdict(&it, 150.0, frequency(10.0)), (Verdict::Pass, Some(300.0)));
    assert_eq!(verdict(&it, 1e6, frequency(0.9)), (Verdict::None, None));
    assert_eq!(verdict(&it, 1e6, frequency(11.0)), (Verdict::None, None));
}

#[test]
fn bands_that_can_hold_at_once_and_masks_without_order_are_refused() {
    let clash = BANDS.replacen("> 20 deg/s", ">= 1 deg/s", 1);
    let empty = BANDS.replacen("velocity = '> 20 deg/s'", "", 1);
    let back = MASK.replacen("'10 Hz'", "'0.5 Hz'", 1);
    let few = MASK.replacen(", '<= 300 N*m'", "", 1);
    let turned = MASK.replacen("'<= 300", "'>= 300", 1);
    let unknown = MASK.replacen("'frequency'", "'frequncy'", 1);
    let all = [clash, empty, back, few, turned, unknown];
    let said: Vec<String> =
        all.iter().map(|keys| messages(&format!("schema = 1\n{}", requirement(keys)))).collect();
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn bands_that_only_touch_where_one_ends_do_not_clash() {
    let it = one(&BANDS.replacen("> 20 deg/s", "> 2 deg/s", 1));
    assert_eq!(verdict(&it, 240.0, Some(velocity(2.0))).1, Some(210.0));
}
