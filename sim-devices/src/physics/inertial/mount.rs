//! Where the sensors sit: on the elevation frame, X and Y at 45° about Z, Z along the line of sight.
//!
//! Frame: e1 horizontal, to the left of the line of sight; e2 up from it; e3 along it. With the sensors turned by μ
//! about e3, e1 = (cos μ, −sin μ, 0) and e2 = (sin μ, cos μ, 0) in sensor axes. The vertical is
//! u = cos el·e2 + sin el·e3 and the horizontal heading r3 = −sin el·e2 + cos el·e3; (e1, u, r3) is right-handed.
//! A positive rate about e1 turns the line of sight down: ω_el = −d(el)/dt.

use crate::motion::Motion;
use crate::physics::phasor::Phasor;
use crate::unit::ImuSettings;

type Vector = [f64; 3];
type Matrix = [Vector; 3];

/// What ideal sensors at the place of the unit feel, in its (misaligned) axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Felt {
    /// Inertial rates about X, Y, Z.
    pub rate_rad_per_s: [f64; 3],
    /// Specific force along X, Y, Z: acceleration minus gravity, so +g on an axis that points up.
    pub specific_force_m_per_s2: [f64; 3],
}

/// Geometry of the unit.
#[derive(Clone, Debug)]
pub struct Mount {
    /// From frame axes e1, e2, e3 to sensor axes, misalignment and non-orthogonality included.
    to_sensor: Matrix,
    lever_arm_m: Vector,
    gravity_m_per_s2: f64,
    earth_up_rad_per_s: f64,
    earth_north_rad_per_s: f64,
    heading_rad: f64,
    elevation: Phasor,
    heading: Phasor,
}

impl Mount {
    /// The mount of a unit.
    pub fn new(imu: &ImuSettings) -> Self {
        let (sin, cos) = imu.mounting_angle_rad.sin_cos();
        let turned = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let aligned = product(&misalignment(imu.misalignment_rad), &turned);
        let (sin_latitude, cos_latitude) = imu.latitude_rad.sin_cos();
        Self {
            to_sensor: product(&lean(imu.nonorthogonality_rad), &aligned),
            lever_arm_m: imu.lever_arm_m,
            gravity_m_per_s2: imu.gravity_m_per_s2,
            earth_up_rad_per_s: imu.earth_rate_rad_per_s * sin_latitude,
            earth_north_rad_per_s: imu.earth_rate_rad_per_s * cos_latitude,
            heading_rad: imu.azimuth_zero_heading_rad,
            elevation: Phasor::new(1.0, 0.0),
            heading: Phasor::new(1.0, imu.azimuth_zero_heading_rad),
        }
    }

    /// What ideal sensors feel.
    ///
    /// Rates: ω = −ėl·e1 + ȧz·u + Earth. Acceleration at the lever arm r (rigid frame, axes that intersect):
    /// α×r + ω×(ω×r) with α = −ël·e1 + äz·u + ėl·ȧz·r3, the last from e1 turning with azimuth. Coriolis terms with
    /// the Earth (10⁻⁵ m/s²) are left out.
    pub fn feel(&mut self, motion: &Motion) -> Felt {
        let [azimuth_rad, elevation_rad] = motion.frame_rad;
        let [az_rate, el_rate] = motion.frame_rad_per_s;
        let [az_acceleration, el_acceleration] = motion.frame_rad_per_s2;
        let (sin, cos) = self.elevation.turn_to(elevation_rad);
        // A vector along e1, u and r3, in frame axes.
        let in_frame =
            |left: f64, up: f64, ahead: f64| [left, up * cos - ahead * sin, up * sin + ahead * cos];
        let spin = in_frame(-el_rate, az_rate, 0.0);
        let spin_change = in_frame(-el_acceleration, az_acceleration, el_rate * az_rate);
        let arm = self.lever_arm_m;
        let tangential = cross(&spin_change, &arm);
        let centripetal = cross(&spin, &cross(&spin, &arm));
        let weight = in_frame(0.0, self.gravity_m_per_s2, 0.0);
        let earth = self.earth(azimuth_rad);
        let earth = in_frame(earth[0], earth[1], earth[2]);
        let force = sum(&sum(&tangential, &centripetal), &weight);
        Felt {
            rate_rad_per_s: apply(&self.to_sensor, &sum(&spin, &earth)),
            specific_force_m_per_s2: apply(&self.to_sensor, &force),
        }
    }

    /// Earth rate along e1, u, r3. Azimuth counts counter-clockwise seen from above, a heading clockwise from north.
    fn earth(&mut self, azimuth_rad: f64) -> Vector {
        let (sin, cos) = self.heading.turn_to(self.heading_rad - azimuth_rad);
        [self.earth_north_rad_per_s * sin, self.earth_up_rad_per_s, self.earth_north_rad_per_s * cos]
    }
}

/// From ideal axes to axes turned by a small rotation vector m: I − \[m×\] + ½\[m×\]², exact to |m|³/6.
fn misalignment(rotation_rad: Vector) -> Matrix {
    let [x, y, z] = rotation_rad;
    let turn = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
    let square = product(&turn, &turn);
    std::array::from_fn(|i| {
        std::array::from_fn(|k| f64::from(u8::from(i == k)) + turn[i][k] + 0.5 * square[i][k])
    })
}

/// Non-orthogonal axes: Y leans towards X, Z towards X and Y.
fn lean([yx, zx, zy]: Vector) -> Matrix {
    [[1.0, 0.0, 0.0], [yx, 1.0, 0.0], [zx, zy, 1.0]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|k| (0..3).map(|j| a[i][j] * b[j][k]).sum()))
}

#[inline]
fn apply(matrix: &Matrix, v: &Vector) -> Vector {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[inline]
fn sum(a: &Vector, b: &Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
