//! Interlocks that people hold in their hands.

use super::{Interlock, View};

pub(super) const EMERGENCY_STOP: Interlock = Interlock {
    name: "emergency stop",
    doc: "The emergency stop chain is open: the hardware takes the torque, and the bench commands nothing against it.",
    unit: "bit",
    shared: true,
    steerable: false,
    check: |v| {
        let open = v.guard.emergency_stop_bit.is_some_and(|bit| is_set(v, bit));
        open.then_some((1.0, 0.0))
    },
};

pub(super) const ENABLING_SWITCH: Interlock = Interlock {
    name: "enabling switch",
    doc: "The enabling switch was let go, or pressed through, while the drives are in operation.",
    unit: "bit",
    shared: true,
    steerable: true,
    check: |v| {
        let released = v.guard.enabling_switch_bit.is_some_and(|bit| !is_set(v, bit));
        (released && v.expects_operation).then_some((0.0, 1.0))
    },
};

fn is_set(view: &View<'_>, bit: u32) -> bool {
    view.rig_inputs >> bit & 1 == 1
}
