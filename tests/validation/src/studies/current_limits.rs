//! Every moving procedure of a campaign on drives that give less than the rig file says, and whether an axis met its stop.
//!
//! `cargo run --release -p validation -- current_limits [--campaign NAME] [--step PERCENT] [--program PATH]`: current
//! limits of both drives from 50 % to 100 %, in steps of 5 % unless told otherwise. Prints a line a limit; ends with 1
//! where an axis met its stop, or where the record of a stop reads well and the world says otherwise.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use bench::files::unit::load_unit;
use serde_json::Value;
use validation::program::built;

/// What the program says of a contact with an end stop.
const CONTACT: &str = "hit its end stop";

pub(crate) fn study() -> ExitCode {
    let words: Vec<String> = crate::arguments().collect();
    let after = |key: &str| words.iter().position(|word| word == key).and_then(|k| words.get(k + 1));
    let campaign = after("--campaign").map_or("quick", String::as_str);
    let step = after("--step").and_then(|text| text.parse::<u32>().ok()).unwrap_or(5).max(1);
    let program = after("--program").map_or_else(built, PathBuf::from);
    println!(
        "{:>7} {:>9} {:>6} {:>6} {:>9} {:>12} {:>6}",
        "current", "contacts", "trips", "stops", "exceeding", "least room", "exit"
    );
    let mut broken = 0;
    for percent in (50..=100).step_by(step as usize) {
        let ran = run(&program, campaign, percent);
        println!("{}", ran.line(percent));
        broken += ran.contacts.len() + ran.lies;
        ran.contacts.iter().for_each(|line| println!("    {line}"));
    }
    println!("{broken} contacts or untrue records");
    if broken == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// What came of a campaign.
#[derive(Default)]
struct Ran {
    /// Lines of the program that tell of a contact.
    contacts: Vec<String>,
    trips: usize,
    stops: usize,
    exceeding: usize,
    least_room_deg: f64,
    /// Contacts of procedures all of whose stops stayed inside the travel, by their records.
    lies: usize,
    exit: i32,
}

impl Ran {
    fn line(&self, percent: u32) -> String {
        format!(
            "{percent:>6}% {:>9} {:>6} {:>6} {:>9} {:>8.3} deg {:>6}",
            self.contacts.len(),
            self.trips,
            self.stops,
            self.exceeding,
            self.least_room_deg,
            self.exit
        )
    }

    fn take(&mut self, procedure: &Value) {
        let list = |name: &str| procedure["safety"][name].as_array().cloned().unwrap_or_default();
        let id = procedure["id"].as_str().unwrap_or_default();
        self.trips += list("trips").len();
        let mut well = true;
        for stop in list("stops") {
            let number = |name: &str| stop[name].as_f64().unwrap_or(f64::NAN);
            let room_deg = number("room_rad").to_degrees();
            self.stops += 1;
            self.least_room_deg = self.least_room_deg.min(room_deg);
            let exceeds = number("reached_angle_rad") > number("computed_angle_rad") || room_deg < 0.0;
            self.exceeding += usize::from(exceeds);
            well &= !exceeds;
        }
        let met = self.contacts.iter().any(|line| line.starts_with(id));
        self.lies += usize::from(met && well);
    }
}

fn run(program: &Path, campaign: &str, percent: u32) -> Ran {
    let folder = std::env::temp_dir().join(format!("current-limits-{}-{percent}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    let nominal = load_unit("nominal").expect("a shipped unit");
    let nominal = nominal.director().expect("a director").clone();
    let limit_a = |whole_a: f64| whole_a * f64::from(percent) / 100.0;
    let unit = format!(
        "schema = 1\nid = \"limited\"\ntitle = \"Drives at {percent} % of their current\"\nbase = \"nominal\"\n\
         [az]\ncurrent-limit = \"{} A\"\n[el]\ncurrent-limit = \"{} A\"\n",
        limit_a(nominal.az.current_limit_a),
        limit_a(nominal.el.current_limit_a)
    );
    std::fs::write(folder.join("unit.toml"), unit).expect("a writable folder");
    let output = Command::new(program)
        .args(["run", campaign, "--unit", "./unit.toml", "--out", "run", "--non-interactive", "--yes"])
        .current_dir(&folder)
        .output()
        .expect("the program under test starts");
    let said =
        format!("{}\n{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let contacts = said.lines().filter(|line| line.contains(CONTACT)).map(str::to_owned).collect();
    let exit = output.status.code().unwrap_or(-1);
    let mut ran = Ran { contacts, exit, least_room_deg: f64::INFINITY, ..Ran::default() };
    let text = std::fs::read_to_string(folder.join("run/results.json")).unwrap_or_default();
    let results: Value = serde_json::from_str(&text).unwrap_or_default();
    for procedure in results["findings"]["procedures"].as_array().into_iter().flatten() {
        ran.take(procedure);
    }
    let _ = std::fs::remove_dir_all(&folder);
    ran
}
