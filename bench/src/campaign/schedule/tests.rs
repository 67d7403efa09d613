use super::*;
use crate::plan::staged;

#[test]
fn on_real_devices_the_plans_order_holds_and_otherwise_whoever_others_wait_for_comes_before_them() {
    let plan = staged();
    let waits = plan.waits();
    let in_order: Vec<usize> = (0..plan.procedures.len()).collect();
    assert_eq!(order(&plan, &waits, true), in_order);
    let taken = order(&plan, &waits, false);
    let place = |index: usize| taken.iter().position(|&k| k == index).expect("each is taken once");
    assert_eq!(taken.len(), in_order.len());
    for (index, before) in waits.iter().enumerate() {
        assert!(
            before.iter().all(|&other| place(other) < place(index)),
            "{}",
            plan.procedures[index].procedure.id
        );
    }
}

#[test]
fn only_declared_needs_and_polarity_of_the_same_build_state_keep_a_procedure_waiting() {
    let plan = staged();
    let waits = plan.waits();
    let index = |id: &str| plan.procedures.iter().position(|p| p.procedure.id == id).expect("planned");
    assert_eq!(waits[index("AZ-FRICTION")], [index("POLARITY")]);
    assert_eq!(waits[index("AZ-FRICTION-TABLE")], [index("POLARITY-TABLE")]);
    assert_eq!(waits[index("POLARITY")], Vec::<usize>::new());
    assert!(waits[index("AZ-VELOCITY-LOOP")].contains(&index("AZ-CURRENT")));
}

#[test]
fn a_queue_gives_nothing_before_its_time_and_ends_when_all_are_taken() {
    let waits = [vec![], vec![0], vec![]];
    let changed = Condvar::new();
    let queue = Mutex::new(Queue { left: vec![1, 0, 2], over: vec![false; 3], running: 0 });
    assert_eq!(next(&queue, &changed, &waits), Some(0), "1 waits for it");
    assert_eq!(next(&queue, &changed, &waits), Some(2));
    {
        let mut queue = lock(&queue);
        queue.over[0] = true;
        queue.running -= 1;
    }
    assert_eq!(next(&queue, &changed, &waits), Some(1));
    assert_eq!(next(&queue, &changed, &waits), None);
}
