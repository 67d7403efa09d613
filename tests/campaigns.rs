//! Runs that are carried out by the library, so that a test chooses the site, the judge and the listener.

use std::path::Path;
use std::sync::Arc;

use bench::campaign::Setup;
use bench::files::parameters;
use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::files::unit::load_unit;
use bench::judge;
use bench::people::Answers;
use bench::people::event::{Listener, RunEvent};
use bench::people::underway::Underway;
use bench::plan::{Wanted, plan};
use bench::site::Site;
use bench::site::unit::Unit;

/// Listens to nothing.
pub(crate) struct Silent;

impl Listener for Silent {
    fn hear(&mut self, _: &RunEvent) {}
}

/// What the site of a run is made from.
pub(crate) fn nominal() -> Unit {
    load_unit("nominal").expect("the shipped unit")
}

/// Hands `carry_out` the setup of a run of these procedures on a shipped rig, everything else as it is by default.
pub(crate) fn with_setup<T>(
    rig: &str,
    names: &[&str],
    folder: &Path,
    (unit, site): (&Unit, &dyn Site),
    carry_out: impl FnOnce(Setup<'_>) -> T,
) -> T {
    let rig = shipped::find(Folder::Rigs, rig, None).and_then(read_rig).expect("a shipped rig");
    let wanted = Wanted { names: names.iter().map(|&name| name.to_owned()).collect(), ..Wanted::default() };
    carry_out(Setup {
        plan: &plan(&wanted, &rig).expect("shipped procedures"),
        unit,
        built: Vec::new(),
        laws: Default::default(),
        gains: &parameters::load(&rig).expect("shipped parameters"),
        rig: &rig,
        folder: folder.to_owned(),
        seed: 1,
        jobs: None,
        answers: Answers::default(),
        lock_folder: folder.to_owned(),
        operator: None,
        serial_number: None,
        command_line: String::new(),
        underway: Underway::default(),
        stop: Arc::default(),
        polarity: None,
        site,
        judge: judge::judge_log,
        judge_program: None,
    })
}
