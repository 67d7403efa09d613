//! Instruments that see torque and deformation: force gauge on a lever arm, strain gauges.

use crate::physics::noise::{Noise, SeedAddress};
use crate::unit::InstrumentsSettings;

/// A force gauge that pulls on a lever arm: 650 N on 630 mm is 410 N·m (study 3.1.1.1).
#[derive(Clone, Debug)]
pub struct ForceGauge {
    arm_m: f64,
    true_arm_m: f64,
    scale: f64,
    zero_n: f64,
    range_n: f64,
    noise: Noise,
}

impl ForceGauge {
    /// The gauge of the bench.
    pub fn new(settings: &InstrumentsSettings, address: &SeedAddress) -> Self {
        Self {
            arm_m: settings.lever_arm_m,
            true_arm_m: settings.lever_arm_m + settings.lever_arm_error_m,
            scale: 1.0 + settings.force_scale_error_ratio,
            zero_n: settings.force_zero_n,
            range_n: settings.force_range_n,
            noise: Noise::new(address, "force-gauge", settings.force_noise_n),
        }
    }

    /// Force that it shows while the pull puts this torque on the axis; it stops at its range.
    pub fn read_n(&mut self, tick: u64, torque_nm: f64) -> f64 {
        let shown_n = torque_nm / self.true_arm_m * self.scale + self.zero_n + self.noise.at(tick);
        shown_n.clamp(-self.range_n, self.range_n)
    }

    /// Torque that a pull of this force puts on the axis.
    pub fn torque_nm(&self, force_n: f64) -> f64 {
        force_n * self.true_arm_m
    }

    /// Torque as the operator computes it: reading times the arm of the data sheet.
    pub fn torque_by_reading_nm(&self, shown_n: f64) -> f64 {
        shown_n * self.arm_m
    }
}

/// A strain gauge whose reading follows the displacement of one structural mode.
#[derive(Clone, Debug)]
pub struct StrainGauge {
    strain_per_rad: f64,
    zero_strain: f64,
    noise: Noise,
}

impl StrainGauge {
    /// The gauge number `channel` (addresses its noise).
    pub fn new(settings: &InstrumentsSettings, address: &SeedAddress, channel: usize) -> Self {
        Self {
            strain_per_rad: settings.strain_per_rad,
            zero_strain: settings.strain_zero_ratio,
            noise: Noise::new(address, &format!("strain.{channel}"), settings.strain_noise_ratio),
        }
    }

    /// Strain (m/m) at a displacement of its mode: frame angle minus shaft angle, or a modal coordinate in rad.
    pub fn read(&mut self, tick: u64, displacement_rad: f64) -> f64 {
        self.strain_per_rad * displacement_rad + self.zero_strain + self.noise.at(tick)
    }
}

/// A clamp-on probe on a motor lead: what an oscilloscope sees of the drive's current (director.md §4.3).
#[derive(Clone, Debug)]
pub struct CurrentProbe {
    scale: f64,
    zero_a: f64,
    noise: Noise,
}

impl CurrentProbe {
    /// The probe on the lead of an axis (`az` or `el`).
    pub fn new(settings: &InstrumentsSettings, address: &SeedAddress, axis: &str) -> Self {
        Self {
            scale: 1.0 + settings.current_probe_scale_error_ratio,
            zero_a: settings.current_probe_zero_a,
            noise: Noise::new(address, &format!("{axis}.current-probe"), settings.current_probe_noise_a),
        }
    }

    /// Current that it shows.
    pub fn read_a(&mut self, tick: u64, current_a: f64) -> f64 {
        current_a * self.scale + self.zero_a + self.noise.at(tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address() -> SeedAddress {
        SeedAddress { seed: 3, procedure: "FRC".into(), point: "1".into() }
    }

    fn mean(mut read: impl FnMut(u64) -> f64) -> f64 {
        (0..1000).map(&mut read).sum::<f64>() / 1000.0
    }

    #[test]
    fn the_study_s_cross_check_comes_out_within_the_gauge_s_errors() {
        let settings = InstrumentsSettings::default();
        let mut gauge = ForceGauge::new(&settings, &address());
        let shown = mean(|tick| gauge.read_n(tick, 410.0));
        assert!((shown - 650.0).abs() < 0.01 * 650.0, "{shown} N");
        // Scale and arm: 0.3 % and 1 mm of 630 mm (0.16 %) may add; the zero is 0.5 N.
        let torque = gauge.torque_by_reading_nm(shown);
        assert!((torque / 410.0 - 1.0).abs() < 0.006 && torque != 410.0, "{torque} N·m");
        assert!((gauge.torque_nm(650.0) - 410.0).abs() < 1.0);
    }

    #[test]
    fn a_gauge_without_errors_is_the_lever_law() {
        let settings = InstrumentsSettings {
            lever_arm_error_m: 0.0,
            force_scale_error_ratio: 0.0,
            force_zero_n: 0.0,
            force_noise_n: 0.0,
            ..InstrumentsSettings::default()
        };
        let mut gauge = ForceGauge::new(&settings, &address());
        let shown = gauge.read_n(0, 63.0);
        assert!((shown - 100.0).abs() < 1e-12);
        assert!((gauge.torque_by_reading_nm(shown) - 63.0).abs() < 1e-12);
        assert_eq!(gauge.read_n(0, 1e6), settings.force_range_n);
    }

    #[test]
    fn strain_follows_its_mode_above_its_noise() {
        let settings = InstrumentsSettings::default();
        let mut gauge = StrainGauge::new(&settings, &address(), 0);
        let read = |gauge: &mut StrainGauge, displacement| mean(|tick| gauge.read(tick, displacement));
        let change = read(&mut gauge, 100e-6) - read(&mut gauge, 0.0);
        assert!((change / (100e-6 * settings.strain_per_rad) - 1.0).abs() < 1e-9);
        assert_ne!(gauge.read(0, 0.0), StrainGauge::new(&settings, &address(), 1).read(0, 0.0));
    }

    #[test]
    fn the_probe_shows_the_current_within_its_errors() {
        let mut probe = CurrentProbe::new(&InstrumentsSettings::default(), &address(), "az");
        let shown = mean(|tick| probe.read_a(tick, 10.0));
        assert!((shown - 10.0).abs() < 0.15 && shown != 10.0, "{shown} A");
    }
}
