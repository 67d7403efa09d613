//! The keys of a rig file.

use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Need, Shape};

use super::device::DEVICE_FIELDS;
use super::instrument::INSTRUMENT_FIELDS;
use crate::files::profile::START_UP_FIELDS;

const fn required(key: &'static str, shape: Shape, doc: &'static str) -> Field {
    Field { key, shape, need: Need::Required, doc }
}

const fn with_default(key: &'static str, shape: Shape, default: &'static str, doc: &'static str) -> Field {
    Field { key, shape, need: Need::Default(default), doc }
}

/// Keys of the file.
pub const FIELDS: &[Field] = &[
    required("schema", Shape::Integer, "Version of the format: 1."),
    required("id", Shape::Text, "Name of the rig."),
    required("title", Shape::Text, "Heading."),
    required(
        "tier",
        Shape::Choice(&["virtual", "paced", "wired", "hardware"]),
        "Fidelity. `virtual` and `paced` run simulated devices in process: `virtual` in virtual time with a new world \
         for each point, `paced` in real time with one session for the whole run. `wired` and `hardware` reach their \
         devices over real wires, in real time, with one session: `wired` simulated ones that `bench sim` serves, \
         `hardware` the director itself.",
    ),
    required("loop-rate", Shape::Quantity(K::Frequency), "Rate of the tick."),
    with_default("max-missed-periods", Shape::Integer, "20", "Longest run of missed periods before a trip."),
    with_default(
        "law-deadline",
        Shape::Quantity(K::Time),
        "100 us",
        "Longest time for the answers of an external velocity law in one tick, where time is real; at most the time of \
         `max-missed-periods`.",
    ),
    with_default(
        super::can::BIT_RATE,
        Shape::Integer,
        "1000000",
        "Bit rate of the CAN bus of the drives, bit/s, as its interface is set: the frames of all drives must fit into a period.",
    ),
    required("parameters", Shape::Text, "Controller parameters: a shipped name or a path."),
    required(
        "axis",
        Shape::Map(&Shape::Table(AXIS_FIELDS)),
        "The axes, 1 to 4 tables `[axis.<name>]`; their order is that of the log.",
    ),
    Field::optional(
        "emergency-stop-bit",
        Shape::Integer,
        "Bit of 60FDh of the first drive that is 1 while the emergency stop chain is open.",
    ),
    Field::optional(
        super::terminal::EMERGENCY_STOP,
        Shape::Text,
        "Instead of that bit: an input of a digital terminal, `ethercat:enp3s0/4#0` (interface, station, input from 0), \
         that is on while the chain is closed. An input that is off, as with a broken wire, counts as pressed.",
    ),
    Field::optional(
        "enabling-switch-bit",
        Shape::Integer,
        "Bit of 60FDh of the first drive that is 1 while the enabling switch is held.",
    ),
    Field::optional(
        "device",
        Shape::Tables(DEVICE_FIELDS),
        "Devices that the bench talks to, `[[device]]`, in the order in which they are opened.",
    ),
    Field::optional(
        "terminal",
        Shape::Tables(super::terminal::TERMINAL_FIELDS),
        "SubDevices on the wire beside the drives, `[[terminal]]`: those that no device names, such as couplers, and those \
         whose identity is to be checked. A SubDevice that nothing in this file names is refused.",
    ),
    Field::optional(
        "instrument",
        Shape::Tables(INSTRUMENT_FIELDS),
        "Instruments of the bench with their calibration, `[[instrument]]`.",
    ),
];

/// Keys of `[axis.<name>]`.
pub const AXIS_FIELDS: &[Field] = &[
    Field::optional(
        "carried-by",
        Shape::Text,
        "Axis on which this one is mounted: azimuth, for elevation. An axis without this key stands on the ground.",
    ),
    Field::optional(
        "gains",
        Shape::Text,
        "Section of the parameters file with the gains of this axis; the one of its own name if left out.",
    ),
    Field::optional(
        "station",
        Shape::Integer,
        "Position of its drive on the simulated bus, 1-based; tiers `virtual` and `paced` need it.",
    ),
    Field::optional(
        "ports",
        Shape::Map(&Shape::Text),
        "Where its drive is connected, `{ bus = \"ethercat:enp3s0/1001\" }`: network interface, then alias of the drive or \
         its place on the wire, from 1; tiers `wired` and `hardware` need it instead of `station`.",
    ),
    Field::optional(
        "profile",
        Shape::Text,
        "Type of its drive: a shipped profile (`bench list profiles`) or the path of one. If left out it is \
         `generic-cia402` on tier `hardware`, and `simulated` elsewhere.",
    ),
    Field::optional(
        "serial",
        Shape::Integer,
        "Serial number of its drive, e.g. `0x00B9B366`: a drive with another one is refused.",
    ),
    Field::optional(
        "start-up",
        Shape::Tables(START_UP_FIELDS),
        "Objects of this drive that are written in PRE-OP behind those of its profile, and read back.",
    ),
    required("travel", Shape::Range(K::Angle), "Required travel; an axis that passes its end crashes."),
    required("soft-limits", Shape::Range(K::Angle), "Limits that the interlocks enforce, inside the travel."),
    required(
        "max-velocity",
        Shape::Quantity(K::AngularVelocity),
        "Largest rate that a procedure may command.",
    ),
    required("max-acceleration", Shape::Quantity(K::AngularAcceleration), "Largest profile acceleration."),
    required("max-jerk", Shape::Quantity(K::AngularJerk), "Largest profile jerk."),
    required("max-torque", Shape::Quantity(K::Torque), "Torque limit, written to the drive and checked."),
    required("torque-constant", Shape::Quantity(K::TorqueConstant), "Motor torque per ampere."),
    with_default(
        "torque-constant-uncertainty",
        Shape::Quantity(K::Ratio),
        "2.9 %",
        "Relative standard uncertainty of the torque constant (type B), until a force gauge measures it.",
    ),
    required("rated-current", Shape::Quantity(K::Current), "The drive's object 6075h must have this value."),
    required(
        "rated-torque",
        Shape::Quantity(K::Torque),
        "The drive's object 6076h must have this value; 1 permille of it is the torque quantum.",
    ),
    required("inertia", Shape::Quantity(K::Inertia), "Inertia about the axis, for the J·α term."),
    with_default(
        "inertia-uncertainty",
        Shape::Quantity(K::Ratio),
        "8.7 %",
        "Relative standard uncertainty of the inertia (type B), until a frequency response measures it.",
    ),
    required(
        "expected-static-friction",
        Shape::Quantity(K::Torque),
        "Used to size gates and excitation levels; never part of a result.",
    ),
    required("cogging-order", Shape::Quantity(K::SpatialOrder), "Expected cogging periods per revolution."),
    with_default("encoder-bits", Shape::Integer, "26", "Counts per revolution as a power of two."),
    with_default("encoder-offset", Shape::Quantity(K::Angle), "0 deg", "Angle of encoder count 0."),
    with_default("encoder-sign", Shape::Choice(&["+", "-"]), "+", "Whether counts increase with the angle."),
    required(
        "safety",
        Shape::Table(super::safety::SAFETY_FIELDS),
        "How the axis is stopped, and how it is left.",
    ),
    with_default(
        "velocity-feedback",
        Shape::Choice(&["encoder", "gyro"]),
        "encoder",
        "Where the production velocity loop takes its rate from; `gyro` needs an inertial unit among the devices.",
    ),
];
