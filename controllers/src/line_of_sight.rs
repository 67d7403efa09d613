//! Rates about the gimbal's axes from an IMU on the elevation frame whose X and Y axes stand at 45°.

use core::f64::consts::FRAC_1_SQRT_2;

use crate::finite_or_zero;

/// Rates of the line of sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisRates {
    /// About the azimuth axis.
    pub az_rad_per_s: f64,
    /// About the elevation axis, in the sense of growing elevation where the mount's sign is right.
    pub el_rad_per_s: f64,
    /// Cross-elevation: about the image's upward axis, `cos el · az` on a base that stands still.
    pub cross_elevation_rad_per_s: f64,
}

/// The 45° mount of the IMU: `[ω_el; ω_az] = [[c, −c, 0], [c·cos el, c·cos el, sin el]]·ω`, c = 1/√2.
///
/// The rows are orthonormal at every elevation, so nothing is divided by a cosine, and the transpose is the inverse.
/// With this matrix ω_el = −d(el)/dt: a vector fixed to the yoke turns against the elevation frame. The sign of the
/// mount, −1, makes d(el)/dt of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuMount {
    sign: f64,
}

impl ImuMount {
    /// A mount; of the sign only that counts: below 0 for the matrix as it is given above.
    pub fn new(elevation_sign: f64) -> Self {
        Self { sign: libm::copysign(1.0, finite_or_zero(elevation_sign)) }
    }

    /// Rates about the axes from the IMU's X, Y, Z rates; the elevation is that of the encoder.
    ///
    /// A rate that is not finite counts as 0.
    pub fn axis_rates(&self, body_rad_per_s: [f64; 3], elevation_rad: f64) -> AxisRates {
        let [x, y, z] = body_rad_per_s.map(finite_or_zero);
        let elevation_rad = finite_or_zero(elevation_rad);
        let cross = FRAC_1_SQRT_2 * (x + y);
        AxisRates {
            az_rad_per_s: libm::cos(elevation_rad) * cross + libm::sin(elevation_rad) * z,
            el_rad_per_s: self.sign * FRAC_1_SQRT_2 * (x - y),
            cross_elevation_rad_per_s: cross,
        }
    }

    /// What the IMU reads when the axes turn so and nothing else does: the transpose; the third row, the rate about
    /// the axis that no motor turns, is 0.
    pub fn body_rates(&self, az_rad_per_s: f64, el_rad_per_s: f64, elevation_rad: f64) -> [f64; 3] {
        let elevation = FRAC_1_SQRT_2 * self.sign * el_rad_per_s;
        let up = FRAC_1_SQRT_2 * libm::cos(elevation_rad) * az_rad_per_s;
        [up + elevation, up - elevation, libm::sin(elevation_rad) * az_rad_per_s]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    const SPIN: f64 = 0.7;
    const ELEVATIONS_DEG: [f64; 7] = [-10.0, 0.0, 30.0, 45.0, 60.0, 89.9, 90.0];

    /// Rows [ω_el, ω_az] of the mount's matrix, by its columns.
    fn rows(elevation_rad: f64) -> [[f64; 3]; 2] {
        let mount = ImuMount::new(1.0);
        let mut rows = [[0.0; 3]; 2];
        for axis in 0..3 {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let rates = mount.axis_rates(unit, elevation_rad);
            (rows[0][axis], rows[1][axis]) = (rates.el_rad_per_s, rates.az_rad_per_s);
        }
        rows
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn rows_are_orthonormal_at_every_elevation() {
        for elevation_deg in ELEVATIONS_DEG {
            let [el, az] = rows(elevation_deg.to_radians());
            assert!((dot(el, el) - 1.0).abs() < 1e-15 && (dot(az, az) - 1.0).abs() < 1e-15);
            assert!(dot(el, az).abs() < 1e-15);
        }
    }

    #[test]
    fn azimuth_spin_reads_the_same_at_every_elevation() {
        let mount = ImuMount::new(-1.0);
        for elevation_rad in ELEVATIONS_DEG.map(f64::to_radians) {
            // The yoke's upward axis seen from the elevation frame: Z points along the line of sight.
            let up = [
                0.5_f64.sqrt() * elevation_rad.cos(),
                0.5_f64.sqrt() * elevation_rad.cos(),
                elevation_rad.sin(),
            ];
            let rates = mount.axis_rates(up.map(|u| SPIN * u), elevation_rad);
            assert!((rates.az_rad_per_s - SPIN).abs() < 1e-15);
            assert!(rates.el_rad_per_s.abs() < 1e-15);
            assert!((rates.cross_elevation_rad_per_s - SPIN * elevation_rad.cos()).abs() < 1e-15);
        }
    }

    #[test]
    fn elevation_counted_the_wrong_way_shows_as_the_cosine_of_twice_the_elevation() {
        let mount = ImuMount::new(-1.0);
        for elevation_rad in ELEVATIONS_DEG.map(f64::to_radians) {
            let body = mount.body_rates(SPIN, 0.0, elevation_rad);
            let wrong = mount.axis_rates(body, -elevation_rad).az_rad_per_s;
            assert!((wrong - SPIN * (2.0 * elevation_rad).cos()).abs() < 1e-15);
        }
    }

    #[test]
    fn negative_sign_makes_the_rate_of_a_growing_elevation_positive() {
        // A star, fixed in the yoke, sinks in the image of a rising frame: du/dt = −ω × u with u = cos el e2 + sin el e3.
        let elevation = 0.4_f64;
        let step = 1e-6;
        let up = |el: f64| {
            let c = 0.5_f64.sqrt() * el.cos();
            [c, c, el.sin()]
        };
        let before = up(elevation - step);
        let after = up(elevation + step);
        let rate: [f64; 3] = std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * step));
        let body = ImuMount::new(-1.0).body_rates(0.0, 1.0, elevation);
        let u = up(elevation);
        let turned = [
            -(body[1] * u[2] - body[2] * u[1]),
            -(body[2] * u[0] - body[0] * u[2]),
            -(body[0] * u[1] - body[1] * u[0]),
        ];
        for (turned, rate) in turned.iter().zip(rate) {
            assert!((turned - rate).abs() < 1e-9, "{turned} {rate}");
        }
    }

    #[test]
    fn broken_gyro_counts_as_no_rate() {
        let rates = ImuMount::new(-1.0).axis_rates([f64::NAN, 0.0, f64::INFINITY], 0.3);
        assert_eq!(rates.az_rad_per_s, 0.0);
        assert_eq!(rates.el_rad_per_s, 0.0);
    }

    proptest! {
        #[test]
        fn body_rates_and_axis_rates_are_inverse(az in -2.0..2.0, el_rate in -2.0..2.0, el in -PI..PI, sign in -1.0..1.0) {
            let mount = ImuMount::new(sign);
            let body = mount.body_rates(az, el_rate, el);
            let rates = mount.axis_rates(body, el);
            prop_assert!((rates.az_rad_per_s - az).abs() < 1e-14);
            prop_assert!((rates.el_rad_per_s - el_rate).abs() < 1e-14);
            let size = dot(body, body);
            prop_assert!((size - az * az - el_rate * el_rate).abs() < 1e-12);
        }
    }
}
