//! A run on a simulated unit in virtual time that nobody watches: one of many, for a comparison.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU16;

use controllers::DirectorGains;
use procedures::diagnostic::Diagnostic;

use super::{RunResult, Setup};
use crate::cycle::laws::Laws;
use crate::exit;
use crate::judge;
use crate::model::rig::Rig;
use crate::people::Answers;
use crate::people::event::{Listener, RunEvent};
use crate::people::lock;
use crate::people::underway::Underway;
use crate::plan::CampaignPlan;
use crate::site::VirtualSite;
use crate::site::unit::Unit;

/// What such a run is made of.
pub(crate) struct Simulated<'a> {
    pub(crate) plan: &'a CampaignPlan,
    pub(crate) rig: &'a Rig,
    pub(crate) gains: &'a DirectorGains,
    pub(crate) laws: &'a Laws,
    pub(crate) unit: &'a Unit,
    pub(crate) seed: u64,
    /// Run folder, not existing.
    pub(crate) folder: &'a Path,
    pub(crate) stop: &'a Arc<AtomicU16>,
}

/// Why there is no result.
pub(crate) struct NoResult {
    pub(crate) why: String,
    pub(crate) exit_code: u8,
}

/// Nobody listens to one run of many.
struct Nobody;

impl Listener for Nobody {
    fn hear(&mut self, _event: &RunEvent) {}
}

impl Simulated<'_> {
    /// Runs it; a point at a time, because several such runs go on at once.
    pub(crate) fn run(&self) -> Result<RunResult, NoResult> {
        let mistakes = |found: Vec<Diagnostic>| {
            let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
            NoResult { why: texts.join("\n"), exit_code: exit::USAGE }
        };
        let failure = |why: String| NoResult { why, exit_code: exit::BENCH };
        let built = self.plan.units(self.unit).map_err(mistakes)?;
        std::fs::create_dir_all(self.folder)
            .map_err(|error| failure(format!("{}: {error}", self.folder.display())))?;
        let site = VirtualSite::new(self.unit, &built);
        let setup = Setup {
            plan: self.plan,
            rig: self.rig,
            unit: self.unit,
            built: built.clone(),
            gains: self.gains,
            laws: self.laws.clone(),
            folder: self.folder.to_owned(),
            seed: self.seed,
            jobs: Some(1),
            answers: Answers { yes: true, non_interactive: true, ..Answers::default() },
            lock_folder: lock::system_folder(),
            operator: None,
            serial_number: None,
            command_line: String::new(),
            underway: Underway::default(),
            stop: Arc::clone(self.stop),
            polarity: None,
            site: &site,
            judge: judge::judge_log,
            judge_program: None,
        };
        super::run(&setup, &mut Nobody).map_err(|error| failure(error.to_string()))
    }
}
