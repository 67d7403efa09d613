//! Autocollimators or a force gauge that send their readings as text, described by a profile. What they measure has the topics
//! of the devices on analog inputs, so procedures do not know the difference.

use std::sync::Arc;
use std::time::Duration;

use drivers::device::DeviceError;
use drivers::reader::{self, Counts, Measured, ReaderProfile, Readings};
use drivers::scpi;
use procedures::axis::AngleReference;
use procedures::quantity::QuantityKind as K;
use procedures::table::{Field, Shape};

use super::force::Force;
use super::on_card::CardChannels;
use super::reference::{FACES, LEAST_FACES, Reference, places_rad};
use crate::model::device::DeviceEntry;
use crate::rig::device::{Device, Group, LookedAt};
use crate::rig::driver::{Driver, Made, Misfit, PortField, not_above_zero};
use crate::rig::wires::Ports;

/// Driver of instruments that a reader profile describes.
pub(super) const DRIVER: Driver = Driver {
    name: "reader",
    doc: "Autocollimators at the polygons, or a force gauge, whose lines of text a profile describes: an angle reference or a \
          force gauge without code (`bench explain reader-file`).",
    role: None,
    certified_as: None,
    rate_range_rad_per_s: None,
    ports: &[PortField::line("Line on which the readings arrive.")],
    has_profile: true,
    fields: &[
        Field::required(
            "profile",
            Shape::Text,
            "Reader profile: a shipped one (`bench list readers`) or the path of one.",
        ),
        Field::optional(
            FACES[0],
            Shape::Quantities(K::Angle),
            "Where the profile has `[azimuth]`: calibration of the polygon on the first axis of the rig, the deviation of each \
             face from its nominal angle; faces are equally spaced from 0.",
        ),
        Field::optional(
            FACES[1],
            Shape::Quantities(K::Angle),
            "Where the profile has `[elevation]`: calibration of the polygon on the second axis.",
        ),
        Field::optional(
            FACES_U,
            Shape::Quantity(K::Angle),
            "Standard uncertainty of a face angle by the calibration of the polygon and its mounting, without that of the \
             instrument, which its profile states.",
        ),
    ],
    check,
    make: |entry, _| Made::InTheTick(Box::new(TextReader::closed(entry))),
};

/// Key of the uncertainty of the polygons.
const FACES_U: &str = "faces-uncertainty";
/// What is measured for each key of [`FACES`].
const ANGLES: [Measured; 2] = [Measured::Azimuth, Measured::Elevation];

fn check(entry: &DeviceEntry) -> Vec<Misfit> {
    let mut all = not_above_zero(entry, &[FACES_U]);
    let Some(profile) = &entry.profile else { return all };
    for (key, which) in FACES.into_iter().zip(ANGLES) {
        let count = entry.optional_numbers(key).len();
        let is_given = entry.settings.contains_key(key);
        let name = which.name();
        match profile.scale(which) {
            Some(_) if count < LEAST_FACES => {
                let help =
                    format!("give the calibration of a polygon, which has at least {LEAST_FACES} faces");
                let message = format!("profile `{}` has `[{name}]`: {count} faces", profile.id);
                all.push(Misfit { key, message, help: Some(help) });
            }
            None if is_given => {
                let message =
                    format!("profile `{}` has no `[{name}]`, so nothing looks at these faces", profile.id);
                all.push(Misfit {
                    key,
                    message,
                    help: Some("remove the key, or choose another profile".to_owned()),
                });
            }
            _ => {}
        }
    }
    let has_angle = ANGLES.iter().any(|which| profile.scale(*which).is_some());
    if has_angle != entry.settings.contains_key(FACES_U) {
        let message = match has_angle {
            true => format!("an angle reference needs `{FACES_U}`"),
            false => format!("profile `{}` measures no angle, so `{FACES_U}` means nothing", profile.id),
        };
        all.push(Misfit { key: FACES_U, message, help: None });
    }
    all
}

/// What the polygons that a reader looks at are to the first two axes of a rig. The uncertainty is that of table and instrument
/// together.
pub(super) fn angle_references(entry: &DeviceEntry, profile: &ReaderProfile) -> [Option<AngleReference>; 2] {
    let faces_u_rad = entry.optional_number(FACES_U).unwrap_or(0.0);
    [0, 1].map(|axis| {
        let scale = profile.scale(ANGLES[axis])?;
        let [least_rad, most_rad] = scale.range_si;
        Some(AngleReference {
            faces_rad: places_rad(entry.optional_numbers(FACES[axis])),
            range_rad: most_rad.min(-least_rad),
            u_rad: faces_u_rad.hypot(scale.u_si),
        })
    })
}

/// A reader on its line, and its newest reading.
pub(super) struct TextReader {
    name: String,
    port: String,
    line: usize,
    profile: Arc<ReaderProfile>,
    driver: reader::Reader,
    readings: Readings,
    /// Forces since the last row, and how many they are.
    sum_n: f64,
    count: u32,
}

impl TextReader {
    /// On a line that is not open yet.
    fn closed(entry: &DeviceEntry) -> Self {
        let profile =
            entry.profile.clone().expect("the reader of rig files refuses a reader without profile");
        Self {
            name: entry.name.clone(),
            port: entry.port("line").to_owned(),
            line: 0,
            driver: reader::Reader::new(&entry.name, Arc::clone(&profile)),
            profile,
            readings: Readings::default(),
            sum_n: 0.0,
            count: 0,
        }
    }

    fn is_gauge(&self) -> bool {
        self.profile.scale(Measured::Force).is_some()
    }

    /// The mean force since the row before, or the newest one where none came; not a number while there is no reading.
    fn force_n(&mut self) -> f64 {
        let newest_n = self.readings.value(Measured::Force);
        let mean_n = if self.count > 0 { Some(self.sum_n / f64::from(self.count)) } else { newest_n };
        (self.sum_n, self.count) = (0.0, 0);
        mean_n.unwrap_or(f64::NAN)
    }
}

impl Device for TextReader {
    fn name(&self) -> &str {
        &self.name
    }

    fn open(&mut self, ports: &mut Ports, now: Duration) -> Result<Option<()>, DeviceError> {
        self.line = ports.find_line(&self.name, &self.port)?;
        Ok(self.driver.open(ports.line(self.line), now)?.then_some(()))
    }

    fn identity(&self) -> Option<String> {
        let said = self.driver.identity();
        let who = said.map(|text| match scpi::Identity::parse(text.as_bytes()) {
            Ok(identity) => identity.to_string(),
            Err(_) => text.to_owned(),
        });
        Some(
            who.unwrap_or_else(|| {
                format!("reader `{}`, which has no query for its identity", self.profile.id)
            }),
        )
    }

    fn configuration(&self) -> Option<String> {
        let ReaderProfile { id, query, period_s, pattern, .. } = &*self.profile;
        let how = match query {
            Some(query) => format!("asked `{query}` every {period_s} s"),
            None => format!("sends by itself every {period_s} s"),
        };
        let quanta = Measured::ALL.into_iter().filter_map(|which| {
            let scale = self.profile.scale(which)?;
            let kind = if which == Measured::Force { K::Force } else { K::Angle };
            Some(format!("{} u = {:.3e} {}", which.name(), scale.u_si, kind.si_unit()))
        });
        let quanta = quanta.collect::<Vec<_>>().join(", ");
        Some(format!("profile `{id}`, {how}, lines `{pattern}`, {quanta}"))
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Counts { readings, rejected_lines, timeouts, out_of_range } = self.driver.counts();
        vec![
            ("readings", readings),
            ("rejected_lines", rejected_lines),
            ("timeouts", timeouts),
            ("out_of_range", out_of_range),
        ]
    }

    fn poll(&mut self, ports: &mut Ports, now: Duration) -> Result<(), DeviceError> {
        let polled = self.driver.poll(ports.line(self.line), now);
        self.readings = self.driver.readings(now);
        if polled? && let Some(force_n) = self.readings.value(Measured::Force) {
            self.sum_n += force_n;
            self.count += 1;
        }
        Ok(())
    }

    fn group(&self) -> Group {
        if self.is_gauge() { Force::GROUP } else { Reference::GROUP }
    }

    fn is_looked_at(&self, looked_at: LookedAt) -> bool {
        !self.is_gauge() || Force::is_looked_at(looked_at)
    }

    fn row(&mut self, row: &mut [f64]) {
        if self.is_gauge() {
            row[0] = self.force_n();
            return;
        }
        for (axis, which) in ANGLES.into_iter().enumerate() {
            let deviation_rad = self.readings.value(which);
            row[axis] = deviation_rad.unwrap_or(0.0);
            row[ANGLES.len() + axis] = f64::from(u8::from(deviation_rad.is_some()));
        }
    }
}
