//! Whether the instruments of the bench may be believed today: a gate before motion, and what the report says of them.

use reports::record::InstrumentRecord;

use crate::model::instrument::{Calibration, Instrument};
use crate::model::rig::Rig;
use crate::rig::devices::certified_as;

#[cfg(test)]
mod tests;

/// Every reason why a run on this rig is refused: an instrument whose calibration is overdue on that day (ISO 8601); with
/// real devices also one that is declared simulated, and a measuring part of the rig without an instrument.
pub(crate) fn refusals(rig: &Rig, real: &[&str], today: &str) -> Vec<String> {
    let mut all: Vec<String> = rig.instruments.iter().filter_map(|i| overdue(i, today)).collect();
    if let Some(device) = real.first() {
        all.extend(rig.instruments.iter().filter(|i| i.calibration == Calibration::Simulated).map(|i| {
            format!(
                "instrument `{}` is declared `simulated`, but {device} is real: enter the real instrument \
                 with its certificate",
                i.name
            )
        }));
        let known = |role: &str| rig.instruments.iter().any(|i| i.role == role);
        let measuring = rig.devices.iter().filter_map(|entry| {
            let role = certified_as(entry)?;
            Some((role, entry.name.as_str()))
        });
        all.extend(measuring.filter(|(role, _)| !known(role)).map(|(role, name)| {
            format!(
                "no instrument is assigned to the device `{name}`, but {device} is real: add an \
                 `[[instrument]]` with `role = \"{role}\"`, its certificate and due date"
            )
        }));
    }
    all
}

fn overdue(instrument: &Instrument, today: &str) -> Option<String> {
    let Calibration::Certified { due, certificate, .. } = &instrument.calibration else { return None };
    (due.as_str() < today).then(|| {
        format!(
            "calibration of instrument `{}` ({} {}, serial number {}) was due on {due}, certificate \
             {certificate}; today is {today}: have it calibrated or replace it by a calibrated one, then \
             update the rig file",
            instrument.name, instrument.maker, instrument.model, instrument.serial_number
        )
    })
}

/// What the report says of each instrument on that day.
pub(crate) fn records(rig: &Rig, today: &str) -> Vec<InstrumentRecord> {
    let record = |i: &Instrument| {
        let known = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        let mut record = InstrumentRecord {
            name: i.name.clone(),
            role: i.role.clone(),
            maker: known(&i.maker),
            model: known(&i.model),
            serial_number: known(&i.serial_number),
            uncertainty: i.uncertainty.clone(),
            status: "simulated".to_owned(),
            ..InstrumentRecord::default()
        };
        if let Calibration::Certified { certificate, calibrated, due } = &i.calibration {
            record.certificate = Some(certificate.clone());
            record.calibrated = Some(calibrated.clone());
            record.due = Some(due.clone());
            let word = if due.as_str() < today { "OVERDUE since" } else { "calibrated until" };
            record.status = format!("{word} {due}");
        }
        record
    };
    rig.instruments.iter().map(record).collect()
}
