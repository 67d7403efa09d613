//! A force gauge on a lever arm.

use crate::physics::noise::{Noise, SeedAddress};
use crate::unit::InstrumentsSettings;

/// A force gauge that pulls on a lever arm: 650 N on 630 mm is 410 N·m (study 3.1.1.1).
#[derive(Clone, Debug)]
pub struct ForceGauge {
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
        let torque = shown * settings.lever_arm_m;
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
        assert!((shown * settings.lever_arm_m - 63.0).abs() < 1e-12);
        assert_eq!(gauge.read_n(0, 1e6), settings.force_range_n);
    }
}
