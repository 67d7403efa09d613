//! Drive profiles: types of drives as data (`drivers/profiles/*.toml`).

use std::ops::Range;
use std::sync::{Arc, LazyLock};

use drivers::cia402::objects::{self, DataType};
use drivers::cia402::pdo::Entry;
use drivers::cia402::profile::{
    DriveClock, DriveProfile, HeatSink, INPUTS, MAY_LACK, OUTPUTS, ObjectPlace, ProcessData, ProfileIdentity,
    ReadBy, TorqueScale, WatchdogObject,
};
use procedures::diagnostic::{Diagnostic, SourceFile};
use procedures::table::{TableReader, quoted, read_file};

use super::shipped::{self, Folder, sort};

mod fields;
mod start_up;

pub use fields::FIELDS;
use fields::TYPES;
pub(super) use start_up::{START_UP_FIELDS, check as check_start_up, read as read_start_up};

/// Profile of the drives of the simulator.
pub const SIMULATED: &str = "simulated";
/// Profile of drives of which nothing else is said.
pub const GENERIC: &str = "generic-cia402";

/// Reads a profile.
///
/// # Errors
/// All mistakes at once.
pub fn read_profile(source: &SourceFile) -> Result<DriveProfile, Vec<Diagnostic>> {
    read_file(source, FIELDS, read)
}

/// The profile of this name; `beside` is the file that names it, if one does.
///
/// # Errors
/// All mistakes of the profile at once, or that there is none.
pub fn load(name: &str, beside: Option<&str>) -> Result<Arc<DriveProfile>, Vec<Diagnostic>> {
    let source = shipped::find(Folder::Profiles, name, beside)?;
    let source = sort::expect(source, Folder::Profiles)?;
    read_profile(&source).map(Arc::new)
}

/// The profile of the drives of the simulator.
pub fn simulated() -> Arc<DriveProfile> {
    static PROFILE: LazyLock<Arc<DriveProfile>> = LazyLock::new(|| {
        load(SIMULATED, None).expect("it is shipped, and a test reads every shipped profile")
    });
    Arc::clone(&PROFILE)
}

fn read(t: &mut TableReader<'_>) -> Option<DriveProfile> {
    let schema = t.schema();
    let id = t.text("id");
    t.text("title");
    t.text("source");
    let identity =
        if t.has("identity") { t.table("identity", read_identity) } else { Some(ProfileIdentity::default()) };
    let heat_sink = optional(t, "heat-sink", read_heat_sink);
    let watchdog = optional(t, "watchdog", read_watchdog);
    let of_heat_sink = heat_sink.flatten();
    let process_data = t.table("process-data", |t| read_process_data(t, of_heat_sink));
    let torque_scale = t.text("torque-scale").map(|word| match word.as_str() {
        "rated-current" => TorqueScale::RatedCurrent,
        _ => TorqueScale::RatedTorque,
    });
    let clock = read_clock(t);
    let lacks = read_lacks(t);
    let start_up = if t.has("start-up") { t.tables("start-up", read_start_up) } else { Some(Vec::new()) };
    let (outputs, inputs) = process_data?;
    let mut profile = DriveProfile {
        id: schema.and(id)?,
        identity: identity?,
        outputs,
        inputs,
        torque_scale: torque_scale?,
        clock: clock?,
        heat_sink: heat_sink?,
        watchdog: watchdog?,
        lacks: lacks?,
        start_up: Vec::new(),
    };
    check_currents(t, &profile);
    profile.start_up = check_start_up(t, &profile, start_up?);
    Some(profile)
}

/// A table that may be left out: `None` where it is wrong.
fn optional<T>(
    t: &mut TableReader<'_>,
    key: &'static str,
    read: impl FnOnce(&mut TableReader<'_>) -> Option<T>,
) -> Option<Option<T>> {
    if t.has(key) { t.table(key, read).map(Some) } else { Some(None) }
}

fn read_identity(t: &mut TableReader<'_>) -> Option<ProfileIdentity> {
    let before = t.mistakes();
    let vendor = number(t, "vendor");
    let product = number(t, "product");
    let lowest = number(t, "lowest-revision");
    let highest = number(t, "highest-revision");
    let revisions =
        (lowest.is_some() || highest.is_some()).then(|| [lowest.unwrap_or(0), highest.unwrap_or(u32::MAX)]);
    if let Some([low, high]) = revisions.filter(|[low, high]| low > high) {
        let message = format!("the highest revision {high:08X}h is below the lowest {low:08X}h");
        t.mistake("highest-revision", message, None);
    }
    (t.mistakes() == before).then_some(ProfileIdentity { vendor, product, revisions })
}

/// A number of 32 bits that may be left out.
pub(super) fn number(t: &mut TableReader<'_>, key: &'static str) -> Option<u32> {
    if !t.has(key) {
        return None;
    }
    let value = t.integer(key, 0)?;
    let fitting = u32::try_from(value).ok();
    if fitting.is_none() {
        t.mistake(key, format!("`{key}`: {value:X}h has more than 32 bits"), None);
    }
    fitting
}

fn read_clock(t: &mut TableReader<'_>) -> Option<DriveClock> {
    let has_sync0 = t.text("assign-activate")? == "0300h";
    let sync0_shift_s = if t.has("sync0-shift") { Some(t.quantity("sync0-shift")?) } else { None };
    if sync0_shift_s.is_some_and(|shift_s| shift_s < 0.0) {
        t.mistake("sync0-shift", "`sync0-shift` must not be negative", None);
    }
    let shortest_cycle_s = if t.has("shortest-cycle") { Some(t.positive("shortest-cycle")?) } else { None };
    Some(DriveClock { has_sync0, sync0_shift_s, shortest_cycle_s })
}

fn read_heat_sink(t: &mut TableReader<'_>) -> Option<HeatSink> {
    let place = object(t, "object");
    let data_type = data_type(t);
    let counts = t.integer("counts-per-degc", 1);
    let by = t.text("by").map(|word| if word == "sdo" { ReadBy::Sdo } else { ReadBy::ProcessData });
    Some(HeatSink { place: place?, data_type: data_type?, counts_per_degc: counts? as f64, by: by? })
}

fn read_watchdog(t: &mut TableReader<'_>) -> Option<WatchdogObject> {
    let place = object(t, "object");
    let data_type = data_type(t);
    let step_s = t.positive("step");
    Some(WatchdogObject { place: place?, data_type: data_type?, step_s: step_s? })
}

fn data_type(t: &mut TableReader<'_>) -> Option<DataType> {
    let word = t.text("type")?;
    TYPES.iter().find(|(name, _)| *name == word).map(|(_, data_type)| *data_type)
}

/// An object at a key.
fn object(t: &mut TableReader<'_>, key: &'static str) -> Option<ObjectPlace> {
    let text = t.text(key)?;
    let span = t.span(key);
    parsed(t, &text, span)
}

/// An object as it is written in a file.
fn parsed(t: &mut TableReader<'_>, text: &str, span: Range<usize>) -> Option<ObjectPlace> {
    let place = parse(text);
    if place.is_none() {
        let help = "write index and sub-index as `6040h` or `607Dh:01`".to_owned();
        t.mistake_at(span, format!("`{text}` is not an object"), Some(help));
    }
    place
}

/// `6040h`, `607Dh:01`: index, then sub-index in hexadecimal digits.
fn parse(text: &str) -> Option<ObjectPlace> {
    let (index, sub) = match text.split_once("h:") {
        Some((index, sub)) => (index, sub),
        None => (text.strip_suffix('h')?, "00"),
    };
    let digits = |text: &str, count: usize| {
        text.len() == count && text.chars().all(|c| c.is_ascii_digit() || c.is_ascii_uppercase())
    };
    let is_written_so = digits(index, 4) && digits(sub, 2);
    let place =
        ObjectPlace { index: u16::from_str_radix(index, 16).ok()?, sub: u8::from_str_radix(sub, 16).ok()? };
    is_written_so.then_some(place)
}

fn read_process_data(
    t: &mut TableReader<'_>,
    heat_sink: Option<HeatSink>,
) -> Option<(ProcessData, ProcessData)> {
    let outputs = read_direction(t, ["outputs", "fixed-outputs"], heat_sink);
    let inputs = read_direction(t, ["inputs", "fixed-inputs"], heat_sink);
    let before = t.mistakes();
    if let Some(ProcessData::Mapped(entries)) = &outputs {
        check_entries(t, "outputs", entries, OUTPUTS);
        let known = |entry: &Entry| *entry == Entry::PADDING || OUTPUTS.iter().any(|o| is_of(entry, o));
        if let Some(other) = entries.iter().find(|entry| !known(entry)) {
            let message = format!("`{:04X}h` would always be sent as 0", other.index);
            let help = "outputs are 6040h, 6071h, 60FFh, 6060h and `pad`".to_owned();
            t.mistake("outputs", message, Some(help));
        }
    }
    if let Some(ProcessData::Mapped(entries)) = &inputs {
        check_entries(t, "inputs", entries, INPUTS);
        let place = heat_sink.filter(|own| own.by == ReadBy::ProcessData).map(|own| own.place);
        if let Some(place) =
            place.filter(|place| !entries.iter().any(|e| (e.index, e.sub) == (place.index, place.sub)))
        {
            let message =
                format!("the heat sink's `{:04X}h:{:02X}` is not among them", place.index, place.sub);
            let help = "add it, or read it `by = \"sdo\"`".to_owned();
            t.mistake("inputs", message, Some(help));
        }
    }
    (t.mistakes() == before).then_some((outputs?, inputs?))
}

fn is_of(entry: &Entry, object: &objects::Object) -> bool {
    (entry.index, entry.sub) == (object.index, object.sub)
}

/// Everything that is needed is there, and nothing twice.
fn check_entries(t: &mut TableReader<'_>, key: &'static str, entries: &[Entry], needed: &[objects::Object]) {
    for object in needed.iter().filter(|object| !entries.iter().any(|entry| is_of(entry, object))) {
        let message = format!("`{key}` lack `{:04X}h`, the {}", object.index, object.name);
        t.mistake(key, message, Some("the driver needs it in every exchange".to_owned()));
    }
    for (k, entry) in entries.iter().enumerate() {
        if *entry != Entry::PADDING && entries[..k].contains(entry) {
            t.mistake(key, format!("`{:04X}h` stands twice in `{key}`", entry.index), None);
        }
    }
}

/// Entries to write, or PDOs to assign: one of two keys.
fn read_direction(
    t: &mut TableReader<'_>,
    [mapped, fixed]: [&'static str; 2],
    heat_sink: Option<HeatSink>,
) -> Option<ProcessData> {
    match (t.has(mapped), t.has(fixed)) {
        (true, false) => {
            let texts = t.spanned_texts(mapped)?;
            let count = texts.len();
            let entries: Vec<Entry> =
                texts.into_iter().filter_map(|(text, span)| entry(t, &text, span, heat_sink)).collect();
            (entries.len() == count).then_some(ProcessData::Mapped(entries))
        }
        (false, true) => {
            let texts = t.spanned_texts(fixed)?;
            let count = texts.len();
            let places = texts.into_iter().filter_map(|(text, span)| parsed(t, &text, span));
            let pdos: Vec<u16> = places.map(|place| place.index).collect();
            (pdos.len() == count && count > 0).then_some(ProcessData::Assigned(pdos))
        }
        (both, _) => {
            let word = if both { "both" } else { "neither" };
            let message = format!("found {word} of `{mapped}` and `{fixed}`: expected one");
            let help = "name the objects that are mapped, or the PDOs with fixed mappings that are assigned";
            t.mistake_at(t.place(), message, Some(help.to_owned()));
            None
        }
    }
}

fn entry(
    t: &mut TableReader<'_>,
    text: &str,
    span: Range<usize>,
    heat_sink: Option<HeatSink>,
) -> Option<Entry> {
    if text == "pad" {
        return Some(Entry::PADDING);
    }
    let ObjectPlace { index, sub } = parsed(t, text, span.clone())?;
    let of_heat_sink = heat_sink.filter(|own| (own.place.index, own.place.sub) == (index, sub));
    let bytes = match of_heat_sink {
        Some(own) => own.data_type.bytes(),
        None => objects::find(index, sub).and_then(|object| object.data_type.bytes()),
    };
    let Some(bytes) = bytes else {
        let help = "the bench neither sends nor reads it; use `pad` for a byte without meaning".to_owned();
        t.mistake_at(span, format!("`{text}` is not an object of the process data"), Some(help));
        return None;
    };
    Some(Entry { index, sub, bits: 8 * bytes as u8 })
}

/// Without 6078h the current comes from 6077h, which must then be one.
fn check_currents(t: &mut TableReader<'_>, profile: &DriveProfile) {
    let ProcessData::Mapped(entries) = &profile.inputs else { return };
    let has_current = entries.iter().any(|entry| is_of(entry, &objects::CURRENT));
    if !has_current && profile.torque_scale == TorqueScale::RatedTorque {
        let message = "`inputs` lack `6078h`, the current actual value";
        let help = "only where `torque-scale = \"rated-current\"` is 6077h the current as well".to_owned();
        t.mistake("process-data", message, Some(help));
    }
}

fn read_lacks(t: &mut TableReader<'_>) -> Option<Vec<ObjectPlace>> {
    if !t.has("lacks") {
        return Some(Vec::new());
    }
    let mut lacks = Vec::new();
    for (text, span) in t.spanned_texts("lacks")? {
        let Some(place) = parsed(t, &text, span.clone()) else { continue };
        if MAY_LACK.iter().any(|may| place.is_of(may.object)) {
            lacks.push(place);
        } else {
            let names: Vec<String> =
                MAY_LACK.iter().map(|may| written(may.object.index, may.object.sub)).collect();
            let help = format!("a type of drive may lack {}", quoted(names.iter().map(String::as_str)));
            t.mistake_at(span, format!("no drive can be used without `{text}`"), Some(help));
        }
    }
    Some(lacks)
}

/// An object as files write it.
fn written(index: u16, sub: u8) -> String {
    if sub == 0 { format!("{index:04X}h") } else { format!("{index:04X}h:{sub:02X}") }
}

#[cfg(test)]
mod tests;
