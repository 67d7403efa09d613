//! The axes of a rig in their order, and which of them carries which.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{AxisLimits, ticks_per_row};
use crate::missing::Missing;

/// Most axes that a rig may have.
pub const MAX_AXES: usize = 4;

/// One axis of a rig, as planning and judging know it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Name in rig, procedures and requirements, and of the topic in the log.
    pub name: String,
    /// Name of the axis on which this one is mounted; `None` for an axis that stands on the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub carried_by: Option<String>,
    /// Limits and scales.
    pub limits: AxisLimits,
}

/// All axes of a rig, in the order of its rig file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Recorded", into = "Vec<Axis>")]
pub struct Axes(Vec<Axis>);

/// Axes as a log has them.
#[derive(Deserialize)]
#[serde(untagged)]
enum Recorded {
    List(Vec<Axis>),
    /// Limits by name. Versions that wrote this knew no other geometry than elevation over azimuth.
    Map(BTreeMap<String, AxisLimits>),
}

impl From<Recorded> for Axes {
    fn from(recorded: Recorded) -> Self {
        match recorded {
            Recorded::List(axes) => Self(axes),
            // The names of azimuth and elevation sort in that order.
            Recorded::Map(limits) if limits.len() == 2 => Self::stacked(limits),
            Recorded::Map(limits) => {
                Self(limits.into_iter().map(|(name, limits)| Axis::on_the_ground(name, limits)).collect())
            }
        }
    }
}

impl From<Axes> for Vec<Axis> {
    fn from(axes: Axes) -> Self {
        axes.0
    }
}

impl Axis {
    /// An axis that no other one carries.
    pub fn on_the_ground(name: String, limits: AxisLimits) -> Self {
        Self { name, carried_by: None, limits }
    }
}

/// Two axes of which one carries the other, as azimuth carries elevation.
///
/// Pairs of the whole bench are in this order: azimuth with the outer axis first, elevation with the inner axis second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gimbal<'a> {
    /// The axis that stands on the ground: azimuth, and cross-elevation of mirror and trackers.
    pub outer: &'a Axis,
    /// The axis that it carries, with the payload: elevation.
    pub inner: &'a Axis,
}

/// A rig has no gimbal, or more than one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two axes are needed, one carrying the other; the rig has {axes}")]
pub struct NoGimbal {
    /// The axes of the rig, and what carries them.
    pub axes: String,
}

impl<'a> Gimbal<'a> {
    /// Names of the outer and the inner axis.
    pub fn names(&self) -> [&'a str; 2] {
        [&self.outer.name, &self.inner.name]
    }

    /// Place of an axis in pairs: 0 for the outer one, 1 for the inner one, `None` for any other.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.names().iter().position(|own| *own == name)
    }

    /// Name of the axis that the axis of this name carries, or that carries it.
    pub fn other(&self, name: &str) -> Option<&'a str> {
        self.index_of(name).map(|own| self.names()[1 - own])
    }
}

impl Axes {
    /// These axes, in this order.
    pub fn new(axes: Vec<Axis>) -> Self {
        Self(axes)
    }

    /// Axes of which each carries the next one, the outermost first.
    pub fn stacked(axes: impl IntoIterator<Item = (String, AxisLimits)>) -> Self {
        let mut all: Vec<Axis> = Vec::new();
        for (name, limits) in axes {
            let carried_by = all.last().map(|carrier| carrier.name.clone());
            all.push(Axis { name, carried_by, limits });
        }
        Self(all)
    }

    /// Limits and scales of the axis of this name.
    ///
    /// # Errors
    /// [`Missing::Axis`].
    pub fn limits(&self, axis: &str) -> Result<&AxisLimits, Missing> {
        self.get(axis).ok_or_else(|| Missing::Axis { axis: axis.to_owned() })
    }

    /// All axes, in order.
    pub fn all(&self) -> &[Axis] {
        &self.0
    }

    /// All axes, in order, to be changed.
    pub fn all_mut(&mut self) -> &mut [Axis] {
        &mut self.0
    }

    /// The axis of this name.
    pub fn axis(&self, name: &str) -> Option<&Axis> {
        self.0.iter().find(|axis| axis.name == name)
    }

    /// The limits of the axis of this name.
    pub fn get(&self, name: &str) -> Option<&AxisLimits> {
        self.axis(name).map(|axis| &axis.limits)
    }

    /// The limits of the axis of this name, to be changed.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut AxisLimits> {
        self.0.iter_mut().find(|axis| axis.name == name).map(|axis| &mut axis.limits)
    }

    /// The names of all axes, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|axis| axis.name.as_str())
    }

    /// The axis that the axis of this name carries: elevation, for azimuth.
    pub fn carries(&self, name: &str) -> Option<&Axis> {
        self.0.iter().find(|axis| axis.carried_by.as_deref() == Some(name))
    }

    /// The pair of axes of which one carries the other.
    ///
    /// # Errors
    /// When no axis of the rig carries another one, or more than one does.
    pub fn gimbal(&self) -> Result<Gimbal<'_>, NoGimbal> {
        let mut carried = self.0.iter().filter_map(|inner| {
            let outer = self.axis(inner.carried_by.as_deref()?)?;
            Some(Gimbal { outer, inner })
        });
        match (carried.next(), carried.next()) {
            (Some(gimbal), None) => Ok(gimbal),
            _ => Err(NoGimbal { axes: self.listed() }),
        }
    }

    /// The axes to which devices belong that come in pairs, such as polygons: outer and inner axis, or the first two of a rig
    /// without gimbal.
    pub fn pair(&self) -> [Option<&Axis>; 2] {
        match self.gimbal() {
            Ok(gimbal) => [Some(gimbal.outer), Some(gimbal.inner)],
            Err(_) => [self.0.first(), self.0.get(1)],
        }
    }

    /// Place of an axis in pairs: 0 for the outer axis of the gimbal, 1 for its inner one, `None` for any other axis.
    pub fn gimbal_index(&self, name: &str) -> Option<usize> {
        self.gimbal().ok()?.index_of(name)
    }

    /// The axes in words, each with what carries it.
    fn listed(&self) -> String {
        let word = |axis: &Axis| match &axis.carried_by {
            Some(carrier) => format!("`{}` on `{carrier}`", axis.name),
            None => format!("`{}`", axis.name),
        };
        match self.0.as_slice() {
            [] => "no axis".to_owned(),
            [only] => format!("the axis {} only", word(only)),
            all => format!("the axes {}", all.iter().map(word).collect::<Vec<_>>().join(", ")),
        }
    }

    /// A pose of all axes.
    pub fn pose(&self, place_rad: impl Fn(&Axis) -> f64) -> BTreeMap<String, f64> {
        self.0.iter().map(|axis| (axis.name.clone(), place_rad(axis))).collect()
    }

    /// These axes in a log of so many rows per second.
    pub fn logged_at(&self, log_rate_hz: Option<f64>) -> Self {
        let mut all = self.clone();
        for axis in &mut all.0 {
            let limits = &mut axis.limits;
            let every = ticks_per_row(limits.loop_rate_hz, log_rate_hz);
            limits.log_rate_hz = if every > 1.0 { limits.loop_rate_hz / every } else { 0.0 };
        }
        all
    }
}
