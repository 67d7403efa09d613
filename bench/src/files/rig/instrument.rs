//! `[[instrument]]`: what measures for the bench, and until when it may be believed.

use procedures::table::{Field, Shape, TableReader};

use crate::model::instrument::{Calibration, Instrument};

/// What an instrument measures for the bench: the parts of the rig file that read it, and those that no part reads.
const ROLES: Shape =
    Shape::Choice(&["reference", "analyser", "scope", "supply", "mirror", "force", "environment", "other"]);

/// Keys of `[[instrument]]`.
pub(super) const INSTRUMENT_FIELDS: &[Field] = &[
    Field::required("name", Shape::Text, "Name in messages and reports, e.g. `autocollimator`."),
    Field::required("role", ROLES, "Role: the part of the rig file that reads it, or its purpose."),
    Field::default(
        "simulated",
        Shape::Boolean,
        "false",
        "The instrument is simulated: it has no certificate and no due date.",
    ),
    Field::optional("maker", Shape::Text, "Manufacturer."),
    Field::optional("model", Shape::Text, "Model."),
    Field::optional("serial-number", Shape::Text, "Serial number."),
    Field::optional("certificate", Shape::Text, "Number of its calibration certificate."),
    Field::optional("calibrated", Shape::Text, "Day of the calibration, `2026-03-01`."),
    Field::optional("due", Shape::Text, "Last day on which it is valid, `2027-03-01`."),
    Field::optional(
        "uncertainty",
        Shape::Text,
        "Uncertainty as on the certificate, e.g. `0.5 urad (k = 2)`.",
    ),
];

/// Reads one `[[instrument]]`.
pub(super) fn read(t: &mut TableReader<'_>) -> Option<Instrument> {
    let name = t.text("name");
    let role = t.text("role");
    let simulated = t.boolean("simulated");
    let [maker, model, serial_number] = ["maker", "model", "serial-number"].map(|key| t.text(key));
    let certificate = t.text("certificate");
    let [calibrated, due] = ["calibrated", "due"].map(|key| day(t, key));
    let uncertainty = t.text("uncertainty");
    let calibration = if simulated? {
        for key in ["certificate", "calibrated", "due"] {
            if t.has(key) {
                let help = "remove it, or remove `simulated`".to_owned();
                t.mistake(key, format!("a simulated instrument has no `{key}`"), Some(help));
            }
        }
        Calibration::Simulated
    } else {
        for key in ["maker", "model", "serial-number", "certificate", "calibrated", "due"] {
            if !t.has(key) {
                let help =
                    "a real instrument needs its certificate; write `simulated = true` for one that does not exist"
                        .to_owned();
                t.mistake("name", format!("the instrument has no `{key}`"), Some(help));
            }
        }
        let calibrated = calibrated?;
        let due = due?;
        if due < calibrated {
            t.mistake("due", "the due date is before the date of calibration", None);
        }
        Calibration::Certified { certificate: certificate?, calibrated, due }
    };
    let text = Option::<String>::unwrap_or_default;
    let maker = text(maker);
    let model = text(model);
    let serial_number = text(serial_number);
    Some(Instrument { name: name?, role: role?, maker, model, serial_number, uncertainty, calibration })
}

/// A day of the calendar, as it is written.
pub(in crate::files) fn day(t: &mut TableReader<'_>, key: &'static str) -> Option<String> {
    let text = t.text(key)?;
    let plain = text.len() == 10 && text.bytes().all(|b| b.is_ascii_digit() || b == b'-');
    if plain && humantime::parse_rfc3339(&format!("{text}T00:00:00Z")).is_ok() {
        return Some(text);
    }
    t.mistake(key, format!("`{key}` must be a day such as `2027-03-01`, found `{text}`"), None);
    None
}
