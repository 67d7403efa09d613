//! Kinds of experiment: how each excites an axis and reads the answer. Each kind lies in a family beside what it shares.

use crate::axis::Axes;
use crate::case::Case;
use crate::device::DeviceRole;
use crate::diagnostic::Diagnostic;
use crate::log::Window;
use crate::measurement::{Conclusion, PointResult};
use crate::quantity::QuantityKind;
use crate::table::{Field, TableReader};

mod friction;
mod inertial;
mod mirror;
mod optics;
mod position;
mod response;
mod safety;

pub use response::modes::{PointModes, VisibleMode};

/// A quantity that a kind yields and a requirement may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measurand {
    /// Name, kebab-case, unique over all kinds, e.g. `friction-torque`.
    pub name: &'static str,
    /// Kind of quantity.
    pub kind: QuantityKind,
    /// One sentence: what it is.
    pub doc: &'static str,
}

impl Measurand {
    /// A measurand of this name and kind of quantity, and what it is.
    pub(crate) const fn new(name: &'static str, kind: QuantityKind, doc: &'static str) -> Self {
        Self { name, kind, doc }
    }
}

/// A kind of experiment.
#[derive(Debug)]
pub struct Kind {
    /// Name in procedure files, e.g. `hysteresis`.
    pub name: &'static str,
    /// Documentation with the headings *What it finds · How it excites · How it computes · Fails when · Source*.
    pub doc: &'static str,
    /// The kind's own keys in a procedure file.
    pub fields: &'static [Field],
    /// What it can yield.
    pub measurands: &'static [Measurand],
    /// Reads the kind's own keys; problems go into the reader's diagnostics, `None` if it cannot go on.
    pub read: fn(&mut TableReader<'_>) -> Option<Box<dyn Experiment>>,
}

impl Kind {
    /// A kind whose keys in a procedure file are read as `K`.
    const fn new<K: ReadKeys>(
        name: &'static str,
        doc: &'static str,
        fields: &'static [Field],
        measurands: &'static [Measurand],
    ) -> Self {
        let read: fn(&mut TableReader<'_>) -> Option<Box<dyn Experiment>> =
            |table| K::read(table).map(|keys| Box::new(keys) as Box<dyn Experiment>);
        Self { name, doc, fields, measurands, read }
    }
}

/// Keys of a kind, and how a procedure file is read for them.
trait ReadKeys: Experiment + Sized + 'static {
    /// Reads the kind's own keys; mistakes stay in the reader, `None` if it cannot go on.
    fn read(table: &mut TableReader<'_>) -> Option<Self>;
}

/// A procedure's kind with its keys read.
pub trait Experiment: Send + Sync + std::fmt::Debug {
    /// Names of the measurands that this procedure yields with these keys; `None` for all of its kind.
    fn yields(&self) -> Option<Vec<&'static str>> {
        None
    }
    /// The points to run on the procedure's axis, or why the rig does not allow them.
    ///
    /// # Errors
    /// One diagnostic for each thing that the axis cannot do (limits crossed, travel left, quantum too coarse).
    fn plan(&self, axis: &str, axes: &Axes) -> Result<Vec<Case>, Vec<Diagnostic>>;
    /// Devices without which it has nothing to read, beside those that its points need to be run (see [`Case::needs`]).
    fn needs(&self) -> Vec<DeviceRole> {
        Vec::new()
    }
    /// What a person should know before it runs, a sentence each.
    fn notes(&self, _axis: &str, _axes: &Axes) -> Vec<String> {
        Vec::new()
    }
    /// What is asked for, does not fit the axis, and is cut or moved until it does, a sentence each.
    fn cuts(&self, _axis: &str, _axes: &Axes) -> Vec<String> {
        Vec::new()
    }
    /// One point, from its window of the log alone.
    fn analyse(&self, case: &Case, window: &Window, axes: &Axes) -> PointResult;
    /// Whether a point that did not complete says something, too: one that looks for faults must not fall silent
    /// because a fault ended it.
    fn reads_broken_off(&self) -> bool {
        false
    }
    /// Over all points, in plan order: what each of them measured and shows, unless the kind has more to say.
    fn conclude(&self, _cases: &[Case], points: &[PointResult], _axes: &Axes) -> Conclusion {
        Conclusion::collected(points)
    }
}

/// Every kind there is. A new kind is one file, its `mod` in the family's file and one line here.
pub const KINDS: &[Kind] = &[
    friction::hysteresis::KIND,
    friction::breakaway::KIND,
    safety::polarity::KIND,
    response::frequency_response::KIND,
    response::latency::KIND,
    response::modes::KIND,
    mirror::fsm_impedance::KIND,
    mirror::fsm_response::KIND,
    response::imported_response::KIND,
    inertial::allan::KIND,
    position::step::KIND,
    position::slew::KIND,
    position::profile::KIND,
    position::accuracy::KIND,
    safety::duty::KIND,
    safety::range::KIND,
    inertial::imu_consistency::KIND,
    safety::stop::KIND,
    friction::model_check::KIND,
    position::static_hold::KIND,
    safety::self_check::KIND,
    optics::optical_gain::KIND,
    optics::atmosphere::KIND,
    optics::tracker_latency::KIND,
    optics::track::KIND,
    friction::torque_constant::KIND,
];

/// The kind of this name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|k| k.name == name)
}

/// The measurand of this name, with the kind that yields it.
pub fn measurand(name: &str) -> Option<(&'static Kind, &'static Measurand)> {
    KINDS.iter().find_map(|k| k.measurands.iter().find(|m| m.name == name).map(|m| (k, m)))
}
