//! The AL state machine: what is refused and by which code, errors and their acknowledgement, slow devices.

use std::time::Duration;

use drivers::wire::BusState;

use super::bench::*;
use super::toy::{Toy, ToyLine, toy, toys};

const MS: Duration = Duration::from_millis(1);

/// A toy in a state: 1 INIT, 2 PRE-OP, 4 SAFE-OP, 8 OP.
fn in_state(state: u8) -> Bench<ToyLine> {
    let mut bench = toy();
    match state {
        2 => bench.reach_pre_op(FIRST),
        4 => bench.reach_safe_op(FIRST, 4, 4),
        8 => bench.reach_op(FIRST, 4, 4),
        _ => {}
    }
    bench
}

#[test]
fn transitions_that_do_not_exist_are_refused_and_states_that_do_not_exist_are_unknown() {
    let rows = [
        (1, 4, 0x0011),
        (1, 8, 0x0011),
        (2, 8, 0x0011),
        (1, 3, 0x0013),
        (2, 3, 0x0013),
        (4, 3, 0x0013),
        (8, 3, 0x0013),
        (1, 0, 0x0012),
        (2, 5, 0x0012),
        (4, 15, 0x0012),
    ];
    for (from, to, code) in rows {
        let mut bench = in_state(from);
        assert_eq!(bench.asked(FIRST, to), [u16::from(from) | 0x10, code], "{from} to {to}");
    }
}

#[test]
fn every_way_down_is_open_and_the_application_goes_along() {
    for (from, to, state) in [
        (8, 4, BusState::SafeOp),
        (8, 2, BusState::PreOp),
        (8, 1, BusState::PreOp),
        (4, 2, BusState::PreOp),
        (4, 1, BusState::PreOp),
        (2, 1, BusState::PreOp),
    ] {
        let mut bench = in_state(from);
        assert_eq!(bench.asked(FIRST, to), [u16::from(to), 0], "{from} to {to}");
        assert_eq!(bench.line.toys[0].state, state);
    }
}

#[test]
fn an_error_stays_until_it_is_acknowledged() {
    let mut bench = in_state(2);
    assert_eq!(bench.asked(FIRST, 8), [0x12, 0x0011]);
    assert_eq!(bench.asked(FIRST, 1), [0x12, 0x0011], "not acknowledged");
    assert_eq!(bench.asked(FIRST, 0x12), [0x02, 0x0000]);
    assert_eq!(bench.asked(FIRST, 1), [0x01, 0x0000]);
    assert_eq!(bench.asked(FIRST, 0x11), [0x01, 0x0000], "nothing to acknowledge");
}

#[test]
fn an_error_can_be_acknowledged_by_the_request_that_follows_it() {
    let mut bench = in_state(4);
    assert_eq!(bench.asked(FIRST, 0x05), [0x14, 0x0012]);
    assert_eq!(bench.asked(FIRST, 0x11), [0x01, 0x0000]);
}

#[test]
fn pre_op_needs_both_mailboxes_where_the_sii_has_them() {
    let right = [(0x1000, 128, 0x26), (0x1080, 128, 0x22)];
    let wrong = [
        [(0x1000, 64, 0x26), right[1]],
        [(0x1200, 128, 0x26), right[1]],
        [(0x1000, 128, 0x22), right[1]],
        [(0x1000, 128, 0x24), right[1]],
        [right[0], (0x1080, 64, 0x22)],
        [right[0], (0x1080, 128, 0x26)],
    ];
    let mut bench = toy();
    assert_eq!(bench.asked(FIRST, 2), [0x11, 0x0016], "none at all");
    for managers in wrong {
        let mut bench = toy();
        for (n, (start, length, control)) in (0..).zip(managers) {
            bench.sync_manager(FIRST, n, start, length, control);
        }
        assert_eq!(bench.asked(FIRST, 2), [0x11, 0x0016], "{managers:?}");
    }
}

#[test]
fn safe_op_needs_sync_managers_as_long_as_the_mapping() {
    let rows = [
        (5, 4, 0x64, 0x20, [0x12, 0x001D]),
        (4, 3, 0x64, 0x20, [0x12, 0x001E]),
        (4, 4, 0x60, 0x20, [0x12, 0x001D]),
        (4, 4, 0x64, 0x24, [0x12, 0x001E]),
        (4, 4, 0x66, 0x20, [0x12, 0x001D]),
        (0, 4, 0x64, 0x20, [0x12, 0x001D]),
        (4, 4, 0x64, 0x20, [0x04, 0x0000]),
        (4, 4, 0x24, 0x20, [0x04, 0x0000]),
    ];
    for (outputs, inputs, out_control, in_control, state) in rows {
        let mut bench = in_state(2);
        bench.sync_manager(FIRST, 2, 0x1100, outputs, out_control);
        bench.sync_manager(FIRST, 3, 0x1400, inputs, in_control);
        assert_eq!(bench.asked(FIRST, 4), state, "{outputs}, {inputs}");
    }
}

#[test]
fn safe_op_is_refused_where_the_mapping_is_invalid_or_the_cycle_too_short() {
    let mut bench = in_state(2);
    bench.line.toys[0].map_fails = true;
    assert_eq!(bench.asked(FIRST, 4), [0x12, 0x0025]);
    let mut bench = in_state(2);
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x64);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    bench.write(FIRST, 0x09A0, &1000_u32.to_le_bytes());
    bench.write(FIRST, 0x0980, &[0, 3]);
    assert_eq!(bench.asked(FIRST, 4), [0x12, 0x0036]);
}

#[test]
fn op_comes_with_the_first_outputs_or_is_refused_after_a_while() {
    let mut bench = in_state(4);
    assert_eq!(bench.asked(FIRST, 8), [4, 0], "no outputs yet");
    bench.wait(MS * 499);
    assert_eq!(bench.state(FIRST), [4, 0]);
    bench.wait(MS * 2);
    assert_eq!(bench.state(FIRST), [0x14, 0x0019]);
    bench.write(FIRST, 0x1100, &[0; 4]);
    assert_eq!(bench.asked(FIRST, 0x18), [8, 0]);
}

#[test]
fn op_with_sync0_is_refused_while_there_is_none() {
    let mut bench = in_state(2);
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x64);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    bench.write(FIRST, 0x09A0, &1_000_000_u32.to_le_bytes());
    bench.write(FIRST, 0x0990, &0_u64.to_le_bytes());
    bench.write(FIRST, 0x0980, &[0, 3]);
    assert_eq!(bench.asked(FIRST, 4), [4, 0]);
    assert_eq!(bench.asked(FIRST, 8), [0x14, 0x002D], "the start has passed");
}

#[test]
fn a_request_that_is_repeated_does_not_begin_anew() {
    let mut bench = in_state(2);
    bench.line.devices[0].misbehaviour.transitions_take = MS * 10;
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x64);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    bench.ask(FIRST, 4);
    for _ in 0..3 {
        bench.wait(MS * 4);
        bench.ask(FIRST, 4);
    }
    assert_eq!(bench.state(FIRST), [4, 0]);
}

#[test]
fn slow_transitions_go_up_late_and_down_at_once() {
    let mut bench = in_state(2);
    bench.line.devices[0].misbehaviour.transitions_take = MS * 10;
    bench.sync_manager(FIRST, 2, 0x1100, 4, 0x64);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    assert_eq!(bench.asked(FIRST, 4), [2, 0]);
    bench.wait(MS * 11);
    assert_eq!(bench.state(FIRST), [4, 0]);
    assert_eq!(bench.asked(FIRST, 1), [1, 0]);
}

#[test]
fn process_data_that_are_switched_off_in_op_end_it() {
    for (manager, code) in [(2, 0x001D), (3, 0x001E)] {
        let mut bench = in_state(8);
        bench.write(FIRST, 0x0806 + 8 * manager, &[0]);
        assert_eq!(bench.state(FIRST), [0x12, code]);
        assert_eq!(bench.line.toys[0].state, BusState::PreOp);
    }
}

#[test]
fn an_application_that_leaves_op_takes_its_device_along() {
    let mut bench = in_state(8);
    bench.line.toys[0].state = BusState::SafeOp;
    bench.wait(MS);
    assert_eq!(bench.state(FIRST), [0x14, 0x001B]);
    let count = bench.line.toys[0].taken.len();
    assert_eq!(bench.write(FIRST, 0x1100, &[5; 4]), 1, "outputs are still written");
    assert_eq!(bench.line.toys[0].taken.len(), count, "and nobody takes them");
    assert_eq!(bench.asked(FIRST, 0x18), [8, 0]);
}

#[test]
fn a_device_without_outputs_needs_none_for_op() {
    let mut toy = Toy::new();
    toy.bytes.outputs = 0;
    let mut bench = toys(vec![toy]);
    bench.reach_pre_op(FIRST);
    bench.sync_manager(FIRST, 3, 0x1400, 4, 0x20);
    assert_eq!(bench.asked(FIRST, 4), [4, 0]);
    assert_eq!(bench.asked(FIRST, 8), [8, 0]);
}
