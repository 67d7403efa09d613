//! `bench schema`: JSON Schema of the files that people write, from the same field lists that read them.

use procedures::comparison::PUBLISHED_FIELDS;
use procedures::diagnostic::Diagnostic;
use procedures::kinds::{KINDS, Kind};
use procedures::log::EVENTS_SCHEMA;
use procedures::regression;
use procedures::schema::{self, Variant};
use serde_json::Value;

use super::output;
use crate::exit;
use crate::files::shipped::{self, Folder};
use crate::files::{answers, family, import_map, parameters, profile, reader, rig, unit, waivers};
use crate::people::event;
use crate::rig::devices::DRIVERS;
use crate::rig::driver::Driver;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// File type: `procedure`, a kind of procedure such as `hysteresis`, `campaign`, `requirements`, `rig`, `unit`,
    /// `unit-table`, `family`, `parameters`, `profile`, `reader`, `import`, `answers`, `criteria`, `waivers`, `published`; or `events` for the
    /// lines of `run --json`, `log-events` for topic `/events` of a log; all of them as one object if not given
    sort: Option<String>,
    /// Rig whose axes procedures may move: a shipped name or a path
    #[arg(long)]
    rig: Option<String>,
}

/// Sort of file: procedures of every kind.
const PROCEDURE: &str = "procedure";

fn schemas() -> Vec<(String, Value)> {
    let kinds: Vec<&Kind> = KINDS.iter().collect();
    let mut all = vec![(PROCEDURE.to_owned(), schema::procedures_schema(&kinds))];
    all.extend(KINDS.iter().map(|k| (k.name.to_owned(), schema::procedure_schema(k))));
    all.push(("campaign".to_owned(), schema::campaign_schema()));
    all.push(("requirements".to_owned(), schema::requirements_schema()));
    for (name, fields) in [
        ("rig", rig::FIELDS),
        ("unit", unit::fields()),
        ("unit-table", unit::table_fields()),
        ("family", family::FIELDS),
        ("parameters", parameters::fields()),
        ("profile", profile::FIELDS),
        ("reader", reader::FIELDS),
        ("import", import_map::FIELDS),
        ("answers", answers::FIELDS),
        ("criteria", regression::FIELDS),
        ("waivers", waivers::FIELDS),
        ("published", PUBLISHED_FIELDS),
    ] {
        all.push((name.to_owned(), schema::json_schema(fields)));
    }
    all.push(("events".to_owned(), event::schema::schema()));
    let of_log = serde_json::from_str(EVENTS_SCHEMA).expect("the schema is JSON: a test of the log reads it");
    all.push(("log-events".to_owned(), of_log));
    if let Some((_, rig)) = all.iter_mut().find(|(name, _)| name == "rig") {
        describe_devices(rig);
    }
    all
}

/// All schemas, with the axes of this rig where a procedure names one.
pub(super) fn with_axes_of(rig: &str) -> Result<Vec<(String, Value)>, Vec<Diagnostic>> {
    let rig = rig::read_rig(shipped::find(Folder::Rigs, rig, None)?)?;
    let axes: Vec<&str> = rig.axes.iter().map(|axis| axis.name.as_str()).collect();
    let mut all = schemas();
    let is_procedure = |sort: &str| sort == PROCEDURE || KINDS.iter().any(|kind| kind.name == sort);
    for (_, schema) in all.iter_mut().filter(|(sort, _)| is_procedure(sort)) {
        schema::name_axes(schema, &axes);
    }
    Ok(all)
}

/// Each driver adds its own keys to `[[device]]`.
fn describe_devices(rig: &mut Value) {
    let variant = |d: &&Driver| Variant { name: d.name, doc: d.doc, fields: d.fields };
    let variants: Vec<Variant> = DRIVERS.iter().map(variant).collect();
    if let Some(items) = rig.pointer_mut("/properties/device/items") {
        *items = schema::variants_schema(rig::DEVICE_FIELDS, "driver", &variants);
    }
}

pub(super) fn run(args: &Args) -> u8 {
    let all = match args.rig.as_deref().map_or_else(|| Ok(schemas()), with_axes_of) {
        Ok(all) => all,
        Err(mistakes) => return output::mistakes(&mistakes),
    };
    let value = match &args.sort {
        None => Value::Object(all.into_iter().collect()),
        Some(sort) => match all.iter().find(|(name, _)| name == sort) {
            Some((_, value)) => value.clone(),
            None => {
                let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
                output::error(&format!("schema {sort}: expected one of {}", names.join(", ")));
                return exit::USAGE;
            }
        },
    };
    match serde_json::to_string_pretty(&value) {
        Ok(text) => {
            output::say(&text);
            exit::PASS
        }
        Err(error) => {
            output::error(&error.to_string());
            exit::INTERNAL
        }
    }
}
