//! `bench sim`: serves the far ends of a rig to another process, or gives an order to who does.

use std::path::PathBuf;

use procedures::quantity::QuantityKind;

use super::options::load;
use super::output;
use crate::exit;
use crate::people::signals;
use crate::sim::{self, Settings, SimError};
use crate::site;
use crate::site::order::{self, Answer};

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Rig whose devices are simulated: a shipped name or a path
    #[arg(long, default_value = "wired")]
    rig: String,
    /// Simulated unit: a shipped name or a path
    #[arg(long, default_value = "nominal")]
    unit: String,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Interface to serve; the other end of the rig's own pair of virtual interfaces if not given
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// Serve the serial lines and sockets of the rig alone, without its interface: needs no rights; a run needs the interface too
    #[arg(long, conflicts_with = "interface")]
    lines: bool,
    /// Control socket; one named after the interface in the user's own folder if not given
    #[arg(long, value_name = "PATH")]
    control: Option<PathBuf>,
    /// Where an axis stands at the start, e.g. `az=20 deg`; where polarity expects it if not given
    #[arg(long, value_name = "AXIS=ANGLE", value_parser = pose, default_values = ["az=20 deg", "el=40 deg"])]
    pose: Vec<(String, f64)>,
    /// Log where the axes really are to this MCAP file
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Give this order to the simulator that runs, print its answer and end: `"status"`, `"stop"`,
    /// `{"wire":{"drop":{"frames":3}}}`, `{"world":{"emergency-stop":{"pressed":true}}}`
    #[arg(long, value_name = "JSON")]
    tell: Option<String>,
}

/// Reads where an axis stands.
fn pose(text: &str) -> Result<(String, f64), String> {
    let expected = || format!("expected an axis and its angle, e.g. `az=20 deg`, found `{text}`");
    let (axis, angle) = text.split_once('=').ok_or_else(expected)?;
    let angle_rad =
        QuantityKind::Angle.parse(angle.trim()).map_err(|error| format!("{}: {error}", expected()))?;
    Ok((axis.trim().to_owned(), angle_rad))
}

pub(super) fn run(args: &Args) -> u8 {
    match &args.tell {
        Some(order) => tell(args, order),
        None => serve(args),
    }
}

fn serve(args: &Args) -> u8 {
    let stop = match signals::listen(|_| {}) {
        Ok(stop) => stop,
        Err(error) => {
            output::error(&format!("signals: {error}; raise the limit of processes (`ulimit -u`)"));
            return exit::BENCH;
        }
    };
    let (rig, unit) = match load(&args.rig, &args.unit) {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    let settings = Settings {
        rig: &rig,
        unit: &unit,
        seed: args.seed,
        pose_rad: args.pose.iter().cloned().collect(),
        interface: args.interface.clone(),
        are_lines_alone: args.lines,
        control: args.control.clone(),
        log: args.log.clone(),
    };
    if let Err(code) = signals::begin(&stop) {
        return code;
    }
    match sim::serve(&settings, &stop, &mut |line| output::say(line)) {
        Ok(report) => {
            output::note(&format!(
                "{} frames answered, {} not; {} answers not sent; {} rows of the truth lost; {} contacts with end stops",
                report.frames,
                report.unanswered,
                report.unsent,
                report.lost_rows,
                report.contacts.len()
            ));
            signals::exit_code(&stop)
        }
        Err(error) => {
            output::error(&error.to_string());
            if matches!(error, SimError::Locked(_)) { exit::REFUSED } else { exit::BENCH }
        }
    }
}

/// Gives an order to the simulator behind the rig's interface.
fn tell(args: &Args, order: &str) -> u8 {
    let order = match order::read(order) {
        Ok(order) => order,
        Err(why) => {
            output::error(&format!("--tell: {why}"));
            return exit::USAGE;
        }
    };
    let path = match control_path(args) {
        Ok(path) => path,
        Err(code) => return code,
    };
    match site::tell(&path, &order) {
        Ok(Answer::Done(text)) => {
            output::say(&text);
            exit::PASS
        }
        Ok(Answer::Refused(why)) => {
            output::error(&format!("the simulator refuses: {why}"));
            exit::USAGE
        }
        Err(error) => {
            output::error(&format!("{}: {error}; does `bench sim` run?", path.display()));
            exit::BENCH
        }
    }
}

fn control_path(args: &Args) -> Result<PathBuf, u8> {
    if let Some(path) = &args.control {
        return Ok(path.clone());
    }
    let (rig, _) = load(&args.rig, &args.unit)?;
    let path = match args.lines {
        true => sim::control_path_of_lines(&rig),
        false => sim::control_path(&rig, args.interface.as_deref()),
    };
    path.map_err(|error| {
        output::error(&error.to_string());
        exit::BENCH
    })
}
