//! Options that several verbs have.

use super::output;
use crate::files::rig::read_rig;
use crate::files::shipped::{self, Folder};
use crate::files::unit::load_unit;
use crate::model::rig::Rig;
use crate::site::unit::Unit;

/// What becomes of procedures that the rig cannot run.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Leave out procedures that need a device that the rig lacks: the outcome is PARTIAL
    #[arg(long)]
    pub(super) skip_missing: bool,
}

/// What a run, a check or a plan is made against.
#[derive(clap::Args, Clone, Debug)]
pub(super) struct On {
    /// Rig: a shipped name or a path
    #[arg(long, default_value = "sim")]
    pub(super) rig: String,
    /// Simulated unit: a shipped name or a path
    #[arg(long, default_value = "nominal")]
    pub(super) unit: String,
}

impl On {
    /// Reads the rig and unit files.
    pub(super) fn load(&self) -> Result<(Rig, Unit), u8> {
        let rig = shipped::find(Folder::Rigs, &self.rig, None).and_then(read_rig);
        let unit = load_unit(&self.unit);
        match (rig, unit) {
            (Ok(rig), Ok(unit)) => Ok((rig, unit)),
            (rig, unit) => {
                let found: Vec<_> = rig.err().into_iter().chain(unit.err()).flatten().collect();
                Err(output::mistakes(&found))
            }
        }
    }
}
