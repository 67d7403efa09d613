//! `[[start-up]]`: objects that are written in PRE-OP, in a profile or for one axis of a rig.

use std::ops::Range;

use drivers::cia402::profile::{DriveProfile, StartUp};
use procedures::table::{Field, Shape, TableReader};

use super::fields::TYPE;
use super::{data_type, object, written};

/// Keys of `[[start-up]]`.
pub(in crate::files) const START_UP_FIELDS: &[Field] = &[
    Field::required("object", Shape::Text, "Object, e.g. `1C32h:01`."),
    Field::required("type", TYPE, "Coding of the object."),
    Field::required("value", Shape::Integer, "Value, in counts of the object."),
    Field::required("why", Shape::Text, "Why it is written."),
];

/// An entry, and where it stands.
pub(in crate::files) struct Written {
    entry: StartUp,
    place: Range<usize>,
}

/// Reads one entry.
pub(in crate::files) fn read(t: &mut TableReader<'_>) -> Option<Written> {
    let place = object(t, "object");
    let data_type = data_type(t);
    let value = t.integer("value", i64::MIN);
    let why = t.text("why");
    let data_type = data_type?;
    let value = value?;
    let (least, most) = data_type.range()?;
    if !(least..=most).contains(&value) {
        t.mistake("value", format!("the type holds {least} to {most}, found {value}"), None);
        return None;
    }
    Some(Written { entry: StartUp { place: place?, data_type, value, why: why? }, place: t.place() })
}

/// The entries of a list, without those that the driver of such a drive would overwrite: these are mistakes.
pub(in crate::files) fn check(
    t: &mut TableReader<'_>,
    profile: &DriveProfile,
    list: Vec<Written>,
) -> Vec<StartUp> {
    let mut kept = Vec::new();
    for Written { entry, place } in list {
        if profile.writes(entry.place) {
            let name = written(entry.place.index, entry.place.sub);
            let help = "it follows from the rig file; change it there".to_owned();
            t.mistake_at(place, format!("`{name}` is written by the driver itself"), Some(help));
        } else {
            kept.push(entry);
        }
    }
    kept
}
