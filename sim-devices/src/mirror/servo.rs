//! The servo of one axis: the production law with the gains that the unit has.

use controllers::MirrorGains;
use controllers::mirror::MirrorController;

use crate::unit::MirrorSettings;

/// The law at the rate of the steps, saturating at the range of the amplifier. A notch that is switched off, or that
/// lies above half that rate, has equal dampings: it lets everything pass.
pub(super) fn law(settings: &MirrorSettings, axis: usize, limit_rad: f64, step_s: f64) -> MirrorController {
    let rate_hz = 1.0 / step_s;
    let gains = gains(settings, limit_rad);
    let notch = MirrorController::new(&gains, settings.notch_frequency_hz[axis], rate_hz);
    notch.filter(|_| settings.notch_switch >= 0.5).unwrap_or_else(|| {
        let equal = MirrorGains { notch_numerator_damping: 1.0, notch_denominator_damping: 1.0, ..gains };
        MirrorController::new(&equal, 0.25 * rate_hz, rate_hz)
            .expect("a quarter of the rate is below half of it")
    })
}

fn gains(settings: &MirrorSettings, limit_rad: f64) -> MirrorGains {
    MirrorGains {
        proportional: settings.proportional_gain_ratio,
        integral_per_s: settings.integral_gain_per_s,
        double_integral_per_s2: settings.double_integral_gain_per_s2,
        az_notch_hz: settings.notch_frequency_hz[0],
        el_notch_hz: settings.notch_frequency_hz[1],
        notch_numerator_damping: settings.notch_numerator_damping_ratio,
        notch_denominator_damping: settings.notch_denominator_damping_ratio,
        drive_limit_rad: limit_rad,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drives of the first steps after an error of 1 µrad.
    fn drives(settings: &MirrorSettings) -> Vec<f64> {
        let mut law = law(settings, 0, 1e-3, 50e-6);
        (0..20).map(|_| law.update(1e-6, 0.0)).collect()
    }

    /// `P·e + I·Σ e·T + I²·ΣΣ e·T²` and nothing else.
    #[test]
    fn a_notch_that_is_off_or_too_high_for_the_rate_lets_everything_pass() {
        let off = MirrorSettings { notch_switch: 0.0, ..MirrorSettings::default() };
        let high = MirrorSettings { notch_frequency_hz: [12_000.0; 2], ..MirrorSettings::default() };
        for settings in [off, high] {
            for (k, drive) in (1_u32..).zip(drives(&settings)) {
                let n = f64::from(k);
                let t = 50e-6;
                let expected = 1e-6 * (0.08 + 500.0 * n * t + 1e5 * 0.5 * n * (n + 1.0) * t * t);
                assert!((drive - expected).abs() < 1e-15, "step {k}: {drive} {expected}");
            }
        }
        assert!(drives(&MirrorSettings::default())[0] < 0.96 * 1e-6 * (0.08 + 500.0 * 50e-6));
    }
}
