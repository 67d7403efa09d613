//! Axes that do not act on each other: any number, each rigid, with friction, cogging, unbalance, cable spring and stops.

use super::{Axis, WorldRecord, record_of};
use crate::unit::AxisSettings;

/// Steps between two looks at whether a stop was left.
const REARM_STEPS: u32 = 8;

/// Where an axis really is, whatever encoder and drive make of it.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisTruth {
    /// Name.
    pub name: String,
    /// Angle of the shaft.
    pub angle_rad: f64,
    /// Rate of the shaft.
    pub rate_rad_per_s: f64,
}

/// Axes with their names, in the order in which they were added.
#[derive(Clone, Debug)]
pub struct UncoupledAxes {
    names: Vec<String>,
    axes: Vec<Axis>,
    step_s: f64,
    steps_to_rearm: u32,
}

impl UncoupledAxes {
    /// No axis yet, in a world with steps of this width.
    pub fn new(step_s: f64) -> Self {
        Self { names: Vec::new(), axes: Vec::new(), step_s, steps_to_rearm: 0 }
    }

    /// An axis more, at rest at this angle, its bristles relaxed.
    pub fn add(&mut self, name: &str, settings: &AxisSettings, angle_rad: f64) {
        self.names.push(name.to_owned());
        self.axes.push(Axis::new(settings, angle_rad, self.step_s));
    }

    /// The axes, each to be stepped by its motor torque; [`UncoupledAxes::end_step`] comes after all.
    #[inline]
    pub(crate) fn axes_mut(&mut self) -> &mut [Axis] {
        &mut self.axes
    }

    /// One step with these motor torques, in the order of the axes.
    #[inline]
    pub fn step(&mut self, motor_nm: &[f64]) {
        for (axis, &torque_nm) in self.axes.iter_mut().zip(motor_nm) {
            axis.step(torque_nm);
        }
        self.end_step();
    }

    /// All axes have made their step.
    #[inline]
    pub(crate) fn end_step(&mut self) {
        if self.steps_to_rearm == 0 {
            self.steps_to_rearm = REARM_STEPS;
            self.axes.iter_mut().for_each(Axis::rearm_stops);
        }
        self.steps_to_rearm -= 1;
    }

    /// True angle of the shaft of an axis.
    #[inline]
    pub fn angle_rad(&self, axis: usize) -> f64 {
        self.axes[axis].angle_rad()
    }

    /// Where every axis really is.
    pub fn truth(&self) -> Vec<AxisTruth> {
        let named = self.names.iter().zip(&self.axes);
        let truth = named.map(|(name, axis)| AxisTruth {
            name: name.clone(),
            angle_rad: axis.angle_rad(),
            rate_rad_per_s: axis.velocity_rad_per_s(),
        });
        truth.collect()
    }

    /// What happened so far, in order of time.
    pub fn record(&self) -> WorldRecord {
        record_of(self.names.iter().map(String::as_str).zip(&self.axes), self.step_s)
    }
}

#[cfg(test)]
mod tests;
