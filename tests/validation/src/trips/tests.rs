use super::*;

/// Two seeds a cause and more; the example tries a thousand.
#[test]
fn the_first_trips_keep_every_rule() {
    let bed = Bed::shipped();
    for seed in 0..24 {
        let trial = bed.trial(seed);
        assert_eq!(trial.breaches, Vec::<String>::new(), "{trial:#?}");
    }
}

#[test]
fn a_seed_stands_for_one_plan_and_every_cause_has_its_turn() {
    let bed = Bed::shipped();
    let plans: Vec<Plan> = (0..100).map(|seed| Plan::draw(seed, &bed.rig)).collect();
    assert_eq!(plans[7], Plan::draw(7, &bed.rig));
    for (index, cause) in CAUSES.iter().enumerate() {
        assert!(plans.iter().any(|plan| plan.cause == index), "{}", cause.name);
    }
    for plan in plans {
        let [low, high] = bed.rig.axes[plan.axis].guard.stop.soft_limits_rad;
        assert!(low < plan.to_rad && plan.to_rad < high, "{plan:?}");
    }
}

/// A current that gets stuck in the middle of a stop brakes less than the stop needs; a gyro that freezes in one is waited for.
#[test]
fn causes_that_come_into_a_stop_of_a_weak_motor_keep_every_rule() {
    let bed = Bed::shipped();
    for seed in [862, 1469, 1792, 2222, 2631] {
        let trial = bed.trial(seed);
        assert_eq!(trial.breaches, Vec::<String>::new(), "{trial:#?}");
    }
}
