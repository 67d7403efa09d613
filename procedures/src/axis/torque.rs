//! What an ampere of an axis is worth: by its rig file, or by a force gauge.

use analysis::uncertainty::{Component, combine, rectangular_u};

use super::AxisLimits;

/// Largest loss of the torque constant between no current and the largest: iron saturates. Data sheets of direct-drive
/// motors state up to 5 % at the peak current; half-width of a rectangular distribution.
const SATURATION_RATIO: f64 = 0.05;
/// Change of the torque constant with temperature: remanence of NdFeB falls by 0.12 % per kelvin (IEC 60404-8-1). The
/// temperature of the magnets is not measured; that of the heat sink stands for it, half-width of a rectangular
/// distribution.
const REMANENCE_PER_K: f64 = 0.001_2;

/// A torque constant that was measured in the same run.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredConstant {
    /// Torque per ampere.
    pub nm_per_a: f64,
    /// Relative standard uncertainty, with its degrees of freedom.
    relative: Component,
    /// Torque at which it was measured, a magnitude.
    pub torque_nm: f64,
    /// Why torques that are told with it pass no limit: it is not what the rig file says.
    pub doubt: Option<String>,
}

impl MeasuredConstant {
    /// A constant with its standard uncertainty and degrees of freedom (`None`: infinite), measured at a torque. `None` if
    /// it is no positive number.
    pub fn new(nm_per_a: f64, u_nm_per_a: f64, dof: Option<f64>, torque_nm: f64) -> Option<Self> {
        let usable =
            nm_per_a.is_finite() && nm_per_a > 0.0 && u_nm_per_a.is_finite() && torque_nm.is_finite();
        let relative = Component { u: u_nm_per_a / nm_per_a, dof: dof.unwrap_or(f64::INFINITY) };
        usable.then(|| Self { nm_per_a, relative, torque_nm: torque_nm.abs(), doubt: None })
    }

    /// The same constant with a reason why what rests on it passes no limit.
    pub fn doubted(self, doubt: Option<String>) -> Self {
        Self { doubt, ..self }
    }

    /// Relative standard uncertainty.
    pub fn u_ratio(&self) -> f64 {
        self.relative.u
    }

    /// The same constant where the heat sink differs by as much as `kelvin` from when it was measured.
    pub fn at_other_temperature(&self, kelvin: f64) -> Self {
        Self { relative: combine(&[self.relative, warming(kelvin)]), ..self.clone() }
    }
}

/// What a torque constant may change by, relative to itself, where the heat sink changes by so many kelvin.
pub(crate) fn warming(kelvin: f64) -> Component {
    Component::rectangular(REMANENCE_PER_K * kelvin.abs())
}

/// How well torques are known that were told from a current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueScale {
    /// Relative standard uncertainty at the torque where the constant was measured.
    relative: Component,
    /// That torque, a magnitude; infinite where no other torque is less certain.
    measured_at_nm: f64,
    /// Relative standard uncertainty for each N·m beyond it.
    beyond_per_nm: f64,
}

impl TorqueScale {
    /// Of efforts that are no torques: nothing is added.
    pub const NONE: Self = Self {
        relative: Component { u: 0.0, dof: f64::INFINITY },
        measured_at_nm: f64::INFINITY,
        beyond_per_nm: 0.0,
    };

    /// Relative uncertainty of the scale at a torque.
    pub fn relative_at(&self, torque_nm: f64) -> Component {
        let beyond_nm = (torque_nm.abs() - self.measured_at_nm).max(0.0);
        combine(&[self.relative, Component::known(self.beyond_per_nm * beyond_nm)])
    }

    /// What the scale adds to the uncertainty of a torque.
    pub fn of_torque(&self, torque_nm: f64) -> Component {
        self.share(torque_nm, torque_nm)
    }

    /// What the scale adds to a value in units of torque (a stiffness, a damping) that was told at torques up to `torque_nm`.
    pub fn share(&self, value: f64, torque_nm: f64) -> Component {
        let relative = self.relative_at(torque_nm);
        Component { u: relative.u * value.abs(), dof: relative.dof }
    }
}

impl AxisLimits {
    /// Motor torque per ampere: as measured in the run, where it was, else by the rig file. `None`: efforts stay in ampere.
    pub fn torque_constant(&self) -> Option<f64> {
        self.measured_constant.as_ref().map(|m| m.nm_per_a).or(self.torque_constant_nm_per_a)
    }

    /// Torque at the axis over the one that the drive says, which knows the rig's constant alone.
    pub fn torque_ratio(&self) -> f64 {
        match (&self.measured_constant, self.torque_constant_nm_per_a) {
            (Some(measured), Some(rig)) => measured.nm_per_a / rig,
            _ => 1.0,
        }
    }

    /// How well torques of this axis are known.
    pub fn torque_scale(&self) -> TorqueScale {
        let Some(measured) = &self.measured_constant else {
            return TorqueScale {
                relative: Component::known(self.torque_constant_u_ratio),
                ..TorqueScale::NONE
            };
        };
        TorqueScale {
            relative: measured.relative,
            measured_at_nm: measured.torque_nm,
            beyond_per_nm: rectangular_u(SATURATION_RATIO) / self.max_torque_nm,
        }
    }
}
