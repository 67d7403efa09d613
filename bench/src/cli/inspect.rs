//! `bench inspect`: look at the rig after a run on it was lost, and put on record what was found.

use std::path::PathBuf;

use super::{output, results};
use crate::exit;
use crate::files::parameters;
use crate::files::rig::read_rig;
use crate::files::unit::load_unit;
use crate::people::inspect::{self, Finding, LastKnown, Standing, TOLERANCE_DEG};
use crate::people::lock::{self, Holder};
use crate::record::evidence;
use crate::record::journal::AxisAngle;
use crate::record::page::Page;
use crate::site::VirtualSite;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Folder of the run that was lost
    run: PathBuf,
    /// Who inspected the rig
    #[arg(long, value_name = "NAME", requires = "found")]
    operator: Option<String>,
    /// What was found
    #[arg(long, value_name = "TEXT", requires = "operator")]
    found: Option<String>,
    /// Release the rig although its positions do not agree with the journal, because the finding explains why
    #[arg(long, requires = "found")]
    accept_positions: bool,
    /// Simulated unit; that of the run if not given
    #[arg(long, value_name = "U")]
    unit: Option<String>,
}

pub(super) fn run(args: &Args) -> u8 {
    inspect(args).unwrap_or_else(|code| code)
}

fn refused(message: impl std::fmt::Display) -> u8 {
    output::error(&message.to_string());
    exit::REFUSED
}

fn inspect(args: &Args) -> Result<u8, u8> {
    let page = Page::read(&args.run).map_err(|message| {
        output::error(&message);
        exit::USAGE
    })?;
    let believed = results::tell(&args.run, &evidence::check(&args.run));
    if believed != exit::PASS && !args.accept_positions {
        output::error(
            "find out who changed the run folder and where the axes are, then add --accept-positions",
        );
        return Err(believed);
    }
    let (journal, known) = inspect::journal_of(&args.run).map_err(refused)?;
    let rig = read_rig(page.rig.source()).map_err(|found| output::mistakes(&found))?;
    let gains = parameters::load(&rig).map_err(|found| output::mistakes(&found))?;
    let of_run = page.unit_files.first().map_or("nominal", |file| file.name.as_str());
    let unit = load_unit(args.unit.as_deref().unwrap_or(of_run)).map_err(|found| output::mistakes(&found))?;
    let _lines =
        lock::claim(&lock::system_folder(), &lock::lines(&rig), &Holder::verb("inspect")).map_err(refused)?;
    let standing =
        inspect::stand(&VirtualSite::new(&unit, &[]), &rig, &gains, &known.angles_deg).map_err(|error| {
            output::error(&error.to_string());
            exit::BENCH
        })?;
    let resources =
        [lock::interfaces(&rig), lock::rig_itself(&rig, &standing.bus, &standing.devices)].concat();
    let held = lock::take_to_inspect(&lock::system_folder(), &resources, &args.run).map_err(refused)?;
    output::say(&told(&known, &standing));
    let (Some(by), Some(found)) = (args.operator.clone(), args.found.clone()) else {
        return Err(refused("nothing was recorded: inspect the rig, then give --operator NAME --found TEXT"));
    };
    let finding = Finding { by, found, accepts_positions: args.accept_positions };
    match inspect::record(journal, &known, &standing, finding) {
        Ok(true) => {
            held.release();
            output::say("recorded; the rig is released");
            Ok(exit::PASS)
        }
        Ok(false) => Err(refused(format!(
            "recorded, but positions do not agree with the journal within {TOLERANCE_DEG} deg: the rig is not \
             released; find out why, then add --accept-positions"
        ))),
        Err(error) => {
            output::error(&format!("{}: the journal cannot be written: {error}", args.run.display()));
            Err(exit::BENCH)
        }
    }
}

/// What the journal says beside what the rig shows.
fn told(known: &LastKnown, standing: &Standing) -> String {
    let mut lines = vec![format!("last entry: {}", known.utc)];
    lines.push(match (&known.why, &known.in_motion) {
        (Some(why), _) => why.clone(),
        (None, Some((procedure, point))) => {
            format!("lost in {procedure} [{point}]: the axes may have been moving")
        }
        (None, None) => "lost between points".to_owned(),
    });
    for AxisAngle { axis, deg } in &standing.angles_deg {
        let before = known.angles_deg.iter().find(|before| before.axis == *axis);
        let before =
            before.map_or("no angle in the journal".to_owned(), |b| format!("was at {:.3} deg", b.deg));
        lines.push(format!("{axis}: {before}, is at {deg:.3} deg"));
    }
    lines.join("\n")
}
