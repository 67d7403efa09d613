//! `bench schema`: JSON Schema of the files that people write, from the same field lists that read them.

use procedures::kinds::KINDS;
use procedures::log::EVENTS_SCHEMA;
use procedures::schema::{self, Variant};
use serde_json::Value;

use super::output;
use crate::exit;
use crate::files::{answers, import_map, parameters, rig, unit, waivers};
use crate::people::event;
use crate::rig::devices::DRIVERS;
use crate::rig::driver::Driver;

#[derive(clap::Args, Debug)]
pub(super) struct Args {
    /// Sort of file: a kind of procedure, `campaign`, `requirements`, `rig`, `unit`, `unit-table`, `parameters`, `import`, `answers`,
    /// `waivers`; or `events` for the lines of `run --json`, `log-events` for topic `/events` of a log; all of them as one object if not given
    sort: Option<String>,
}

fn schemas() -> Vec<(String, Value)> {
    let mut all: Vec<(String, Value)> =
        KINDS.iter().map(|k| (k.name.to_owned(), schema::procedure_schema(k))).collect();
    all.push(("campaign".to_owned(), schema::campaign_schema()));
    all.push(("requirements".to_owned(), schema::requirements_schema()));
    for (name, fields) in [
        ("rig", rig::FIELDS),
        ("unit", unit::fields()),
        ("unit-table", unit::table_fields()),
        ("parameters", parameters::fields()),
        ("import", import_map::FIELDS),
        ("answers", answers::FIELDS),
        ("waivers", waivers::FIELDS),
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

/// Each driver adds its own keys to `[[device]]`.
fn describe_devices(rig: &mut Value) {
    let variant = |d: &&Driver| Variant { name: d.name, doc: d.doc, fields: d.fields };
    let variants: Vec<Variant> = DRIVERS.iter().map(variant).collect();
    if let Some(items) = rig.pointer_mut("/properties/device/items") {
        *items = schema::variants_schema(rig::DEVICE_FIELDS, "driver", &variants);
    }
}

pub(super) fn run(args: &Args) -> u8 {
    let all = schemas();
    let value = match &args.sort {
        None => Value::Object(all.into_iter().collect()),
        Some(sort) => {
            let names: Vec<String> = all.iter().map(|(name, _)| name.clone()).collect();
            match all.into_iter().find(|(name, _)| name == sort) {
                Some((_, value)) => value,
                None => {
                    output::error(&format!("schema {sort}: expected one of {}", names.join(", ")));
                    return exit::USAGE;
                }
            }
        }
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
