//! The model: steady friction and what pulls at the axis.

/// Friction in steady sliding (Canudas de Wit et al. 1995), unbalance and spring, SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    pub(super) coulomb_nm: f64,
    pub(super) static_nm: f64,
    pub(super) stribeck_rad_per_s: f64,
    pub(super) shape_ratio: f64,
    pub(super) viscous_nm_s_per_rad: f64,
    pub(super) unbalance_nm: f64,
    pub(super) spring_nm_per_rad: f64,
    pub(super) rest_rad: f64,
}

impl Model {
    /// Motor torque that keeps the axis at a rate that is not zero, at an angle: director.md §3 and §8 (motor sign).
    pub(super) fn motor_nm(&self, angle_rad: f64, rate_rad_per_s: f64) -> f64 {
        let fall = (-(rate_rad_per_s / self.stribeck_rad_per_s).abs().powf(self.shape_ratio)).exp();
        let sliding_nm = self.coulomb_nm + (self.static_nm - self.coulomb_nm) * fall;
        let friction_nm = sliding_nm.copysign(rate_rad_per_s) + self.viscous_nm_s_per_rad * rate_rad_per_s;
        let load_nm =
            self.unbalance_nm * angle_rad.cos() - self.spring_nm_per_rad * (angle_rad - self.rest_rad);
        friction_nm - load_nm
    }
}
