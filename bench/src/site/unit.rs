//! The unit that a simulated site obeys, as its file and the files below it say; nothing else reads its settings.

use procedures::diagnostic::SourceFile;
use sim_devices::unit::{TableSettings, UnitSettings};

/// What is simulated.
#[derive(Clone, Debug, PartialEq)]
pub enum World {
    /// Two axes with structure, payload, trackers and instruments.
    Director(Box<UnitSettings>),
    /// One to four axes that do not act on each other.
    Table(TableSettings),
}

/// A unit file with everything that its bases say.
#[derive(Clone, Debug)]
pub struct Unit {
    /// E.g. `nominal`, `azimuth-retainer`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What the simulation obeys.
    pub world: World,
    /// Requirements that this defect must turn to fail.
    pub must_flip: Vec<String>,
    /// Requirements that it may turn.
    pub may_flip: Vec<String>,
    /// The check before motion or the interlock that this defect must trip, so that nothing is measured.
    pub must_trip: Option<String>,
    /// The physical reason.
    pub reason: Option<String>,
    /// The files, from the unit itself to its last base.
    pub sources: Vec<SourceFile>,
}

/// What differs in a unit that is not complete yet. A state is laid over whichever unit is chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildState {
    /// E.g. `azimuth-table`.
    pub id: String,
    /// Heading.
    pub title: String,
    /// The file.
    pub source: SourceFile,
}

impl Unit {
    /// Whether something is planted in it: it claims to fail a requirement, or to end a run.
    pub fn is_defect(&self) -> bool {
        self.must_trip.is_some() || !self.must_flip.is_empty()
    }

    /// The settings of a director; `None` for a unit that is something else.
    pub fn director(&self) -> Option<&UnitSettings> {
        match &self.world {
            World::Director(settings) => Some(settings),
            World::Table(_) => None,
        }
    }
}
