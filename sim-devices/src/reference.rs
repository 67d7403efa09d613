//! External angle reference: a polygon mirror on the axis and an autocollimator on the ground (ISO 230-1, 6.4).
//!
//! The polygon turns with the frame that carries the line of sight, so the reference sees the true angle, whatever
//! the encoder says. Near a face the autocollimator reads how far the face's normal is off; the face's place comes
//! from the calibration table of the polygon, which is right but for its own uncertainty.

use std::f64::consts::TAU;

use crate::physics::noise::{Noise, SeedAddress};
use crate::unit::InstrumentsSettings;

/// What the reference says of an axis angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceReading {
    /// Face that the autocollimator sees.
    pub face: usize,
    /// Place of this face by the calibration table, rad from face 0, in −π..π.
    pub face_rad: f64,
    /// Reading of the autocollimator.
    pub deviation_rad: f64,
    /// Angle of the axis: face plus deviation.
    pub angle_rad: f64,
}

/// Polygon and autocollimator on one axis.
#[derive(Clone, Debug)]
pub struct AngleReference {
    /// Table of the calibration certificate: place of each face, rad.
    table_rad: Vec<f64>,
    /// What the table is wrong by.
    table_errors_rad: Vec<f64>,
    range_rad: f64,
    resolution_rad: f64,
    scale: f64,
    expanded_uncertainty_rad: f64,
    noise: Noise,
}

impl AngleReference {
    /// The reference of an axis (`az` or `el`: the name addresses its noise and its faces).
    pub fn new(settings: &InstrumentsSettings, address: &SeedAddress, axis: &str) -> Self {
        let faces = (settings.polygon_faces_count.round() as usize).max(1);
        // The polygon is a thing: its faces do not depend on run, procedure or point.
        let thing = SeedAddress { seed: 0, procedure: String::new(), point: String::new() };
        let mut manufacture = Noise::new(&thing, &format!("{axis}.polygon"), settings.polygon_face_error_rad);
        let mut calibration =
            Noise::new(&thing, &format!("{axis}.polygon-table"), settings.polygon_calibration_rad);
        let place = |face: usize| face as f64 * TAU / faces as f64;
        Self {
            table_rad: (0..faces).map(|face| place(face) + manufacture.at(face as u64)).collect(),
            table_errors_rad: (0..faces).map(|face| calibration.at(face as u64)).collect(),
            range_rad: settings.autocollimator_range_rad,
            resolution_rad: settings.autocollimator_resolution_rad,
            scale: 1.0 + settings.autocollimator_scale_error_ratio,
            expanded_uncertainty_rad: expanded_uncertainty_rad(settings),
            noise: Noise::new(address, &format!("{axis}.autocollimator"), settings.autocollimator_noise_rad),
        }
    }

    /// Reads at a true frame angle; `None` if no face is within the autocollimator's range.
    pub fn read(&mut self, tick: u64, true_angle_rad: f64) -> Option<ReferenceReading> {
        let faces = self.table_rad.len();
        let nearest = (true_angle_rad * faces as f64 / TAU).round() as i64;
        let face = nearest.rem_euclid(faces as i64) as usize;
        let truth_rad = self.table_rad[face] + self.table_errors_rad[face];
        let off_rad = wrapped(true_angle_rad - truth_rad);
        if off_rad.abs() > self.range_rad {
            return None;
        }
        let seen_rad = off_rad * self.scale + self.noise.at(tick);
        let deviation_rad = if self.resolution_rad > 0.0 {
            (seen_rad / self.resolution_rad).round() * self.resolution_rad
        } else {
            seen_rad
        };
        let face_rad = wrapped(self.table_rad[face]);
        Some(ReferenceReading { face, face_rad, deviation_rad, angle_rad: wrapped(face_rad + deviation_rad) })
    }

    /// Places of the faces by the calibration table, rad in −π..π: where to stand.
    pub fn faces_rad(&self) -> Vec<f64> {
        self.table_rad.iter().map(|&place| wrapped(place)).collect()
    }

    /// Expanded uncertainty (k = 2) of an angle, rad.
    pub fn expanded_uncertainty_rad(&self) -> f64 {
        self.expanded_uncertainty_rad
    }
}

/// k = 2 of table, noise, resolution (rectangular) and scale over the range (rectangular), GUM 5.1.
fn expanded_uncertainty_rad(settings: &InstrumentsSettings) -> f64 {
    let rectangular = |half_width: f64| half_width * half_width / 3.0;
    let variance = settings.polygon_calibration_rad.powi(2)
        + settings.autocollimator_noise_rad.powi(2)
        + rectangular(0.5 * settings.autocollimator_resolution_rad)
        + rectangular(settings.autocollimator_scale_error_ratio * settings.autocollimator_range_rad);
    2.0 * variance.sqrt()
}

/// Nearest turn: −π..π.
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - (angle_rad / TAU).round() * TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(point: &str) -> SeedAddress {
        SeedAddress { seed: 3, procedure: "POS".into(), point: point.into() }
    }

    fn nominal() -> AngleReference {
        AngleReference::new(&InstrumentsSettings::default(), &address("1"), "az")
    }

    #[test]
    fn near_each_face_the_true_angle_is_read_within_the_stated_uncertainty() {
        let mut reference = nominal();
        let uncertainty_rad = reference.expanded_uncertainty_rad();
        assert!(uncertainty_rad <= 6e-6, "POS-ACC asks for 6 µrad, k = 2: {uncertainty_rad:e}");
        let mut inside = 0;
        let mut all = 0;
        for (face, place) in reference.faces_rad().into_iter().enumerate() {
            for k in 0..20_u32 {
                let truth = place + 1e-5 * (f64::from(k) - 10.0);
                let reading = reference.read(u64::from(20 * face as u32 + k), truth).expect("in range");
                assert_eq!(reading.face, face);
                inside += u32::from(wrapped(reading.angle_rad - truth).abs() <= uncertainty_rad);
                all += 1;
            }
        }
        // 36 faces dominate: 95 % of them, less three standard deviations.
        assert!(f64::from(inside) > 0.84 * f64::from(all), "{inside} of {all}");
    }

    #[test]
    fn between_faces_nothing_is_read() {
        let mut reference = nominal();
        assert_eq!(reference.read(0, 5.0_f64.to_radians()), None);
        assert_eq!(reference.read(0, reference.faces_rad()[1] + 600e-6), None);
        assert!(reference.read(0, reference.faces_rad()[1] - 300e-6).is_some());
    }

    #[test]
    fn an_encoder_that_reads_wrong_does_not_move_the_reference() {
        use crate::physics::encoder::Encoder;
        use crate::unit::UnitSettings;
        let mut unit = UnitSettings::default();
        unit.az.encoder_eccentricity_rad = 150e-6;
        let mut encoder = Encoder::new(&unit.az);
        let mut reference = nominal();
        let mut worst = 0.0_f64;
        for (face, place) in reference.faces_rad().into_iter().enumerate() {
            let encoder_rad = encoder.unwrapped_counts(place) as f64 * encoder.rad_per_count();
            let reading = reference.read(face as u64, place).expect("on the face");
            worst = worst.max(wrapped(encoder_rad - reading.angle_rad).abs());
        }
        assert!((worst - 150e-6).abs() < 8e-6, "{worst:e}");
    }

    #[test]
    fn the_polygon_stays_the_same_from_point_to_point() {
        let other = AngleReference::new(&InstrumentsSettings::default(), &address("2"), "az");
        assert_eq!(nominal().faces_rad(), other.faces_rad());
        let elevation = AngleReference::new(&InstrumentsSettings::default(), &address("1"), "el");
        assert_ne!(nominal().faces_rad(), elevation.faces_rad());
    }
}
