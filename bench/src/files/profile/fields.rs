//! The keys of a drive profile.

use drivers::cia402::objects::DataType;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, SCHEMA_FIELD, Shape};

use super::start_up::START_UP_FIELDS;

/// Codings of numbers by their words in files.
pub(super) const TYPES: &[(&str, DataType)] = &[
    ("i8", DataType::I8),
    ("u8", DataType::U8),
    ("i16", DataType::I16),
    ("u16", DataType::U16),
    ("i32", DataType::I32),
    ("u32", DataType::U32),
];

/// The words of [`TYPES`].
pub(super) const TYPE: Shape = Shape::Choice(&["i8", "u8", "i16", "u16", "i32", "u32"]);

/// Keys of a profile.
pub const FIELDS: &[Field] = &[
    SCHEMA_FIELD,
    Field::required("id", Shape::Text, "Name of the profile."),
    Field::required("title", Shape::Text, "Heading: the drives that it is for."),
    Field::required(
        "source",
        Shape::Text,
        "Where its facts come from: a manual, an ESI, a drive that was read out.",
    ),
    Field::default(
        "torque-scale",
        Shape::Choice(&["rated-torque", "rated-current"]),
        "rated-torque",
        "What 1000 of 6071h, 6072h and 6077h are: `rated-torque` (6076h) as CiA 402 has it, or the torque of the \
         `rated-current` (6075h) where torque objects are currents.",
    ),
    Field::default(
        "assign-activate",
        Shape::Choice(&["0300h", "0000h"]),
        "0300h",
        "AssignActivate of the ESI: `0300h` drives with SYNC0, `0000h` drives that run by the frames.",
    ),
    Field::optional(
        "sync0-shift",
        Shape::Quantity(K::Time),
        "When a frame should pass after SYNC0, less than the cycle; half of the cycle if left out.",
    ),
    Field::optional(
        "shortest-cycle",
        Shape::Quantity(K::Time),
        "Shortest cycle that the drive follows (1C32h:05).",
    ),
    Field::optional(
        "identity",
        Shape::Table(IDENTITY_FIELDS),
        "Who such a drive says it is (1018h), e.g. `vendor = 0x9A`; what is left out may be anything.",
    ),
    Field::required(
        "process-data",
        Shape::Table(PROCESS_DATA_FIELDS),
        "What goes over the bus in each exchange. Offsets come from the mapping that the drive reads back.",
    ),
    Field::optional(
        "heat-sink",
        Shape::Table(HEAT_SINK_FIELDS),
        "Where the temperature of the heat sink is read. Without it no interlock watches the temperature, and gates that \
         ask for it stay closed.",
    ),
    Field::optional(
        "watchdog",
        Shape::Table(WATCHDOG_FIELDS),
        "A process-data watchdog of the drive's own, beside that of its sync manager.",
    ),
    Field::optional(
        "lacks",
        Shape::Texts,
        "Objects that the drive does not have or cannot be given, e.g. `[\"608Fh:01\", \"608Fh:02\"]`: they are neither \
         read nor written. Each is a residual risk in `plan` and report.",
    ),
    Field::optional(
        "start-up",
        Shape::Tables(START_UP_FIELDS),
        "Objects that are written in PRE-OP before anything else, in this order, and read back.",
    ),
];

/// Keys of `[identity]`.
const IDENTITY_FIELDS: &[Field] = &[
    Field::optional("vendor", Shape::Integer, "Vendor (1018h:01)."),
    Field::optional("product", Shape::Integer, "Product code (1018h:02)."),
    Field::optional("lowest-revision", Shape::Integer, "Lowest revision (1018h:03) that is accepted."),
    Field::optional("highest-revision", Shape::Integer, "Highest revision (1018h:03) that is accepted."),
];

/// Keys of `[process-data]`.
const PROCESS_DATA_FIELDS: &[Field] = &[
    Field::optional(
        "outputs",
        Shape::Texts,
        "Objects that are mapped into 1600h in this order: 6040h, 6060h, 6071h, 60FFh; `pad` is a byte without meaning.",
    ),
    Field::optional(
        "inputs",
        Shape::Texts,
        "Objects that are mapped into 1A00h in this order, as `outputs`.",
    ),
    Field::optional(
        "fixed-outputs",
        Shape::Texts,
        "PDOs with a fixed mapping that are assigned in 1C12h instead, e.g. `[\"1602h\"]`.",
    ),
    Field::optional(
        "fixed-inputs",
        Shape::Texts,
        "PDOs with a fixed mapping that are assigned in 1C13h instead.",
    ),
];

/// Keys of `[heat-sink]`.
const HEAT_SINK_FIELDS: &[Field] = &[
    Field::required("object", Shape::Text, "Object, e.g. `22A3h:01`."),
    Field::required("type", TYPE, "Coding of the object."),
    Field::default("counts-per-degc", Shape::Integer, "1", "Counts of 1 degC."),
    Field::default(
        "by",
        Shape::Choice(&["process-data", "sdo"]),
        "process-data",
        "In every exchange, or by SDO once a second; after 10 s without an answer the temperature counts as too high.",
    ),
];

/// Keys of `[watchdog]`.
const WATCHDOG_FIELDS: &[Field] = &[
    Field::required("object", Shape::Text, "Object, e.g. `2F00h`."),
    Field::required("type", TYPE, "Coding of the object."),
    Field::required("step", Shape::Quantity(K::Time), "Time of one count."),
];
