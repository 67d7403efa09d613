//! Interlocks on what drive, motor and supply bear, and on the switches that people hold in their hands.

use super::{Interlock, View, above, below, operates};

pub(crate) const DRIVE_STATE: Interlock = Interlock {
    name: "drive state",
    doc: "A drive that must follow commands left operation enabled (statusword seen, 0027h expected).",
    unit: "hex",
    shared: false,
    steerable: false,
    check: |v| {
        let left = v.expects_operation && !operates(v.actuals);
        left.then(|| (f64::from(v.actuals.statusword), f64::from(0x0027_u16)))
    },
};

pub(crate) const TORQUE: Interlock = Interlock {
    name: "torque",
    doc: "The drive reports more torque than the rig allows (with 2 % tolerance for ripple).",
    unit: "N*m",
    shared: false,
    steerable: true,
    check: |v| above(v.actuals.torque_nm.abs(), 1.02 * v.guard.max_torque_nm),
};

pub(crate) const UNCOMMANDED_TORQUE: Interlock = Interlock {
    name: "uncommanded torque",
    doc: "For 10 ms the drive has reported torque that was not commanded. The torque is switched off; the \
          bench does not control against it.",
    unit: "s",
    shared: false,
    steerable: false,
    check: |v| above(v.memory.uncommanded_s(), UNCOMMANDED_S).filter(|_| v.expects_operation),
};

/// How long torque may be there that nobody asked for.
const UNCOMMANDED_S: f64 = 0.010;

pub(crate) const MEAN_TORQUE: Interlock = Interlock {
    name: "I2t",
    doc: "The root mean square of the torque, over the thermal time of motor and drive, exceeds what they \
          can sustain.",
    unit: "N*m",
    shared: false,
    steerable: true,
    check: |v| above(v.memory.mean_torque_nm(), v.guard.safety.continuous_torque_nm),
};

pub(crate) const TEMPERATURE: Interlock = Interlock {
    name: "temperature",
    doc: "The heat sink is hotter than the rig allows, or a drive that tells its temperature by SDO has not answered for \
          10 s. Not watched where the type of the drive tells no temperature.",
    unit: "degC",
    shared: false,
    steerable: true,
    check: |v| {
        let seen = v.guard.watches_heat_sink.then_some(v.actuals.heat_sink_degc)?;
        above(seen, v.guard.safety.max_heat_sink_degc)
    },
};

pub(crate) const BUS_VOLTAGE: Interlock = Interlock {
    name: "bus voltage",
    doc: "The DC link is outside its band.",
    unit: "V",
    shared: true,
    steerable: true,
    check: bus_voltage,
};

fn bus_voltage(view: &View<'_>) -> Option<(f64, f64)> {
    let [low, high] = view.guard.safety.bus_voltage_v;
    below(view.actuals.bus_v, low).or_else(|| above(view.actuals.bus_v, high))
}

pub(super) const EMERGENCY_STOP: Interlock = Interlock {
    name: "emergency stop",
    doc: "The emergency stop chain is open: the hardware removes the torque, and the bench commands \
          nothing against it.",
    unit: "bit",
    shared: true,
    steerable: false,
    check: |v| {
        let by_drive = v.guard.emergency_stop_bit.is_some_and(|bit| is_set(v, bit));
        let open = by_drive || v.emergency_stop_is_open;
        open.then_some((1.0, 0.0))
    },
};

pub(super) const ENABLING_SWITCH: Interlock = Interlock {
    name: "enabling switch",
    doc: "The enabling switch was released, or fully pressed, while the drives were in operation.",
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
