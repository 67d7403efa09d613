//! Secant gain of cross-elevation control, with the keyhole around the zenith.

use crate::{KeyholeSettings, finite_or_zero};

/// What cross-elevation control does at this elevation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Secant {
    /// Azimuth rate per cross-elevation rate: 1/cos el, limited, with the sign of the cosine.
    pub gain: f64,
    /// Factor for the steps of integrals: 1 outside, falling to 0 at the keyhole.
    pub integral_factor: f64,
    /// Whether the elevation is in the keyhole.
    pub inside: bool,
}

/// `k = 1/max(|cos el|, cos el_lim)`: azimuth needs k times the cross-elevation rate, which has no end at the zenith.
///
/// From the keyhole's start on integrals fade, at its limit they stand and the gain grows no more; the keyhole is
/// left again a hysteresis below the limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyhole {
    start_rad: f64,
    limit_rad: f64,
    leave_rad: f64,
    smallest_cosine: f64,
    inside: bool,
}

impl Keyhole {
    /// `None` unless `0 < start ≤ limit < 90°` and the hysteresis is ≥ 0.
    pub fn new(settings: &KeyholeSettings) -> Option<Self> {
        let KeyholeSettings { start_rad, limit_rad, hysteresis_rad } = *settings;
        let smallest_cosine = libm::cos(limit_rad);
        let valid = start_rad > 0.0
            && start_rad <= limit_rad
            && limit_rad < core::f64::consts::FRAC_PI_2
            && (0.0..=limit_rad).contains(&hysteresis_rad);
        let leave_rad = limit_rad - hysteresis_rad;
        valid.then_some(Self { start_rad, limit_rad, leave_rad, smallest_cosine, inside: false })
    }

    /// One tick; an elevation that is not finite counts as 0.
    pub fn update(&mut self, elevation_rad: f64) -> Secant {
        let cosine = libm::cos(finite_or_zero(elevation_rad));
        // Beyond the zenith it is as far from it as below.
        let elevation_rad = libm::acos(cosine.abs());
        let border_rad = if self.inside { self.leave_rad } else { self.limit_rad };
        self.inside = elevation_rad > border_rad;
        let gain = libm::copysign(1.0 / cosine.abs().max(self.smallest_cosine), cosine);
        Secant { gain, integral_factor: self.fade(elevation_rad), inside: self.inside }
    }

    fn fade(&self, elevation_rad: f64) -> f64 {
        if self.inside {
            0.0
        } else if elevation_rad <= self.start_rad {
            1.0
        } else {
            (self.limit_rad - elevation_rad) / (self.limit_rad - self.start_rad)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use proptest::prelude::*;

    use super::*;

    fn keyhole() -> Keyhole {
        let [start_rad, limit_rad, hysteresis_rad] = [80.0_f64, 85.0, 1.5].map(f64::to_radians);
        Keyhole::new(&KeyholeSettings { start_rad, limit_rad, hysteresis_rad }).expect("valid")
    }

    #[test]
    fn secant_is_exact_below_the_limit_and_no_more_than_its_value_there() {
        let mut keyhole = keyhole();
        for (elevation_deg, secant) in [(0.0, 1.0), (45.0, 1.414), (60.0, 2.0), (70.0, 2.92), (80.0, 5.76)] {
            let gain = keyhole.update(f64::to_radians(elevation_deg)).gain;
            assert!((gain - secant).abs() < 0.005, "{elevation_deg} deg: {gain}");
        }
        for elevation_deg in [85.0, 88.0, 89.9, 90.0] {
            let gain = keyhole.update(f64::to_radians(elevation_deg)).gain;
            assert!((gain - 11.474).abs() < 0.001, "{elevation_deg} deg: {gain}");
        }
    }

    #[test]
    fn sign_of_the_cosine_is_kept_beyond_the_zenith() {
        let mut keyhole = keyhole();
        assert!((keyhole.update(90.5_f64.to_radians()).gain + 11.474).abs() < 0.001);
        assert!((keyhole.update(120.0_f64.to_radians()).gain + 2.0).abs() < 1e-12);
    }

    #[test]
    fn keyhole_is_entered_at_its_limit_and_left_a_hysteresis_below() {
        let mut keyhole = keyhole();
        let inside = [84.9, 85.1, 84.0, 83.6, 83.4, 84.9, 85.1]
            .map(|elevation_deg: f64| keyhole.update(elevation_deg.to_radians()).inside);
        assert_eq!(inside, [false, true, true, true, false, false, true]);
    }

    #[test]
    fn integral_fades_between_start_and_limit_and_stands_inside() {
        let mut keyhole = keyhole();
        let factors = [0.0, 79.9, 81.0, 84.0, 86.0, 84.0, 82.0]
            .map(|elevation_deg: f64| keyhole.update(elevation_deg.to_radians()).integral_factor);
        let expected = [1.0, 1.0, 0.8, 0.2, 0.0, 0.0, 0.6];
        for (factor, expected) in factors.iter().zip(expected) {
            assert!((factor - expected).abs() < 1e-9, "{factors:?}");
        }
    }

    #[test]
    fn keyholes_that_do_not_exist_are_refused() {
        let valid = KeyholeSettings { start_rad: 1.4, limit_rad: 1.48, hysteresis_rad: 0.02 };
        assert!(Keyhole::new(&valid).is_some());
        assert_eq!(Keyhole::new(&KeyholeSettings { start_rad: 1.5, ..valid }), None);
        assert_eq!(Keyhole::new(&KeyholeSettings { limit_rad: FRAC_PI_2, ..valid }), None);
        assert_eq!(Keyhole::new(&KeyholeSettings { hysteresis_rad: -0.1, ..valid }), None);
        assert_eq!(Keyhole::new(&KeyholeSettings { limit_rad: f64::NAN, ..valid }), None);
    }

    proptest! {
        #[test]
        fn cross_elevation_rate_is_met_outside_and_never_exceeded(elevations in prop::collection::vec(-0.2..1.6_f64, 1..50)) {
            let mut keyhole = keyhole();
            for elevation in elevations {
                let secant = keyhole.update(elevation);
                let reached = secant.gain * elevation.cos();
                prop_assert!((0.0..=1.0 + 1e-12).contains(&reached));
                prop_assert!(secant.gain.abs() >= 1.0 && (0.0..=1.0).contains(&secant.integral_factor));
                if elevation.cos() > 85.0_f64.to_radians().cos() {
                    prop_assert!((reached - 1.0).abs() < 1e-12);
                }
            }
        }
    }
}
